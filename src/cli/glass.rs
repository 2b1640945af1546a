//! `--setup FILE`: the glass and the place of the camera that `meniscus setup` has written down.

use meniscus::host::setup::{Misfit, Setup};
use meniscus::model::Header;
use meniscus::surface::Settings;
use std::path::Path;

/// The reader's settings for a model's glass before a camera: with a setup its view, without one that of
/// [`Settings::for_glass`]; intrinsics and depth unit are those of `camera`.
pub(super) fn settings(setup: Option<&Path>, header: &Header, camera: Settings) -> anyhow::Result<Settings> {
    let (intrinsics, depth_unit_m) = (camera.intrinsics, camera.depth_unit_m);
    let Some(path) = setup else {
        let glass = Settings::for_glass(header.radius_m, header.fill_m, header.rim_m);
        return Ok(Settings { intrinsics, depth_unit_m, ..glass });
    };
    let fitted = Setup::read(path)?.settings_for(header, intrinsics, depth_unit_m);
    fitted.map_err(|misfit: Misfit| anyhow::anyhow!("{}: {misfit}", path.display()))
}
