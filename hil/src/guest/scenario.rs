//! The scenarios, as what is done in the guest.

use super::{facts, kernel, program, service_scenarios, soak};
use meniscus_hil::FaultList;
use meniscus_hil::device::{Device, Film, Habits, Scenery, TestCard, Trouble};
use meniscus_hil::vhci::Plugged;
use serde_json::{Map, Value};
use std::error::Error;
use std::path::Path;
use std::time::{Duration, Instant};

type Done = Result<Map<String, Value>, Box<dyn Error>>;

/// Longest time for the kernel to enumerate the camera.
const ENUMERATION: Duration = Duration::from_secs(5);

/// Film of a glass with the tag [`TAG`], beside the other one.
const TAG_FILM: &str = "tag.raw";
/// Tag on that film, as `run --motion` takes it.
const TAG: &str = "tag:7,40";

/// `NAME[:TROUBLE[:SECONDS]]`.
struct Plan<'p> {
    name: &'p str,
    trouble: &'p str,
    seconds: Option<f64>,
}

impl<'p> Plan<'p> {
    fn read(text: &'p str) -> Result<Self, Box<dyn Error>> {
        let mut words = text.split(':');
        let name = words.next().unwrap_or_default();
        let trouble = words.next().unwrap_or_default();
        let seconds = words.next().map(str::parse).transpose()?;
        Ok(Self { name, trouble, seconds })
    }

    /// Length of the run.
    fn seconds(&self) -> f64 {
        self.seconds.unwrap_or(4.0)
    }

    fn device(&self, film: &Path) -> Result<Device, Box<dyn Error>> {
        let trouble = match self.trouble {
            "" => None,
            name => Some(Trouble::find(name).ok_or_else(|| format!("no trouble is called `{name}`"))?),
        };
        let film = if self.name == "tag" { film.with_file_name(TAG_FILM) } else { film.to_owned() };
        let scenery: Box<dyn Scenery> = match Film::open(&film) {
            Ok(film) => Box::new(film),
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => Box::<TestCard>::default(),
            Err(error) => return Err(format!("{}: {error}", film.display()).into()),
        };
        let device = Device::new(scenery, trouble, FaultList::default(), 1);
        // In the soak a camera that comes back has been without power.
        let clock_restarts = self.name == "soak";
        Ok(device.with_habits(Habits { clock_restarts, ..Habits::default() }))
    }
}

/// Runs one scenario on a camera of its own and takes it away again.
pub(crate) fn run(plan: &str, film: &Path) -> Done {
    let plan = Plan::read(plan)?;
    let begun = Instant::now();
    let plugged = Plugged::new(plan.device(film)?)?;
    let found = kernel::wait_for_camera(ENUMERATION);
    let done = match plan.name {
        "enumerate" => Ok(Map::new()),
        "doctor" => doctor(&plugged),
        "record" => record(&plan),
        "run" => run_program(&plan, &plugged, &[]),
        "track" => run_program(&plan, &plugged, &["--truth", "shipped"]),
        "tag" | "tag-away" => run_program(&plan, &plugged, &["--motion", TAG]),
        "service" => service_scenarios::service(plan.seconds()),
        "flash" => service_scenarios::flash(&plugged, plan.seconds()),
        "full-disk" => service_scenarios::full_disk(plan.seconds()),
        "low-memory" => service_scenarios::low_memory(plan.seconds()),
        "soak" => soak::run(&plugged, plan.seconds()),
        "busy" => service_scenarios::busy(&plugged, plan.seconds()),
        other => Err(format!("no scenario is called `{other}`").into()),
    };
    let witness = plugged.unplug()?;
    let mut facts = done?;
    if let Some((enumerated, after)) = found {
        facts.insert("enumerated".into(), enumerated.json());
        facts.insert("enumerated_s".into(), after.as_secs_f64().into());
    }
    facts.insert("port_resets".into(), witness.resets.into());
    facts.insert("kernel_complaints".into(), kernel::complaints().into());
    facts.insert("guest_s".into(), begun.elapsed().as_secs_f64().into());
    Ok(facts)
}

/// `meniscus doctor`.
fn doctor(_: &Plugged) -> Done {
    let arguments = ["doctor", "--json"].map(str::to_owned);
    Ok(facts::of(&program::run(&arguments)?))
}

/// `meniscus record` into a file; how large it is.
fn record(plan: &Plan<'_>) -> Done {
    let (file, seconds) = ("/tmp/record.mcap", plan.seconds.unwrap_or(1.0).to_string());
    let arguments = ["record", "--source", "usb", "--seconds", &seconds, "--out", file].map(str::to_owned);
    let ran = program::run(&arguments)?;
    let mut facts = facts::of(&ran);
    facts.insert("recorded_bytes".into(), std::fs::metadata(file).map_or(0, |file| file.len()).into());
    let _gone = std::fs::remove_file(file);
    Ok(facts)
}

/// `meniscus run`, with what the camera's side has seen of it.
fn run_program(plan: &Plan<'_>, plugged: &Plugged, more: &[&str]) -> Done {
    let ran = program::run(&program::arguments(plan.seconds(), more))?;
    Ok(facts::with_turns(&ran, &plugged.witness()))
}
