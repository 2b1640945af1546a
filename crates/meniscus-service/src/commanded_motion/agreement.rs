//! Agreement of a commanded motion with the glass that the camera sees.
//!
//! The accelerations `b_n` that the filter would take are second differences of positions, so they give these back up to a
//! straight line:
//!
//! ```text
//! X_{n+1} = 2 X_n - X_{n-1} + h^2 b_{n+1}
//! r_n = x_n - X_n - (c_0 + c_1 n + c_2 n^2)      x_n tracked position, c by least squares over the window
//! ```
//!
//! `c_0` and `c_1` are that line, `c_2` is a constant error of the sensor: gravity on an inclined one. The motion disagrees
//! where the root mean square of `r` exceeds a floor and a share of what the glass itself does, and where `now` is not the
//! acceleration that the next frame's mean says: values that alternate between frames leave no trace in the positions.

use super::samples::Accelerations;
use meniscus::units::{FRAME_INTERVAL_S, Micros};

/// Frames of the window.
const WINDOW: usize = 60;
/// Frames from which on there is a verdict.
const LEAST: usize = 20;
/// Disagreement that the tracked position's own error explains, m.
const FLOOR_M: f64 = 0.0015;
/// Share of the tracked motion up to which a residual is a late, stretched or noisy sensor.
const SHARE: f64 = 0.4;
/// Difference of `now` and the next frame's mean that a sensor's noise explains, m/s2.
const JITTER_M_S2: f64 = 8.0;
/// Frames in a row that disagree before a motion is not used any more.
const DOUBTS: u32 = 15;
/// Frames in a row that agree before a contradicted motion is used again.
const AMENDS: u32 = 60;
/// The window goes on where fewer turns than these were left out.
const BRIDGED: usize = 5;

/// Whether a motion is used.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Trust {
    /// Too little of it has been compared.
    #[default]
    Untried,
    /// The camera does not deny it.
    Used,
    /// The camera denies it.
    Contradicted,
}

/// One frame of the window.
#[derive(Clone, Copy, Debug, Default)]
struct Compared {
    commanded: Accelerations,
    tracked_m: Option<f64>,
}

/// The comparison. Its memory is fixed and it never allocates.
#[derive(Debug)]
pub(super) struct Agreement {
    frames: [Compared; WINDOW],
    /// Frames in the window, and the place of the next one.
    length: usize,
    next: usize,
    newest: Option<Micros>,
    trust: Trust,
    /// Frames in a row that disagree or, for a contradicted motion, agree.
    streak: u32,
}

impl Default for Agreement {
    fn default() -> Self {
        Self {
            frames: [Compared::default(); WINDOW],
            length: 0,
            next: 0,
            newest: None,
            trust: Trust::default(),
            streak: 0,
        }
    }
}

impl Agreement {
    /// Returns the trust in the motion.
    pub(super) fn trust(&self) -> Trust {
        self.trust
    }

    /// Takes the motion of the turn at `at`; `ago` is the motion of so many seconds earlier. Of a turn that was left out, or whose
    /// samples came late, the motion is known by now.
    pub(super) fn commanded(
        &mut self,
        at: Micros,
        commanded: Accelerations,
        ago: impl Fn(f64) -> Option<Accelerations>,
    ) {
        let intervals =
            self.newest.map_or(f64::INFINITY, |last| (at.0 as f64 - last.0 as f64) * 1e-6 / FRAME_INTERVAL_S);
        let goes_on = if intervals < 0.5 {
            // Turns without a frame went on in the silence; the frames that come late are turns again.
            self.pop(1 + intervals.abs().round() as usize)
        } else {
            let missed = intervals.round() as usize - 1;
            missed < BRIDGED
                && (1..=missed).rev().all(|back| {
                    let motion = ago(back as f64 * FRAME_INTERVAL_S);
                    motion.map(|motion| self.push(motion)).is_some()
                })
        };
        if !goes_on {
            // The second difference over a gap is no sum any more. Trust and streak stay.
            (self.length, self.next) = (0, 0);
        }
        self.newest = Some(at);
        self.push(commanded);
    }

    /// Takes the newest frames out of the window again; returns whether it had as many.
    fn pop(&mut self, frames: usize) -> bool {
        let has = frames <= self.length;
        if has {
            self.length -= frames;
            self.next = (self.next + WINDOW - frames) % WINDOW;
        }
        has
    }

    fn push(&mut self, commanded: Accelerations) {
        self.frames[self.next] = Compared { commanded, tracked_m: None };
        self.next = (self.next + 1) % WINDOW;
        self.length = (self.length + 1).min(WINDOW);
    }

