//! The decision: none, named, tied or unknown; the class before the name.

use super::choose::{Choice, believed, choose, stand_apart};
use super::evidence::{held_out, inclusion};
use super::fit::{Fitted, fit};
use super::offsets::stands_off;
use super::problem::Problem;
use super::rank::{Candidate, rank};
use super::record::Quantity;
use super::settings::Settings;
use super::thresholds::Thresholds;
use meniscus::reduced::effects::{Class, find};

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

/// Everything that came out.
#[derive(Clone, Debug)]
pub struct Verdict {
    /// The decision.
    pub decision: Decision,
    /// Names: the effect (or the two) if named, those that cannot be told apart if tied.
    pub names: Vec<&'static str>,
    /// Whether two effects that explain it together may be making up for one that the library lacks.
    pub makeshift: bool,
    /// Where the rest stands off by more than clean glasses do, and by how much, m.
    pub stands_off: Option<(Quantity, f64)>,
    /// The class, where one is certain.
    pub class: Option<Class>,
    /// Single effects, best first.
    pub ranking: Vec<Candidate>,
    /// Pairs with the best single effect, best first.
    pub pairs: Vec<Candidate>,
    /// The fit without any effect, before formulas were distrusted.
    pub first: Fitted,
    /// The fit without any effect.
    pub plain: Fitted,
    /// The chosen fit.
    pub chosen: Fitted,
    /// Gain in BIC over none of the chosen fit; of the best where nothing is believed.
    pub gain: f64,
    /// Share of bootstrap draws that the winner won.
    pub inclusion: f64,
    /// Misfit a number of the chosen fit.
    pub chi2: f64,
    /// Numbers that were seen.
    pub count: usize,
    /// Recordings whose held-out score the effect improves, of all.
    pub held_out: (usize, usize),
    /// What stands at the end of its range in the chosen fit.
    pub edges: Vec<String>,
    /// By how much it improves the held-out score of all together, in units of minus twice the log score.
    pub foretold: f64,
}

impl Verdict {
    /// The decision in a sentence.
    #[must_use]
    pub fn sentence(&self) -> String {
        let about = |name: &str| find(name).map_or("", |entry| entry.about);
        let class = self.class.map_or(String::new(), |class| format!(" (class: {})", class.words()));
        let gain = self.gain;
        let edges = if self.edges.is_empty() {
            String::new()
        } else {
            format!(" Not to be trusted: {}.", self.edges.join("; "))
        };
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
                "Something is missing{class}, and these recordings do not {} (gain {gain:.0} over nothing).{edges}",
                match self.names.as_slice() {
                    [one] => format!("bear out that it is {one}"),
                    names => format!("tell {} apart", names.join(", ")),
                }
            ),
            Decision::Unknown if self.makeshift => format!(
                "Something is missing that no single effect of the library explains: {} do it together (gain \
                 {gain:.0} over nothing), but so may one that the library lacks.{edges}",
                self.names.join(" and ")
            ),
            Decision::Unknown => format!(
                "Something is missing that the library does not explain: the best of it leaves a misfit of {:.2}; \
                 nearest is {}.{}{edges}",
                self.chi2,
                if self.names.is_empty() { "nothing".into() } else { self.names.join(" + ") },
                self.stands_off.map_or(String::new(), |(quantity, m)| format!(
                    " At rest the {} stands off by {:.2} mm.",
                    quantity.words(),
                    1e3 * m
                ))
            ),
        }
    }
}

