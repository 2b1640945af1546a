//! The camera side at work on a recording: the blob is loaded and turned frame by frame.

use meniscus::blob::Model;
use meniscus::latent::generic::LATENTS;
use meniscus::runtime::{Clock, Estimator, Memory, TurnInput};
use meniscus::surface::{POINTS, SurfaceProfile};
use meniscus::units::Micros;
use meniscus_data::recording::Recording;

/// No time passes.
struct Still;

impl Clock for Still {
    fn now_us(&mut self) -> u64 {
        0
    }
}

/// Figures of one recording.
pub(crate) struct Watched {
    /// |z - zhat| / |z - z_rest| over points and time.
    pub(crate) slosh_rel: f64,
    /// Distance of the decoded rest from the recording's, m.
    pub(crate) at_rest_m: f64,
    /// Heat at the end, J.
    pub(crate) heat_j: f64,
    /// Turns of the implicit step that did not converge.
    pub(crate) unconverged: u64,
}

/// Runs `blob` over the noiseless profiles of `recording`.
pub(crate) fn watch(blob: &[u8], recording: &Recording) -> Watched {
    // The weights are read in place, so the blob must be aligned as it is in flash.
    let mut room = vec![0_u8; blob.len() + 64];
    let skip = room.as_ptr().align_offset(64);
    room[skip..skip + blob.len()].copy_from_slice(blob);
    let model = Model::load(&room[skip..skip + blob.len()]).expect("a blob that the camera side accepts");

    let rest = model.decoder.surface(&model.decoder.coefficients(&[0.0; LATENTS], 0.0));
    let off = rest.iter().zip(recording.profile(0)).map(|(a, b)| f64::from(a - b).abs()).fold(0.0, f64::max);
    let estimator = Estimator::new(&model);
    let mut memory = Memory::default();
    let (mut miss, mut size, mut heat_j) = (0.0, 0.0, 0.0);
    for frame in 0..recording.frames() {
        let truth = recording.profile(frame);
        let profile = SurfaceProfile {
            height_m: truth.try_into().expect("21 points"),
            variance_m2: [1e-8; POINTS],
            valid: [true; POINTS],
            glass_x_m: Some(recording.glass_x_m[frame] as f32),
            sequence: frame as u32,
            captured: Micros(frame as u64 * 16_667),
        };
        let estimate = estimator.turn(&mut memory, TurnInput::tracked(&profile), &mut Still, &mut []);
        for ((z, said), z0) in truth.iter().zip(estimate.surface_m).zip(recording.profile(0)) {
            miss += f64::from(z - said).powi(2);
            size += f64::from(z - z0).powi(2);
        }
        heat_j = estimate.heat_j;
    }
    Watched {
        slosh_rel: (miss / size).sqrt(),
        at_rest_m: off,
        heat_j,
        unconverged: memory.health.step_unconverged,
    }
}
