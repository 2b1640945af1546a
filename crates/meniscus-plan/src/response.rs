//! Linear response of the surface: from jerks to inputs of the liquid, and from inputs to heights at both ends of the wall.
//!
//! ```text
//! u_k = (x_k - 2 x_(k-1) + x_(k-2)) / dt^2   or   (v_k - v_(k-1)) / dt          by what the model takes
//! h_k = d_k + sum_(l <= k) g_(k-l) u_l        g_k = [ h_k(1, 0, 0, ...) - h_k(-1, 0, 0, ...) ] / 2 about rest
//! ```

use crate::course::{GlassState, basis};
use crate::models::{FrameInput, SurfaceModel};
use meniscus::units::FRAME_INTERVAL_S;

/// The two ends of the wall, s = -1 and s = 1.
pub(crate) const ENDS: usize = 2;

/// Impulse response of both ends, m for 1 m/s2 in one frame.
#[derive(Clone, Debug)]
pub(crate) struct Response(Vec<[f64; ENDS]>);

impl Response {
    /// The response of `model` over so many frames.
    pub(crate) fn of<M: SurfaceModel>(model: &M, frames: usize) -> Self {
        let kicked = |kick: f64| {
            let mut inputs = vec![0.0; frames];
            inputs.iter_mut().take(1).for_each(|input| *input = kick);
            model.forecast(&model.rest(), &inputs)
        };
        let (up, down) = (kicked(1.0), kicked(-1.0));
        let half = |(up, down): (&[f64; ENDS], &[f64; ENDS])| [0, 1].map(|end| 0.5 * (up[end] - down[end]));
        Self(up.iter().zip(&down).map(|(up, down)| half((&up.ends_m(), &down.ends_m()))).collect())
    }

    /// Heights at both ends under `inputs`, m.
    pub(crate) fn heights(&self, inputs: &[f64]) -> Vec<[f64; ENDS]> {
        let mut out = vec![[0.0; ENDS]; inputs.len()];
        for (l, input) in inputs.iter().enumerate().filter(|(_, input)| **input != 0.0) {
            for (height, g) in out[l..].iter_mut().zip(&self.0) {
                height.iter_mut().zip(g).for_each(|(h, g)| *h += g * input);
            }
        }
        out
    }
}

/// A glass at the start of a plan.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Departure {
    /// Now.
    pub(crate) glass: GlassState,
    /// Position one frame ago, m.
    pub(crate) before_m: f64,
}

/// Returns the inputs of `frames` frames of a motion, which gives the glass at a time since its start. The times rise.
pub(crate) fn inputs_of(
    kind: FrameInput,
    before_m: f64,
    frames: usize,
    mut motion: impl FnMut(f64) -> GlassState,
) -> Vec<f64> {
    let dt = FRAME_INTERVAL_S;
    let mut last = motion(0.0);
    let mut older_m = before_m;
    (1..=frames)
        .map(|frame| {
            let now = motion(frame as f64 * dt);
            let input = match kind {
                FrameInput::Mean => (now.speed_m_s - last.speed_m_s) / dt,
                FrameInput::SecondDifference => {
                    (now.position_m - 2.0 * last.position_m + older_m) / (dt * dt)
                }
            };
            (older_m, last) = (last.position_m, now);
            input
        })
        .collect()
}

/// Returns the inputs of `frames` frames by a jerk of unity behind knot `index`, for knots `knot_s` apart.
pub(crate) fn unit_inputs(kind: FrameInput, index: usize, knot_s: f64, frames: usize) -> Vec<f64> {
    inputs_of(kind, 0.0, frames, |time_s| {
        let part = basis(index, knot_s, time_s);
        GlassState { position_m: part.position, speed_m_s: part.speed, acceleration_m_s2: part.acceleration }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::models::Pendulum;

    /// The convolution is the model itself, stepped.
    #[test]
    fn a_linear_model_is_its_response() {
        let pendulum = Pendulum { frequency: 22.0, damping: 0.1, radius_m: 0.035, room_m: 0.04 };
        let inputs: Vec<f64> = (0..40).map(|k| (0.7 * f64::from(k)).sin()).collect();
        let heights = Response::of(&pendulum, 40).heights(&inputs);
        for (height, stepped) in heights.iter().zip(pendulum.forecast(&[0.0; 2], &inputs)) {
            assert!((height[1] - stepped.ends_m()[1]).abs() < 1e-12);
        }
    }

    /// A steady acceleration is the input of both kinds.
    #[test]
    fn a_steady_acceleration_is_its_own_input() {
        let start = GlassState { position_m: 0.2, speed_m_s: 0.1, acceleration_m_s2: 1.5 };
        for kind in [FrameInput::Mean, FrameInput::SecondDifference] {
            let before_m = start.drifted(-FRAME_INTERVAL_S).position_m;
            let inputs = inputs_of(kind, before_m, 5, |time_s| start.drifted(time_s));
            assert!(inputs.iter().all(|u| (u - 1.5).abs() < 1e-9), "{kind:?} {inputs:?}");
        }
    }
}
