//! From the bus to an agreed camera: found, opened, planned, identified, calibrated, set, negotiated.

use super::error::CameraError;
use super::monitor::{REQUEST, ask, payload, set, set_colour};
use super::negotiate::negotiate;
use super::plan::{INFRARED, Plan};
use super::settings::{OutlineImage, SIZE, SIZE_USB2, Settings};
use crate::transport::{Listed, Speed, Transport, UsbError};
use meniscus::surface::{Intrinsics, Optics, Rectifier};
use meniscus::usb::d4xx;
use meniscus::usb::d4xx::{
    AUTO_EXPOSURE, COEFFICIENTS, COLOUR, CalibrationError, Colour, DEFAULT_DEPTH_UNIT_UM, DepthTable,
    EXPOSURE, EXPOSURE_BY_CAMERA, EXPOSURE_MODE, EXPOSURE_PRIORITY, Firmware, Identity, LASER_POWER, Product,
    Table,
};
use meniscus::usb::uvc::request::Setup;
use std::time::Duration;

/// Tries to connect, and the first pause between two; each pause is twice the one before, 4.5 s together: a
/// camera that is plugged in anew needs a third of a second until the kernel shows it.
const TRIES: u32 = 5;
const PAUSE: Duration = Duration::from_millis(300);
/// Pause between two looks at the bus.
pub(super) const LOOK: Duration = Duration::from_millis(50);
/// Room for a configuration descriptor: the most that Linux lets a control request have. Those of these
/// cameras have about half of it.
const CONFIGURATION_MAX: usize = 4096;

/// A camera that is open and agreed on.
#[derive(Clone, Debug, PartialEq)]
pub struct Connected {
    /// Which camera.
    pub product: Product,
    /// Where.
    pub device: Listed,
    /// Serial numbers and firmware.
    pub identity: Identity,
    /// Pixels in a row, rows.
    pub size: (u16, u16),
    /// The link is USB 2 and the images are smaller for it.
    pub stepped_down: bool,
    /// Of the depth image.
    pub intrinsics: Intrinsics,
    /// Distance of the imagers, millimetres.
    pub baseline_mm: f32,
    /// The camera's advanced mode, which the depth unit belongs to.
    pub advanced: bool,
    /// Micrometres in one unit of the depth image.
    pub depth_unit_um: u32,
    /// The colour lens, if the outline is traced in its image.
    pub colour: Option<Colour>,
}

impl Connected {
    /// Returns the optics that surface extraction needs.
    #[must_use]
    pub fn optics(&self) -> Optics {
        Optics {
            intrinsics: self.intrinsics,
            depth_unit_m: self.depth_unit_um as f32 * 1e-6,
            depth_lens_m: self.colour.map_or([0.0; 3], |colour| colour.depth_lens_m),
        }
    }

    /// Returns the rectifier from the colour image to the outline's image, if colour is streamed.
    #[must_use]
    pub fn rectifier(&self) -> Option<Rectifier> {
        self.colour.map(|colour| Rectifier::new(colour.lens, self.intrinsics))
    }
}

/// Tries five times, with pauses, where another try may find things changed.
pub(super) fn connect(
    transport: &mut impl Transport,
    settings: &Settings,
) -> Result<(Connected, Plan), CameraError> {
    let mut pause = PAUSE;
    let mut was_there = false;
    for _ in 1..TRIES {
        match establish(transport, settings) {
            Err(error)
                if error.passes()
                    || (was_there && matches!(error, CameraError::NoCamera(_)))
                    || (settings.waits_for_arrival && error.may_arrive()) =>
            {
                was_there = true;
                transport.close();
                pause_or_return(transport, settings.serial.as_deref(), pause, || true);
                pause *= 2;
            }
            done => return done,
        }
    }
    establish(transport, settings)
}

/// A pause that ends as soon as a camera that was not there comes back; one that is there and fails has all of it.
pub(super) fn pause_or_return(
    transport: &mut impl Transport,
    serial: Option<&str>,
    pause: Duration,
    mut wanted: impl FnMut() -> bool,
) {
    let deadline = transport.now() + pause;
    let mut was_away = false;
    while wanted() && transport.now() + LOOK < deadline {
        let listed = transport.list().unwrap_or_default();
        let known = |d: &Listed| Product::of(d.vendor, d.product).is_some();
        let wanted = |d: &Listed| known(d) && (serial.is_none() || d.serial.as_deref() == serial);
        match (listed.iter().any(wanted), was_away) {
            (true, true) => return,
            (true, false) => break,
            (false, _) => was_away = true,
        }
        transport.pause(LOOK);
    }
    let left = deadline.saturating_sub(transport.now());
    transport.pause(left);
}

