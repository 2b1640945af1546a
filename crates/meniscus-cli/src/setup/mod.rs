//! `meniscus setup`: a glass of one's own before the camera, measured, checked and written down.

mod camera;
mod screen;

use super::doctor::{Camera, camera_findings};
use super::{bus, inputs};
use crate::outputs::Force;
use anyhow::{Context, bail};
use camera::{Scene, Sitting, from_bus, from_recording};
use meniscus::blob::Model;
use meniscus_report::checks::{Check, table};
use meniscus_service::setup::{Finding, Inspection, MeasuredGlass, Setup, SetupOrigin, inspect};
use meniscus_usb::camera::OutlineImage;
use serde_json::{Value, json};
use std::io::IsTerminal;
use std::path::{Path, PathBuf};

/// The rim of a glass of which nobody says it, above the fill, mm.
const RIM_MM: f64 = 40.0;

/// Measure a glass before the camera and write it down.
///
/// In a terminal a wizard leads through four steps beside the camera's picture: camera (link, permission, frame rate), glass
/// (is it seen, where is the camera), measures (inner radius, fill and rim by hand, compared with what the camera sees), rest
/// (level, slope, noise, share of points). Enter then writes the file.
///
/// With --yes nothing is asked, for scripts. The file is written only if every check meets its target. Otherwise each miss is
/// reported with its remedy, and the exit status is 1.
///
/// The liquid must be opaque in the outline's image. The glass must stand still and upright before an even background, 25 to
/// 70 cm from the camera, whose height is between the foot of the glass and the surface. Measure heights from the inner
/// bottom; the radius is half of what a calliper reads between the inner walls.
///
/// `run`, `record`, `correct` and `recognise` take the file by --setup. Its radius and fill must be the model's to 1 mm.
#[derive(clap::Args)]
#[command(
    after_help = "Examples:\n  meniscus setup\n  meniscus setup --source simulated-usb\n  meniscus setup --source simulated-usb --yes \\\n    --radius-mm 35 --fill-mm 70 --rim-mm 110 --json\n  meniscus run --source usb --setup glass.toml"
)]
pub(crate) struct Arguments {
    /// Camera on the bus, a simulated one before a resting glass, or a recording that begins at rest.
    ///
    /// simulated-usb takes a trouble by name or number.
    #[arg(
        long,
        default_value = "usb",
        value_name = "usb|simulated-usb[:TROUBLE]|FILE",
        help_heading = "Images"
    )]
    source: String,
    /// Pairs of images to look at, 8 to 600; of a recording the first ones.
    #[arg(
        long,
        default_value_t = 60,
        value_parser = clap::value_parser!(u16).range(8..=600),
        help_heading = "Images"
    )]
    pairs: u16,
    /// Image in which the outline is traced.
    ///
    /// colour is for a liquid that is opaque in the light of the room and clear in the near infrared. A recording has the
    /// image of its making.
    #[arg(long, default_value = "infrared", value_name = "infrared|colour", help_heading = "Images")]
    outline: OutlineImage,
    /// Serial number of the only camera that is taken, as USB shows it.
    #[arg(long, help_heading = "Images")]
    serial: Option<String>,
    /// Inner radius of the glass, mm, 10 to 60 [default: 35].
    #[arg(long, value_name = "MM", required_if_eq("yes", "true"), help_heading = "Glass")]
    radius_mm: Option<f64>,
    /// Height of the liquid at rest above the inner bottom, mm, 15 to 200 [default: 70].
    #[arg(long, value_name = "MM", required_if_eq("yes", "true"), help_heading = "Glass")]
    fill_mm: Option<f64>,
    /// Height of the rim above the inner bottom, mm, 20 to 300 [default: 40 above the fill].
    #[arg(long, value_name = "MM", help_heading = "Glass")]
    rim_mm: Option<f64>,
    /// Model that the glass is compared with: shipped, a blob, or a folder of `meniscus flash`.
    #[arg(long, default_value = "shipped", value_name = "shipped|FILE|FOLDER", help_heading = "Glass")]
    model: String,
    /// Settings file to write.
    #[arg(long, default_value = "glass.toml", value_name = "FILE.toml", help_heading = "Output")]
    out: PathBuf,
    #[command(flatten)]
    force: Force,
    /// Ask nothing: take the measures from the command line.
    #[arg(long, help_heading = "Output")]
    yes: bool,
    /// Print one JSON object; with --yes.
    #[arg(long, requires = "yes", help_heading = "Output")]
    json: bool,
}

