//! The decision: none, named, tied or unknown; the class before the name.

use super::fit::{Fitted, derivatives, fit, fit_beside, search};
use super::problem::Problem;
use crate::effects::{Active, Class, Entry};
use crate::offline::prelude::*;
use nalgebra::DVector;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

/// Gain in BIC over none from which an effect is believed at all.
pub const CERTAIN: f64 = 10.0;

/// Gain over the second, in another class.
pub const APART: f64 = 10.0;

/// Gain over the second, in the same class: near twins.
pub const TWINS: f64 = 20.0;

/// What a second effect has to gain as a part of the first one's gain, if it acts on the liquid as the first
/// one does, and otherwise: the formula of the first is not exact.
const RELATED: f64 = 0.3;
const UNRELATED: f64 = 0.05;

/// Share of bootstrap draws that the winner has to win.
const INCLUSION: f64 = 0.9;

/// Candidates that are fitted in full after the coarse search.
const FINALISTS: usize = 6;

/// Frames of a block of the bootstrap.
const BLOCK: usize = 12;

/// What was decided.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Decision {
    /// Nothing is missing.
    None,
    /// One effect (or two) is missing, and this is its name.
    Named,
    /// Something of this class is missing, or one of a few effects.
    Tied,
    /// Something is missing that no effect of the library explains.
    Unknown,
}

impl Decision {
    /// In a word.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Named => "named",
            Self::Tied => "tied",
            Self::Unknown => "unknown",
        }
    }
}

/// One line of the ranking.
#[derive(Clone, Debug)]
pub struct Candidate {
    /// Names of its effects.
    pub names: Vec<&'static str>,
    /// Gain in BIC over none.
    pub gain: f64,
    /// The fit; none where the coarse search was enough to leave it behind.
    pub fitted: Option<Fitted>,
    /// What the coarse search left, whitened.
    pub signature: DVector<f64>,
}

/// Everything that came out.
#[derive(Clone, Debug)]
pub struct Verdict {
    /// The decision.
    pub decision: Decision,
    /// Names: the effect (or the two) if named, those that cannot be told apart if tied.
    pub names: Vec<&'static str>,
    /// The class, where one is certain.
    pub class: Option<Class>,
    /// Single effects, best first.
    pub ranking: Vec<Candidate>,
    /// Pairs with the best single effect, best first.
    pub pairs: Vec<Candidate>,
    /// The fit without any effect.
    pub plain: Fitted,
    /// The chosen fit.
    pub chosen: Fitted,
    /// Share of bootstrap draws that the winner won.
    pub inclusion: f64,
    /// Misfit a number of the chosen fit.
    pub chi2: f64,
    /// Numbers that were seen.
    pub count: usize,
    /// Recordings whose held-out score the effect improves, of all.
    pub held_out: (usize, usize),
    /// By how much it improves the held-out score of all together, in units of minus twice the log score.
    pub foretold: f64,
}

impl Verdict {
    /// The decision in a sentence.
    #[must_use]
    pub fn sentence(&self) -> String {
        let about = |name: &str| crate::effects::find(name).map_or("", |entry| entry.about);
        let class = self.class.map_or(String::new(), |class| format!(" (class: {})", class.words()));
        let gain = self.ranking.first().map_or(0.0, |best| best.gain);
        match self.decision {
            Decision::None => {
                "Nothing is missing: the model explains these recordings as well as it explains its \
                               references."
                    .into()
            }
            Decision::Named => {
                let told: Vec<String> =
                    self.names.iter().map(|name| format!("{name}, that is, {}", about(name))).collect();
                format!("Missing is {} (gain {gain:.0} over nothing).", told.join("; and "))
            }
            Decision::Tied => format!(
                "Something is missing{class}, and these recordings do not tell {} apart (gain {gain:.0} over nothing).",
                self.names.join(", ")
            ),
            Decision::Unknown => format!(
                "Something is missing that the library does not explain: the best of it leaves a misfit of {:.2}; \
                 nearest is {}.",
                self.chi2,
                if self.names.is_empty() { "nothing".into() } else { self.names.join(" + ") }
            ),
        }
    }
}

/// Thresholds that the references set.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Thresholds {
    /// Least gain in BIC over none.
    pub gain: f64,
    /// Largest misfit a number.
    pub chi2: f64,
}

impl Default for Thresholds {
    fn default() -> Self {
        Self { gain: CERTAIN, chi2: 1.25 }
    }
}

