//! A damped oscillation fitted to a series, beside others that are already known.
//!
//! ```text
//! |y - A(f, d) c|^2  ->  least in f and d,      c = (A^T A)^-1 A^T y
//! ```
//! For given frequencies and decays the amplitudes c follow by linear least squares, so that frequency and decay of the
//! one sought are the only parameters of the nonlinear search (variable projection: Golub and Pereyra, SIAM J. Numer.
//! Anal. 10 (1973) 413).

use super::theory::Tone;
use meniscus_numerics::least_squares::{Model, Settings, forward_differences, minimise};
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

/// Amplitudes of `tones` in `series` by linear least squares, and what they leave of it; `None` where the series does
/// not determine them.
fn projected(series: &[(f64, f64)], tones: &[Tone]) -> Option<(DVector<f64>, DVector<f64>)> {
    let size = 2 * tones.len();
    let waves = DMatrix::from_row_iterator(
        series.len(),
        size,
        series.iter().flat_map(|(t, _)| tones.iter().flat_map(move |tone| wave(tone, *t))),
    );
    let values = DVector::from_iterator(series.len(), series.iter().map(|(_, value)| *value));
    let amplitudes = waves.tr_mul(&waves).cholesky()?.solve(&waves.tr_mul(&values));
    let residual = values - waves * &amplitudes;
    Some((amplitudes, residual))
}

/// The series as a function of frequency and decay of the tone that is sought.
struct Series<'a> {
    points: &'a [(f64, f64)],
    known: &'a [Tone],
    /// Widths of the differences: frequency in Hz, decay in 1/s.
    widths: DVector<f64>,
}

impl Series<'_> {
    fn projected(&self, tone: Tone) -> Option<(DVector<f64>, DVector<f64>)> {
        let tones: Vec<_> = std::iter::once(tone).chain(self.known.iter().copied()).collect();
        projected(self.points, &tones)
    }
}

impl Model for Series<'_> {
    fn residual(&self, parameters: &DVector<f64>) -> DVector<f64> {
        let tone = Tone { hz: parameters[0], decay: parameters[1] };
        // A tone that the series does not determine is no better than any other: the solver turns away from it.
        let undetermined = || DVector::from_element(self.points.len(), f64::NAN);
        self.projected(tone).map_or_else(undetermined, |(_, residual)| residual)
    }

    fn jacobian(&self, parameters: &DVector<f64>, residual: &DVector<f64>) -> DMatrix<f64> {
        forward_differences(parameters, residual, &self.widths, |p| self.residual(p))
    }
}

/// Fits the oscillation near `guess` to `series` (times in s, values), beside the oscillations `known`; `None` where the
/// series does not determine it.
#[must_use]
pub fn fit(series: &[(f64, f64)], guess: Tone, known: &[Tone]) -> Option<Fit> {
    let widths = DVector::from_column_slice(&[1e-6 * guess.hz, 1e-5]);
    let model = Series { points: series, known, widths };
    model.projected(guess)?;
    let found = minimise(&model, DVector::from_column_slice(&[guess.hz, guess.decay]), &Settings::default());
    let tone = Tone { hz: found.parameters[0], decay: found.parameters[1] };
    let (amplitudes, _) = model.projected(tone)?;
    Some(Fit { tone, amplitude: [amplitudes[0], amplitudes[1]] })
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
