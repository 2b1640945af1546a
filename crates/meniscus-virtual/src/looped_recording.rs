//! A recording that begins again where it ends, for those who watch longer than it lasts.
//!
//! Between two rounds the glass is carried back to where it began, slowly, with the liquid as it stood at the end:
//! along `10 s^3 - 15 s^4 + 6 s^5` in two seconds the shipped recording's glass is accelerated by 0.04 m/s2 at
//! most, under which a liquid at rest would lean by 0.15 mm.

use crate::render::Liquid;
use meniscus_data::recording::Recording;

/// Frames in which the glass is carried back: two seconds. A round is the recording's frames and these.
pub const BACK: usize = 120;

/// The frame of `recording` that shot `shot` shows: the last one while the glass is carried back.
#[must_use]
pub fn frame_shown(recording: &Recording, shot: u64) -> usize {
    place(recording, shot).min(recording.frames().saturating_sub(1))
}

/// The liquid that shot `shot` of an endless recording shows.
///
/// # Panics
/// When the recording has no frame.
#[must_use]
pub fn repeated(recording: &Recording, shot: u64) -> Liquid<'_> {
    let mut liquid = Liquid::of(recording, frame_shown(recording, shot));
    let carried = place(recording, shot).saturating_sub(recording.frames() - 1);
    if carried > 0 {
        let s = carried as f64 / (BACK + 1) as f64;
        let way = s * s * s * (10.0 - 15.0 * s + 6.0 * s * s);
        for (at, began) in liquid.glass_m.iter_mut().zip(Liquid::of(recording, 0).glass_m) {
            *at += way * (began - *at);
        }
    }
    liquid
}

/// The shot within its round.
fn place(recording: &Recording, shot: u64) -> usize {
    (shot % (recording.frames() + BACK) as u64) as usize
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    #[test]
    fn the_glass_comes_back_without_a_jump() {
        let bytes = meniscus_shipped::RECORDING;
        let recording = Recording::from_bytes(Path::new("shipped"), bytes).expect("it is sound");
        let round = (recording.frames() + BACK) as u64;
        let place = |shot| repeated(&recording, shot).glass_m[0];
        assert_eq!(place(round + 7), recording.glass_x_m[7]);
        assert_eq!(place(599), recording.glass_x_m[599]);
        let x: Vec<f64> = (590..round + 10).map(place).collect();
        let most = x.windows(3).map(|x| (x[2] - 2.0 * x[1] + x[0]).abs() * 3600.0).fold(0.0, f64::max);
        assert!(most < 0.06, "the carried glass is accelerated by {most} m/s2");
        assert!((x[0] - recording.glass_x_m[0]).abs() > 0.01, "there is a way to go back");
    }
}
