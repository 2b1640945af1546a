//! Which bus a command works on: the machine's own, or one with a simulated camera.

use anyhow::anyhow;
#[cfg(feature = "desk")]
use meniscus_data::recording::Recording;
#[cfg(feature = "desk")]
use meniscus_hil::FaultList;
#[cfg(feature = "desk")]
use meniscus_hil::device::{Device, Scenery, TestCard};
use meniscus_hil::device::{TROUBLES, Trouble};
use meniscus_usb::camera::CameraError;
use meniscus_usb::transport::Machine;
#[cfg(feature = "desk")]
use meniscus_virtual::render::SceneSettings;
#[cfg(feature = "desk")]
use meniscus_virtual::usb::RecordedGlass;
#[cfg(feature = "desk")]
use meniscus_virtual::usb::SimulatedBus;
#[cfg(feature = "desk")]
use std::path::Path;

/// The machine's own.
pub(crate) fn machine() -> Result<Machine, CameraError> {
    Machine::new().map_err(CameraError::NoBus)
}

/// A trouble by name or number; an empty name is none.
pub(crate) fn trouble(name: &str) -> anyhow::Result<Option<Trouble>> {
    if name.is_empty() {
        return Ok(None);
    }
    let known = || TROUBLES.iter().map(|(name, ..)| *name).collect::<Vec<_>>().join(" ");
    let found = Trouble::find(name);
    Ok(Some(found.ok_or_else(|| anyhow!("no trouble is called `{name}`; there are: {}", known()))?))
}

/// A simulated camera before a test card, in real time.
#[cfg(feature = "desk")]
pub(crate) fn simulated(trouble_name: &str) -> anyhow::Result<SimulatedBus> {
    let scenery: Box<dyn Scenery> = Box::<TestCard>::default();
    let device = Device::new(scenery, trouble(trouble_name)?, FaultList::default(), 1);
    Ok(SimulatedBus::new(device).in_real_time())
}

/// A simulated camera before the glass of the shipped recording at rest, in real time.
#[cfg(feature = "desk")]
pub(crate) fn resting(trouble_name: &str) -> anyhow::Result<SimulatedBus> {
    let recording = Recording::from_bytes(Path::new("the shipped recording"), meniscus_shipped::RECORDING)?;
    let glass = RecordedGlass::new(recording, SceneSettings::default()).resting();
    let device = Device::new(Box::new(glass), trouble(trouble_name)?, FaultList::default(), 1);
    Ok(SimulatedBus::new(device).in_real_time())
}

#[cfg(all(feature = "bags", feature = "desk"))]
/// A simulated camera before the shipped recording, in real time.
pub(crate) fn recorded(trouble_name: &str) -> anyhow::Result<SimulatedBus> {
    let recording = Recording::from_bytes(Path::new("the shipped recording"), meniscus_shipped::RECORDING)?;
    let glass = RecordedGlass::new(recording, SceneSettings::default());
    let device = Device::new(Box::new(glass), trouble(trouble_name)?, FaultList::default(), 1);
    Ok(SimulatedBus::new(device).in_real_time())
}

/// Refuses a simulated camera, which a board's program is built without.
#[cfg(not(feature = "desk"))]
pub(crate) fn simulated(_: &str) -> anyhow::Result<Machine> {
    anyhow::bail!(WITHOUT_SIMULATED)
}

/// Refuses a simulated camera before a resting glass.
#[cfg(not(feature = "desk"))]
pub(crate) fn resting(_: &str) -> anyhow::Result<Machine> {
    anyhow::bail!(WITHOUT_SIMULATED)
}

/// Refusal of a board's program, with the remedy.
#[cfg(not(feature = "desk"))]
pub(crate) const WITHOUT_SIMULATED: &str = "this program was built for a board, without a simulated camera: give --source usb, or \
                                            from the repository: cargo run --release -- run";
