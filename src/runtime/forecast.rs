//! Forecasts of the surface with their half-widths, and its next crest.
//!
//! The GENERIC step is repeated from the present estimate without a measurement, under the accelerations that are
//! planned for the glass. Where no plan reaches, nobody knows what the hand or the robot will do, and the glass is
//! taken to move on evenly (u = 0): the slosh then rings out freely, and energy cannot rise. The interval counts what
//! a glass that does move would add.

use super::memory::Memory;
use crate::blob::Model;
use crate::latent::generic::{LATENTS, LatentState};
use crate::surface::POINTS;
use crate::uncertainty::intervals::Horizon;

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

/// The decoder's surface of `state` with a cross-axis slosh of amplitude `lateral_m`, m.
fn surface(model: &Model<'_>, state: &LatentState, lateral_m: f64) -> [f32; POINTS] {
    let latent: [f64; LATENTS] = state.latent.into();
    let coefficients = model.decoder.coefficients(&latent.map(|x| x as f32), 0.0);
    let mut surface_m = model.decoder.surface(&coefficients);
    model.cross_axis.add_to(&mut surface_m, lateral_m);
    if let Some(observation_model) = &model.observation_model {
        observation_model.add_offset(&mut surface_m);
    }
    surface_m
}

/// The port value of turn `ahead` of `plan`, m/s2; zero behind its end and for what is no number.
fn port(model: &Model<'_>, plan: &[f64], ahead: usize) -> f64 {
    let planned = plan.get(ahead).copied().filter(|a| a.is_finite()).unwrap_or(0.0);
    let gain = model.observation_model.as_ref().map_or(1.0, |observation_model| observation_model.gain);
    gain * planned / f64::from(model.header.acceleration_scale)
}

/// Half-widths of the surface at `horizon` after what `memory` holds, m.
fn half_width_m(model: &Model<'_>, memory: &Memory, horizon: Horizon) -> [f32; POINTS] {
    let mut lateral = memory.filter.lateral(model);
    for _ in 0..horizon.frames {
        model.cross_axis.step(&mut lateral);
    }
    let lateral = model.cross_axis.variance(&lateral, &model.error_model.surface);
    let latent_energy = model.generic.potential.value(&memory.state.latent);
    let covariance = memory.filter.covariance();
    model.error_model.ahead(&covariance, &model.generic, latent_energy, &lateral, horizon)
}

impl Forecast {
    /// The surface `frames` turns after what `memory` holds. `plan` has the accelerations along x of the turns to
    /// come, m/s2, the next one first, each as `before` of [`super::InputSource::Measured`]; an empty one plans nothing.
    #[must_use]
    pub fn new(model: &Model<'_>, memory: &Memory, frames: usize, plan: &[f64]) -> Self {
        let (mut state, mut lateral) = (memory.state, memory.filter.lateral(model).amplitude_m);
        for ahead in 0..frames {
            model.generic.step(&mut state, port(model, plan, ahead));
            lateral = model.cross_axis.next(lateral);
        }
        let [lateral_m, _] = lateral;
        let half_width_m = half_width_m(model, memory, Horizon { frames, planned: plan.len() });
        Self { surface_m: surface(model, &state, lateral_m), half_width_m }
    }
}

impl Forecast {
    /// Hands the forecasts of the next `frames` turns to `visit`, each with its turn, from 1 on: the same as [`Self::new`] of
    /// each, for the work of the last.
    pub fn course(
        model: &Model<'_>,
        memory: &Memory,
        frames: usize,
        plan: &[f64],
        mut visit: impl FnMut(usize, &Self),
    ) {
        let errors = &model.error_model;
        let (mut state, mut lateral) = (memory.state, memory.filter.lateral(model));
        let mut carried =
            errors.carried(&memory.filter.covariance(), model.generic.potential.value(&state.latent));
        let planned = plan.len();
        for ahead in 0..frames {
            model.generic.step(&mut state, port(model, plan, ahead));
            model.cross_axis.step(&mut lateral);
            errors.carry(&mut carried, &model.generic, Horizon { frames: ahead, planned });
            let [lateral_m, _] = lateral.amplitude_m;
            let variance = model.cross_axis.variance(&lateral, &errors.surface);
            let turn = ahead.saturating_add(1);
            let half_width_m = errors.carried_heights(&carried, &variance, Horizon { frames: turn, planned });
            visit(turn, &Self { surface_m: surface(model, &state, lateral_m), half_width_m });
        }
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
        let (mut state, mut lateral) = (memory.state, memory.filter.lateral(model).amplitude_m);
        let [lateral_m, _] = lateral;
        let mut last = highest(&surface(model, &state, lateral_m));
        let mut rose = false;
        for ahead in 0..frames {
            model.generic.step(&mut state, port(model, plan, ahead));
            lateral = model.cross_axis.next(lateral);
            let [lateral_m, _] = lateral;
            let now = highest(&surface(model, &state, lateral_m));
            if rose && now.1 < last.1 {
                let lead = if plan.len() < ahead { frames } else { ahead };
                let horizon = Horizon { frames: lead, planned: plan.len() };
                let half_width_m = half_width_m(model, memory, horizon).get(last.0).copied().unwrap_or(0.0);
                let spills = f64::from(last.1 + half_width_m) >= model.header.rim_m;
                return Some(Self { frames: ahead, height_m: last.1, half_width_m, spills });
            }
            rose = now.1 > last.1;
            last = now;
        }
        None
    }
}
