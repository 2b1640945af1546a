//! A known liquid on a glass, and several of them on the same one.

use super::evidence::{Calibration, Evidence, FrameResidual};
use super::oscillation::{Change, Swing, Tone};
use super::posterior::{Verdict, posterior};
use super::slope::slope;
use crate::surface::SurfaceProfile;
use crate::units::FRAME_INTERVAL_S;

/// Share of what a reading says that the oscillator takes over each frame: it forgets a wrong start in half a second,
/// and predicts for about as long.
const PULL: f64 = 0.03;

/// Height of a wave that some liquid has to predict for a frame to count, m: a liquid at rest has no name.
const MOVED_M: f64 = 1e-3;

/// Frames after a start in the midst of a slosh before they count.
pub const SETTLING_FRAMES: u32 = 60;

/// Slope and travel of the glass in a frame, m, below which both rest, and the number of such frames that make a rest.
const RESTING_M: f64 = 5e-4;
const RESTS: u32 = 8;

/// Frames from one sight to the next over which the glass is taken to go evenly; after more all begins anew.
const GAP: u32 = 4;

/// Weight of a frame in the mean of A^2: a memory of a second.
const MEMORY: f64 = 1.0 / 60.0;

/// A liquid that was seen before.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KnownLiquid {
    /// Its first mode.
    pub tone: Tone,
    /// Residual statistics of that mode.
    pub calibration: Calibration,
}

/// State of one liquid from frame to frame.
#[derive(Clone, Copy, Debug, Default)]
struct Course {
    swing: Swing,
    wave_m2: f64,
    evidence: Evidence,
    residual: Option<FrameResidual>,
}

/// State from frame to frame, for at most `N` liquids.
#[derive(Clone, Debug)]
pub struct Trail<const N: usize> {
    courses: [Course; N],
    /// Position of the glass when it was last seen, m.
    place_m: Option<f64>,
    /// The slope then, m.
    height_m: f64,
    /// Frames since then.
    ago: u32,
    /// Frames since the start that is followed.
    followed: u32,
    /// Frames in a row at rest.
    resting: u32,
    /// Whether the start is forgotten or was at rest.
    settled: bool,
}

impl<const N: usize> Default for Trail<N> {
    fn default() -> Self {
        let courses = [Course::default(); N];
        Self { courses, place_m: None, height_m: 0.0, ago: 0, followed: 0, resting: 0, settled: false }
    }
}

/// Several liquids and a glass.
///
/// ```
/// use meniscus::identify::{Calibration, Change, KnownLiquid, Recogniser, Swing, Tone, Trail};
/// use meniscus::surface::{POINTS, SurfaceProfile, profile_abscissa};
/// use meniscus::units::Micros;
///
/// let calibration = Calibration { scale: 0.05, scatter: 0.3, numbers: 0.2 };
/// let known = [0.5, 8.0].map(|decay| {
///     let tone = Tone { frequency: 22.5, decay, yielding: 0.0, breaking: 0.0, softening: 0.0, lever: 1.5 };
///     KnownLiquid { tone, calibration }
/// });
///
/// // The first liquid, kicked by a jump of its glass.
/// let recogniser = Recogniser::new(&known, 0.07);
/// let mut trail = Trail::<2>::default();
/// let (mut swing, mut position_m) = (Swing::default(), 0.0);
/// for sequence in 0..180 {
///     let next_m = if sequence < 20 { 0.0 } else { 0.01 };
///     known[0].tone.advance(&mut swing, Change { from_m: position_m, to_m: next_m }, 1);
///     position_m = next_m;
///     let height = |i| (0.07 + swing.height_m * profile_abscissa(i)) as f32;
///     let profile = SurfaceProfile {
///         height_m: core::array::from_fn(height),
///         variance_m2: [1e-8; POINTS],
///         valid: [true; POINTS],
///         glass_x_m: Some(position_m as f32),
///         sequence,
///         captured: Micros(0),
///     };
///     recogniser.turn(&mut trail, Some(&profile));
/// }
/// let mut probabilities = [0.0; 2];
/// assert_eq!(recogniser.verdict(&trail, &mut probabilities).best, Some(0));
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Recogniser<'k> {
    known: &'k [KnownLiquid],
    fill_m: f64,
}

impl<'k> Recogniser<'k> {
    /// A recogniser of these liquids, in a glass where they rest at `fill_m`. A trail has to have room for all; what
    /// has none is not asked.
    #[must_use]
    pub fn new(known: &'k [KnownLiquid], fill_m: f64) -> Self {
        Self { known, fill_m }
    }

