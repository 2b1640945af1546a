//! Motion files: CSV, joined by cubic splines.
//!
//! ```text
//! # pivot_m = 0, 0.05             where the glass is inclined about; the middle of its bottom otherwise
//! t, x_m, y_m, z_m, tilt_rad      the columns, by name, in any order after t; each but t may lack; y: away from the camera
//! 0.00, 0.000, 0.000, 0.000, 0.0
//! ```
//! Every name has its unit ([`super::columns`]). Without a heading there are two columns, `time_s, position_m` along x,
//! which may span 1 m at most. The first positions along x, y and z count as zero; the inclination has to start at zero.

use super::columns::Columns;
use super::kinematics::Channel;
use super::{MotionError, Pivoted, spline};
use meniscus_platform::files::read_text;
use std::path::Path;

/// Longest gap between two samples, s: a longer one would leave the acceleration to invention.
const LONGEST_GAP_S: f64 = 0.1;

/// Largest inclination, rad.
const STEEPEST_RAD: f64 = 0.6;

/// Longest way of a table without a heading, m: a longer one is hardly in metres.
const LONGEST_UNNAMED_M: f64 = 1.0;

/// The motion in the file at `path`; lines that start with `#` are skipped but for the pivot.
pub(super) fn read(path: &Path) -> Result<Pivoted, MotionError> {
    parse(path, &read_text(path).map_err(|e| MotionError::Io(path.into(), e))?)
}

/// The motion that `text` describes; `path` names it in errors.
fn parse(path: &Path, text: &str) -> Result<Pivoted, MotionError> {
    let mut out = Pivoted::default();
    let mut columns = Columns::default();
    let mut rows: Vec<(f64, [f64; 4])> = Vec::new();
    let (mut first, mut named) = (true, false);
    for (line, content) in text.lines().enumerate().map(|(i, l)| (i + 1, l.trim())) {
        let malformed = |why: String| MotionError::Malformed { path: path.into(), line, why };
        if let Some(comment) = content.strip_prefix('#') {
            if let Some(place) = comment.trim().strip_prefix("pivot_m") {
                out.pivot_m = pivot(place).ok_or_else(|| {
                    malformed(format!(
                        "expected '# pivot_m = X, Z' within 1 m of the glass, found '{content}'"
                    ))
                })?;
            }
            continue;
        }
        if content.is_empty() {
            continue;
        }
        let fields: Vec<&str> = content.split(',').map(str::trim).collect();
        if std::mem::take(&mut first) && fields[0].parse::<f64>().is_err() {
            columns = Columns::named(&fields).map_err(malformed)?;
            named = true;
            continue;
        }
        let numbers: Vec<f64> = fields.iter().map_while(|field| field.parse().ok()).collect();
        if numbers.len() != fields.len() || fields.len() != columns.count() {
            return Err(malformed(format!("expected '{columns}' as numbers, found '{content}'")));
        }
        if numbers.iter().any(|number| !number.is_finite()) {
            return Err(malformed(format!("'{content}' is not finite")));
        }
        let (time, place) = columns.si(&numbers);
        if place[3].abs() > STEEPEST_RAD {
            return Err(malformed(format!("an inclination of {} rad; at most {STEEPEST_RAD}", place[3])));
        }
        match rows.last() {
            None if place[3] != 0.0 => {
                let why = "the glass must start upright; a constant inclination is the effect container_tilt";
                return Err(malformed(format!("it starts at {} rad: {why}", place[3])));
            }
            Some(&(last, _)) if time <= last => {
                return Err(malformed(format!(
                    "time {time} s does not come after {last} s: sort the rows by time"
                )));
            }
            Some(&(last, _)) if time - last > LONGEST_GAP_S => {
                return Err(malformed(format!(
                    "a gap of {:.3} s; at most {LONGEST_GAP_S} s: sample the motion more often",
                    time - last
                )));
            }
            _ => {}
        }
        rows.push((time, place));
    }
    if rows.len() < 2 {
        let why = format!("a motion needs two samples or more, and this file has {}", rows.len());
        return Err(MotionError::Malformed { path: path.into(), line: text.lines().count().max(1), why });
    }
    if !named {
        let along = rows.iter().map(|(_, place)| place[0]);
        let span_m = along.clone().fold(f64::MIN, f64::max) - along.fold(f64::MAX, f64::min);
        if span_m > LONGEST_UNNAMED_M {
            let why = format!(
                "without a heading the second column is x in metres, and it spans {span_m} m: name the columns and their \
                 units in the first line (t,x_mm or t,x_m)"
            );
            return Err(MotionError::Malformed { path: path.into(), line: 1, why });
        }
    }
    for column in columns.coordinates() {
        let samples: Vec<_> = rows.iter().map(|(t, place)| (*t, place[column] - rows[0].1[column])).collect();
        out.channels[column] = Channel(spline::through(&samples));
    }
    Ok(out)
}

/// `= X, Z`.
fn pivot(text: &str) -> Option<[f64; 2]> {
    let (x, z) = text.trim().strip_prefix('=')?.split_once(',')?;
    let place = [x.trim().parse().ok()?, z.trim().parse().ok()?];
    place.iter().all(|p: &f64| p.abs() <= 1.0).then_some(place)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refusal(text: &str) -> String {
        format!("{}", parse(Path::new("motion.csv"), text).expect_err(text))
    }

    #[test]
    fn a_heading_and_comments_are_skipped_and_the_first_position_is_zero() {
        let motion = parse(Path::new("m.csv"), "time, x_m\n# robot\n0, 0.5\n0.05, 0.5\n0.1, 0.51\n")
            .expect("a motion");
        let pieces = &motion.channels[0].0;
        assert_eq!(pieces.len(), 3);
        assert_eq!(pieces[0].coefficient[0], 0.0);
        assert!((pieces[2].coefficient[0] - 0.01).abs() < 1e-12);
    }

    #[test]
    fn named_columns_reach_their_coordinates() {
        let text = "# pivot_m = 0.01, 0.05\nt, tilt_rad, z_m, y_m\n0, 0, 1, 2\n0.05, 0.1, 1.2, 2.3\n";
        let motion = parse(Path::new("m.csv"), text).expect("a motion");
        let ends: Vec<_> = motion.channels.iter().map(|channel| channel.value(0.05)).collect();
        assert_eq!(motion.pivot_m, [0.01, 0.05]);
        let expected = [0.0, 0.3, 0.2, 0.1];
        assert!(ends.iter().zip(expected).all(|(end, e)| (end - e).abs() < 1e-12), "{ends:?}");
    }

    #[test]
    fn gaps_disorder_and_nonsense_are_refused_with_their_line() {
        assert!(refusal("0,0\n0.2,0\n").contains("line 2: a gap of 0.200 s"));
        assert!(refusal("0,0\n0.05,nan\n").contains("not finite"));
        assert!(refusal("0.05,0\n0.05,0\n").contains("does not come after"));
        assert!(refusal("0,0\n0.05,0,1\n").contains("expected"));
        assert!(refusal("0,0\n").contains("two samples"));
        let far = refusal("0,0\n0.05,20\n");
        assert!(far.contains("spans 20 m") && far.contains("t,x_mm"), "{far}");
        assert!(refusal("t,tilt_rad\n0,0.2\n").contains("line 2: it starts at 0.2 rad"));
        assert!(refusal("t,tilt_rad\n0,0\n0.1,0.7\n").contains("line 3: an inclination of 0.7 rad"));
        assert!(refusal("# pivot_m = 3, 0\n0,0\n0.1,0\n").contains("line 1: expected '# pivot_m"));
    }
}
