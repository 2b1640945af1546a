//! Motion of the glass: along x, away from the camera, upwards and by inclination about a pivot, from rest to rest,
//! position and acceleration exact at any time.
//!
//! Every motion is a chain of polynomials in time, so that position and acceleration belong to one
//! another to the last bit. On the command line a motion is `kind:seed`, `kind:seedxSCALE` for one of
//! SCALE times the travel (low-viscosity liquids leave the glass at the full one; up to 1.2, more than models are trained
//! on), or the path of a CSV file.

mod columns;
mod csv;
mod error;
mod kinematics;
mod spline;
mod strokes;
mod waves;

pub use error::MotionError;
pub use kinematics::Kinematics;

use kinematics::{Channel, Piece};
use std::path::PathBuf;

/// The glass rests this long at the start, s.
pub const REST_S: f64 = 0.3;

/// Farthest the glass may go from where it started, m.
pub const REACH_M: f64 = 0.060;

/// Strongest acceleration of a scripted motion, m/s2; crests in glycerine stay below about 20 mm.
pub const STRONGEST_M_S2: f64 = 3.5;

/// Inclination for a metre of stroke in `tilts` and `carry`: 60 mm become 0.15 rad, and the surface is
/// accelerated by up to 0.6 m/s2.
const TILT_RAD_PER_M: f64 = 2.5;

/// Sideways deviation of a hand that moves along x, per unit of travel: a guess, 6 mm at most.
const OUT_OF_LINE: f64 = 0.1;

/// Least and largest part of its way that a motion may be scaled to: a fifth more than any model is trained on, to see what
/// becomes of it there.
pub(super) const SCALES: [f64; 2] = [0.01, 1.2];

/// Shortest recording of a scripted motion, s.
const SHORTEST_S: f64 = 1.5;

/// The kinds that the command line knows, and what each is.
pub const KINDS: [(&str, &str); 9] = [
    ("still", "no motion"),
    ("strokes", "smooth strokes of 20 to 60 mm with rests between them"),
    ("sweep", "a sine whose frequency rises through the first slosh mode"),
    ("jolts", "short half-sine pushes, each caught by an equal one the other way"),
    ("random", "a random motion between 0.5 and 4.5 Hz"),
    ("hand", "strokes, and a tenth as large ones away from the camera and back: a line drawn by hand"),
    ("heave", "smooth strokes of 20 to 60 mm upwards and downwards"),
    ("tilts", "smooth inclinations of up to 0.15 rad about the middle of the bottom"),
    ("carry", "strokes, half as large heaves and inclinations at once"),
];

/// Coordinates along x, away from the camera and upwards (m) and of inclination (rad), and the pivot that they belong to.
#[derive(Clone, Debug, Default, PartialEq)]
struct Pivoted {
    channels: [Channel; 4],
    pivot_m: [f64; 2],
}

/// A coordinate that stays where it is.
fn none() -> Channel {
    Channel::default()
}