/// One try.
pub(super) fn establish(
    transport: &mut impl Transport,
    settings: &Settings,
) -> Result<(Connected, Plan), CameraError> {
    let (device, product) = find(transport, settings.serial.as_deref())?;
    let slow = matches!(device.speed, Speed::Full | Speed::High);
    if slow && (settings.refuse_usb2 || device.speed == Speed::Full) {
        return Err(CameraError::SlowLink(device.port));
    }
    if slow && settings.outline == OutlineImage::Colour {
        return Err(CameraError::SlowColour(device.port));
    }
    let size = if slow { SIZE_USB2 } else { SIZE };
    let refused = |doing| {
        let port = device.port.clone();
        move |error| match error {
            UsbError::Access => CameraError::NoAccess(port),
            UsbError::Busy => CameraError::Busy(port),
            error => CameraError::Usb { doing, error },
        }
    };
    transport.open(&device).map_err(refused("open the camera"))?;
    let mut configuration = vec![0; CONFIGURATION_MAX];
    let length = transport.control_in(Setup::CONFIGURATION, &mut configuration, REQUEST);
    configuration.truncate(length.map_err(refused("read the camera's descriptors"))?);
    let plan = match Plan::read(&configuration, size, settings.outline) {
        Err(CameraError::NoMode { .. }) if slow => return Err(CameraError::SlowLink(device.port)),
        Err(CameraError::NoMode { stream: INFRARED, .. })
            if Plan::read(&configuration, size, OutlineImage::Colour).is_ok() =>
        {
            return Err(CameraError::NoInfrared(device.port));
        }
        read => read?,
    };
    for interface in plan.interfaces() {
        transport.claim(interface).map_err(refused("claim the camera's interfaces"))?;
    }
    let identity = identify(transport, &plan)?;
    let (intrinsics, baseline_mm) = calibrate(transport, &plan)?;
    let (advanced, depth_unit_um) = depth_unit(transport, &plan, settings.depth_unit_um)?;
    set_exposure(transport, &plan, settings)?;
    let colour = plan.colour.map(|_| prepare_colour(transport, &plan)).transpose()?;
    negotiate(transport, &plan)?;
    let connected = Connected {
        product,
        device,
        identity,
        size,
        stepped_down: slow,
        intrinsics,
        baseline_mm,
        advanced,
        depth_unit_um,
        colour,
    };
    Ok((connected, plan))
}

/// The camera on the bus. One in recovery is named only if there is no other.
fn find(transport: &mut impl Transport, serial: Option<&str>) -> Result<(Listed, Product), CameraError> {
    let listed = transport.list();
    let listed = listed.map_err(|error| CameraError::Usb { doing: "list the devices on the bus", error })?;
    let other =
        listed.iter().find_map(|d| Some((Product::unsupported(d.vendor, d.product)?, d.port.clone())));
    let known =
        listed.into_iter().filter_map(|d| Product::of(d.vendor, d.product).map(|product| (d, product)));
    let (recovery, cameras): (Vec<_>, Vec<_>) = known.partition(|(_, product)| *product == Product::Recovery);
    let wanted = |(device, _): &(Listed, Product)| serial.is_none_or(|s| device.serial.as_deref() == Some(s));
    match (cameras.into_iter().find(wanted), recovery.first()) {
        (Some(found), _) => Ok(found),
        (None, Some((device, _))) => Err(CameraError::Recovery(device.port.clone())),
        (None, None) => Err(match other.filter(|_| serial.is_none()) {
            Some((name, port)) => CameraError::OtherCamera { name, port },
            None => CameraError::NoCamera(serial.map(str::to_owned)),
        }),
    }
}

fn identify(transport: &mut impl Transport, plan: &Plan) -> Result<Identity, CameraError> {
    const ASKED: &str = "identity";
    let message = ask(transport, plan, ASKED, &Identity::COMMAND, 0)?;
    let identity = Identity::read(&message).map_err(|error| CameraError::Monitor { asked: ASKED, error })?;
    if identity.firmware < Firmware::OLDEST {
        return Err(CameraError::OldFirmware(identity.firmware));
    }
    Ok(identity)
}

