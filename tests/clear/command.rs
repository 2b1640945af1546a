//! The command: `setup` and `record` of a recording of clear water.

use crate::program::{errors, folder, json, meniscus};
use crate::scenes::{at_rest, optics, pairs};
use meniscus::usb::uvc::Stream;
use meniscus_bags::{Calibration, Image, McapWriter};
use meniscus_service::setup::Pair;
use meniscus_virtual::camera_study::traced::set::TracedScene;
use std::path::Path;

fn film(scene: &TracedScene, path: &Path) {
    let calibration = Calibration::of(&optics(scene), 0.05, "a traced camera");
    let mut writer = McapWriter::create(path, &calibration).expect("created");
    for Pair { depth, outline, stamp } in pairs(scene, 12) {
        let depth = depth.expect("a camera with depth");
        for (stream, pixels) in [(Stream::Depth, depth), (Stream::Outline, outline)] {
            writer.write(&Image { stream, stamp, pixels }).expect("written");
        }
    }
    writer.finish().expect("finished");
}

/// Mean height of all points of a table of profiles, millimetres, and the number of its profiles.
fn table(path: &Path) -> (f64, usize) {
    let text = std::fs::read_to_string(path).expect("a table");
    let heights: Vec<f64> = text
        .lines()
        .skip(1)
        .flat_map(|line| {
            line.split(',').skip(3).take(21).filter_map(|z| z.parse().ok()).collect::<Vec<f64>>()
        })
        .collect();
    (1e3 * heights.iter().sum::<f64>() / heights.len() as f64, text.lines().count() - 1)
}

#[test]
fn the_command_sets_up_and_records_clear_water() {
    let (folder, scene) = (folder("clear", "command"), at_rest("judge"));
    film(&scene, &folder.join("water.mcap"));
    let fill_mm = scene.truth.fill_mm;
    let measures = format!("--yes --json --pairs 12 --radius-mm 35 --fill-mm {fill_mm} --rim-mm 110");
    let opaque = meniscus(&folder, &format!("setup --source water.mcap {measures}"));
    println!("opaque: {}", errors(&opaque));
    let output =
        meniscus(&folder, &format!("setup --source water.mcap --outline clear --out clear.toml {measures}"));
    let report = json(&output);
    assert!(output.status.success(), "{report:#}");
    assert!(
        std::fs::read_to_string(folder.join("clear.toml")).expect("written").contains("tone = \"clear\"")
    );

    let output = meniscus(&folder, "record --source water.mcap --setup clear.toml --out seen.csv");
    assert!(output.status.success(), "{}", errors(&output));
    let (mean_mm, count) = table(&folder.join("seen.csv"));
    println!("{count} profiles of 12, mean {mean_mm:.2} mm, rest {fill_mm} mm");
    assert!(count == 12 && (mean_mm - fill_mm).abs() < 0.3);

    let half =
        meniscus(&folder, &format!("setup --source water.mcap --outline clear --distance-mm 360 {measures}"));
    assert!(errors(&half).contains("together"), "half a place is refused");
}
