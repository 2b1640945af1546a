//! Comparison of candidates by the simulator on recordings that their sizes were not fitted to.
//!
//! Each recording of the fit is left out in turn, which the emulator does without a further simulation; the recording
//! that was held out from everything is simulated at the final size. Squares are those of residuals over noise:
//! ```text
//! F = S_rival/S_best,    both with n/tau degrees of freedom,    tau = 1 + 2 sum_k rho_k
//! ```
//! n are the numbers, tau is the correlation time of the residual in frames.

use super::emulator::Emulator;
use super::tried::MappedEmulator;
use meniscus_numerics::statistics::f_exceeded;
use nalgebra::DVector;

/// Chance of a difference as large as the one that decides.
const CHANCE: f64 = 0.01;

/// Frames over which the residual is correlated at most.
const LONGEST: usize = 36;

/// Squares that a candidate leaves of one recording that it was not fitted to.
#[derive(Clone, Debug, PartialEq)]
pub struct Score {
    /// Recording.
    pub recording: String,
    /// Numbers.
    pub numbers: usize,
    /// Squares of the residual over the noise.
    pub squares: f64,
    /// The same without the effect, with the viscosity fitted.
    pub absent: f64,
}

/// Scores of a candidate.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Scores {
    /// By recording.
    pub each: Vec<Score>,
    /// Correlation time of the residual, frames.
    pub correlation: f64,
}

impl Scores {
    /// Returns the scores on the recordings of the fit, each left out in turn.
    #[must_use]
    pub fn left_out(mapped: &MappedEmulator, names: &[String], neutral: f64) -> Self {
        let emulator = &mapped.emulator;
        let nodes = &emulator.nodes;
        let range = (nodes[0].size, nodes[nodes.len() - 1].size);
        let squares = |left: &DVector<f64>, which: usize| {
            let range = emulator.recordings[which].clone();
            left.rows(range.start, range.len()).norm_squared()
        };
        let one = |(which, name): (usize, &String)| {
            let fit = emulator.minimum(range, Some(which));
            let absent = emulator.fit_at(neutral, Some(which));
            Score {
                recording: name.clone(),
                numbers: mapped.projections[which].measured(),
                squares: squares(&emulator.linearised(&fit).0, which),
                absent: squares(&emulator.linearised(&absent).0, which),
            }
        };
        Self {
            each: names.iter().enumerate().map(one).collect(),
            correlation: correlation_time(emulator, mapped, range),
        }
    }

    fn total(&self, of: impl Fn(&Score) -> f64) -> f64 {
        self.each.iter().map(of).sum()
    }

    /// Returns the squares over all recordings.
    #[must_use]
    pub fn squares(&self) -> f64 {
        self.total(|score| score.squares)
    }

    /// Returns the squares over all recordings without the effect.
    #[must_use]
    pub fn absent(&self) -> f64 {
        self.total(|score| score.absent)
    }

    /// Returns the ratio of squares from which a difference is no chance.
    #[must_use]
    pub fn decisive_ratio(&self) -> f64 {
        let freedom = (self.total(|score| score.numbers as f64) / self.correlation.max(1.0)).max(3.0);
        f_exceeded(CHANCE, freedom as usize, freedom)
    }

    /// Returns whether these are decisively better than `others`: by the ratio of squares, and on most recordings.
    #[must_use]
    pub fn beat(&self, others: &Self) -> bool {
        let better = self.each.iter().zip(&others.each).filter(|(a, b)| a.squares < b.squares).count();
        let ratio = others.squares() / self.squares().max(f64::MIN_POSITIVE);
        ratio >= self.decisive_ratio().max(others.decisive_ratio()) && 2 * better > self.each.len()
    }

    /// Returns whether the effect explains more than chance of what is left without it.
    #[must_use]
    pub fn beat_absent(&self) -> bool {
        let better = self.each.iter().filter(|score| score.squares < score.absent).count();
        let ratio = self.absent() / self.squares().max(f64::MIN_POSITIVE);
        ratio >= self.decisive_ratio() && 2 * better > self.each.len()
    }
}

/// Returns the correlation time of the residual of the best fit, frames.
fn correlation_time(emulator: &Emulator, mapped: &MappedEmulator, range: (f64, f64)) -> f64 {
    let left = emulator.linearised(&emulator.minimum(range, None)).0;
    let (mut square, mut products) = (0.0, vec![0.0; LONGEST]);
    for channel in mapped.channels() {
        let series = left.rows(channel.start, channel.len());
        square += series.norm_squared();
        for (apart, product) in products.iter_mut().enumerate() {
            *product += series.iter().zip(series.iter().skip(apart + 1)).map(|(a, b)| a * b).sum::<f64>();
        }
    }
    // Up to the first lag without correlation; what swings back beyond it would hide what came before.
    let correlations = products.iter().map(|product| product / square.max(f64::MIN_POSITIVE));
    1.0 + 2.0 * correlations.take_while(|rho| *rho > 0.0).sum::<f64>()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scores(squares: [f64; 3], correlation: f64) -> Scores {
        let each =
            squares.map(|squares| Score { recording: "a".into(), numbers: 400, squares, absent: 4000.0 });
        Scores { each: each.to_vec(), correlation }
    }

    #[test]
    fn a_difference_decides_only_beyond_what_correlated_residuals_show_by_chance() {
        let best = scores([400.0, 420.0, 380.0], 10.0);
        assert!(!best.beat(&scores([500.0, 460.0, 440.0], 10.0)), "a sixth more");
        assert!(best.beat(&scores([800.0, 900.0, 700.0], 10.0)), "twice as much");
        assert!(!best.beat(&scores([800.0, 900.0, 700.0], 200.0)), "of a handful of numbers");
        // One recording alone does not decide.
        assert!(!best.beat(&scores([3000.0, 400.0, 370.0], 10.0)));
        assert!(best.beat_absent() && !scores([3900.0, 3900.0, 3900.0], 10.0).beat_absent());
    }
}
