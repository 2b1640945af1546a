//! Learning of a liquid: its tone, and the error of that tone on recordings that it was not fitted to.
//!
//! ```text
//! for each recording r: tone fitted to the others, held against r          (leave one out)
//! kappa_r^2 = <q> over the livelier half of r       a: such that the mean of ln kappa_r is 0
//! s^2 = [3 s_0^2 + (m - 1) v]/(m + 2) (1 + 1/m),  v = var ln kappa_r - <1 / (2 nu_r)>        m recordings
//! nu  = 2 <q>^2 n / [var q (1 + 2 sum rho)],  g = nu / n    rho: autocorrelation of q up to where it falls to zero
//! ```
//! A mean of n squares of which nu are independent scatters by `2/nu` of its square; that of a correlated series is
//! wider by `1 + 2 sum rho` (Bayley and Hammersley, J. R. Stat. Soc. Suppl. 8 (1946) 184). What chance adds to the
//! variance is taken off, and what few recordings agree on is drawn towards s_0 with the weight of three of them
//! (scaled inverse chi-squared prior: Gelman et al., Bayesian Data Analysis, 2013, section 2.6). Rest shows nothing of a
//! liquid, so that only the livelier half of a recording is used.

use super::fit::{Profiles, fit};
use meniscus::identify::{Calibration, FrameResidual, KnownLiquid, Recogniser, Tone, Trail};
use meniscus_numerics::statistics::{mean, median, variance};

/// Frames that the livelier half of a recording must hold: a second.
const FEWEST: usize = 60;

/// s_0 and its weight in recordings: few can agree by chance. Five liquids of the simulator have 0.23 to 0.79.
const USUAL: (f64, f64) = (0.4, 3.0);

/// Bounds of a. Two recordings that are predicted to 2 % do not show how well the next one will be.
const SCALES: (f64, f64) = (0.02, 10.0);

/// Bounds of g.
const NUMBERS: (f64, f64) = (0.01, 1.0);

/// Reason for which a liquid cannot be learnt.
#[derive(Clone, Debug, PartialEq)]
pub enum LearnError {
    /// Fewer than two recordings.
    TooFew(usize),
    /// This recording shows too little: its number, and the frames that it held.
    TooShort(usize, usize),
}

impl std::fmt::Display for LearnError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::TooFew(count) => write!(
                f,
                "{count} recording cannot say how much recordings of the liquid differ: give two or more, better four"
            ),
            Self::TooShort(which, count) => write!(
                f,
                "recording {} shows the liquid in {count} frames, {} are needed: give 3 s and more with the liquid in \
                 sight",
                which + 1,
                2 * FEWEST
            ),
        }
    }
}

impl std::error::Error for LearnError {}

/// Learns a liquid from `recordings` of it, in a glass of this radius and fill (m).
///
/// # Errors
/// [`LearnError`].
pub fn learn(recordings: &[&Profiles], glass: (f64, f64)) -> Result<KnownLiquid, LearnError> {
    if recordings.len() < 2 {
        return Err(LearnError::TooFew(recordings.len()));
    }
    let mut missed = Vec::new();
    for (which, profiles) in recordings.iter().enumerate() {
        let others: Vec<&Profiles> = recordings
            .iter()
            .enumerate()
            .filter(|(k, _)| *k != which)
            .map(|(_, profiles)| *profiles)
            .collect();
        let lively = livelier_half(misses(fit(&others, glass), profiles, glass.1));
        if lively.len() < FEWEST {
            return Err(LearnError::TooShort(which, 2 * lively.len()));
        }
        missed.push(lively);
    }
    Ok(KnownLiquid { tone: fit(recordings, glass), calibration: calibration(&missed) })
}

/// Returns the errors of `tone` over `profiles`, in order of time.
fn misses(tone: Tone, profiles: &Profiles, fill_m: f64) -> Vec<FrameResidual> {
    let known = [KnownLiquid { tone, calibration: Calibration { scale: 1.0, scatter: 1.0, numbers: 1.0 } }];
    let recogniser = Recogniser::new(&known, fill_m);
    let mut trail = Trail::<1>::default();
    let turn = |profile: &Option<_>| {
        recogniser.turn(&mut trail, profile.as_ref());
        trail.residual(0)
    };
    profiles.iter().filter_map(turn).collect()
}

/// Returns those of `misses` whose wave is not below the median, in order of time.
fn livelier_half(mut misses: Vec<FrameResidual>) -> Vec<FrameResidual> {
    let Some(median) = median(misses.iter().map(|residual| residual.wave_m2)) else { return misses };
    misses.retain(|residual| residual.wave_m2 >= median);
    misses
}

