//! The books of one step: what the port did, what became heat, what is left over.

use serde::{Deserialize, Serialize};

/// Outcome of the closed step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum StepOutcome {
    /// The implicit equation was solved to its tolerance.
    #[default]
    Solved,
    /// The iterations ran out; the laws hold, the step is less accurate.
    Unconverged,
    /// The iterations ended where energy would have risen: shortened until it does not.
    Backtracked,
    /// Nothing finite came out: the latent stays where it was.
    Held,
}

/// The books of one step, in units of H (multiply by the blob's energy scale for joules).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Audit {
    /// Work of the moving glass through the port.
    pub work: f64,
    /// Heat: H lost by the closed step. Never negative; equals the entropy produced, as S = s.
    pub heat: f64,
    /// dE - work: rounding, and nothing else.
    pub energy_residual: f64,
    /// Iterations of the implicit equation.
    pub iterations: u32,
    /// Outcome of the closed step.
    pub outcome: StepOutcome,
}
