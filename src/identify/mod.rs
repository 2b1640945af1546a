//! Which liquid is it: liquids that were seen before foretell the same slosh, and the one that does it best is in the
//! glass.
//!
//! ```text
//! profile z --> slope s, place X of the glass
//! each known liquid k:  its own first mode, driven by X alone  -->  f_k      (a weak pull of 3 % a frame towards s)
//! q_k = (s - f_k)^2 / S_k,    S_k = var s + a_k^2 (A_r^2 + <A_k^2>)
//! ```
//! What tells liquids apart is decay and frequency, and they show only where nothing is read: a filter that reads the
//! surface follows any liquid. The trained models read it in every turn, and half a second without a reading those of
//! thin liquids miss by more than half of the slosh (`docs/recognition.md`), so that water and butter are the same to
//! them. One oscillator with six numbers of its own misses by 5 to 10 % over whole recordings.
//!
//! | file | what |
//! |---|---|
//! | `tone` | the first mode of a liquid: six numbers, one step |
//! | `sight` | from a profile to the slope |
//! | `known` | a known liquid on a glass, and several of them |
//! | `evidence` | what is summed of what each misses, and what a calibration says |
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
