//! The form in which every verifying command answers: one JSON object with a `checks` array.

use serde::Serialize;

/// Target of a measured value.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Target {
    AtMost(f64),
    AtLeast(f64),
    Exactly(f64),
    Within(f64, f64),
    Informational,
}

/// One measured value with its target; `ok` is computed from the two and from nothing else.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Check {
    /// Name, the same in every output of this project.
    pub name: String,
    /// The measured value; `null` in JSON where it could not be measured.
    pub value: Option<f64>,
    /// Unit of the value.
    pub unit: &'static str,
    /// The target in words: `<= 0.25` or `= 0`; `informational` for a value without a target.
    pub target: String,
    /// Whether the value meets the target; none without a target. A value that could not be measured misses its target.
    pub ok: Option<bool>,
    /// The target itself.
    #[serde(skip)]
    against: Target,
}

impl Check {
    /// A value that must not exceed `limit`.
    #[must_use]
    pub fn at_most(name: impl Into<String>, value: f64, unit: &'static str, limit: f64) -> Self {
        Self::new(name.into(), value, unit, Target::AtMost(limit))
    }

    /// A value that must reach `limit`.
    #[must_use]
    pub fn at_least(name: impl Into<String>, value: f64, unit: &'static str, limit: f64) -> Self {
        Self::new(name.into(), value, unit, Target::AtLeast(limit))
    }

    /// A value that must be `wanted`.
    #[must_use]
    pub fn exactly(name: impl Into<String>, value: f64, unit: &'static str, wanted: f64) -> Self {
        Self::new(name.into(), value, unit, Target::Exactly(wanted))
    }

    /// A value that must lie between `least` and `most`, both included.
    #[must_use]
    pub fn within(name: impl Into<String>, value: f64, unit: &'static str, least: f64, most: f64) -> Self {
        Self::new(name.into(), value, unit, Target::Within(least, most))
    }

    /// A value without a target, given for comparison.
    #[must_use]
    pub fn informational(name: impl Into<String>, value: f64, unit: &'static str) -> Self {
        Self::new(name.into(), value, unit, Target::Informational)
    }

    fn new(name: String, value: f64, unit: &'static str, target: Target) -> Self {
        let measured = value.is_finite();
        let (words, met) = match target {
            Target::AtMost(limit) => (format!("<= {}", short(limit)), Some(value <= limit)),
            Target::AtLeast(limit) => (format!(">= {}", short(limit)), Some(value >= limit)),
            Target::Exactly(wanted) => (format!("= {wanted}"), Some(value == wanted)),
            Target::Within(least, most) => {
                (format!("{least} to {most}"), Some((least..=most).contains(&value)))
            }
            Target::Informational => ("informational".into(), None),
        };
        let value = measured.then_some(value);
        Self { name, value, unit, target: words, ok: met.map(|met| measured && met), against: target }
    }

    /// Whether the value misses its target; never without one.
    #[must_use]
    pub fn missed(&self) -> bool {
        self.ok == Some(false)
    }

    /// Returns the verdict for a table: nothing without a target.
    #[must_use]
    pub fn verdict(&self) -> &'static str {
        match self.ok {
            Some(true) => "ok",
            Some(false) => "MISSED",
            None => "",
        }
    }

    /// The same figure without a target.
    #[must_use]
    pub fn without_target(&self) -> Self {
        Self::new(self.name.clone(), self.value.unwrap_or(f64::NAN), self.unit, Target::Informational)
    }

    /// Whether the value is a relative error above 1000 %, which says that the estimate means nothing.
    fn absurd(&self) -> bool {
        let value = self.value.unwrap_or(0.0).abs();
        // Frames that were missed are counted, and no error.
        let error = ["error", "slosh"].iter().any(|word| self.name.contains(word))
            || self.name.split('_').any(|word| word == "miss");
        error && (self.unit == "%" && value > 1000.0 || self.unit == "1" && value > 10.0)
    }

    /// The same figure with another value, held against the same target.
    #[must_use]
    pub fn with(&self, name: impl Into<String>, value: f64) -> Self {
        Self::new(name.into(), value, self.unit, self.against)
    }

    /// Returns a measure of how bad `value` is: the larger the worse. Of a figure without a target the larger one counts
    /// as the worse, as most are errors.
    #[must_use]
    pub fn badness(&self, value: f64) -> f64 {
        match self.against {
            Target::AtMost(_) | Target::Informational => value,
            Target::AtLeast(_) => -value,
            Target::Exactly(wanted) => (value - wanted).abs(),
            Target::Within(least, most) => (value - 0.5 * (least + most)).abs(),
        }
    }
}

