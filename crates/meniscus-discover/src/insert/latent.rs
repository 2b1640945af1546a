//! Roll-out of a recording by the flashed model, from rest, with its motion and no measurement.

use crate::recordings::record::{Quantity, Record, parts};
use meniscus::blob::Model;
use meniscus::latent::generic::{LATENTS, LatentState};
use meniscus::surface::POINTS;

/// Returns each channel of `record` as `model` predicts it, m. `lag_s` is the delay of its frames against their times.
///
/// As in training, the port gets the acceleration from the positions of the glass in the last three frames, and the
/// decoder that of the instant.
///
/// # Errors
/// In words, when the recording is of another kind than the model has: other frames, an inclination or a vertical
/// motion, peaks instead of profiles.
pub fn roll_out(model: &Model<'_>, record: &Record, lag_s: f64) -> Result<Vec<Vec<f64>>, String> {
    let dt = model.header.dt_s;
    if (record.interval_s - dt).abs() > 0.01 * dt {
        return Err(format!(
            "{}: frames every {:.4} s, and the model steps by {dt:.4} s",
            record.name, record.interval_s
        ));
    }
    if record.drive.holds() != [false; 2] || !record.drive.is_planar() {
        return Err(format!(
            "{}: the glass is inclined, lifted or moved across, which the latents do not represent",
            record.name
        ));
    }
    if record.channels.iter().any(|channel| channel.quantity == Quantity::Peak) {
        return Err(format!("{}: heights of a peak, where the model gives profiles", record.name));
    }
    let gain = model.observation_model.as_ref().map_or(1.0, |observation_model| observation_model.gain);
    let place = |frame: f64| gain * record.drive.at(frame * dt - lag_s).3;
    let scale = dt * dt * f64::from(model.header.acceleration_scale);
    let acceleration =
        |middle: f64| (place(middle + 1.0) - 2.0 * place(middle) + place(middle - 1.0)) / scale;
    let mut state = LatentState::default();
    let mut out: Vec<Vec<f64>> =
        record.channels.iter().map(|_| Vec::with_capacity(record.frames())).collect();
    for frame in 0..record.frames() {
        let n = frame as f64;
        model.generic.step(&mut state, acceleration(n - 1.0));
        let latent: [f64; LATENTS] = state.latent.into();
        let coefficients = model.decoder.coefficients(&latent.map(|x| x as f32), acceleration(n) as f32);
        let surface = viewed(model, model.decoder.surface(&coefficients));
        let fill = model.header.fill_m;
        let [level, slope, bow, _] =
            parts(surface.iter().map(|z| f64::from(*z) - fill).enumerate()).unwrap_or([f64::NAN; 4]);
        for (series, channel) in out.iter_mut().zip(&record.channels) {
            series.push(match channel.quantity {
                Quantity::Level => level,
                Quantity::Slope => slope,
                Quantity::Bow => bow,
                Quantity::Place | Quantity::Peak => place(n),
            });
        }
    }
    Ok(out)
}

/// Returns a surface of the model with the effects of its camera.
fn viewed(model: &Model<'_>, mut surface: [f32; POINTS]) -> [f32; POINTS] {
    if let Some(observation_model) = &model.observation_model {
        observation_model.add_offset(&mut surface);
        surface = observation_model.to_measured(&surface);
    }
    surface
}