/// Ranks the effects of `library` on `problem` and decides.
#[must_use]
pub fn decide(problem: &Problem, library: &[&'static Entry], limits: Thresholds, seed: u64) -> Verdict {
    let count = problem.count();
    let plain = fit(problem, &problem.mean, &[], &[]);
    let ranking = rank(problem, &plain, library, plain.bic(count));
    // Formulas are not exact: the correction that the best one makes says by how much. Under that
    // covariance everything is fitted again.
    let best = ranking.first().filter(|best| best.gain >= limits.gain).and_then(|best| best.fitted.clone());
    let trusting = best.and_then(|best| problem.trusting(&best.theta, &best.active).ok());
    let (problem, plain, ranking) = match &trusting {
        Some(problem) => {
            let plain = fit(problem, &plain.theta, &[], &[]);
            let ranking = rank(problem, &plain, library, plain.bic(count));
            (problem, plain, ranking)
        }
        None => (problem, plain, ranking),
    };
    let mut verdict = Verdict {
        decision: Decision::None,
        names: Vec::new(),
        class: None,
        chi2: plain.chi2(count),
        chosen: plain.clone(),
        plain,
        ranking,
        pairs: Vec::new(),
        inclusion: 0.0,
        count,
        held_out: (0, 0),
        foretold: 0.0,
    };
    let Some((best, single)) =
        verdict.ranking.first().and_then(|best| best.fitted.clone().map(|fitted| (best.clone(), fitted)))
    else {
        return verdict;
    };
    if best.gain < limits.gain {
        // Nothing of the library helps; something may be missing all the same.
        if verdict.chi2 > limits.chi2 {
            verdict.decision = Decision::Unknown;
        }
        return verdict;
    }
    verdict.pairs = rank(problem, &single, library, verdict.plain.bic(count));
    let pair =
        verdict.pairs.first().and_then(|pair| pair.fitted.clone().map(|fitted| (pair.clone(), fitted)));
    let two = pair.as_ref().is_some_and(|(pair, _)| {
        let part = if related(&pair.names) { RELATED } else { UNRELATED };
        pair.gain - best.gain > limits.gain.max(APART).max(part * best.gain)
    });
    (verdict.chosen, verdict.names) = match (two, pair) {
        (true, Some((pair, fitted))) => (fitted, pair.names),
        _ => (single, best.names.clone()),
    };
    verdict.chi2 = verdict.chosen.chi2(count);
    (verdict.held_out, verdict.foretold) = held_out(problem, &verdict.plain, &verdict.chosen);
    let rivals: Vec<Candidate> = if two { verdict.pairs.clone() } else { verdict.ranking.clone() };
    verdict.inclusion = inclusion(problem, &rivals, &verdict.plain, seed);
    let top = rivals[0].gain;
    let class_of = |name: &str| crate::effects::find(name).map(|entry| entry.class);
    let last = |candidate: &Candidate| candidate.names.last().and_then(|name| class_of(name));
    let class = last(&rivals[0]);
    let near: Vec<&Candidate> = rivals
        .iter()
        .filter(|rival| top - rival.gain < if last(rival) == class { TWINS } else { APART })
        .collect();
    let same_class = near.iter().all(|rival| last(rival) == class);
    let inside = verdict
        .chosen
        .active
        .iter()
        .zip(0..)
        .all(|(active, effect)| in_range(&verdict.chosen, active, effect));
    let improves = verdict.foretold > 0.0;
    verdict.class = class.filter(|_| same_class && !two);
    verdict.decision = if verdict.chi2 > limits.chi2 {
        Decision::Unknown
    } else if near.len() == 1 && verdict.inclusion >= INCLUSION && improves && inside {
        Decision::Named
    } else {
        let mut names: Vec<&'static str> = near.iter().flat_map(|rival| rival.names.clone()).collect();
        names.dedup();
        let mut seen = Vec::new();
        names.retain(|name| {
            !seen.contains(name) && {
                seen.push(name);
                true
            }
        });
        verdict.names = names;
        Decision::Tied
    };
    verdict
}

/// Whether all of `names` act in the liquid: what the formula of one leaves may then look like another.
fn related(names: &[&'static str]) -> bool {
    let in_liquid = |name: &&'static str| {
        let class = crate::effects::find(name).map(|entry| entry.class);
        !matches!(class, Some(Class::View | Class::Timing | Class::Actuation))
    };
    names.iter().all(in_liquid)
}

/// Whether the free parameters stay inside their ranges.
fn in_range(fitted: &Fitted, active: &Active, effect: usize) -> bool {
    fitted.free.iter().filter(|(e, _)| *e == effect).all(|(_, which)| {
        let (least, largest) = active.entry.parameters[*which].range;
        let value = active.values[*which];
        let edge = 1e-6 * (largest - least);
        value > least + edge.min(1e-9) && value < largest - edge
    })
}

/// Every effect of `library` beside those of `base`, best first: all by the coarse search, the best of
/// them fitted in full.
fn rank(problem: &Problem, base: &Fitted, library: &[&'static Entry], plain: f64) -> Vec<Candidate> {
    let count = problem.count();
    let here: Vec<&'static str> = base.active.iter().map(|active| active.entry.name).collect();
    let mut found: Vec<(Candidate, Active, &'static Entry)> = library
        .par_iter()
        .filter(|entry| !here.contains(&entry.name))
        .map(|entry| {
            let (cost, active, rest) = search(problem, base, entry);
            let parameters = base.free.len() + super::fit::free_of(problem, entry).len();
            let mut names = here.clone();
            names.push(entry.name);
            let gain = plain - cost - parameters as f64 * (count as f64).ln();
            (Candidate { names, gain, fitted: None, signature: rest }, active, *entry)
        })
        .collect();
    found.sort_by(|a, b| b.0.gain.total_cmp(&a.0.gain));
    found.par_iter_mut().take(FINALISTS).for_each(|(candidate, active, entry)| {
        let fitted = fit_beside(problem, base, entry, active);
        candidate.gain = plain - fitted.bic(count);
        candidate.fitted = Some(fitted);
    });
    // What was not fitted in full stays behind what was.
    found.sort_by(|a, b| {
        let fitted = b.0.fitted.is_some().cmp(&a.0.fitted.is_some());
        fitted.then(b.0.gain.total_cmp(&a.0.gain))
    });
    found.into_iter().map(|(candidate, ..)| candidate).collect()
}

/// Share of draws of blocks in which the first of `rivals` keeps the lead over the others and over none.
fn inclusion(problem: &Problem, rivals: &[Candidate], plain: &Fitted, seed: u64) -> f64 {
    let places = problem.places();
    let mut names: Vec<(usize, usize)> = places.iter().map(|(r, _, f)| (*r, f / BLOCK)).collect();
    names.dedup();
    names.sort_unstable();
    names.dedup();
    let block = |r: usize, f: usize| names.binary_search(&(r, f / BLOCK)).unwrap_or(0);
    let sums = |fitted: &Fitted| {
        let mut sums = vec![0.0; names.len()];
        for ((r, _, f), e) in places.iter().zip(fitted.residual.iter()) {
            sums[block(*r, *f)] += e * e;
        }
        sums
    };
    let mut all = vec![(sums(plain), 0.0)];
    let penalty = (problem.count() as f64).ln();
    for rival in rivals.iter().filter_map(|rival| rival.fitted.as_ref()) {
        let prior = rival.residual.rows_range(problem.count()..).norm_squared();
        all.push((sums(rival), penalty * rival.free.len() as f64 + prior));
    }
    all[0].1 = plain.residual.rows_range(problem.count()..).norm_squared();
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    const DRAWS: usize = 200;
    let mut won = 0;
    for _ in 0..DRAWS {
        let drawn: Vec<usize> = (0..names.len()).map(|_| random.random_range(0..names.len())).collect();
        let cost = |(sums, extra): &(Vec<f64>, f64)| drawn.iter().map(|b| sums[*b]).sum::<f64>() + extra;
        let mine = cost(&all[1]);
        won += usize::from(all.iter().enumerate().all(|(i, other)| i == 1 || cost(other) >= mine));
    }
    won as f64 / DRAWS as f64
}

/// Recordings that are foretold better with the effects when they are left out of the fit, and all, and
/// by how much together: each
/// is taken out to first order, `theta` and parameters follow from the others.
fn held_out(problem: &Problem, plain: &Fitted, chosen: &Fitted) -> ((usize, usize), f64) {
    let counts = problem.counts();
    let score = |fitted: &Fitted, first: usize, rows: usize| {
        let (j, r) = (&fitted.jacobian, &fitted.residual);
        let (own_j, own_r) = (j.rows(first, rows), r.rows(first, rows));
        let square = j.transpose() * j - own_j.transpose() * own_j;
        let slope = j.transpose() * r - own_j.transpose() * own_r;
        let step = square.cholesky().map(|factor| factor.solve(&slope));
        step.map_or(f64::INFINITY, |step| (own_r - own_j * step).norm_squared())
    };
    let (mut better, mut first, mut sum) = (0, 0, 0.0);
    for rows in &counts {
        let gained = score(plain, first, *rows) - score(chosen, first, *rows);
        better += usize::from(gained > 0.0);
        sum += gained;
        first += rows;
    }
    ((better, counts.len()), sum)
}

/// Signatures of the effects of `library` at their typical size, with what the baseline can do taken out:
/// length (signal over noise) and cosines.
#[must_use]
pub fn isolability(
    problem: &Problem,
    plain: &Fitted,
    library: &[&'static Entry],
) -> (Vec<f64>, Vec<Vec<f64>>) {
    let jacobian = derivatives(problem, &plain.theta, &[], &[], &plain.residual, Some(&plain.jacobian));
    let basis = jacobian.qr().q();
    let signatures: Vec<DVector<f64>> = library
        .par_iter()
        .map(|entry| {
            let mut values = entry.neutral();
            let which = super::fit::free_of(problem, entry)[0];
            let parameter = &entry.parameters[which];
            let up = parameter.neutral + parameter.typical;
            values[which] = if up <= parameter.range.1 { up } else { parameter.neutral - parameter.typical };
            let change = problem.residual(&plain.theta, &[Active { entry, values }]) - &plain.residual;
            let part = basis.tr_mul(&change);
            change - &basis * part
        })
        .collect();
    let length: Vec<f64> = signatures.iter().map(|s| s.norm()).collect();
    let cosine = |a: &DVector<f64>, b: &DVector<f64>| a.dot(b) / (a.norm() * b.norm()).max(1e-12);
    let matrix = signatures.iter().map(|a| signatures.iter().map(|b| cosine(a, b)).collect()).collect();
    (length, matrix)
}
