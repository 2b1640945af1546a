//! Motion files: CSV lines `time_s, position_m`, joined by a cubic spline.

use super::{MotionError, Piece, spline};
use crate::offline::prelude::*;
use std::path::Path;

/// Longest gap between two samples, s: a longer one would leave the acceleration to invention.
const LONGEST_GAP_S: f64 = 0.1;

/// The motion in the file at `path`; lines that start with `#`, and one heading, are skipped. The
/// first position counts as zero.
pub(super) fn read(path: &Path) -> Result<Vec<Piece>, MotionError> {
    parse(path, &std::fs::read_to_string(path).map_err(|e| MotionError::Io(path.into(), e))?)
}

/// The motion that `text` describes; `path` names it in errors.
fn parse(path: &Path, text: &str) -> Result<Vec<Piece>, MotionError> {
    let mut samples: Vec<(f64, f64)> = Vec::new();
    let mut origin = 0.0;
    for (line, content) in text.lines().enumerate().map(|(i, l)| (i + 1, l.trim())) {
        if content.is_empty() || content.starts_with('#') {
            continue;
        }
        let malformed = |why: String| MotionError::Malformed { path: path.into(), line, why };
        let mut fields = content.split(',').map(str::trim).map(str::parse::<f64>);
        let (time, position) = match (fields.next(), fields.next(), fields.next()) {
            (Some(Ok(time)), Some(Ok(position)), None) => (time, position),
            (Some(Err(_)), _, _) if samples.is_empty() && line == 1 => continue,
            _ => return Err(malformed(format!("expected 'time_s, position_m', found '{content}'"))),
        };
        if !time.is_finite() || !position.is_finite() {
            return Err(malformed(format!("'{content}' is not finite")));
        }
        match samples.last() {
            None => origin = position,
            Some(&(last, _)) if time <= last => {
                return Err(malformed(format!("time {time} s does not come after {last} s")));
            }
            Some(&(last, _)) if time - last > LONGEST_GAP_S => {
                return Err(malformed(format!("a gap of {:.3} s; at most {LONGEST_GAP_S} s", time - last)));
            }
            Some(_) => {}
        }
        samples.push((time, position - origin));
    }
    if samples.len() < 2 {
        let why = "a motion needs two samples or more".into();
        return Err(MotionError::Malformed { path: path.into(), line: text.lines().count(), why });
    }
    Ok(spline::through(&samples))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refusal(text: &str) -> String {
        format!("{}", parse(Path::new("motion.csv"), text).expect_err(text))
    }

    #[test]
    fn a_heading_and_comments_are_skipped_and_the_first_position_is_zero() {
        let pieces =
            parse(Path::new("m.csv"), "time, x\n# robot\n0, 0.5\n0.05, 0.5\n0.1, 0.51\n").expect("a motion");
        assert_eq!(pieces.len(), 3);
        assert_eq!(pieces[0].coefficient[0], 0.0);
        assert!((pieces[2].coefficient[0] - 0.01).abs() < 1e-12);
    }

    #[test]
    fn gaps_disorder_and_nonsense_are_refused_with_their_line() {
        assert!(refusal("0,0\n0.2,0\n").contains("line 2: a gap of 0.200 s"));
        assert!(refusal("0,0\n0.05,nan\n").contains("not finite"));
        assert!(refusal("0.05,0\n0.05,0\n").contains("does not come after"));
        assert!(refusal("0,0\n0.05,0,1\n").contains("expected"));
        assert!(refusal("0,0\n").contains("two samples"));
    }
}