    /// Takes the position of the glass in the frame of the turn at `at`, and judges.
    pub(super) fn tracked(&mut self, at: Micros, tracked_m: Option<f64>) {
        if self.newest != Some(at) {
            return;
        }
        self.frames[(self.next + WINDOW - 1) % WINDOW].tracked_m = tracked_m;
        if self.length < LEAST {
            return;
        }
        let disagrees = self.disagrees();
        let (counts, enough) = match self.trust {
            Trust::Untried => (false, 0),
            Trust::Used => (disagrees, DOUBTS),
            Trust::Contradicted => (!disagrees, AMENDS),
        };
        self.streak = if counts { self.streak + 1 } else { 0 };
        if self.trust == Trust::Untried {
            self.trust = if disagrees { Trust::Contradicted } else { Trust::Used };
        } else if self.streak >= enough {
            self.trust = if disagrees { Trust::Contradicted } else { Trust::Used };
            self.streak = 0;
        }
    }

    /// Frames of the window, oldest first.
    fn window(&self) -> impl Iterator<Item = &Compared> {
        let first = (self.next + WINDOW - self.length) % WINDOW;
        (0..self.length).map(move |place| &self.frames[(first + place) % WINDOW])
    }

    /// Whether the window's motion is not that of the glass. Without enough tracked positions nothing is denied.
    fn disagrees(&self) -> bool {
        let (mut position, mut speed) = (0.0, 0.0);
        let mut jitter = Mean::default();
        let (mut denied, mut own) = (Detrended::default(), Detrended::default());
        let (mut last_now, mut scale) = (None, Mean::default());
        let half = 0.5 * self.length as f64;
        for (place, frame) in self.window().enumerate() {
            let Accelerations { before, now } = frame.commanded;
            // Speed in metres a frame.
            speed += before * FRAME_INTERVAL_S * FRAME_INTERVAL_S;
            position += speed;
            if let Some(last_now) = last_now {
                let apart: f64 = last_now - before;
                jitter.add(apart * apart);
                scale.add(before * before);
            }
            last_now = Some(now);
            if let Some(tracked_m) = frame.tracked_m {
                let time = (place as f64 - half) / half;
                denied.add(time, tracked_m - position);
                own.add(time, tracked_m);
            }
        }
        if jitter.root() > JITTER_M_S2 + scale.root() {
            return true;
        }
        let enough = denied.count() >= LEAST as f64 * 0.5;
        enough && denied.residual() > FLOOR_M + SHARE * own.residual()
    }
}

/// Mean of squares.
#[derive(Default)]
struct Mean {
    sum: f64,
    count: f64,
}

impl Mean {
    fn add(&mut self, square: f64) {
        self.sum += square;
        self.count += 1.0;
    }

    fn root(&self) -> f64 {
        (self.sum / self.count.max(1.0)).sqrt()
    }
}

/// Sums for a least-squares parabola over times in -1 to 1.
#[derive(Default)]
struct Detrended {
    /// Sums of t^0 to t^4.
    moments: [f64; 5],
    /// Sums of y, t y, t^2 y.
    weighted: [f64; 3],
    squares: f64,
    /// First value, from which all others are counted: positions may be far from zero.
    origin: Option<f64>,
}

impl Detrended {
    fn add(&mut self, time: f64, value: f64) {
        let value = value - *self.origin.get_or_insert(value);
        let mut power = 1.0;
        for (order, moment) in self.moments.iter_mut().enumerate() {
            *moment += power;
            if let Some(weighted) = self.weighted.get_mut(order) {
                *weighted += power * value;
            }
            power *= time;
        }
        self.squares += value * value;
    }

    fn count(&self) -> f64 {
        self.moments[0]
    }

    /// Returns the root mean square of what the parabola leaves.
    fn residual(&self) -> f64 {
        let [m0, m1, m2, m3, m4] = self.moments;
        let [w0, w1, w2] = self.weighted;
        // Cramer's rule for [m0 m1 m2; m1 m2 m3; m2 m3 m4] c = w.
        let minor = [m2 * m4 - m3 * m3, m1 * m4 - m2 * m3, m1 * m3 - m2 * m2];
        let determinant = m0 * minor[0] - m1 * minor[1] + m2 * minor[2];
        if determinant.abs() < 1e-9 {
            return 0.0;
        }
        let c0 = (w0 * minor[0] - m1 * (w1 * m4 - m3 * w2) + m2 * (w1 * m3 - m2 * w2)) / determinant;
        let c1 = (m0 * (w1 * m4 - m3 * w2) - w0 * minor[1] + m2 * (m1 * w2 - w1 * m2)) / determinant;
        let c2 = (m0 * (m2 * w2 - w1 * m3) - m1 * (m1 * w2 - w1 * m2) + w0 * minor[2]) / determinant;
        let left = self.squares - c0 * w0 - c1 * w1 - c2 * w2;
        (left.max(0.0) / self.count().max(1.0)).sqrt()
    }
}

#[cfg(test)]
#[path = "agreement_tests.rs"]
mod tests;
