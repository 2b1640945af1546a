//! One GENERIC step: energy kept exactly, entropy never falling, for every weight blob.
//!
//! State: latent x (N numbers, zero at rest) and heat s. With energy E(x, s) = H(x) + s, entropy
//! S = s, L skew and D = C C^T >= 0, the full operators are degenerate by construction:
//!
//! ```text
//! L_full = [ L  0 ]      M_full = [  D          -D grad H          ]      x' = (L - D) grad H + B u
//!          [ 0  0 ]               [ -grad H^T D  grad H^T D grad H ]      s' = grad H^T D grad H >= 0
//! ```
//! so L_full grad S = 0 and M_full grad E = 0 identically. A moved glass is not closed: the port B u
//! (u the acceleration of the glass) does the work dE = B u . grad H dt.
//!
//! Where the viscosity depends on the rate of shear, D is phi D with a number phi > 0 of [`FrictionLaw`], and all of this holds.
//!
//! Grmela and Öttinger, Phys. Rev. E 56 (1997) 6620; the discrete gradient is the mean value
//! of Harten, Lax and van Leer, SIAM Rev. 25 (1983) 35, which has a closed form for this H.

mod audit;
mod flow;
mod friction_law;
mod newton;
mod operators;
mod potential;
mod slots;
mod step;
mod step_jacobian;

pub use audit::{Audit, StepOutcome};
pub use friction_law::{FrictionLaw, LAW_NUMBERS};
pub use operators::Operators;
pub use potential::{MAX_HIDDEN, Potential, RidgeState};
pub use slots::{MEMORIES, ModeMap, Slots};
pub use step::{Generic, LatentState};
pub use step_jacobian::StepJacobian;

/// Latent variables (paper: 13).
pub const LATENTS: usize = 13;

/// A point or direction in latent space.
pub type Latent = LatentOf<f64>;

/// Latent state in the precision of a stage.
pub type LatentOf<R> = nalgebra::SVector<R, LATENTS>;