    /// One frame. Call it once a frame interval, with `None` where no frame came or no liquid was seen.
    ///
    /// A frame counts if some liquid predicts a wave. That is known before the frame is read, so that choosing does not
    /// lean towards any of them.
    pub fn turn<const N: usize>(&self, trail: &mut Trail<N>, profile: Option<&SurfaceProfile>) {
        for course in &mut trail.courses {
            course.residual = None;
        }
        trail.ago = trail.ago.saturating_add(1);
        let read = profile.and_then(|profile| {
            let place = profile.glass_x_m.map(f64::from).filter(|x| x.is_finite())?;
            Some((slope(profile, self.fill_m)?, place))
        });
        let Some((read, place)) = read else { return };
        let (from, ago) = (trail.place_m, trail.ago);
        trail.place_m = Some(place);
        trail.ago = 0;
        let Some(from) = from.filter(|_| ago <= GAP) else {
            trail.begin(read.height_m);
            return;
        };
        let begun = trail.followed == 0;
        let before_m = trail.height_m;
        trail.follow(read.height_m, place - from, ago);
        let mut moved = false;
        for (known, course) in self.known.iter().zip(&mut trail.courses) {
            let speed = (place - from) / (f64::from(ago) * FRAME_INTERVAL_S);
            if begun {
                course.swing =
                    known.tone.caught(Change { from_m: before_m, to_m: read.height_m }, ago, speed);
            } else {
                known.tone.advance(&mut course.swing, Change { from_m: from, to_m: place }, ago);
            }
            let wave_m2 = known.tone.amplitude2_m2(&course.swing, speed);
            course.wave_m2 += (MEMORY * f64::from(ago)).min(1.0) * (wave_m2 - course.wave_m2);
            moved |= course.wave_m2 > MOVED_M * MOVED_M;
            let residual_m = read.height_m - course.swing.height_m;
            let (noise_m2, wave_m2) = (read.variance_m2, course.wave_m2);
            course.residual = Some(FrameResidual { residual_m, noise_m2, wave_m2 });
            course.swing.height_m += PULL * residual_m;
        }
        for (known, course) in self.known.iter().zip(&mut trail.courses) {
            course.residual = course.residual.filter(|_| trail.settled);
            if let Some(residual) = course.residual.filter(|_| moved) {
                course
                    .evidence
                    .add(residual.residual_m * residual.residual_m, known.calibration.variance_m2(&residual));
            }
        }
    }

    /// The probabilities as things stand, into `probabilities` (as many as liquids).
    pub fn verdict<const N: usize>(&self, trail: &Trail<N>, probabilities: &mut [f64]) -> Verdict {
        let sums = self.known.iter().zip(&trail.courses);
        posterior(sums.map(|(known, course)| (&known.calibration, &course.evidence)), probabilities)
    }
}

impl<const N: usize> Trail<N> {
    /// Begins anew with a surface of slope `height_m`; the sums stay.
    fn begin(&mut self, height_m: f64) {
        (self.followed, self.resting, self.settled) = (0, 0, false);
        self.height_m = height_m;
        for course in &mut self.courses {
            course.swing = Swing { height_m, rate_m_s: 0.0 };
            course.wave_m2 = height_m * height_m;
        }
    }

    /// Notes whether the start is forgotten by now, or was at rest.
    fn follow(&mut self, height_m: f64, way_m: f64, frames: u32) {
        self.height_m = height_m;
        self.followed = self.followed.saturating_add(frames);
        let rests = height_m.abs() < RESTING_M && way_m.abs() < RESTING_M;
        self.resting = if rests { self.resting.saturating_add(1) } else { 0 };
        self.settled |= self.followed >= SETTLING_FRAMES || self.resting >= RESTS;
    }

    /// Returns the residual of liquid `index` in the last frame; none where nothing was seen, or the start still shows.
    #[must_use]
    pub fn residual(&self, index: usize) -> Option<FrameResidual> {
        self.courses.get(index)?.residual
    }

    /// Returns the height of the first mode that liquid `index` predicts, m, the last reading included.
    #[must_use]
    pub fn height_m(&self, index: usize) -> Option<f64> {
        Some(self.courses.get(index)?.swing.height_m)
    }

