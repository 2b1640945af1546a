//! Running totals of a run: figures over all of its turns, in memory that does not grow with its length.

use crate::timed_turn::TimedTurn;
use hdrhistogram::Histogram;
use meniscus::runtime::{DEADLINE_US, Mode, Stages};

/// Longest time that a histogram distinguishes, microseconds: a minute.
const LONGEST_US: u64 = 60_000_000;

/// Significant digits of a time in a histogram: it is read to a thousandth of itself.
const DIGITS: u8 = 3;

/// A stage of a turn by name.
#[derive(Clone, Copy, Debug)]
pub struct Stage {
    /// Its name in reports.
    pub name: &'static str,
    /// Its time, microseconds.
    pub us: fn(&Stages) -> u64,
}

/// The stages of a turn, in their order.
pub const STAGES: [Stage; 5] = [
    Stage { name: "surface", us: |stages| stages.surface_us },
    Stage { name: "predict", us: |stages| stages.predict_us },
    Stage { name: "encode", us: |stages| stages.encode_us },
    Stage { name: "correct", us: |stages| stages.correct_us },
    Stage { name: "field", us: |stages| stages.field_us },
];

/// Figures over all turns so far.
#[derive(Clone, Debug)]
pub struct RunTotals {
    /// Turns.
    pub turns: u64,
    /// Turns that ended more than a frame interval after their last payload had come.
    pub turns_late: u64,
    /// Allocations of the worker during turns.
    pub allocations: u64,
    /// Turns after which there was less heat than before.
    pub entropy_falls: u64,
    /// Largest |dE - work| of a predicting step, in units of the energy scale.
    pub energy_drift: f64,
    /// Times of the turns, microseconds.
    turn_us: Histogram<u64>,
    /// Times of the stages over the turns that tracked, microseconds, in the order of [`STAGES`].
    stage_us: [Histogram<u64>; STAGES.len()],
    heat_j: f64,
}

impl Default for RunTotals {
    fn default() -> Self {
        Self {
            turns: 0,
            turns_late: 0,
            allocations: 0,
            entropy_falls: 0,
            energy_drift: 0.0,
            turn_us: histogram(),
            stage_us: STAGES.map(|_| histogram()),
            heat_j: f64::NEG_INFINITY,
        }
    }
}

impl RunTotals {
    /// Adds a turn. All memory was there before.
    pub fn add(&mut self, logged: &TimedTurn) {
        let estimate = &logged.turn.estimate;
        self.turns += 1;
        self.turns_late += u64::from(logged.latency_us > DEADLINE_US);
        self.allocations += logged.allocations;
        self.entropy_falls += u64::from(estimate.heat_j < self.heat_j);
        self.heat_j = estimate.heat_j;
        self.energy_drift = self.energy_drift.max(estimate.audit.energy_residual.abs());
        self.turn_us.saturating_record(logged.turn_us);
        if estimate.mode == Mode::Tracking {
            let histograms = self.stage_us.iter_mut().zip(STAGES);
            histograms
                .for_each(|(histogram, stage)| histogram.saturating_record((stage.us)(&estimate.stages)));
        }
    }

    /// Returns the time that a share of the turns stayed within, microseconds; 0 of no turns.
    #[must_use]
    pub fn turn_within_us(&self, share: f64) -> u64 {
        self.turn_us.value_at_quantile(share)
    }

    /// Returns the median of each stage, microseconds, in the order of [`STAGES`]; 0 where no turn tracked.
    #[must_use]
    pub fn stage_medians_us(&self) -> [u64; STAGES.len()] {
        self.stage_us.each_ref().map(|histogram| histogram.value_at_quantile(0.5))
    }
}

/// Returns an empty histogram.
fn histogram() -> Histogram<u64> {
    Histogram::new_with_bounds(1, LONGEST_US, DIGITS).expect("bounds that are in order")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::timed_turn::tests::timed_turn;

    #[test]
    fn quantiles_are_those_of_the_sorted_times_to_a_thousandth() {
        let mut totals = RunTotals::default();
        assert_eq!((totals.turn_within_us(0.5), totals.stage_medians_us()), (0, [0; 5]));
        [90_000, 400, 5_000].iter().for_each(|us| totals.add(&timed_turn(0, *us)));
        let near = |share, us: u64| totals.turn_within_us(share).abs_diff(us) <= us / 1000;
        assert!(near(0.5, 5_000) && near(0.99, 90_000) && near(1.0, 90_000));
        assert_eq!((totals.turns, totals.turns_late), (3, 1));
    }

    #[test]
    fn a_turn_is_late_after_the_deadline_and_not_on_it() {
        let mut totals = RunTotals::default();
        [DEADLINE_US, DEADLINE_US + 1].iter().for_each(|us| totals.add(&timed_turn(0, *us)));
        assert_eq!(totals.turns_late, 1);
    }

    #[test]
    fn less_heat_and_the_largest_drift_are_kept_over_any_number_of_turns() {
        let mut totals = RunTotals::default();
        let mut turn = timed_turn(0, 100);
        for number in 0..10_000_u32 {
            turn.turn.estimate.heat_j = f64::from(if number == 9_000 { 5 } else { number });
            turn.turn.estimate.audit.energy_residual = if number == 50 { -3e-7 } else { 1e-9 };
            turn.allocations = u64::from(number == 7_000);
            totals.add(&turn);
        }
        assert_eq!((totals.turns, totals.entropy_falls, totals.allocations), (10_000, 1, 1));
        assert!((totals.energy_drift - 3e-7).abs() < 1e-12);
    }
}
