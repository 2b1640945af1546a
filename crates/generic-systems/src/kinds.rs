//! Kinds of the variables of a state: points, momenta, entropies, plain ones.

use super::dataset::Dataset;
use nalgebra::DVector;

/// Kinds of the variables of a state; numbers count from zero. All empty: plain variables, of unknown entropy.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Kinds {
    /// Coordinates of every point.
    pub points: Vec<Vec<usize>>,
    /// Its momentum, in the same order.
    pub momenta: Vec<Vec<usize>>,
    /// Variables whose sum is the entropy of the whole.
    pub entropies: Vec<usize>,
}

impl Kinds {
    /// Returns the fault of the kinds for states of `n` variables, if there is one.
    #[must_use]
    pub fn fault(&self, n: usize) -> Option<String> {
        let all: Vec<usize> =
            (self.points.iter().chain(&self.momenta).flatten().chain(&self.entropies)).copied().collect();
        if let Some(k) = all.iter().find(|&&k| k >= n) {
            return Some(format!("variable {} of {n}", k + 1));
        }
        if let Some(at) = (0..all.len()).find(|&i| all[..i].contains(&all[i])) {
            return Some(format!("variable {} has two kinds", all[at] + 1));
        }
        let width = self.points.first().map_or(0, Vec::len);
        if self.points.iter().any(|q| q.len() != width) {
            return Some("points of different dimensions".into());
        }
        let same = |p: &Vec<Vec<usize>>| p.len() == self.points.len() && p.iter().all(|p| p.len() == width);
        (!self.momenta.is_empty() && !same(&self.momenta))
            .then(|| "every point needs its momentum, of as many coordinates".into())
    }

    /// Returns the conflict of the kinds with the L of `data`, if there is one: reversible motion makes no entropy.
    #[must_use]
    pub fn clash(&self, data: &Dataset) -> Option<String> {
        let c = DVector::from_fn(data.variables(), |i, _| f64::from(u8::from(self.entropies.contains(&i))));
        let moved = data.skew.as_ref().map_or(0.0, |l| (l * c).amax());
        (moved > 1e-9).then(|| format!("array 'L' moves the sum of the entropies, by {moved}"))
    }
}