/// Runs the verb.
pub(crate) fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let fill_mm = arguments.fill_mm.unwrap_or(70.0);
    let rim_mm = arguments.rim_mm.unwrap_or(fill_mm + RIM_MM);
    let said = MeasuredGlass { radius_mm: arguments.radius_mm.unwrap_or(35.0), fill_mm, rim_mm };
    said.check().map_err(|what| anyhow::anyhow!("{what}"))?;
    arguments.force.check(&arguments.out)?;
    if !arguments.yes && (!std::io::stdout().is_terminal() || crate::bars::is_plain_terminal()) {
        bail!(
            "setup asks in a terminal, and this is none: give --yes with --radius-mm, --fill-mm and --rim-mm"
        );
    }
    let job = Job { arguments, said, pairs: arguments.pairs.into() };
    match arguments.source.split_once(':').unwrap_or((&arguments.source, "")) {
        ("usb", "") => from_bus(bus::machine()?, &job),
        ("simulated-usb", trouble) => from_bus(bus::resting(trouble)?, &job),
        _ => from_recording(Path::new(&arguments.source), &job),
    }
}

/// Task, whatever the camera.
struct Job<'a> {
    arguments: &'a Arguments,
    said: MeasuredGlass,
    pairs: usize,
}

impl Job<'_> {
    /// The inspection of a scene under these measures.
    fn inspect(&self, scene: &Scene, pairs: usize, said: MeasuredGlass) -> Inspection {
        let made_by = format!("meniscus setup {}", env!("CARGO_PKG_VERSION"));
        let origin = SetupOrigin { outline: scene.outline, camera: &scene.name, made_by: &made_by };
        inspect(&scene.newest(pairs), scene.optics, said, origin)
    }

    /// The dialogue, or its answers, before a camera that is `sitting`.
    fn hold(&self, scene: &Scene, sitting: &dyn Sitting) -> anyhow::Result<()> {
        if self.arguments.yes {
            let camera = self.camera(sitting.wait(scene, self.pairs));
            return self.answer(scene, camera, self.inspect(scene, self.pairs, self.said));
        }
        let camera = self.camera(sitting.wait(scene, 8));
        match screen::ask(self, scene, sitting, camera.clone())? {
            Some(inspection) => self.answer(scene, camera, inspection),
            None => bail!("left without a settings file"),
        }
    }

    /// The doctor's findings of the camera; a recording has none.
    fn camera(&self, camera: Option<Camera>) -> Vec<Finding> {
        let all = camera.as_ref().map(camera_findings).unwrap_or_default();
        all.into_iter().map(|(check, remedy)| Finding { check, remedy }).collect()
    }

    /// Writes the file if all is well, and tells.
    fn answer(&self, scene: &Scene, camera: Vec<Finding>, inspection: Inspection) -> anyhow::Result<()> {
        let out = &self.arguments.out;
        let all: Vec<&Finding> = camera.iter().chain(&inspection.findings).collect();
        let checks: Vec<Check> = all.iter().map(|finding| finding.check.clone()).collect();
        let ok = checks.iter().all(|check| !check.missed());
        let setup = inspection.setup.as_ref().filter(|_| ok);
        if let Some(setup) = setup {
            setup.write(out)?;
        }
        let fits = setup.map(|setup| self.fits(setup, scene)).transpose()?;
        let missed = camera.iter().filter(|finding| finding.check.missed());
        let remedies: Vec<&Finding> = missed.chain(inspection.remedies()).collect();
        if self.arguments.json {
            let remedies: serde_json::Map<String, Value> =
                remedies.iter().map(|one| (one.check.name.clone(), json!(one.remedy))).collect();
            let report = json!({
                "command": "meniscus setup",
                "version": env!("CARGO_PKG_VERSION"),
                "source": self.arguments.source,
                "camera": scene.name,
                "said": inspection.setup.as_ref().map(|setup| setup.glass),
                "view": inspection.setup.as_ref().map(|setup| &setup.view),
                "written": setup.map(|_| out),
                "model": { "name": self.arguments.model, "fits": fits.as_ref().map(Option::is_none),
                           "why": fits.as_ref().and_then(Option::as_ref) },
                "remedies": remedies,
                "checks": checks,
            });
            println!("{}", serde_json::to_string_pretty(&report)?);
        } else {
            println!("{}", scene.name);
            print!("{}", table(&checks));
            remedies.iter().for_each(|one| println!("{}: {}", one.check.name, one.remedy));
            if setup.is_some() {
                println!("written: {}", out.display());
            }
            if let Some(Some(why)) = &fits {
                println!("{}: {why}", self.arguments.model);
            }
        }
        if ok { Ok(()) } else { bail!("the glass is not ready, and nothing is written") }
    }

    /// Why the setup does not fit the model, if it does not.
    fn fits(&self, setup: &Setup, scene: &Scene) -> anyhow::Result<Option<String>> {
        let bytes = inputs::blob(Path::new(&self.arguments.model), None)?;
        let model =
            Model::load(&bytes).with_context(|| format!("the model {} is refused", self.arguments.model))?;
        let fitted = setup.settings_for(&model.header, scene.optics);
        Ok(fitted.err().map(|misfit| misfit.to_string()))
    }
}
