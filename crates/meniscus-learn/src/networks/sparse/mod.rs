//! Sparse autoencoders of the paper, for comparison: five, one a field group, cut down to thirteen latents in all.
//!
//! ```text
//! x = E(z), z^ = D(x)      perceptrons of the paper's depths and widths, linear at the ends, ReLU between
//! loss = <|z^ - z|^2> / <|z|^2> + lambda <|x|_1>        lambda = 0.003 (the paper: 0.001 to 0.005)
//! ```
//! z are the POD coefficients of the group: the basis folds into the linear outer layers, so that nothing but what
//! the decomposition leaves out is lost. The surface, which the paper reads off the positions, goes with
//! them and counts for as much.
//!
//! Which latents stay is decided by the data. Those of a group are ordered by the error of holding them at their
//! mean; then the thirteen are given out one by one, each to the group whose relative error it lowers most
//! (Nemhauser, Wolsey and Fisher 1978 on why greed does well). What stays is trained on without the penalty.

mod energy;
mod net;

use crate::data::dataset::{Frame, Sequence};
use crate::data::errors::{GroupErrors, percent};
use crate::data::groups::SURFACE;
use crate::hyperparameters::{Hyperparameters, SparseParameters};
use crate::stage::{StageRun, TrainingSplit};
use energy::Energy;
use meniscus::latent::generic::LATENTS;
use meniscus_data::recording::Recording;
use meniscus_optim::seed::derive_seed;
use meniscus_report::checks::Check;
use net::{Net, NetShape, Rows};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

/// The paper's five.
static PAPER: [NetShape; 5] = [
    NetShape { name: "q", trunk: Some(0), hidden_width: 120, hidden_layers: 2, bottleneck: 20 },
    NetShape { name: "v", trunk: Some(1), hidden_width: 200, hidden_layers: 4, bottleneck: 20 },
    NetShape { name: "e", trunk: None, hidden_width: 40, hidden_layers: 3, bottleneck: 10 },
    NetShape { name: "sigma", trunk: Some(2), hidden_width: 200, hidden_layers: 3, bottleneck: 20 },
    NetShape { name: "tau", trunk: Some(3), hidden_width: 200, hidden_layers: 3, bottleneck: 20 },
];

/// The five.
pub(crate) struct Sparse {
    nets: Vec<Net>,
    /// Latents of each that were in use before any were cut off.
    active: Vec<usize>,
    energy: Energy,
}

/// Number of latents that each group gets of `all`, by the curves of their errors: one by one to where the error falls
/// most a latent, over as many latents as that takes.
fn given_out(curves: &[Vec<f64>], all: usize) -> Vec<usize> {
    let mut given = vec![0; curves.len()];
    loop {
        let left = all - given.iter().sum::<usize>();
        let mut steps = Vec::new();
        for (group, curve) in curves.iter().enumerate() {
            let here: usize = given[group];
            for more in 1..=left.min(curve.len() - 1 - here) {
                steps.push(((curve[here] - curve[here + more]) / more as f64, group, more));
            }
        }
        let Some((_, group, more)) = steps.into_iter().max_by(|a, b| a.0.total_cmp(&b.0)) else {
            return given;
        };
        given[group] += more;
    }
}

/// A net with the rows that it is trained on and chosen by.
struct Trainee {
    shape: &'static NetShape,
    net: Net,
    training: Rows,
    validation: Rows,
}

impl Trainee {
    /// Trains the net in the stage `stage`.
    fn train(&mut self, stage: &str, l1_weight: f32, parameters: &SparseParameters, run: StageRun<'_>) {
        let data = TrainingSplit { training: &self.training, validation: &self.validation };
        self.net.train(stage, &data, l1_weight, parameters, run);
    }
}

/// Recordings and their projections, from which the rows of every net are taken.
pub(crate) struct SparseData<'a> {
    /// Bases and scales.
    pub(crate) frame: &'a Frame,
    /// Recordings, for the internal energy.
    pub(crate) recordings: TrainingSplit<'a, [Recording]>,
    /// Projected recordings, for every other group.
    pub(crate) sequences: TrainingSplit<'a, [Sequence]>,
}

impl Sparse {
    /// Trains all five, cuts them down to the latents of the joint one, and trains them on without the penalty.
    #[must_use]
    pub(crate) fn train(data: &SparseData<'_>, parameters: &Hyperparameters, run: StageRun<'_>) -> Self {
        let energy = Energy::new(data.recordings.training, &parameters.pod);
        let parameters = &parameters.sparse;
        let rows = |shape: &NetShape, recordings: &[Recording], sequences: &[Sequence]| match shape.trunk {
            Some(group) => trunk_rows(data.frame, group, sequences),
            None => energy.rows(recordings),
        };
        // Two threads inside of one net gain nothing; nets side by side do.
        let trained: Vec<Trainee> = std::thread::scope(|scope| {
            let one = |(i, shape): (usize, &'static NetShape)| {
                let training = rows(shape, data.recordings.training, data.sequences.training);
                let validation = rows(shape, data.recordings.validation, data.sequences.validation);
                scope.spawn(move || {
                    let seed = derive_seed(run.seed, i as u64);
                    let net = Net::fresh(shape, training.width, &mut ChaCha8Rng::seed_from_u64(seed));
                    let mut one = Trainee { shape, net, training, validation };
                    let stage = format!("sparse {}", shape.name);
                    one.train(&stage, parameters.l1_weight, parameters, StageRun { seed, ..run });
                    one
                })
            };
            let threads: Vec<_> = PAPER.iter().enumerate().map(one).collect();
            threads.into_iter().map(|thread| thread.join().expect("a net's thread ends")).collect()
        });
        let (cut, active) = cut_down(trained, parameters);
        let nets = std::thread::scope(|scope| {
            let one = |(i, mut one): (usize, Trainee)| {
                scope.spawn(move || {
                    let stage = format!("sparse {}, cut", one.shape.name);
                    let seed = derive_seed(run.seed, 16 + i as u64);
                    one.train(&stage, 0.0, parameters, StageRun { steps: run.steps / 2, seed, ..run });
                    one.net
                })
            };
            let threads: Vec<_> = cut.into_iter().enumerate().map(one).collect();
            threads.into_iter().map(|thread| thread.join().expect("a net's thread ends")).collect()
        });
        Self { nets, active, energy }
    }

