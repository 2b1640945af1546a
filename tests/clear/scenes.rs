//! The path-traced scenes, and what is known of them without a look.

use meniscus::surface::Optics;
use meniscus::units::Micros;
use meniscus::usb::frame::Stamp;
use meniscus_service::setup::{MeasuredGlass, Pair};
use meniscus_virtual::camera_study::traced::degrade::{Faults, degrade};
use meniscus_virtual::camera_study::traced::set::{Behind, Kind, Light, TracedScene, folder, read, settings};

pub(crate) const WIDTH: usize = 640;
pub(crate) const HEIGHT: usize = 480;

/// Start of the names of scenes that nobody looked at.
pub(crate) const JUDGED: &str = "judge";

pub(crate) fn scenes(set: &str, kind: Kind) -> Vec<TracedScene> {
    let all = read(&folder(), set).expect("the repository holds the set");
    all.into_iter().filter(|scene| scene.truth.liquid == kind).collect()
}

/// Scenes of water before a card under light of 850 nm.
pub(crate) fn before_a_card(set: &str) -> Vec<TracedScene> {
    let fit =
        |scene: &TracedScene| scene.truth.behind == Behind::Card && scene.truth.light == Light::NearInfrared;
    scenes(set, Kind::Water).into_iter().filter(fit).collect()
}

/// Stated measures of a scene's glass.
pub(crate) fn said(scene: &TracedScene) -> MeasuredGlass {
    MeasuredGlass::of([35.0, scene.truth.fill_mm, 110.0])
}

pub(crate) fn pairs(scene: &TracedScene, count: u64) -> Vec<Pair> {
    let pair = |frame: u64| {
        let pair = degrade(scene, WIDTH, &Faults::default(), frame);
        let stamp = Stamp { sequence: frame as u32, captured: Micros(1_000_000 + 16_667 * frame) };
        Pair { depth: Some(pair.depth), outline: pair.infrared, stamp }
    };
    (0..count).map(pair).collect()
}

pub(crate) fn optics(scene: &TracedScene) -> Optics {
    settings(&scene.truth).optics()
}

pub(crate) fn at_rest(set: &str) -> TracedScene {
    let rest = |scene: &TracedScene| scene.truth.name.contains("rest");
    scenes(set, Kind::Water).into_iter().find(rest).expect("a scene at rest")
}