/// Ranks the effects of the library on `problem` and decides.
#[must_use]
pub fn decide(problem: &Problem, limits: &Thresholds, settings: &Settings) -> Verdict {
    let Settings { library, rules, .. } = settings;
    let count = problem.count();
    let plain = fit(problem, &problem.mean, &[], &[]);
    let first = plain.clone();
    let ranking = rank(problem, &plain, library, plain.bic(count));
    // Formulas are not exact: the correction that the best one makes says by how much. Under that
    // covariance everything is fitted again.
    let best = believed(problem, &ranking, limits).and_then(|place| ranking[place].fitted.clone());
    let trusting = best.and_then(|best| problem.trusting(&best.theta, &best.active, rules).ok());
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
        makeshift: false,
        stands_off: None,
        class: None,
        chi2: plain.chi2(count),
        chosen: plain.clone(),
        gain: ranking.first().map_or(0.0, |best| best.gain),
        first,
        plain,
        ranking,
        pairs: Vec::new(),
        inclusion: 0.0,
        count,
        held_out: (0, 0),
        edges: Vec::new(),
        foretold: 0.0,
    };
    verdict.stands_off = limits.beyond(&stands_off(problem, &verdict.plain));
    let Some(place) = believed(problem, &verdict.ranking, limits) else {
        // Nothing of the library helps; something may be missing all the same.
        if verdict.chi2 > limits.clean_chi2 || verdict.stands_off.is_some() {
            verdict.decision = Decision::Unknown;
        }
        return verdict;
    };
    let Some(choice) = choose(problem, limits, settings, &mut verdict, place) else { return verdict };
    judge(problem, limits, settings, &mut verdict, choice);
    verdict
}

/// Whether the choice is a name, a tie or unknown.
fn judge(problem: &Problem, limits: &Thresholds, settings: &Settings, verdict: &mut Verdict, choice: Choice) {
    let Choice { fitted, rivals, two } = choice;
    verdict.chosen = fitted;
    verdict.names.clone_from(&rivals[0].names);
    verdict.gain = rivals[0].gain;
    verdict.chi2 = verdict.chosen.chi2(verdict.count);
    verdict.stands_off = limits.beyond(&stands_off(problem, &verdict.chosen));
    (verdict.held_out, verdict.foretold) = held_out(problem, &verdict.plain, &verdict.chosen);
    verdict.inclusion = inclusion(problem, &rivals, &verdict.plain, settings.seed);
    let class_of = |candidate: &Candidate| find(candidate.last()).map(|entry| entry.class);
    let class = class_of(&rivals[0]);
    let close =
        |rival: &&Candidate| verdict.gain - rival.gain < settings.rules.min_gap(class_of(rival) == class);
    let near: Vec<&Candidate> = rivals.iter().filter(close).collect();
    let same_class = near.iter().all(|rival| class_of(rival) == class);
    let chosen = &verdict.chosen;
    verdict.edges = edges(chosen);
    verdict.class = class.filter(|_| same_class && !two);
    let borne_out = verdict.inclusion >= settings.rules.min_inclusion
        && verdict.foretold > 0.0
        && verdict.edges.is_empty();
    let leaves = verdict.chi2 > limits.chi2 || verdict.stands_off.is_some();
    verdict.makeshift = two && !leaves && !stand_apart(&verdict.chosen.active);
    verdict.decision = if leaves || verdict.makeshift {
        Decision::Unknown
    } else if near.len() == 1 && borne_out {
        Decision::Named
    } else {
        let mut names: Vec<&'static str> = Vec::new();
        for name in near.iter().flat_map(|rival| &rival.names) {
            if !names.contains(name) {
                names.push(name);
            }
        }
        verdict.names = names;
        Decision::Tied
    };
}

/// The free parameters of `fitted` that stand at the end of their range.
fn edges(fitted: &Fitted) -> Vec<String> {
    let edge = |(effect, which): &(usize, usize)| {
        let active = &fitted.active[*effect];
        let (parameter, value) = (&active.entry.parameters[*which], active.values[*which]);
        let (least, largest) = parameter.range;
        let near = 1e-6 * (largest - least);
        (value <= least + near.min(1e-9) || value >= largest - near).then(|| {
            format!(
                "the {} of {} stands at the end of its range of {least} to {largest}{}{}",
                parameter.name,
                active.entry.name,
                if parameter.unit == "1" { "" } else { " " },
                parameter.unit.trim_start_matches('1')
            )
        })
    };
    fitted.free.iter().filter_map(edge).collect()
}
