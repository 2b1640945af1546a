//! `meniscus setup`: a glass of one's own before the camera, measured, checked and written down.

mod camera;
mod glass;
#[cfg(feature = "desk")]
mod screen;
mod webcam;

use super::{bus, inputs};
use crate::outline::Outline;
use crate::outputs::Force;
use crate::webcam::Eye;
use anyhow::{Context, bail};
#[cfg(feature = "bags")]
use camera::from_recording;
use camera::{Scene, Sitting, from_bus};
use glass::GlassArguments;
use meniscus::blob::Model;
use meniscus_report::checks::{Check, table};
use meniscus_service::setup::{
    Finding, Inspection, MeasuredGlass, Setup, SetupOrigin, inspect, inspect_clear, inspect_outline,
};
use serde_json::{Value, json};
use std::io::IsTerminal;
use std::path::{Path, PathBuf};
use webcam::WebcamArguments;

/// Measure a glass before the camera and write it down.
///
/// In a terminal a wizard leads through four steps beside the camera's picture: camera (link, permission, frame rate), glass
/// (is it seen, where is the camera), measures (inner radius, fill and rim by hand, compared with what the camera sees), rest
/// (level, slope, noise, share of points). Enter then writes the file.
///
/// With --yes nothing is asked, for scripts. The file is written only if every check meets its target. Otherwise each miss is
/// reported with its remedy, and the exit status is 1.
///
/// The liquid must be opaque in the outline's image, or clear before a white card under light of 850 nm (--outline clear). Of
/// a clear liquid give --distance-mm and --camera-height-mm where the depth image does not show the wall of the glass. The
/// glass must stand still and upright before an even background, 25 to 70 cm from the camera, whose height is between the
/// foot of the glass and the surface. Measure heights from the inner bottom; the radius is half of what a calliper reads
/// between the inner walls. Of a thick glass give --wall-mm and --base-mm, too.
///
/// A colour webcam (--source v4l:/dev/video0) has no depth and tells nothing of its lens. Give its focal length or field of
/// view, its distance and its height; the silhouette of the glass and the height of the liquid check them. For the lens, hold
/// a ruler level before the camera at a distance of L mm and read how many mm, W, the whole width of the image shows. The
/// focal length is (width of the image in px) * L / W. A distance that is 5 mm wrong makes a wave of 10 mm wrong by 0.14 mm.
///
/// `run`, `record`, `correct` and `recognise` take the file by --setup. Its radius and fill must be the model's to 1 mm.
#[derive(clap::Args)]
#[command(
    after_help = "Examples:\n  meniscus setup\n  meniscus setup --source simulated-usb\n  meniscus setup --source simulated-usb --yes \\\n    --radius-mm 35 --fill-mm 70 --rim-mm 110 --json\n  meniscus setup --source v4l:/dev/video0 --focal-px 610 --distance-mm 365 --camera-height-mm 30\n  meniscus run --source usb --setup glass.toml"
)]
pub(crate) struct Arguments {
    /// Camera on the bus, a simulated one before a resting glass, or a recording that begins at rest.
    ///
    /// simulated-usb takes a trouble by name or number. v4l:DEVICE is a colour webcam; a folder of images
    /// with their times stands for one.
    #[arg(
        long,
        default_value = "usb",
        value_name = "usb|v4l:DEVICE|simulated-usb[:TROUBLE]|FILE|FOLDER",
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
    /// colour is for a liquid that is opaque in the light of the room and clear in the near infrared. clear is for clear water
    /// in the infrared image: it needs a white card behind the glass and light of 850 nm (docs/clear.md). A recording has
    /// the image of its making.
    #[arg(long, default_value = "infrared", value_name = "infrared|colour|clear", help_heading = "Images")]
    outline: Outline,
    /// Serial number of the only camera that is taken, as USB shows it.
    #[arg(long, help_heading = "Images")]
    serial: Option<String>,
    /// A webcam.
    #[command(flatten)]
    webcam: WebcamArguments,
    #[command(flatten)]
    glass: GlassArguments,
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
    let said = arguments.glass.said();
    said.check().map_err(|what| anyhow::anyhow!("{what}"))?;
    arguments.force.check(&arguments.out)?;
    if cfg!(not(feature = "desk")) && !arguments.yes {
        bail!(
            "this program was built for a board, without the wizard: give --yes with --radius-mm, --fill-mm and --rim-mm"
        );
    }
    if !arguments.yes && (!std::io::stdout().is_terminal() || crate::bars::is_plain_terminal()) {
        bail!(
            "setup asks in a terminal, and this is none: give --yes with --radius-mm, --fill-mm and --rim-mm"
        );
    }
    let eye = Eye::of(Path::new(&arguments.source))?;
    arguments.webcam.check(eye.is_some(), arguments.outline)?;
    let job = Job { arguments, said, pairs: arguments.pairs.into() };
    if let Some(eye) = eye {
        return webcam::from_eye(&eye, &job);
    }
    match arguments.source.split_once(':').unwrap_or((&arguments.source, "")) {
        ("usb", "") => from_bus(bus::machine()?, &job),
        ("simulated-usb", trouble) => from_bus(bus::resting(trouble)?, &job),
        #[cfg(feature = "bags")]
        _ => from_recording(Path::new(&arguments.source), &job),
        #[cfg(not(feature = "bags"))]
        _ => bail!(
            "--source {}: this program was built without recordings of a camera: give usb",
            arguments.source
        ),
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
        match scene.stated {
            Some(stated) => inspect_outline(&scene.newest(pairs), stated, said, origin),
            None if self.arguments.outline == Outline::Clear => {
                let place = self.arguments.webcam.place();
                inspect_clear(&scene.newest(pairs), scene.optics, place, said, origin)
            }
            None => inspect(&scene.newest(pairs), scene.optics, said, origin),
        }
    }

    /// The dialogue, or its answers, before a camera that is `sitting`.
    fn hold(&self, scene: &Scene, sitting: &dyn Sitting) -> anyhow::Result<()> {
        if self.arguments.yes {
            let camera = sitting.wait(scene, self.pairs);
            return self.answer(scene, camera, self.inspect(scene, self.pairs, self.said));
        }
        self.ask(scene, sitting)
    }

    /// The dialogue.
    #[cfg(feature = "desk")]
    fn ask(&self, scene: &Scene, sitting: &dyn Sitting) -> anyhow::Result<()> {
        let camera = sitting.wait(scene, 8);
        match screen::ask(self, scene, sitting, camera.clone())? {
            Some(inspection) => self.answer(scene, camera, inspection),
            None => bail!("left without a settings file"),
        }
    }

    /// Nothing: a board's program has refused a call without --yes.
    #[cfg(not(feature = "desk"))]
    fn ask(&self, _: &Scene, _: &dyn Sitting) -> anyhow::Result<()> {
        bail!("setup asks nothing in a board's program: give --yes")
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