/// A motion of the glass; before it begins the glass rests at zero.
#[derive(Clone, Debug, PartialEq)]
pub struct Motion {
    /// As the command line spells it.
    pub spelling: String,
    /// The seed in the spelling, 0 if there is none.
    pub seed: u64,
    course: Pivoted,
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
            return Ok(Self { spelling: spelling.into(), seed: 0, course: csv::read(&path)? });
        };
        let (seed, scale) = seed.split_once('x').unwrap_or((seed, "1"));
        let seed: u64 = seed.parse().map_err(|_| MotionError::Unknown(spelling.into()))?;
        let scale: f64 = scale.parse().map_err(|_| MotionError::Unknown(spelling.into()))?;
        let [least, most] = SCALES;
        if !(least..=most).contains(&scale) {
            return Err(MotionError::Scale(scale));
        }
        if kind != "still" && (seconds.is_nan() || seconds < SHORTEST_S) {
            return Err(MotionError::Short(seconds));
        }
        // A free decay ends every recording: a fifth of it, at most a second.
        let end_s = seconds - (0.2 * seconds).min(1.0);
        let strokes = |seed| Channel(strokes::strokes(seed, end_s));
        let tilts = |seed| strokes(seed).scaled(TILT_RAD_PER_M);
        // Seeds far from one another, so that courses of one motion are not those of neighbours.
        let (aside, upwards, turned) = (seed ^ 0x51de << 32, seed ^ 0x5eed << 32, seed ^ 0x7117 << 32);
        let channels = match kind {
            "strokes" => [strokes(seed), none(), none(), none()],
            "sweep" => [Channel(waves::sweep(seed, end_s)), none(), none(), none()],
            "jolts" => [Channel(waves::jolts(seed, end_s)), none(), none(), none()],
            "random" => [Channel(waves::random(seed, end_s)), none(), none(), none()],
            "hand" => [strokes(seed), strokes(aside).scaled(OUT_OF_LINE), none(), none()],
            "heave" => [none(), none(), strokes(seed), none()],
            "tilts" => [none(), none(), none(), tilts(seed)],
            "carry" => [strokes(seed), none(), strokes(upwards).scaled(0.5), tilts(turned)],
            _ => Default::default(),
        };
        let channels = channels.map(|channel| channel.scaled(scale));
        let course = Pivoted { channels, pivot_m: [0.0; 2] };
        Ok(Self { spelling: spelling.into(), seed, course })
    }

    /// A motion along x through `samples` of time (s) and place (m), joined by a cubic spline; `None` of
    /// fewer than two samples, or of times that do not rise.
    #[must_use]
    pub fn sampled(samples: &[(f64, f64)]) -> Option<Self> {
        if samples.len() < 2 || samples.windows(2).any(|w| w[1].0 <= w[0].0) {
            return None;
        }
        let channels = [Channel(spline::through(samples)), none(), none(), none()];
        let course = Pivoted { channels, pivot_m: [0.0; 2] };
        Some(Self { spelling: "samples".into(), seed: 0, course })
    }

    /// First time of a table, s; 0 of a motion that has none.
    #[must_use]
    pub fn start_s(&self) -> f64 {
        let starts = self.course.channels.iter().filter_map(|channel| channel.0.first());
        starts.map(|piece| piece.start_s).reduce(f64::min).unwrap_or(0.0)
    }

    /// From when on the glass rests: the last time of a table; s.
    #[must_use]
    pub fn end_s(&self) -> f64 {
        let ends = self.course.channels.iter().filter_map(|channel| channel.0.last());
        ends.map(|piece| piece.start_s).fold(0.0, f64::max)
    }

    /// When the part of the motion along x that holds at `time_s` began (a stroke or the rest after it, a stretch of a
    /// table), s; 0 before the first.
    #[must_use]
    pub fn began_s(&self, time_s: f64) -> f64 {
        self.course.channels[0].began_s(time_s).unwrap_or(0.0)
    }

    /// Position along x at `time_s`, m.
    #[must_use]
    pub fn position(&self, time_s: f64) -> f64 {
        self.course.channels[0].value(time_s)
    }

    /// Acceleration along x at `time_s`, m/s2.
    #[must_use]
    pub fn acceleration(&self, time_s: f64) -> f64 {
        self.course.channels[0].acceleration(time_s)
    }

    /// Place behind where it started, away from the camera, at `time_s`, m.
    #[must_use]
    pub fn away(&self, time_s: f64) -> f64 {
        self.course.channels[1].value(time_s)
    }

    /// Height of the pivot over where it started at `time_s`, m.
    #[must_use]
    pub fn height(&self, time_s: f64) -> f64 {
        self.course.channels[2].value(time_s)
    }

    /// Inclination towards +x at `time_s`, rad.
    #[must_use]
    pub fn tilt(&self, time_s: f64) -> f64 {
        self.course.channels[3].value(time_s)
    }

    /// The point of the glass that is moved and about which it is inclined: x and z from the middle of
    /// its bottom, m.
    #[must_use]
    pub fn pivot_m(&self) -> [f64; 2] {
        self.course.pivot_m
    }

    /// Everything about the motion at `time_s` that the liquid feels.
    #[must_use]
    pub fn kinematics(&self, time_s: f64) -> Kinematics {
        let [x, y, z, tilt] = &self.course.channels;
        Kinematics {
            acceleration_m_s2: [x, y, z].map(|along| along.acceleration(time_s)),
            tilt_rad: tilt.value(time_s),
            tilt_rate: tilt.rate(time_s),
            tilt_acceleration: tilt.acceleration(time_s),
            pivot_m: self.course.pivot_m,
        }
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
        assert!((at("strokes:1x0.4") - 0.4 * at("strokes:1")).abs() < 1e-15);
    }

    #[test]
    fn a_stroke_says_when_it_began() {
        let motion = Motion::parse("strokes:1", 4.0).expect("a known kind");
        assert_eq!(motion.began_s(0.1), 0.0);
        assert_eq!(motion.began_s(REST_S), REST_S);
        assert_eq!(motion.began_s(REST_S + 0.2), REST_S, "a stroke lasts 0.25 s at least");
        assert!(motion.began_s(3.9) > 2.0);
    }

    #[test]
    fn wrong_spellings_are_refused() {
        for wrong in ["stroke:1", "strokes:x", "strokes:1x", "strokes:1xx2", "strokes:-1", ""] {
            assert!(matches!(Motion::parse(wrong, 4.0), Err(MotionError::Unknown(_))), "{wrong}");
        }
        assert!(matches!(Motion::parse("strokes:1", f64::NAN), Err(MotionError::Short(_))));
        assert!(matches!(Motion::parse("strokes:1x1.5", 4.0), Err(MotionError::Scale(_))));
    }
}