    /// Errors of what the five decode from their thirteen latents on the validation recordings, and how many each
    /// group used and kept.
    #[must_use]
    pub(crate) fn checks(&self, frame: &Frame, validation: &[Recording], held: &[Sequence]) -> Vec<Check> {
        let (scale, ranges, width) = (frame.coefficient_scale(), frame.ranges(), frame.width());
        let mut errors = GroupErrors::default();
        for sequence in held {
            let mut coefficients = vec![0.0; sequence.frames() * width];
            for (shape, net) in PAPER.iter().zip(&self.nets) {
                let Some(group) = shape.trunk else { continue };
                let rows = trunk_rows(frame, group, std::slice::from_ref(sequence));
                let [again, _] = net.run(&rows);
                for (n, row) in again.chunks_exact(rows.width).enumerate() {
                    for (at, z) in columns(&ranges, group).zip(row) {
                        coefficients[n * width + at] = z * scale[at];
                    }
                }
            }
            errors.add(frame, sequence, 0, &coefficients, &sequence.port);
        }
        const STAGE: &str = "five sparse autoencoders";
        let mut checks = errors.checks(STAGE, [None; 5]);
        for (shape, net) in PAPER.iter().zip(&self.nets).filter(|(shape, _)| shape.trunk.is_none()) {
            let error = self.energy.error(net, validation);
            checks.push(percent(format!("{STAGE}: {}", shape.name), error, None));
        }
        for ((shape, net), active) in PAPER.iter().zip(&self.nets).zip(&self.active) {
            let name =
                |what: &str| format!("{STAGE}: latents of {} {what} of {}", shape.name, shape.bottleneck);
            checks.push(Check::informational(name("in use"), *active as f64, "1"));
            checks.push(Check::informational(name("kept"), f64::from(net.keep.iter().sum::<f32>()), "1"));
        }
        checks
    }
}

/// Holds all but [`LATENTS`] latents of `trained` at their means; returns with them how many each had in use before.
fn cut_down(mut trained: Vec<Trainee>, parameters: &SparseParameters) -> (Vec<Trainee>, Vec<usize>) {
    let (mut active, mut orders, mut curves) = (Vec::new(), Vec::new(), Vec::new());
    for Trainee { net, training, .. } in &mut trained {
        let deviation = net.measure(training);
        let most = deviation.iter().copied().fold(0.0, f32::max);
        active.push(deviation.iter().filter(|d| **d > parameters.silent_share * most).count());
        let (order, curve) = net.ordered(training);
        orders.push(order);
        curves.push(curve);
    }
    let given = given_out(&curves, LATENTS);
    for ((Trainee { net, .. }, order), count) in trained.iter_mut().zip(&orders).zip(given) {
        let kept = &order[..count];
        net.keep = (0..net.keep.len()).map(|l| f32::from(u8::from(kept.contains(&l)))).collect();
    }
    (trained, active)
}

/// The coefficients that go with trunk group `group`: the surface goes with the positions.
fn columns(ranges: &[std::ops::Range<usize>], group: usize) -> impl Iterator<Item = usize> + use<> {
    let surface = if group == 0 { ranges[SURFACE].clone() } else { 0..0 };
    ranges[group].clone().chain(surface)
}

/// Coefficients of one trunk group over its scale, row by row.
fn trunk_rows(frame: &Frame, group: usize, sequences: &[Sequence]) -> Rows {
    let (scale, ranges, width) = (frame.coefficient_scale(), frame.ranges(), frame.width());
    let rows = sequences.iter().flat_map(|s| s.coefficients.chunks_exact(width));
    let values =
        rows.flat_map(|row| columns(&ranges, group).map(|at| row[at] / scale[at]).collect::<Vec<_>>());
    Rows { values: values.collect(), width: columns(&ranges, group).count() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn latents_go_where_they_are_worth_most_and_a_pair_that_is_worth_much_is_not_missed() {
        // The second group gains only by its second latent.
        let curves = vec![vec![1.0, 0.5, 0.4, 0.39], vec![1.0, 1.0, 0.1, 0.1], vec![1.0, 0.9, 0.88]];
        assert_eq!(given_out(&curves, 4), [1, 2, 1]);
        assert_eq!(given_out(&curves, 1), [1, 0, 0]);
        assert_eq!(given_out(&curves, 8).iter().sum::<usize>(), 8);
    }
}
