//! A damped oscillation fitted to a series, beside others that are already known.
//!
//! For given frequencies and decays the amplitudes follow by linear least squares; frequency and
//! decay of the one sought are then moved until the misfit no longer falls (pattern search).

use super::theory::Tone;
use nalgebra::{DMatrix, DVector};
use std::f64::consts::TAU;

/// A fitted oscillation.
#[derive(Clone, Debug, PartialEq)]
pub struct Fit {
    /// Frequency and decay sought.
    pub tone: Tone,
    /// Factors of `e^(-decay t) cos(2 pi hz t)` and of the same with the sine.
    pub amplitude: [f64; 2],
}

impl Fit {
    /// The oscillation at `time_s`.
    #[must_use]
    pub fn at(&self, time_s: f64) -> f64 {
        let [c, s] = wave(&self.tone, time_s);
        self.amplitude[0] * c + self.amplitude[1] * s
    }
}

fn wave(tone: &Tone, time_s: f64) -> [f64; 2] {
    let (s, c) = (TAU * tone.hz * time_s).sin_cos();
    let envelope = (-tone.decay * time_s).exp();
    [envelope * c, envelope * s]
}

/// Squared misfit and amplitudes of `tones` in `series` (times in s, values).
fn amplitudes(series: &[(f64, f64)], tones: &[Tone]) -> Option<(f64, DVector<f64>)> {
    let size = 2 * tones.len();
    let mut normal = DMatrix::zeros(size, size);
    let mut right = DVector::zeros(size);
    let mut square = 0.0;
    for &(t, y) in series {
        let row = DVector::from_iterator(size, tones.iter().flat_map(|tone| wave(tone, t)));
        normal.ger(1.0, &row, &row, 1.0);
        right.axpy(y, &row, 1.0);
        square += y * y;
    }
    let found = normal.cholesky()?.solve(&right);
    Some((square - right.dot(&found), found))
}

/// The oscillation near `guess` in `series`, beside the oscillations `known`; `None` where the series
/// does not determine it.
#[must_use]
pub fn fit(series: &[(f64, f64)], guess: Tone, known: &[Tone]) -> Option<Fit> {
    let with = |tone: Tone| {
        let tones: Vec<_> = std::iter::once(tone).chain(known.iter().copied()).collect();
        amplitudes(series, &tones)
    };
    let (mut tone, mut best) = (guess, with(guess)?);
    let (mut hz, mut decay) = (0.05 * guess.hz, 1.0);
    while hz > 1e-5 * guess.hz {
        let moves = [(hz, 0.0), (-hz, 0.0), (0.0, decay), (0.0, -decay)];
        let tried = moves.map(|(h, d)| Tone { hz: tone.hz + h, decay: tone.decay + d });
        let found = tried.into_iter().filter_map(|t| with(t).map(|fit| (t, fit)));
        match found.min_by(|a, b| a.1.0.total_cmp(&b.1.0)) {
            Some((better, fit)) if fit.0 < best.0 => (tone, best) = (better, fit),
            _ => (hz, decay) = (0.5 * hz, 0.5 * decay),
        }
    }
    Some(Fit { tone, amplitude: [best.1[0], best.1[1]] })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_tone_is_found_beside_a_louder_one() {
        let (loud, weak) = (Tone { hz: 3.6, decay: 0.5 }, Tone { hz: 6.15, decay: 1.7 });
        let value = |t: f64| 5.0 * wave(&loud, t)[0] + wave(&weak, t)[1];
        let series: Vec<_> = (0..800).map(|i| f64::from(i) * 1e-3).map(|t| (t, value(t))).collect();
        let found = fit(&series, Tone { hz: 6.3, decay: 1.0 }, &[loud]).expect("it is determined");
        assert!((found.tone.hz - 6.15).abs() < 1e-3 && (found.tone.decay - 1.7).abs() < 1e-2, "{found:?}");
        assert!((found.at(0.1) - wave(&weak, 0.1)[1]).abs() < 1e-3);
        assert!(fit(&series[..1], loud, &[]).is_none());
    }
}
