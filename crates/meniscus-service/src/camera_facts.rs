//! A connected camera for reports: as JSON and as one line.

use meniscus::usb::d4xx::Trial;
use meniscus_usb::camera::Connected;
use serde_json::{Value, json};

/// Returns the camera as a JSON object.
#[must_use]
pub fn camera_json(camera: &Connected) -> Value {
    json!({
        "product": camera.product.name(),
        "port": camera.device.port,
        "serial": camera.device.serial,
        "optical_serial": camera.identity.serial.to_string(),
        "firmware": camera.identity.firmware.to_string(),
        "link": camera.device.speed.to_string(),
        "size": [camera.size.0, camera.size.1],
        "stepped_down": camera.stepped_down,
        "intrinsics": { "fx": camera.intrinsics.fx, "fy": camera.intrinsics.fy,
                        "ppx": camera.intrinsics.ppx, "ppy": camera.intrinsics.ppy },
        "baseline_mm": camera.baseline_mm,
        "advanced_mode": camera.advanced,
        "depth_unit_um": camera.depth_unit_um,
    })
}

/// Returns the camera in one line.
#[must_use]
pub fn camera_line(camera: &Connected) -> String {
    let (width, height) = camera.size;
    let stepped = if camera.stepped_down { ", stepped down because of the USB 2 link" } else { "" };
    let untried = match camera.product.trial() {
        Trial::Simulated => "",
        Trial::Never => " (a model that was never tried, not even simulated)",
    };
    format!(
        "{}{untried} {} at {}, firmware {}, {}: {width}x{height} at 60 Hz{stepped}",
        camera.product.name(),
        camera.identity.serial,
        camera.device.port,
        camera.identity.firmware,
        camera.device.speed
    )
}
