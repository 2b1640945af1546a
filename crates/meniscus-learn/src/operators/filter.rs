//! A filter of constant gain, x+ = x- + G (y - x-), x- predicted by the exact GENERIC step, y read by the
//! encoder: linear regression of the true innovation on the seen one, in closed loop. A correction learns through it
//! ([`crate::correct`]); the camera side has a gain of its own in every turn (`runtime::filter`).

use crate::TrainError;
use crate::data::trajectory::Track;
use crate::hyperparameters::FilterParameters;
use crate::operators::reference_step::{Dynamics, Square};
use meniscus::latent::generic::Latent;
use meniscus::units::FRAME_INTERVAL_S;

/// Prediction and estimate at every frame of `track`, from rest.
#[must_use]
pub(crate) fn run(dynamics: &Dynamics, gain: &Square, track: &Track) -> Vec<(Latent, Latent)> {
    let next = |x: &mut Latent, (y, &u): (&Latent, &f64)| {
        let predicted = dynamics.turn(x, u).x;
        *x = predicted + gain * (y - predicted);
        Some((predicted, *x))
    };
    track.y.iter().zip(&track.u).scan(Latent::zeros(), next).collect()
}

/// The gain that regression settles on: G = <(x - x-)(y - x-)^T> <(y - x-)(y - x-)^T>^-1.
///
/// It starts from the encoder alone (G = 1) and goes half the way in each round; of all rounds the one
/// whose estimates are best in `metric` stays, so that the filter is never worse than the encoder.
///
/// # Errors
/// [`TrainError::Singular`] when the innovations span nothing.
pub(crate) fn tune(
    dynamics: &Dynamics,
    tracks: &[Track],
    metric: &Square,
    parameters: &FilterParameters,
) -> Result<Square, TrainError> {
    let active = active(tracks);
    let (mut gain, mut best, mut least) = (active, active, f64::INFINITY);
    for _ in 0..=parameters.rounds {
        let (mut cross, mut spread, mut error) = (Square::zeros(), Square::zeros(), 0.0);
        for track in tracks {
            let states = run(dynamics, &gain, track);
            for ((y, truth), (predicted, x)) in track.y.iter().zip(&track.truth).zip(states) {
                let (seen, due) = (y - predicted, truth - predicted);
                cross += due * seen.transpose();
                spread += seen * seen.transpose();
                error += (metric * (x - truth)).norm_squared();
            }
        }
        if error < least {
            (best, least) = (gain, error);
        }
        let ridge = Square::identity() * (1e-3 * spread.trace() / spread.nrows() as f64);
        let inverse = (spread + ridge).try_inverse().ok_or(TrainError::Singular("the filter's gain"))?;
        let next = active * (cross * inverse) * active;
        gain = settle(dynamics, (gain + next) * 0.5);
    }
    Ok(best)
}

/// One on the diagonal for every latent that ever moves, zero for a silent one: what the encoder says of
/// it is noise, and the dynamics have never been there.
fn active(tracks: &[Track]) -> Square {
    let mut size = Latent::zeros();
    let truths = tracks.iter().flat_map(|track| &track.truth);
    truths.for_each(|x| size += x.component_mul(x));
    let most = size.max();
    Square::from_diagonal(&size.map(|s| if s > 1e-12 * most { 1.0 } else { 0.0 }))
}

/// Moves the gain towards 1, where the loop forgets at once, until the loop (1 - G) A about rest is stable.
pub(crate) fn settle(dynamics: &Dynamics, gain: Square) -> Square {
    let half = dynamics.flow() * dynamics.stiffness() * (0.5 * FRAME_INTERVAL_S);
    let identity = Square::identity();
    let a = (identity - half).try_inverse().map_or(identity, |inverse| inverse * (identity + half));
    let blends = (0..=20).map(|k| gain + (identity - gain) * (0.05 * f64::from(k)));
    let stable = |g: &Square| ((identity - g) * a).complex_eigenvalues().iter().all(|l| l.norm() < 0.9995);
    let mut blends = blends.skip_while(|g| !stable(g));
    blends.next().unwrap_or(identity)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::networks::noise::normal;
    use crate::operators::reference_step::tests::random;
    use meniscus::latent::generic::LATENTS;

    /// With noise of one size on y and on the port, the filter beats both the encoder and the model.
    #[test]
    fn filter_beats_what_it_is_made_of() {
        let (dynamics, mut rng) = random(21);
        let ports: Vec<f64> = (0..400).map(|_| normal(&mut rng)).collect();
        let truth = dynamics.roll_out(Latent::zeros(), &ports);
        let noise = 0.3 * truth.iter().map(|x| x.norm()).sum::<f64>() / (truth.len() * LATENTS) as f64;
        let y: Vec<Latent> =
            truth.iter().map(|x| x + Latent::from_fn(|_, _| 4.0 * noise * normal(&mut rng))).collect();
        let u = ports.iter().map(|u| u + 0.3 * normal(&mut rng)).collect();
        let track = Track { y, u, port: Vec::new(), truth };
        let gain =
            tune(&dynamics, std::slice::from_ref(&track), &Square::identity(), &FilterParameters::default())
                .expect("a determined gain");
        let error = |g: &Square| {
            let states = run(&dynamics, g, &track);
            states.iter().zip(&track.truth).map(|((_, x), t)| (x - t).norm_squared()).sum::<f64>()
        };
        let tuned = error(&gain);
        assert!(tuned < error(&Square::identity()), "better than the encoder alone");
        assert!(tuned < error(&Square::zeros()), "better than the model alone");
    }

    #[test]
    fn an_unstable_gain_is_pulled_back() {
        let (dynamics, _) = random(22);
        let gain = settle(&dynamics, Square::identity() * -3.0);
        let track = Track {
            y: vec![Latent::repeat(0.1); 200],
            u: vec![0.0; 200],
            port: Vec::new(),
            truth: Vec::new(),
        };
        let last = run(&dynamics, &gain, &track).pop().expect("two hundred frames").1;
        assert!(last.norm() < 10.0, "{}", last.norm());
    }
}
