//! How the glass is moved: along x, from rest to rest, position and acceleration exact at any time.
//!
//! Every motion is a chain of polynomials in time, so that position and acceleration belong to one
//! another to the last bit. On the command line a motion is `kind:seed`, or the path of a CSV file.

mod csv;
mod spline;
mod strokes;
mod waves;

use crate::offline::prelude::*;
use std::path::PathBuf;

/// The glass rests this long at the start, s.
pub const REST_S: f64 = 0.3;

/// Farthest the glass may go from where it started, m.
pub const REACH_M: f64 = 0.060;

/// Strongest acceleration of a scripted motion, m/s2; crests in glycerine stay below about 20 mm.
pub const STRONGEST_M_S2: f64 = 3.5;

/// Shortest recording of a scripted motion, s.
const SHORTEST_S: f64 = 1.5;

/// The kinds that the command line knows, and what each is.
pub const KINDS: [(&str, &str); 5] = [
    ("still", "no motion"),
    ("strokes", "smooth strokes of 20 to 60 mm with rests between them"),
    ("sweep", "a sine whose frequency rises through the first slosh mode"),
    ("jolts", "short half-sine pushes, each caught by an equal one the other way"),
    ("random", "a random motion between 0.5 and 4.5 Hz"),
];

/// Why a motion could not be had.
#[derive(Debug)]
pub enum MotionError {
    /// Neither a known kind with a seed nor a file.
    Unknown(String),
    /// The file could not be read.
    Io(PathBuf, std::io::Error),
    /// The file is not a motion.
    Malformed {
        /// The file.
        path: PathBuf,
        /// Line, from 1.
        line: usize,
        /// What is wrong there.
        why: String,
    },
    /// The recording is too short for a scripted motion.
    Short(f64),
}

impl std::fmt::Display for MotionError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Unknown(spec) => {
                let kinds: Vec<_> = KINDS.iter().map(|(kind, _)| *kind).collect();
                write!(
                    f,
                    "no motion is spelled '{spec}': write KIND:SEED with KIND one of {} and SEED a whole number \
                     (strokes:7), or the path of a CSV file of times and positions",
                    kinds.join(", ")
                )
            }
            Self::Io(path, error) => write!(f, "{}: {error}", path.display()),
            Self::Malformed { path, line, why } => write!(f, "{}, line {line}: {why}", path.display()),
            Self::Short(seconds) => {
                write!(f, "{seconds} s is too short for a scripted motion: give at least {SHORTEST_S} s")
            }
        }
    }
}

impl std::error::Error for MotionError {}

/// One polynomial piece: `x(t) = sum_k coefficient[k] (t - start)^k`, valid until the next piece starts.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Piece {
    start_s: f64,
    coefficient: [f64; 6],
}

/// A scripted motion; before its first piece the glass rests at zero.
#[derive(Clone, Debug, PartialEq)]
pub struct Motion {
    /// As the command line spells it.
    pub spelling: String,
    /// The seed in the spelling, 0 if there is none.
    pub seed: u64,
    pieces: Vec<Piece>,
}

impl Motion {
    /// The motion that `spelling` names, for a recording of `seconds`.
    ///
    /// # Errors
    /// When there is no such motion, or its file is wrong.
    pub fn parse(spelling: &str, seconds: f64) -> Result<Self, MotionError> {
        let (kind, seed) = spelling.split_once(':').unwrap_or((spelling, "0"));
        let Some(&(kind, _)) = KINDS.iter().find(|(k, _)| *k == kind) else {
            let path = PathBuf::from(spelling);
            if path.extension().is_none() && !path.exists() {
                return Err(MotionError::Unknown(spelling.into()));
            }
            return Ok(Self { spelling: spelling.into(), seed: 0, pieces: csv::read(&path)? });
        };
        let seed: u64 = seed.parse().map_err(|_| MotionError::Unknown(spelling.into()))?;
        if kind != "still" && (seconds.is_nan() || seconds < SHORTEST_S) {
            return Err(MotionError::Short(seconds));
        }
        // A free decay ends every recording: a fifth of it, at most a second.
        let end_s = seconds - (0.2 * seconds).min(1.0);
        let pieces = match kind {
            "strokes" => strokes::strokes(seed, end_s),
            "sweep" => waves::sweep(seed, end_s),
            "jolts" => waves::jolts(seed, end_s),
            "random" => waves::random(seed, end_s),
            _ => Vec::new(),
        };
        Ok(Self { spelling: spelling.into(), seed, pieces })
    }

    fn piece(&self, time_s: f64) -> Option<(&Piece, f64)> {
        let after = self.pieces.partition_point(|p| p.start_s <= time_s);
        let piece = self.pieces.get(after.checked_sub(1)?)?;
        Some((piece, time_s - piece.start_s))
    }

    /// Position at `time_s`, m.
    #[must_use]
    pub fn position(&self, time_s: f64) -> f64 {
        self.piece(time_s).map_or(0.0, |(p, t)| p.coefficient.iter().rev().fold(0.0, |sum, c| sum * t + c))
    }

    /// Acceleration at `time_s`, m/s2.
    #[must_use]
    pub fn acceleration(&self, time_s: f64) -> f64 {
        self.piece(time_s).map_or(0.0, |(p, t)| {
            let [_, _, c2, c3, c4, c5] = p.coefficient;
            2.0 * c2 + t * (6.0 * c3 + t * (12.0 * c4 + t * 20.0 * c5))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_kind_keeps_its_limits_and_its_acceleration_is_its_second_derivative() {
        for (kind, _) in KINDS {
            for seed in 0..20 {
                let motion = Motion::parse(&format!("{kind}:{seed}"), 4.0).expect("a known kind");
                let h = 1e-4;
                for i in 0..4000 {
                    let t = i as f64 * 1e-3 + 0.5e-3;
                    let [a, b, c] = [t - h, t, t + h].map(|t| motion.position(t));
                    // A spline may overshoot its samples by a little.
                    assert!(b.abs() <= REACH_M + 1e-6, "{kind}:{seed} is at {b} m at {t} s");
                    assert!(motion.acceleration(t).abs() <= 1.02 * STRONGEST_M_S2, "{kind}:{seed} at {t} s");
                    let second = (a - 2.0 * b + c) / (h * h);
                    assert!((second - motion.acceleration(t)).abs() < 0.1, "{kind}:{seed} at {t} s");
                    if !(REST_S..=3.2).contains(&t) {
                        assert!(motion.acceleration(t).abs() < 1e-6, "{kind}:{seed} does not rest at {t} s");
                    }
                }
            }
        }
    }

    #[test]
    fn seeds_differ_and_repeat() {
        let at = |spelling: &str| Motion::parse(spelling, 4.0).expect("a known kind").position(1.3);
        assert_eq!(at("strokes:1"), at("strokes:1"));
        assert_ne!(at("strokes:1"), at("strokes:2"));
    }

    #[test]
    fn wrong_spellings_are_refused() {
        for wrong in ["stroke:1", "strokes:x", "strokes:-1", ""] {
            assert!(matches!(Motion::parse(wrong, 4.0), Err(MotionError::Unknown(_))), "{wrong}");
        }
        assert!(matches!(Motion::parse("strokes:1", f64::NAN), Err(MotionError::Short(_))));
    }
}
