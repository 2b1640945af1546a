//! Points that were simulated, and the emulator through them.

use super::emulator::{Emulator, Node, Prior};
use super::forward::{Point, Simulated};
use super::projection::{Observed, Projection, Series};
use nalgebra::DVector;
use std::ops::Range;

/// Simulated point.
#[derive(Clone, Debug)]
pub struct Tried {
    /// Point.
    pub point: Point,
    /// Its simulation.
    pub simulated: Simulated,
}

/// Derivative of all recordings by a parameter.
pub type Slope = Vec<Series>;

/// Emulator with the maps that it was made by.
#[derive(Clone, Debug)]
pub struct MappedEmulator {
    /// Emulator.
    pub emulator: Emulator,
    /// Map of each recording.
    pub projections: Vec<Projection>,
}

impl MappedEmulator {
    /// Returns the emulator through the points of `tried`, of sizes that differ, with the derivatives `slopes`; nuisances are
    /// projected out by the simulation of `like`, whose other parameters are the origin.
    #[must_use]
    pub fn new(
        observed: &[Observed],
        tried: &[&Tried],
        like: &Tried,
        slopes: &[Slope],
        priors: &[Prior],
    ) -> Self {
        let projections: Vec<Projection> = observed
            .iter()
            .zip(like.simulated.recordings.iter().zip(&like.simulated.control))
            .map(|(observed, (series, control))| Projection::new(observed, series, control.as_ref()))
            .collect();
        let mut recordings: Vec<Range<usize>> = Vec::new();
        for projection in &projections {
            let first = recordings.last().map_or(0, |range| range.end);
            recordings.push(first..first + projection.len());
        }
        let mut out = Self {
            emulator: Emulator {
                data: DVector::zeros(0),
                recordings,
                nodes: Vec::new(),
                slopes: Vec::new(),
                origin: like.point.parameters[1..].to_vec(),
                priors: priors.to_vec(),
            },
            projections,
        };
        let data: Vec<DVector<f64>> = out.projections.iter().map(Projection::data).collect();
        out.emulator.data = joined(&data);
        out.emulator.slopes = slopes.iter().map(|slope| out.reduce(slope)).collect();
        let mut nodes: Vec<Node> = tried
            .iter()
            .map(|tried| Node { size: tried.point.parameters[0], numbers: out.at_origin(tried) })
            .collect();
        nodes.sort_by(|a, b| a.size.total_cmp(&b.size));
        out.emulator.nodes = nodes;
        out
    }

    /// Returns the numbers of all `recordings`, nuisances projected out.
    #[must_use]
    pub fn reduce(&self, recordings: &[Series]) -> DVector<f64> {
        let each =
            self.projections.iter().zip(recordings).map(|(projection, series)| projection.reduce(series));
        joined(&each.collect::<Vec<_>>())
    }

    /// Returns the numbers of `tried`, moved to the origin of the other parameters by their derivatives.
    #[must_use]
    pub fn at_origin(&self, tried: &Tried) -> DVector<f64> {
        let mut numbers = self.reduce(&tried.simulated.recordings);
        let others = tried.point.parameters[1..].iter().zip(&self.emulator.origin);
        for (slope, (value, origin)) in self.emulator.slopes.iter().zip(others) {
            numbers.axpy(origin - value, slope, 1.0);
        }
        numbers
    }

    /// Returns the numbers of each channel of each recording.
    #[must_use]
    pub fn channels(&self) -> Vec<Range<usize>> {
        let pairs = self.projections.iter().zip(&self.emulator.recordings);
        pairs.flat_map(|(projection, range)| projection.channels(range.start).collect::<Vec<_>>()).collect()
    }

    /// Returns how many numbers were measured.
    #[must_use]
    pub fn measured(&self) -> usize {
        self.projections.iter().map(Projection::measured).sum()
    }
}

/// Returns the derivative between two simulations that differ by `step` in one parameter.
#[must_use]
pub fn slope(from: &Simulated, to: &Simulated, step: f64) -> Slope {
    let series = |from: &Vec<f64>, to: &Vec<f64>| from.iter().zip(to).map(|(a, b)| (b - a) / step).collect();
    let channels = |from: &Series, to: &Series| from.iter().zip(to).map(|(a, b)| series(a, b)).collect();
    from.recordings.iter().zip(&to.recordings).map(|(a, b)| channels(a, b)).collect()
}

fn joined(parts: &[DVector<f64>]) -> DVector<f64> {
    let count = parts.iter().map(DVector::len).sum();
    DVector::from_iterator(count, parts.iter().flat_map(|part| part.iter().copied()))
}