    /// The sums of liquid `index`.
    #[must_use]
    pub fn evidence(&self, index: usize) -> Option<Evidence> {
        Some(self.courses.get(index)?.evidence)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::{POINTS, profile_abscissa};
    use crate::units::Micros;

    const FILL_M: f64 = 0.07;
    const THIN: Tone =
        Tone { frequency: 22.5, decay: 0.5, yielding: 0.0, breaking: 0.1, softening: 0.02, lever: 1.5 };
    const USUAL: Calibration = Calibration { scale: 0.05, scatter: 0.3, numbers: 0.2 };

    fn known(decay: f64) -> KnownLiquid {
        KnownLiquid { tone: Tone { decay, ..THIN }, calibration: USUAL }
    }

    /// Water, a liquid of twice its decay and more, and two thick ones.
    fn four() -> [KnownLiquid; 4] {
        [0.5, 1.3, 8.0, 60.0].map(known)
    }

    /// Four seconds of a liquid with `tone` in a glass that is pushed to and fro three times, with a ripple on each
    /// height that stands for noise.
    fn seen(tone: Tone) -> impl Iterator<Item = SurfaceProfile> {
        let place = |n: u32| {
            let t = f64::from(n) / 60.0;
            let stroke = |start: f64| {
                let part = ((t - start) / 0.5).clamp(0.0, 1.0);
                part * part * (3.0 - 2.0 * part)
            };
            0.02 * (stroke(0.4) - stroke(1.3) + stroke(2.2))
        };
        let mut swing = Swing::default();
        (0..240_u32).map(move |n| {
            if n > 0 {
                tone.advance(&mut swing, Change { from_m: place(n - 1), to_m: place(n) }, 1);
            }
            let ripple = |i: usize| 2e-4 * (f64::from((n * 37 + i as u32 * 101) % 64) / 32.0 - 1.0);
            let height = |i: usize| (FILL_M + swing.height_m * profile_abscissa(i) + ripple(i)) as f32;
            SurfaceProfile {
                height_m: core::array::from_fn(height),
                variance_m2: [1e-8; POINTS],
                valid: [true; POINTS],
                glass_x_m: Some(place(n) as f32),
                sequence: n,
                captured: Micros(u64::from(n) * 16_667),
            }
        })
    }

    /// Returns the verdict of `known` on the frames that `keep` keeps.
    fn said(known: &[KnownLiquid], tone: Tone, keep: impl Fn(u32) -> bool) -> (Verdict, [f64; 4]) {
        let recogniser = Recogniser::new(known, FILL_M);
        let mut trail = Trail::<4>::default();
        for profile in seen(tone) {
            recogniser.turn(&mut trail, Some(&profile).filter(|p| keep(p.sequence)));
        }
        let mut probabilities = [0.0; 4];
        let verdict = recogniser.verdict(&trail, &mut probabilities[..known.len()]);
        (verdict, probabilities)
    }

    #[test]
    fn each_liquid_is_named_and_a_stranger_is_none() {
        for (index, known) in four().iter().enumerate() {
            let (verdict, p) = said(&four(), known.tone, |_| true);
            assert_eq!(verdict.best, Some(index), "{p:?} {verdict:?}");
        }
        let (verdict, p) = said(&four(), Tone { decay: 3.0, frequency: 20.0, ..THIN }, |_| true);
        assert_eq!(verdict.best, None, "{p:?} {verdict:?}");
    }

    #[test]
    fn lost_frames_do_not_lean_towards_any() {
        for (index, known) in four().iter().enumerate() {
            // One of five, then a gap of ten, then one that is too long to be bridged.
            let kept =
                [|n: u32| n % 5 != 3, |n: u32| !(80..90).contains(&n), |n: u32| !(100..140).contains(&n)];
            for (how, keep) in kept.into_iter().enumerate() {
                let (verdict, p) = said(&four(), known.tone, keep);
                assert_eq!(verdict.best, Some(index), "loss {how}: {p:?} {verdict:?}");
            }
        }
    }

    #[test]
    fn a_start_in_the_midst_of_a_slosh_settles_first() {
        let (verdict, p) = said(&four(), four()[1].tone, |n| n > 70);
        assert_eq!(verdict.best, Some(1), "{p:?} {verdict:?}");
        assert!(verdict.profiles <= 169 - SETTLING_FRAMES, "{verdict:?}");
    }

    #[test]
    fn a_liquid_at_rest_has_no_name() {
        let (verdict, p) = said(&four(), THIN, |n| n < 20);
        assert_eq!(verdict.profiles, 0);
        assert!(p.iter().all(|p| (p - 0.2).abs() < 1e-2), "{p:?}");
    }
}
