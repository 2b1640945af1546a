//! Upper quantiles of Student's t and of Fisher's F.

use statrs::distribution::{Continuous, ContinuousCDF, FisherSnedecor, StudentsT};

/// Newton iterations that carry the library's quantile, which is good to about eight digits, to rounding.
const NEWTON_ITERATIONS: usize = 3;

/// Returns the value that Student's t of `freedom` degrees of freedom exceeds with probability `chance`; not a number
/// unless `freedom > 0` and `0 < chance < 1`.
///
/// ```text
/// P(T > t) = I_(nu/(nu + t^2))(nu/2, 1/2) / 2,   t >= 0       (Abramowitz and Stegun 1964, 26.7.1)
/// ```
///
/// ```
/// use meniscus_numerics::statistics::student_t_exceeded;
///
/// assert!((student_t_exceeded(0.01, 3.0) - 4.541).abs() < 1e-3);
/// ```
#[must_use]
pub fn student_t_exceeded(chance: f64, freedom: f64) -> f64 {
    let Ok(student) = StudentsT::new(0.0, 1.0, freedom) else { return f64::NAN };
    if !(chance > 0.0 && chance < 1.0) {
        return f64::NAN;
    }
    // By symmetry the lower tail is used: there a small chance keeps all its digits.
    let mut t = student.inverse_cdf(chance);
    for _ in 0..NEWTON_ITERATIONS {
        t -= (student.cdf(t) - chance) / student.pdf(t);
    }
    -t
}

/// Returns the value that Fisher's F of `numerator` and `denominator` degrees of freedom exceeds with probability `chance`;
/// not a number unless both are positive and `0 < chance < 1`.
///
/// ```text
/// F(1, nu) = t_nu^2                              P(F(2, nu) > f) = (1 + 2 f / nu)^(-nu/2)
/// ```
/// (Johnson, Kotz and Balakrishnan 1995, chapter 27); for a larger numerator the quantile of the library `statrs`.
///
/// ```
/// use meniscus_numerics::statistics::f_exceeded;
///
/// assert!((f_exceeded(0.01, 2, 8.0) - 8.649).abs() < 1e-3);
/// ```
#[must_use]
pub fn f_exceeded(chance: f64, numerator: usize, denominator: f64) -> f64 {
    match numerator {
        1 => student_t_exceeded(0.5 * chance, denominator).powi(2),
        2 => 0.5 * denominator * (chance.powf(-2.0 / denominator) - 1.0),
        _ if chance > 0.0 && chance < 1.0 => FisherSnedecor::new(numerator as f64, denominator)
            .map_or(f64::NAN, |fisher| fisher.inverse_cdf(1.0 - chance)),
        _ => f64::NAN,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_of_t_agree_with_scipy() {
        // python3 -c "from scipy.stats import t; print(t.isf(0.01, 3), t.isf(0.005, 3), t.isf(0.01, 10), ...)"
        for (chance, freedom, due) in [
            (0.01, 3.0, 4.540_702_858_568_134),
            (0.005, 3.0, 5.840_909_309_733_357),
            (0.01, 10.0, 2.763_769_458_112_696),
            (0.0005, 6.0, 5.958_816_178_818_76),
            (0.025, 7.0, 2.364_624_251_592_785),
            (0.000_238_095_238_095_238, 12.0, 4.744_974_291_092_67),
        ] {
            let found = student_t_exceeded(chance, freedom);
            assert!((found / due - 1.0).abs() < 1e-12, "t({freedom}) above {chance}: {found}, not {due}");
            assert!((student_t_exceeded(1.0 - chance, freedom) / due + 1.0).abs() < 1e-10);
        }
    }

    #[test]
    fn quantiles_of_f_agree_with_scipy() {
        // python3 -c "from scipy.stats import f; print(f.isf(0.01, 1, 6), f.isf(0.01, 2, 8), f.isf(0.01, 3, 9))"
        assert!((f_exceeded(0.01, 1, 6.0) / 13.745_022_533_304_17 - 1.0).abs() < 1e-12);
        assert!((f_exceeded(0.01, 2, 8.0) / 8.649_110_640_673_52 - 1.0).abs() < 1e-12);
        assert!(
            (f_exceeded(0.01, 3, 9.0) / 6.991_917_222_233_465 - 1.0).abs() < 1e-6,
            "{}",
            f_exceeded(0.01, 3, 9.0)
        );
    }

    #[test]
    fn arguments_without_a_quantile_give_no_number() {
        assert!(student_t_exceeded(0.0, 3.0).is_nan() && student_t_exceeded(0.1, 0.0).is_nan());
        assert!(student_t_exceeded(f64::NAN, 3.0).is_nan() && f_exceeded(0.1, 0, 4.0).is_nan());
    }
}
