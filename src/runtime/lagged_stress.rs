//! One-step smoothing of sigma: a frame puts the stresses of the one before it right.
//!
//! The position of the glass gives its acceleration a frame late (three positions make a second difference), and the inertial part
//! of sigma follows the acceleration at once. A user who can wait for a frame has half of the error:
//! ```text
//! sigma(t - dt) = decode(x(t - dt), u(t - dt) as the frame at t tells it)
//! ```
//! With a camera alone sigma of the shipped recording has an error of 19 %, a frame late of 9 % (`meniscus run --patient`).
//! Where an IMU or a robot's command reports the acceleration there is nothing to wait for.

use super::estimate::Estimate;
use crate::blob::{FieldGroup, Model};
use crate::latent::decoder::{STRESS_GROUP, Selection};

/// Sigma of the frame of `before`, Pa, three numbers a tracer, from the estimate `now` of the next frame; gives how many
/// numbers of `out` were written: none where the model does not know sigma.
///
/// ```
/// # #[repr(align(64))]
/// # struct Aligned<T: ?Sized>(T);
/// # static BLOB: &Aligned<[u8]> =
/// #     &Aligned(*include_bytes!(concat!(env!("CARGO_MANIFEST_DIR"), "/models/glycerine.blob")));
/// # struct NoClock;
/// # impl meniscus::runtime::Clock for NoClock {
/// #     fn now_us(&mut self) -> u64 {
/// #         0
/// #     }
/// # }
/// let model = meniscus::blob::Model::load(&BLOB.0)?;
/// use meniscus::runtime::{Estimator, InputSource, Memory, TurnInput, smoothed_stress};
///
/// let (estimator, mut memory) = (Estimator::new(&model), Memory::default());
/// let mut turn = |before: f64, now: f64| {
///     let source = InputSource::Measured { before, now };
///     estimator.turn(&mut memory, TurnInput { source, ..TurnInput::default() }, &mut NoClock, &mut [])
/// };
/// let (first, second) = (turn(0.0, 0.0), turn(1.0, 1.0));
/// // Three normal stresses a tracer, from the acceleration that the next turn reports.
/// let mut sigma_pa = vec![0.0; 3 * model.header.particles as usize];
/// assert_eq!(smoothed_stress(&model, &first, &second, &mut sigma_pa), sigma_pa.len());
/// let mut unaccelerated_pa = sigma_pa.clone();
/// smoothed_stress(&model, &first, &first, &mut unaccelerated_pa);
/// assert_ne!(sigma_pa, unaccelerated_pa);
/// # Ok::<(), meniscus::blob::LoadError>(())
/// ```
pub fn smoothed_stress(model: &Model<'_>, before: &Estimate, now: &Estimate, out: &mut [f32]) -> usize {
    if !model.header.known().contains(FieldGroup::NormalStress) {
        return 0;
    }
    let latent = before.latent.map(|x| x as f32);
    let port = now.acceleration_m_s2 / model.header.acceleration_scale;
    let coefficients = model.decoder.coefficients(&latent, port);
    model.decoder.part(Selection::NONE.with(STRESS_GROUP), &coefficients, before.heat_j as f32, out)
}