/// Intrinsics from the camera's list; from the coefficients where the list is missing or lacks the size.
fn calibrate(transport: &mut impl Transport, plan: &Plan) -> Result<(Intrinsics, f32), CameraError> {
    const ASKED: &str = "calibration";
    let command = Table::command(COEFFICIENTS);
    let message = ask(transport, plan, ASKED, &command, 0)?;
    let table = Table::read(payload(&command, ASKED, &message)?, COEFFICIENTS).map_err(CameraError::Table)?;
    let baseline_mm = d4xx::baseline_mm(&table).map_err(CameraError::Calibration)?;
    let list = match ask(transport, plan, ASKED, &d4xx::recommended::COMMAND, 0) {
        Ok(message) => Some(message),
        Err(CameraError::Monitor { error: d4xx::MonitorError::Refused(_), .. }) => None,
        Err(error) => return Err(error),
    };
    let listed = match &list {
        Some(message) => {
            d4xx::recommended::read(payload(&d4xx::recommended::COMMAND, ASKED, message)?, plan.size)
        }
        None => Err(CalibrationError::Size { width: plan.size.0, height: plan.size.1 }),
    };
    let intrinsics = match listed {
        Err(CalibrationError::Size { .. }) => d4xx::coefficients(&table, plan.size),
        listed => listed,
    };
    Ok((intrinsics.map_err(CameraError::Calibration)?, baseline_mm))
}

/// Returns whether the advanced mode is on, and the depth unit in force, after a request for another one if it can be set.
fn depth_unit(
    transport: &mut impl Transport,
    plan: &Plan,
    wanted_um: Option<u32>,
) -> Result<(bool, u32), CameraError> {
    const ASKED: &str = "depth unit";
    let refused = |error| CameraError::Monitor { asked: ASKED, error };
    let message = ask(transport, plan, ASKED, &DepthTable::ADVANCED, 1)?;
    if payload(&DepthTable::ADVANCED, ASKED, &message)?.first() == Some(&0) {
        return Ok((false, DEFAULT_DEPTH_UNIT_UM));
    }
    let message = ask(transport, plan, ASKED, &DepthTable::COMMAND, 0)?;
    let table = DepthTable::read(&message).map_err(refused)?;
    let Some(wanted_um) = wanted_um.filter(|wanted| *wanted != table.unit_um()) else {
        return Ok((true, table.unit_um()));
    };
    ask(transport, plan, ASKED, &table.with_unit_um(wanted_um).set(), 0)?;
    // What holds is what the camera reports afterwards, not what was requested of it.
    let message = ask(transport, plan, ASKED, &DepthTable::COMMAND, 0)?;
    Ok((true, DepthTable::read(&message).map_err(refused)?.unit_um()))
}

fn set_exposure(transport: &mut impl Transport, plan: &Plan, settings: &Settings) -> Result<(), CameraError> {
    let automatic = u8::from(settings.exposure_us.is_none());
    set(transport, plan, "set the automatic exposure", AUTO_EXPOSURE, &[automatic])?;
    if let Some(exposure_us) = settings.exposure_us {
        set(transport, plan, "set the exposure", EXPOSURE, &exposure_us.to_le_bytes())?;
    }
    let Some(laser_mw) = settings.laser_mw else { return Ok(()) };
    set(transport, plan, "set the laser's power", LASER_POWER, &laser_mw.to_le_bytes())
}

/// The colour lens; its exposure is the camera's choice as long as the rate holds.
fn prepare_colour(transport: &mut impl Transport, plan: &Plan) -> Result<Colour, CameraError> {
    const ASKED: &str = "colour calibration";
    let command = Table::command(COLOUR);
    let message = ask(transport, plan, ASKED, &command, 0)?;
    let table = Table::read(payload(&command, ASKED, &message)?, COLOUR).map_err(CameraError::Table)?;
    let colour = d4xx::colour(&table, plan.size).map_err(CameraError::Calibration)?;
    set_colour(transport, plan, EXPOSURE_MODE, EXPOSURE_BY_CAMERA)?;
    set_colour(transport, plan, EXPOSURE_PRIORITY, 0)?;
    Ok(colour)
}