/// A table of checks for a person, one a line.
#[must_use]
pub fn table(checks: &[Check]) -> String {
    let width = checks.iter().map(|check| check.name.len()).max().unwrap_or(0);
    let line = |check: &Check| {
        let value = check.value.map_or("not measured".into(), number);
        let absurd = if check.absurd() { " above 1000 %: this estimate means nothing" } else { "" };
        let line = format!(
            "  {:width$}  {value:>12} {:<6} {:<13} {}{absurd}",
            check.name,
            check.unit,
            check.target,
            check.verdict()
        );
        format!("{}\n", line.trim_end())
    };
    checks.iter().map(line).collect()
}

/// Returns a limit as it was written, or with four significant digits if it was computed and has many.
fn short(limit: f64) -> String {
    let whole = limit.to_string();
    if whole.len() <= 8 { whole } else { number(limit) }
}

/// Four significant digits, without an exponent where one can do without.
fn number(value: f64) -> String {
    match value.abs() {
        0.0 => "0".into(),
        size if (1e-3..1e6).contains(&size) => {
            let decimals = (3 - size.log10().floor() as i32).clamp(0, 6) as usize;
            format!("{value:.decimals$}")
        }
        _ => format!("{value:.2e}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ok_follows_from_value_and_target() {
        assert_eq!(Check::at_most("a", 0.25, "", 0.25).ok, Some(true));
        assert!(Check::at_most("a", 0.26, "", 0.25).missed());
        assert_eq!(Check::at_least("a", 58.0, "", 58.0).ok, Some(true));
        assert!(Check::at_least("a", 57.9, "", 58.0).missed());
        assert!(Check::exactly("a", 1.0, "", 0.0).missed());
        let unmeasured = Check::at_most("a", f64::NAN, "", 1.0);
        assert!(unmeasured.missed() && unmeasured.value.is_none());
    }

    #[test]
    fn a_computed_limit_is_shortened_in_words_alone() {
        let check = Check::at_most("a", 87.570_09, "%", 87.570_096_620_021_73);
        assert_eq!((check.target.as_str(), check.ok), ("<= 87.57", Some(true)));
        assert_eq!(Check::at_least("a", 1.0, "", 0.000_001).target, ">= 0.000001");
    }

    #[test]
    fn a_row_without_a_target_has_no_verdict() {
        for value in [1.0, f64::INFINITY] {
            let check = Check::informational("a", value, "");
            assert!(check.ok.is_none() && !check.missed());
            assert!(serde_json::to_value(&check).expect("JSON")["ok"].is_null());
        }
        let text = table(&[Check::informational("cost", 1.0, "s")]);
        assert!(text.trim_end().ends_with("informational") && !text.contains("ok"), "{text}");
        let late = Check::exactly("late", 3.0, "1", 0.0).without_target();
        assert!(late.value == Some(3.0) && late.ok.is_none());
    }

    #[test]
    fn an_absurd_error_is_marked() {
        for (check, marked) in [
            (Check::informational("field_error_tau", 616.8, "1"), true),
            (Check::at_most("surface_slosh_rel", 2000.0, "%", 5.0), true),
            (Check::informational("field_error_tau", 0.5, "1"), false),
            (Check::informational("bytes_after", 1e6, "1"), false),
            (Check::informational("miss_of_the_wave", 41.0, "1"), true),
            (Check::informational("deadline_300hz_missed", 41.0, "1"), false),
            (Check::informational("deadline_misses", 219.0, "1"), false),
        ] {
            assert_eq!(table(&[check]).contains("means nothing"), marked);
        }
    }

    #[test]
    fn the_table_says_what_was_missed() {
        let text = table(&[Check::at_most("drift", 3e-9, "1", 1e-6), Check::exactly("falls", 2.0, "1", 0.0)]);
        assert!(text.contains("drift       3.00e-9"), "{text}");
        assert!(text.lines().nth(1).is_some_and(|line| line.contains("2.000") && line.ends_with("MISSED")));
    }
}
