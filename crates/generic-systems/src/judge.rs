//! Roll-outs of every net from the first state of each trajectory that judges, and what they do to the laws.

use super::dataset::Dataset;
use super::exact::Exact;
use super::kinds::Kinds;
use super::published::Published;
use super::scaling::Scaling;
use super::soft::Soft;
use burn::tensor::{Device, Tensor};
use meniscus_optim::laws::Laws;
use meniscus_optim::weights::{Matrix, constants, numbers};
use nalgebra::{DMatrix, DVector};

/// A net that is judged.
pub(super) enum Judged<'a> {
    Published(&'a Published),
    Exact(&'a Scaling, Box<Exact>),
    Soft(&'a Scaling, &'a Soft, Vec<Matrix>),
}

/// Figures of a net on the test trajectories.
#[derive(Clone, Debug)]
pub struct Figures {
    /// `published`, `soft` or `exact`.
    pub name: &'static str,
    /// Mean square error of each variable over all steps, the first included, in its unit squared.
    pub mse: Vec<f64>,
    /// |z - said| / |z - mean of z| of each variable that moves; NaN of one that does not.
    pub relative: Vec<f64>,
    /// The root mean square of `relative` over the variables that move.
    pub rollout: f64,
    /// The same at every step.
    pub over_time: Vec<f64>,
    /// The roll-outs, `[trajectory][step]`.
    pub paths: Vec<Vec<DVector<f64>>>,
    /// Steps rolled out.
    pub steps: u32,
    /// Steps whose entropy fell.
    pub falls: u32,
    /// Root mean squares of |dE . dz| / (|dE| |dz|), |L dS| / |L dE| and |M dE| / |M dS|.
    pub laws: [f64; 3],
    /// Steps along which the sum of the state's own entropies fell, where it says which these are.
    pub system_falls: Option<u32>,
    /// Steps that the exact net could not solve and did not take.
    pub held: u32,
    /// Of the exact net, the largest |E1 - E0| of a step over what a step passes around on average; NaN of others, which
    /// have no energy.
    pub drift: f64,
}

/// Energy balance of the exact net.
#[derive(Default)]
struct Books {
    /// Largest change of the energy of the whole in a step.
    rise: f64,
    /// Sum of |dE_i dz_i| over variables and steps.
    passed: f64,
    falls: u32,
    held: u32,
}

/// Steps of `paths` along which the sum of the entropies fell by more than the digits of the sum.
fn system_falls(kinds: &Kinds, paths: &[Vec<DVector<f64>>]) -> Option<u32> {
    let sum = |z: &DVector<f64>| kinds.entropies.iter().map(|&i| z[i]).sum::<f64>();
    let digits =
        |z: &DVector<f64>| 4.0 * f64::EPSILON * kinds.entropies.iter().map(|&i| z[i].abs()).sum::<f64>();
    let falls = |w: &[DVector<f64>]| sum(&w[1]) - sum(&w[0]) < -digits(&w[0]).max(digits(&w[1]));
    let count = paths.iter().flat_map(|path| path.windows(2)).filter(|w| falls(w)).count();
    (!kinds.entropies.is_empty()).then_some(count as u32)
}

impl Judged<'_> {
    fn name(&self) -> &'static str {
        match self {
            Self::Published(_) => "published",
            Self::Exact(..) => "exact",
            Self::Soft(..) => "soft",
        }
    }

    /// `count` states from `state` on; `laws` sees every step, and `books` what the exact net's energy did.
    fn roll(
        &self,
        state: &DVector<f64>,
        count: usize,
        laws: &mut Laws,
        books: &mut Books,
    ) -> Vec<DVector<f64>> {
        let slices = |e: &DVector<f64>, s: &DVector<f64>, dz: &DVector<f64>, laws: &mut Laws| {
            laws.step(e.as_slice(), s.as_slice(), dz.as_slice());
        };
        let said =
            |laws: &mut Laws, (l, m): (&DMatrix<f64>, &DMatrix<f64>), e: &DVector<f64>, s: &DVector<f64>| {
                laws.reversible((l * s).norm(), (l * e).norm());
                laws.irreversible((m * e).norm(), (m * s).norm());
            };
        let mut path = vec![state.clone()];
        match self {
            Self::Published(net) => {
                let mut z = net.inward(state);
                while path.len() < count {
                    let step = net.say(&z);
                    slices(&step.energy, &step.entropy, &(&step.next - &z), laws);
                    said(laws, (&net.skew, &net.friction), &step.energy, &step.entropy);
                    z = step.next;
                    path.push(net.outward(&z));
                }
            }
            Self::Soft(scaling, net, weights) => {
                let device = Device::flex();
                let tensors = constants(weights, &device);
                let vector =
                    |t: Tensor<2>| DVector::from_iterator(state.len(), numbers(t).into_iter().map(f64::from));
                let n = state.len();
                let matrix =
                    |t: Tensor<3>| DMatrix::from_row_iterator(n, n, numbers(t).into_iter().map(f64::from));
                let mut x = scaling.inward(state);
                while path.len() < count {
                    let row = Matrix::new(1, n, x.iter().map(|&v| v as f32).collect()).tensor(&device);
                    let ([e, s], [l, m]) = net.say(&tensors, row);
                    let (e, s, l, m) = (vector(e), vector(s), matrix(l), matrix(m));
                    let step = &l * &e + &m * &s;
                    slices(&e, &s, &step, laws);
                    said(laws, (&l, &m), &e, &s);
                    x += step;
                    path.push(scaling.outward(&x));
                }
            }
            Self::Exact(scaling, net) => {
                let (mut x, appended) = (scaling.inward(state), net.form.kinds.entropies.is_empty());
                while path.len() < count {
                    for turn in net.turn(&x) {
                        let ([de, ds, dz], [l, m]) = (&turn.slopes, &turn.operators);
                        slices(de, ds, dz, laws);
                        said(laws, (l, m), de, ds);
                        let gained = if appended { turn.heat } else { 0.0 };
                        let rise = net.energy(&turn.x) - net.energy(&x) + gained;
                        books.rise = books.rise.max(rise.abs());
                        books.passed += de.iter().zip(dz).map(|(e, z)| (e * z).abs()).sum::<f64>();
                        books.falls += u32::from(turn.heat < 0.0);
                        books.held += u32::from(turn.held);
                        x = turn.x;
                    }
                    path.push(scaling.outward(&x));
                }
            }
        }
        path
    }

    /// Rolls out from the first state of every trajectory of `data` that judges.
    pub(super) fn figures(&self, data: &Dataset, scaling: &Scaling, kinds: &Kinds) -> Figures {
        let (mut laws, mut books, mut paths) = (Laws::default(), Books::default(), Vec::new());
        for &k in &data.test {
            let truth = &data.paths[k];
            paths.push(self.roll(&truth[0], truth.len(), &mut laws, &mut books));
        }
        let exact = matches!(self, Self::Exact(..));
        let drift = if exact { books.rise * f64::from(laws.steps()) / books.passed } else { f64::NAN };
        let truth: Vec<&[DVector<f64>]> = data.test.iter().map(|&k| data.paths[k].as_slice()).collect();
        let square = square_errors(&truth, &paths);
        let count = (truth.len() * truth[0].len()) as f64;
        let mean = truth.iter().copied().flatten().fold(&truth[0][0] * 0.0, |sum, z| sum + z) / count;
        let variance =
            truth.iter().copied().flatten().fold(&mean * 0.0, |sum, z| sum + (z - &mean).map(|d| d * d))
                / count;
        let mse = square.iter().fold(&mean * 0.0, |sum, s| sum + s) / square.len() as f64;
        let part = |errors: &DVector<f64>| {
            let all = (0..errors.len()).filter(|&i| scaling.moving[i]).map(|i| errors[i] / variance[i]);
            (all.clone().sum::<f64>() / all.count().max(1) as f64).sqrt()
        };
        let relative = (0..mse.len())
            .map(|i| if scaling.moving[i] { (mse[i] / variance[i]).sqrt() } else { f64::NAN })
            .collect();
        Figures {
            name: self.name(),
            rollout: part(&mse),
            over_time: square.iter().map(part).collect(),
            mse: mse.iter().copied().collect(),
            relative,
            steps: laws.steps(),
            falls: if exact { books.falls } else { laws.falls() },
            system_falls: system_falls(kinds, &paths),
            held: books.held,
            laws: laws.figures(),
            drift,
            paths,
        }
    }
}

/// Mean over the trajectories of the square error of each variable, at every step.
fn square_errors(truth: &[&[DVector<f64>]], said: &[Vec<DVector<f64>>]) -> Vec<DVector<f64>> {
    (0..truth[0].len())
        .map(|step| {
            let all = truth.iter().zip(said).map(|(z, y)| (&z[step] - &y[step]).map(|d| d * d));
            all.fold(&truth[0][0] * 0.0, |sum, d| sum + d) / truth.len() as f64
        })
        .collect()
}