/// Returns a, s and g of recordings that each hold something.
fn calibration(all: &[Vec<FrameResidual>]) -> Calibration {
    let squares = |scale: f64, of: &[FrameResidual]| -> Vec<f64> {
        let calibration = Calibration { scale, scatter: 1.0, numbers: 1.0 };
        of.iter()
            .map(|residual| residual.residual_m * residual.residual_m / calibration.variance_m2(residual))
            .collect()
    };
    let ln_kappa = |scale: f64| -> Vec<f64> {
        all.iter().map(|of| 0.5 * mean(&squares(scale, of)).max(1e-12).ln()).collect()
    };
    // The mean of ln kappa falls with a.
    let (mut low, mut high) = (SCALES.0.ln(), SCALES.1.ln());
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if mean(&ln_kappa(middle.exp())) > 0.0 { low = middle } else { high = middle }
    }
    let scale = high.exp();
    let series: Vec<Vec<f64>> = all.iter().map(|of| squares(scale, of)).collect();
    let numbers = mean(&series.iter().map(|q| numbers(q)).collect::<Vec<f64>>());
    let numbers = numbers.clamp(NUMBERS.0, NUMBERS.1);
    let kappas = ln_kappa(scale);
    let by_chance: Vec<f64> = series.iter().map(|q| 0.5 / (numbers * q.len() as f64)).collect();
    let m = kappas.len() as f64;
    let own = (variance(&kappas) - mean(&by_chance)).max(0.0);
    let drawn = (USUAL.1 * USUAL.0 * USUAL.0 + (m - 1.0) * own) / (USUAL.1 + m - 1.0);
    Calibration { scale, scatter: (drawn * (1.0 + 1.0 / m)).sqrt(), numbers }
}

/// g of one series of q.
fn numbers(q: &[f64]) -> f64 {
    let (mean, spread) = (mean(q), variance(q));
    // The variance of one number is none.
    if spread.is_nan() || spread <= 0.0 {
        return NUMBERS.1;
    }
    let correlation = |lag: usize| {
        let pairs = q.iter().zip(q.iter().skip(lag));
        pairs.map(|(a, b)| (a - mean) * (b - mean)).sum::<f64>() / (q.len() as f64 * spread)
    };
    let positive = (1..q.len() / 2).map(correlation).take_while(|rho| *rho > 0.0);
    2.0 * mean * mean / (spread * (1.0 + 2.0 * positive.sum::<f64>()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use meniscus_numerics::random::normal;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;

    /// Misses of a scale and a scatter that are known.
    fn drawn(scale: f64, scatter: f64, recordings: usize, long: usize, seed: u64) -> Vec<Vec<FrameResidual>> {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut one = || {
            let kappa = (scatter * normal(&mut rng)).exp();
            let mut draw = |k: usize| {
                let mut residual =
                    FrameResidual { residual_m: 0.0, noise_m2: 1e-8, wave_m2: 1e-5 * (1.0 + (k % 7) as f64) };
                let due = Calibration { scale, scatter: 1.0, numbers: 1.0 }.variance_m2(&residual);
                residual.residual_m = kappa * due.sqrt() * normal(&mut rng);
                residual
            };
            (0..long).map(&mut draw).collect()
        };
        (0..recordings).map(|_| one()).collect()
    }

    #[test]
    fn scale_scatter_and_numbers_come_back() {
        let found = calibration(&drawn(0.2, 0.4, 60, 400, 1));
        assert!((found.scale / 0.2 - 1.0).abs() < 0.15, "{found:?}");
        assert!((found.scatter / 0.4 - 1.0).abs() < 0.2, "{found:?}");
        assert!(found.numbers > 0.7, "each frame is a number of its own: {found:?}");
    }

    #[test]
    fn recordings_that_agree_by_chance_do_not_narrow_the_scatter() {
        let found = calibration(&drawn(0.2, 0.0, 3, 400, 2));
        assert!((0.25..0.5).contains(&found.scatter), "{found:?}");
        let many = calibration(&drawn(0.2, 0.0, 100, 400, 4));
        assert!(many.scatter < 0.1, "many that agree are: {many:?}");
    }

    #[test]
    fn neighbours_that_go_together_are_worth_less() {
        let apart = drawn(0.1, 0.0, 4, 600, 3);
        let five = |of: &Vec<FrameResidual>| of.iter().flat_map(|residual| [*residual; 5]).collect();
        let together: Vec<Vec<FrameResidual>> = apart.iter().map(five).collect();
        let (one, each) = (calibration(&apart).numbers, calibration(&together).numbers);
        assert!((5.0 * each / one - 1.0).abs() < 0.4, "{each} of {one}");
    }

    #[test]
    fn what_cannot_be_learnt_from_is_reported() {
        let glass = (0.035, 0.07);
        let text = |error: LearnError| format!("{error}");
        assert!(text(learn(&[&[]], glass).expect_err("one")).contains("1 recording cannot say"));
        assert!(text(learn(&[&[], &[]], glass).expect_err("empty")).contains("recording 1 shows"));
    }
}
