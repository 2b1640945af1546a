//! Statistics of a run that need no truth: times, conservation laws, late turns.

use crate::live::Log;
use crate::timed_turn::TimedTurn;
use meniscus::runtime::{DEADLINE_US, Mode, Stages};
use serde_json::{Value, json};

/// Quantiles of the times of the turns, microseconds; zero for a run without turns.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct TurnTimes {
    /// Median.
    pub median: u64,
    /// 99th percentile.
    pub p99: u64,
    /// Longest.
    pub max: u64,
}

impl TurnTimes {
    /// Returns the quantiles of a log. The quantile `p` of `n` sorted times is the `ceil(p n)`-th.
    #[must_use]
    pub fn of(log: &Log) -> Self {
        let mut times: Vec<u64> = log.turns.iter().map(|logged| logged.turn_us).collect();
        times.sort_unstable();
        let at = |p: f64| {
            let rank = (p * times.len() as f64).ceil() as usize;
            times.get(rank.saturating_sub(1)).copied().unwrap_or(0)
        };
        Self { median: at(0.5), p99: at(0.99), max: times.last().copied().unwrap_or(0) }
    }
}

/// Returns the turns that ended more than a frame interval after their last payload had come.
pub fn late(log: &Log) -> impl Iterator<Item = &TimedTurn> {
    log.turns.iter().filter(|logged| logged.latency_us > DEADLINE_US)
}

/// Returns the largest |dE - work| of a predicting step, in units of the energy scale.
#[must_use]
pub fn energy_drift(log: &Log) -> f64 {
    let residuals = log.turns.iter().map(|logged| logged.turn.estimate.audit.energy_residual.abs());
    residuals.fold(0.0, f64::max)
}

/// Returns the number of turns after which there was less heat than before.
#[must_use]
pub fn entropy_falls(log: &Log) -> usize {
    let heat = |logged: &TimedTurn| logged.turn.estimate.heat_j;
    log.turns.windows(2).filter(|pair| heat(&pair[1]) < heat(&pair[0])).count()
}

/// Returns the median time of each stage over the turns that tracked, microseconds.
#[must_use]
pub fn stage_medians(log: &Log) -> [(&'static str, u64); 5] {
    let tracking = || log.turns.iter().map(|l| &l.turn.estimate).filter(|e| e.mode == Mode::Tracking);
    let median = |stage: fn(&Stages) -> u64| {
        let mut times: Vec<u64> = tracking().map(|estimate| stage(&estimate.stages)).collect();
        times.sort_unstable();
        times.get(times.len() / 2).copied().unwrap_or(0)
    };
    [
        ("surface", median(|stages| stages.surface_us)),
        ("predict", median(|stages| stages.predict_us)),
        ("encode", median(|stages| stages.encode_us)),
        ("correct", median(|stages| stages.correct_us)),
        ("field", median(|stages| stages.field_us)),
    ]
}

/// Returns [`stage_medians`] as a JSON object.
#[must_use]
pub fn stages_json(log: &Log) -> Value {
    stage_medians(log).into_iter().map(|(name, us)| (name.to_owned(), json!(us))).collect()
}

/// Returns [`stage_medians`] as a line for a person.
#[must_use]
pub fn stages_line(log: &Log) -> String {
    let stages: Vec<String> = stage_medians(log).iter().map(|(name, us)| format!("{name} {us}")).collect();
    format!("stages, median us: {}\n", stages.join(", "))
}

/// Returns the turns by the origin of their motion as JSON, `null` without a commanded motion. Scripts read the names
/// `told` and `untold`.
#[must_use]
pub fn motion_json(log: &Log) -> Value {
    log.motion.map_or(Value::Null, |turns| json!({ "told": turns.commanded, "untold": turns.tracked }))
}

/// Returns the same as a line for a person; empty without a commanded motion.
#[must_use]
pub fn motion_line(log: &Log) -> String {
    log.motion.map_or(String::new(), |turns| {
        format!("motion: commanded in {} turns, tracked in {}\n", turns.commanded, turns.tracked)
    })
}

/// Returns the losses of the camera's streams as JSON.
#[must_use]
pub fn losses_json(log: &Log) -> Value {
    json!({ "depth": log.losses.0, "infrared": log.losses.1, "solitary": log.solitary,
            "payloads_dropped": log.payloads_dropped })
}

/// Returns the number of turns in each mode as JSON.
#[must_use]
pub fn modes_json(log: &Log) -> Value {
    let health = &log.health;
    json!({ "filling": health.filling, "tracking": health.tracking, "coasting": health.coasting,
            "halted": health.halted })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::timed_turn::tests::timed_turn;

    #[test]
    fn quantiles_are_those_of_the_sorted_times() {
        let turns = [90_000, 400, 5_000].map(|us| timed_turn(0, us)).to_vec();
        let times = TurnTimes::of(&Log { turns, ..Log::default() });
        assert_eq!(times, TurnTimes { median: 5_000, p99: 90_000, max: 90_000 });
        let turns = (1..=200).map(|us| timed_turn(0, us)).collect();
        let times = TurnTimes::of(&Log { turns, ..Log::default() });
        assert_eq!(times, TurnTimes { median: 100, p99: 198, max: 200 });
        assert_eq!(TurnTimes::of(&Log::default()), TurnTimes::default());
    }

    #[test]
    fn a_turn_is_late_after_the_deadline_and_not_on_it() {
        let turns = [DEADLINE_US, DEADLINE_US + 1].map(|us| timed_turn(0, us)).to_vec();
        assert_eq!(late(&Log { turns, ..Log::default() }).count(), 1);
    }
}
