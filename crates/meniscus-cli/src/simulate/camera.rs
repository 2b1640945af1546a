//! `meniscus simulate --camera DIR`: the recording as a D435 would see it, one pair of images a frame.

use anyhow::{Context, bail};
use image::{ImageEncoder, codecs::png::PngEncoder};
use meniscus::reduced::effects::EffectKind;
use meniscus::units::FRAME_INTERVAL_S;
use meniscus_data::glass::WallShape;
use meniscus_data::motion::Motion;
use meniscus_data::recording::Recording;
use meniscus_platform::files::write_whole;
use meniscus_sph::Setup;
use meniscus_virtual::render::{Images, Liquid, Scene, SceneSettings};
use std::fmt::Write as _;
use std::path::Path;

/// Refuses, before any work, what the renderer cannot show.
pub(super) fn check(setup: &Setup, motion: &Motion, seconds: f64) -> anyhow::Result<()> {
    if !setup.glass.is_cylinder() {
        let glass = match setup.glass.wall {
            WallShape::Straight { taper } => format!("a taper of {taper}"),
            WallShape::Curved(_) => "a curved profile".into(),
        };
        bail!("--camera shows upright cylinders only, and this glass has {glass}");
    }
    let still = |t: f64| motion.height(t) == 0.0 && motion.tilt(t) == 0.0;
    let frames = (seconds / FRAME_INTERVAL_S) as usize;
    let upright = setup.resolved().effects.value(EffectKind::ContainerTilt).unwrap_or(0.0) == 0.0;
    if !upright || !(0..=frames).all(|n| still(n as f64 * FRAME_INTERVAL_S)) {
        bail!("--camera shows glasses that stand upright and move along x only, and this one does not");
    }
    Ok(())
}

/// Renders `recording` into `folder`: depth-NNNN.png (16 bit, steps of 0.1 mm), infrared-NNNN.png (8 bit) and
/// frames.csv.
pub(super) fn render(recording: &Recording, folder: &Path) -> anyhow::Result<()> {
    let mut settings = SceneSettings::default();
    settings.camera.radius_m = recording.glass.radius_m as f32;
    settings.camera.fill_m = recording.glass.fill_m as f32;
    settings.camera.rim_m = recording.glass.rim_m as f32;
    let lens = settings.camera.intrinsics;
    let (width, height) = (lens.width as u32, lens.height as u32);
    let (mut scene, mut images) = (Scene::new(settings), Images::new(&settings));
    let bar = crate::bars::bar(recording.frames() as u64);
    bar.set_style(crate::bars::style("camera {wide_bar} {pos}/{len} frames, {left}")?);
    let mut table = String::from("frame,time_s,depth,infrared\n");
    for frame in 0..recording.frames() {
        scene.render(&Liquid::of(recording, frame), frame as u64, &mut images);
        // PNG keeps its 16-bit samples with the high byte first; the encoder wants those of the machine.
        let depth: Vec<u8> = images
            .depth
            .chunks_exact(2)
            .flat_map(|z| u16::from_le_bytes([z[0], z[1]]).to_ne_bytes())
            .collect();
        let names = [format!("depth-{frame:04}.png"), format!("infrared-{frame:04}.png")];
        let kinds = [image::ExtendedColorType::L16, image::ExtendedColorType::L8];
        for ((name, kind), pixels) in names.iter().zip(kinds).zip([&depth, &images.infrared]) {
            let mut bytes = Vec::new();
            PngEncoder::new(&mut bytes)
                .write_image(pixels, width, height, kind)
                .with_context(|| format!("cannot encode {name}"))?;
            write_whole(&folder.join(name), &bytes)?;
        }
        writeln!(table, "{frame},{:.6},{},{}", frame as f64 * FRAME_INTERVAL_S, names[0], names[1])?;
        bar.inc(1);
    }
    bar.finish_and_clear();
    write_whole(&folder.join("frames.csv"), table.as_bytes())?;
    Ok(())
}
