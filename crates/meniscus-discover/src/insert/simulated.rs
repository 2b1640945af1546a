//! A recording of a discovery simulated again, with the effects that were found.
//!
//! The simulator carries effects of the liquid, fill, inclination and lift. Gain and delay of the commanded motion and
//! the effects of the camera are applied around it, by the formulas of [`meniscus::reduced::effects`].

use crate::recordings::known::Known;
use crate::recordings::record::{Quantity, Record, parts};
use meniscus::blob::ObservationModel;
use meniscus::reduced as slosh;
use meniscus::reduced::effects::{Active, Simulator, Slot};
use meniscus::reduced::{Baseline, Cylinder, ReducedModel};
use meniscus::surface::POINTS;
use meniscus_data::effects::Effects;
use meniscus_data::glass::WallShape;
use meniscus_data::liquids::{Liquid, Rheology};
use meniscus_data::motion::Motion;
use meniscus_data::recording::Glass;
use meniscus_sph::{Setup, record_surfaces};

/// Resolution of a simulation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Resolution {
    /// Spacing of the particles, m.
    pub spacing_m: f64,
    /// Seed of their packing.
    pub seed: u64,
}

/// Height of the rim over the fill: high enough for any slosh that a discovery can use, m.
const ROOM_M: f64 = 0.05;

/// Returns each channel of `record` by the simulator for the glass and liquid of `known` with `effects`, m. `lag_s` as in
/// [`super::latent::roll_out`].
///
/// # Errors
/// In words, when the simulator does not carry an effect, a value is out of its range, or it stops.
pub fn simulate(
    known: &Known,
    effects: &[Active],
    record: &Record,
    lag_s: f64,
    resolution: Resolution,
) -> Result<Vec<Vec<f64>>, String> {
    if record.drive.holds() != [false; 2] || !record.drive.is_planar() {
        return Err(format!("{}: only a glass that is moved along x is simulated again", record.name));
    }
    let mut inside = Effects::default();
    for effect in effects {
        match (effect.entry.simulator, effect.entry.slot) {
            // These are applied around the simulator, below.
            (Simulator::Absent(_), Slot::Port(_) | Slot::View(_)) => {}
            _ => inside.set_simulated(effect, &known.stated()).map_err(|error| format!("{error}"))?,
        }
    }
    let vessel =
        Cylinder { radius_m: known.radius_m, depth_m: known.fill_m, density_kg_m3: known.density_kg_m3 };
    let resists = slosh::Rheology::newtonian(known.viscosity_pa_s);
    let reduced = ReducedModel::new(vessel, resists, &Baseline::default(), effects, record.interval_s);
    let (port, view) = (reduced.port, reduced.view);
    let observation_model = ObservationModel::new(known.radius_m, known.fill_m, &reduced);
    let shift = lag_s + port.delay_s + view.latency_s;
    let (dt, frames) = (record.interval_s, record.frames());
    let samples: Vec<(f64, f64)> = (0..=4 * (frames + 60))
        .map(|n| 0.25 * f64::from(n as u32) * dt)
        .map(|t| (t, port.gain * record.drive.at(t - shift).3))
        .collect();
    let motion = Motion::sampled(&samples)
        .ok_or_else(|| format!("{}: its motion cannot be joined to a curve", record.name))?;
    let glass = Glass {
        radius_m: known.radius_m,
        fill_m: known.fill_m,
        rim_m: known.fill_m + ROOM_M,
        wall: WallShape::UPRIGHT,
    };
    let liquid = Liquid {
        name: "as stated".into(),
        density_kg_m3: known.density_kg_m3,
        rheology: Rheology::newtonian(known.viscosity_pa_s),
        effects: Effects::default(),
    };
    let setup = Setup {
        glass,
        liquid,
        spacing_m: resolution.spacing_m,
        seed: resolution.seed,
        no_slip: true,
        effects: inside,
        step_s: None,
    };
    let recordings = record_surfaces(&setup, &[(motion, frames, String::new())])
        .map_err(|error| format!("{}: {error}", record.name))?;
    let recording = recordings.first().ok_or("nothing was recorded")?;
    let mut out: Vec<Vec<f64>> = record.channels.iter().map(|_| Vec::with_capacity(frames)).collect();
    for frame in 0..frames {
        let mut surface = [0.0; POINTS];
        surface.copy_from_slice(recording.profile(frame));
        let surface = observation_model.to_measured(&surface);
        let height = |i: usize| f64::from(surface[i]) - known.fill_m;
        let [level, slope, bow, _] =
            parts((0..POINTS).map(|i| (i, height(i)))).ok_or("the surface was not found")?;
        let highest = (0..POINTS).map(height).fold(f64::NEG_INFINITY, f64::max);
        for (series, channel) in out.iter_mut().zip(&record.channels) {
            series.push(match channel.quantity {
                Quantity::Level => level,
                Quantity::Slope => slope,
                Quantity::Bow => bow,
                Quantity::Place => view.scale * port.gain * record.drive.at(frame as f64 * dt - shift).3,
                Quantity::Peak => highest,
            });
        }
    }
    Ok(out)
}
