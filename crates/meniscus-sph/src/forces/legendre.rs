//! Numbers of a Runge-Kutta-Legendre step: many stages of a step that would be far too long for explicit ones.
//!
//! For `y' = f(y)` from `y_0` over `dt`, with `s` stages:
//! ```text
//! w = 4/(s^2 + s - 2),   b_0 = b_1 = b_2 = 1/3,   b_j = (j^2 + j - 2)/(2 j (j + 1)),   a_j = 1 - b_j
//! Y_0 = y_0,   Y_1 = Y_0 + b_1 w dt f(Y_0)
//! Y_j = mu_j Y_(j-1) + nu_j Y_(j-2) + (1 - mu_j - nu_j) Y_0 + w mu_j dt (f(Y_(j-1)) - a_(j-1) f(Y_0))
//! mu_j = (2j - 1)/j b_j/b_(j-1),   nu_j = -(j - 1)/j b_j/b_(j-2)
//! ```
//! of second order (Meyer, Balsara and Aslam 2014, J. Comput. Phys. 257, 594). They are stable up to `dt = (s^2 + s - 2)/(2 lambda)`, with
//! `lambda` the largest rate of decay, where as many explicit steps reach `2 s/lambda`. Where `f` is nothing, every stage stands still.

/// Stages of a step after which a liquid gets shorter steps instead.
pub(crate) const MOST: f64 = 24.0;

/// Part of the bound of stability that is used.
const SAFE: f64 = 0.95;

/// Factors of stage `j` after the first.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Factors {
    /// Of the stage before.
    pub(crate) last: f64,
    /// Of the stage before that.
    pub(crate) before: f64,
    /// Of the rate at the stage before, in steps.
    pub(crate) rate: f64,
    /// Of the rate at the start, in steps.
    pub(crate) first_rate: f64,
}

/// `w`.
fn weight(stages: usize) -> f64 {
    let s = stages as f64;
    4.0 / (s * s + s - 2.0)
}

/// `b_j`.
fn b(j: usize) -> f64 {
    let j = j.max(2) as f64;
    (j * j + j - 2.0) / (2.0 * j * (j + 1.0))
}

impl Factors {
    /// Returns `b_1 w`, the part of a step that the first of `stages` takes.
    pub(crate) fn first(stages: usize) -> f64 {
        b(1) * weight(stages)
    }

    /// Returns the factors of stage `j`, from 2 on, of `stages`.
    pub(crate) fn of(j: usize, stages: usize) -> Self {
        let weight = weight(stages);
        let n = j as f64;
        let last = (2.0 * n - 1.0) / n * b(j) / b(j - 1);
        let rate = weight * last;
        Self { last, before: (1.0 - n) / n * b(j) / b(j - 2), rate, first_rate: -(1.0 - b(j - 1)) * rate }
    }
}

/// Returns the part of a step after which stage `j` of `stages` stands, 1 after the last.
fn reached(j: usize, stages: usize) -> f64 {
    match j {
        0 => 0.0,
        1 => Factors::first(stages),
        _ => {
            let n = j as f64;
            0.25 * weight(stages) * (n * n + n - 2.0)
        }
    }
}

/// Returns the part of a step that the rate at stage `j` of `stages` stands for, of those from 0 to the last but one: all that is
/// nearer to it than to the others.
pub(crate) fn nearest_part(j: usize, stages: usize) -> f64 {
    let middle = |j: usize| 0.5 * (reached(j, stages) + reached(j + 1, stages));
    let start = if j == 0 { 0.0 } else { middle(j - 1) };
    let end = if j + 1 == stages { 1.0 } else { middle(j) };
    end - start
}

/// Longest step over which `stages` of them are stable, in units of `1/lambda`.
pub(crate) fn reach(stages: f64) -> f64 {
    SAFE * 0.5 * (stages * stages + stages - 2.0)
}

/// The stages that a step of `steps/lambda` needs, at least 2: [`reach`] turned around.
pub(crate) fn needed(steps: f64) -> usize {
    (0.5 * ((9.0 + 8.0 * steps / SAFE).sqrt() - 1.0)).ceil().max(2.0) as usize
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_parts_of_all_stages_are_the_step_and_each_is_near_its_stage() {
        for stages in 2..=24 {
            let parts: Vec<f64> = (0..stages).map(|j| nearest_part(j, stages)).collect();
            assert!(parts.iter().all(|part| *part > 0.0), "{parts:?}");
            assert!((parts.iter().sum::<f64>() - 1.0).abs() < 1e-12, "{parts:?}");
            assert!((reached(stages, stages) - 1.0).abs() < 1e-12);
            // The rule of trapezoids up to the last stage that has a rate, and that rate from there on: exact for what grows with time,
            // but for half the square of what is left.
            let left = 1.0 - reached(stages - 1, stages);
            let mean: f64 = parts.iter().enumerate().map(|(j, part)| part * reached(j, stages)).sum();
            assert!((mean - 0.5 * (1.0 - left * left)).abs() < 1e-12, "{mean} of {stages} stages");
        }
    }

    #[test]
    fn stages_follow_the_exponential_and_stand_where_forces_balance() {
        // y' = -y lambda from 1, scalar: the same recurrence with numbers.
        let end = |steps: f64, source: f64| {
            let stages = needed(steps);
            let slope = |y: f64| source - steps * y;
            let (start, first) = (1.0, slope(1.0));
            let (mut before, mut last) = (start, start + Factors::first(stages) * first);
            for j in 2..=stages {
                let f = Factors::of(j, stages);
                let rest = 1.0 - f.last - f.before;
                let next = f.last * last + f.before * before + rest * start;
                (before, last) = (last, next + f.rate * slope(last) + f.first_rate * first);
            }
            last
        };
        for steps in [0.01, 0.1, 0.3_f64] {
            let error = end(steps, 0.0) - (-steps).exp();
            assert!(error.abs() < steps.powi(3), "{error} at {steps}");
        }
        for steps in [1.0, 10.0, 100.0, 1000.0] {
            assert!((0.0..0.75).contains(&end(steps, 0.0)), "{} at {steps}", end(steps, 0.0));
            assert!((end(steps, steps) - 1.0).abs() < 1e-12, "a balance is kept at {steps}");
        }
    }
}
