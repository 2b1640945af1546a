//! Identification of the liquid: known liquids predict the same slosh, and the one with the best prediction is in the
//! glass.
//!
//! ```text
//! profile z --> slope s, position X of the glass
//! each known liquid k:  its own first mode, driven by X alone  -->  f_k      (a weak pull of 3 % a frame towards s)
//! q_k = (s - f_k)^2 / S_k,    S_k = var s + a_k^2 (A_r^2 + <A_k^2>)
//! ```
//! Decay and frequency distinguish liquids, and they show only in a prediction: a filter that reads the surface follows
//! any liquid. The trained models read it in every turn. Half a second without a reading those of low-viscosity liquids
//! have a slosh-relative error of more than 50 % (`docs/recognition.md`), so that water and butter are the same to them. One
//! oscillator with six numbers of its own has one of 5 to 10 % over whole recordings.
//!
//! | file | what |
//! |---|---|
//! | `oscillation` | the first mode of a liquid: six numbers, one step |
//! | `slope` | from a profile to the slope |
//! | `known_liquid` | a known liquid on a glass, and several of them |
//! | `evidence` | sums of the residuals of each liquid, and their calibration |
//! | `posterior` | from sums to probabilities, `none of these` among them |

mod evidence;
mod known_liquid;
mod oscillation;
mod posterior;
mod slope;

pub use evidence::{Calibration, Evidence, FrameResidual};
pub use known_liquid::{KnownLiquid, Recogniser, SETTLING_FRAMES, Trail};
pub use oscillation::{Change, Swing, Tone};
pub use posterior::{Verdict, posterior};
pub use slope::{Slope, slope};
