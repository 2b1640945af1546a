//! Interface of a model that is sized: parameters and a packing in, channels of all recordings out.

use super::error::SizingError;
use super::projection::Series;

/// Parameters and packing of a simulation of all recordings.
#[derive(Clone, Debug, PartialEq)]
pub struct Point {
    /// Size first, then the other parameters.
    pub parameters: Vec<f64>,
    /// Packing, from 0.
    pub packing: usize,
}

impl Point {
    /// Returns the point halfway to `other`, in the packing of `other`.
    #[must_use]
    pub fn halfway(&self, other: &Self) -> Self {
        let pairs = self.parameters.iter().zip(&other.parameters);
        Self { parameters: pairs.map(|(a, b)| 0.5 * (a + b)).collect(), packing: other.packing }
    }
}

/// Simulated recordings.
#[derive(Clone, Debug)]
pub struct Simulated {
    /// Channels of each recording, the control variate added.
    pub recordings: Vec<Series>,
    /// Control variate of each recording: measured less simulated reference, where there is one.
    pub control: Vec<Option<Series>>,
}

/// Model that is sized.
pub trait Forward {
    /// Returns what each of `points` simulates, or why it could not.
    ///
    /// # Errors
    /// [`SizingError`], when the work ends early.
    fn run(&self, points: &[Point]) -> Result<Vec<Result<Simulated, String>>, SizingError>;
}
