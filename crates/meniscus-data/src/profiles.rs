//! Profiles as CSV: one line an instant, an empty field where a point was not seen.
//!
//! `sequence,captured_us,glass_x_m,z0_m..z20_m,s0_m..s20_m`, heights and their standard deviations.

use meniscus::surface::{POINTS, SurfaceProfile};
use meniscus::units::Micros;
use std::fmt::Write;

/// A line that is no profile.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ProfileError {
    /// Number of the line, from 1.
    pub line: usize,
    /// Fault of the line.
    pub why: String,
}

impl std::fmt::Display for ProfileError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "line {}: {}", self.line, self.why)
    }
}

impl std::error::Error for ProfileError {}

/// The table of some profiles.
#[must_use]
pub fn profiles_to_csv(profiles: &[SurfaceProfile]) -> String {
    let mut text = heading();
    for profile in profiles {
        // Writing into a string cannot fail.
        let _ = write!(text, "{},{},", profile.sequence, profile.captured.0);
        let _ = profile.glass_x_m.map(|x| write!(text, "{x}"));
        for values in [profile.height_m, profile.variance_m2.map(f32::sqrt)] {
            for (value, valid) in values.iter().zip(profile.valid) {
                text.push(',');
                let _ = valid.then(|| write!(text, "{value}"));
            }
        }
        text.push('\n');
    }
    text
}

fn heading() -> String {
    let names = |letter: &str| (0..POINTS).map(|i| format!(",{letter}{i}_m")).collect::<String>();
    format!("sequence,captured_us,glass_x_m{}{}\n", names("z"), names("s"))
}

/// Reads such a table.
///
/// # Errors
/// [`ProfileError`] names the first line that is no profile; numbers must be finite.
pub fn profiles_from_csv(text: &str) -> Result<Vec<SurfaceProfile>, ProfileError> {
    let mut profiles: Vec<SurfaceProfile> = Vec::new();
    for (line, content) in text.lines().enumerate().map(|(i, l)| (i + 1, l.trim_end())) {
        if content.is_empty() || (line == 1 && content == heading().trim_end()) {
            continue;
        }
        let profile = profile(content).map_err(|why| ProfileError { line, why })?;
        if profiles.last().is_some_and(|last| profile.captured <= last.captured) {
            return Err(ProfileError { line, why: "the time does not come after the one before".into() });
        }
        profiles.push(profile);
    }
    Ok(profiles)
}

fn profile(content: &str) -> Result<SurfaceProfile, String> {
    let fields: Vec<&str> = content.split(',').map(str::trim).collect();
    if fields.len() != 3 + 2 * POINTS {
        return Err(format!("{} fields instead of {}", fields.len(), 3 + 2 * POINTS));
    }
    let number = |field: usize| -> Result<Option<f32>, String> {
        let text = fields[field];
        if text.is_empty() {
            return Ok(None);
        }
        let value: f32 = text.parse().map_err(|_| format!("field {}: '{text}' is no number", field + 1))?;
        if value.is_finite() {
            Ok(Some(value))
        } else {
            Err(format!("field {}: '{text}' is not finite", field + 1))
        }
    };
    let whole = |field: usize| -> Result<u64, String> {
        fields[field]
            .parse()
            .map_err(|_| format!("field {}: '{}' is no whole number", field + 1, fields[field]))
    };
    let mut profile = SurfaceProfile {
        height_m: [0.0; POINTS],
        variance_m2: [0.0; POINTS],
        valid: [false; POINTS],
        glass_x_m: number(2)?,
        sequence: u32::try_from(whole(0)?).map_err(|_| String::from("field 1: the number is too large"))?,
        captured: Micros(whole(1)?),
    };
    for point in 0..POINTS {
        match (number(3 + point)?, number(3 + POINTS + point)?) {
            (Some(height_m), Some(deviation_m)) if (0.0..1e6).contains(&deviation_m) => {
                profile.height_m[point] = height_m;
                profile.variance_m2[point] = deviation_m * deviation_m;
                profile.valid[point] = true;
            }
            (None, None) => {}
            _ => {
                return Err(format!(
                    "point {point} needs a height and a deviation that is not negative, or neither"
                ));
            }
        }
    }
    Ok(profile)
}
