//! A figure of the simulator held against theory.

/// A measured figure beside that of theory.
#[derive(Clone, Debug, PartialEq)]
pub struct Held {
    /// Name of the measured figure.
    pub what: &'static str,
    /// The measured value.
    pub measured: f64,
    /// Value of the theory.
    pub theory: f64,
}

impl Held {
    /// Deviation from theory, per cent of it.
    #[must_use]
    pub fn error(&self) -> f64 {
        100.0 * (self.measured / self.theory - 1.0)
    }
}
