//! Forecasts of the surface with their half-widths, and its next crest.
//!
//! The GENERIC step is repeated from the present estimate without a measurement, under the accelerations that are
//! planned for the glass. Where no plan reaches, nobody knows what the hand or the robot will do, and the glass is
//! taken to move on evenly (u = 0): the slosh then rings out freely, and energy cannot rise. The interval counts what
//! a glass that does move would add.

use super::course::Course;
use super::memory::Memory;
use crate::blob::Model;
use crate::surface::POINTS;

/// The surface some turns from now.
///
/// ```
/// # #[repr(align(64))]
/// # struct Aligned<T: ?Sized>(T);
/// # static BLOB: &Aligned<[u8]> =
/// #     &Aligned(*include_bytes!(concat!(env!("CARGO_MANIFEST_DIR"), "/models/glycerine.blob")));
/// let model = meniscus::blob::Model::load(&BLOB.0)?;
/// use meniscus::runtime::{Forecast, Memory};
///
/// // A liquid at rest, and a robot that accelerates its glass by 1 m/s2 for a tenth of a second.
/// let (memory, plan) = (Memory::default(), [1.0; 6]);
/// let (rest, moved) = (Forecast::new(&model, &memory, 6, &[]), Forecast::new(&model, &memory, 6, &plan));
/// assert!((rest.surface_m[0] - rest.surface_m[20]).abs() < 1e-3);
/// // The liquid stays behind: it rises at the side that the glass comes from.
/// assert!(moved.surface_m[0] > moved.surface_m[20] + 1e-3);
/// // Without a plan the motion of the glass is unknown, and the interval is wider.
/// assert!(rest.half_width_m[0] > moved.half_width_m[0]);
/// # Ok::<(), meniscus::blob::LoadError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Forecast {
    /// The 21 heights, metres above the inner bottom.
    pub surface_m: [f32; POINTS],
    /// Half-widths that hold nine times out of ten, m.
    pub half_width_m: [f32; POINTS],
}

/// The highest that the surface will stand next.
///
/// ```
/// # #[repr(align(64))]
/// # struct Aligned<T: ?Sized>(T);
/// # static BLOB: &Aligned<[u8]> =
/// #     &Aligned(*include_bytes!(concat!(env!("CARGO_MANIFEST_DIR"), "/models/glycerine.blob")));
/// let model = meniscus::blob::Model::load(&BLOB.0)?;
/// use meniscus::runtime::{Crest, Memory};
///
/// // From rest, under 1 m/s2 for a tenth of a second, and then without acceleration.
/// let (memory, mut plan) = (Memory::default(), [0.0; 30]);
/// plan[..6].fill(1.0);
/// let crest = Crest::next(&model, &memory, 30, &plan).expect("the surface rises and falls");
/// assert!(f64::from(crest.height_m) > model.header.fill_m && crest.frames < 30);
/// assert_eq!(crest.spills, f64::from(crest.height_m + crest.half_width_m) >= model.header.rim_m);
/// # Ok::<(), meniscus::blob::LoadError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Crest {
    /// Turns from now.
    pub frames: usize,
    /// Height of the highest point, metres above the inner bottom.
    pub height_m: f32,
    /// Half-width that holds nine times out of ten, m.
    pub half_width_m: f32,
    /// Whether the liquid may pass the rim: the crest with its half-width reaches it.
    pub spills: bool,
}

impl Forecast {
    /// The surface `frames` turns after what `memory` holds. `plan` has the accelerations along x of the turns to
    /// come, m/s2, the next one first, each as `before` of [`super::InputSource::Measured`]; an empty one plans nothing.
    #[must_use]
    pub fn new(model: &Model<'_>, memory: &Memory, frames: usize, plan: &[f64]) -> Self {
        let mut course = Course::new(model, memory, plan);
        (0..frames).for_each(|_| course.step());
        Self::at(&course)
    }

    /// Hands the forecasts of the next `frames` turns to `visit`, each with its turn, from 1 on: the same as [`Self::new`] of
    /// each, for the work of the last.
    pub fn course(
        model: &Model<'_>,
        memory: &Memory,
        frames: usize,
        plan: &[f64],
        mut visit: impl FnMut(usize, &Self),
    ) {
        let mut course = Course::new(model, memory, plan);
        for turn in 1..=frames {
            course.step();
            visit(turn, &Self::at(&course));
        }
    }

    fn at(course: &Course<'_>) -> Self {
        Self { surface_m: course.surface_m(), half_width_m: course.half_width_m() }
    }
}

impl Crest {
    /// Returns the first maximum over time of the highest point within `frames` turns after the state of `memory`,
    /// `None` if the surface only sinks; `plan` as in [`Forecast::new`]. It takes one GENERIC step for each turn
    /// ahead.
    ///
    /// Where the plan does not reach the crest, an acceleration may bring another one at any time of the horizon, and the
    /// half-width is that of the last.
    #[must_use]
    pub fn next(model: &Model<'_>, memory: &Memory, frames: usize, plan: &[f64]) -> Option<Self> {
        let highest = |heights: &[f32; POINTS]| {
            let points = heights.iter().copied().enumerate();
            points.fold((0, f32::NEG_INFINITY), |best, point| if point.1 > best.1 { point } else { best })
        };
        let mut course = Course::new(model, memory, plan);
        let mut last = highest(&course.surface_m());
        let mut rose = false;
        for ahead in 0..frames {
            let before = course;
            course.step();
            let now = highest(&course.surface_m());
            if rose && now.1 < last.1 {
                let half_width_m = before.crest_half_width_m(frames).get(last.0).copied().unwrap_or(0.0);
                let spills = f64::from(last.1 + half_width_m) >= model.header.rim_m;
                return Some(Self { frames: ahead, height_m: last.1, half_width_m, spills });
            }
            rose = now.1 > last.1;
            last = now;
        }
        None
    }
}
