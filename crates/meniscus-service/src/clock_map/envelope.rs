//! Lower envelope of arrival minus camera time: a line whose slope is the drift between the two clocks.
//!
//! ```text
//! y_i = a_i - c_i                      of frame i: camera time c, arrival a; delays only ever add to it
//! block: the (c, y) of least y in one second of arrivals; the last n = 32 blocks are kept
//! m = median of (y_{i+n/2} - y_i) / (c_{i+n/2} - c_i),  i = 1 .. n/2      s: its standard deviation
//! e = m p^2 / (p^2 + s^2)              p = 58 ppm, standard deviation of the drift of two crystals
//! y(c) = min_i [ y_i + e (c - c_i) ]
//! ```
//! e is the posterior mean. Where m exceeds what two crystals can have, the delays have changed and e stays as it was.
//! The slope is the incomplete method of Theil (Proc. K. Ned. Akad. Wet. 53 (1950) 386): a quarter of the blocks may be
//! delayed as a whole without moving it. That the least delays of a window carry offset and skew is from Paxson (On
//! calibrating measurements of packet transit times, SIGMETRICS 1998).

/// Blocks that are kept.
const BLOCKS: usize = 32;

/// Blocks from which on the drift is estimated: a baseline of four seconds.
const BLOCKS_FOR_DRIFT: usize = 8;

/// Length of a block, s.
const BLOCK_S: f64 = 1.0;

/// Largest drift between the two clocks that is accepted, as a share: twice what crystals of consumer devices have.
const DRIFT_LIMIT: f64 = 2e-4;

/// Standard deviation of the drift before it has been estimated, as a share: 100 ppm, uniform.
const DRIFT_PRIOR_STD: f64 = 1e-4 * 0.577_350_269_189_625_8;

/// Least standard deviation of an estimated drift: a crystal changes by this with the temperature of a room.
const DRIFT_LEAST_STD: f64 = 1e-6;

/// Weight of the newest frame in the mean delay.
const MEMORY: f64 = 1.0 / 64.0;

/// Slope of the line: by how much arrivals run ahead of camera times, as a share.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Drift {
    /// e.
    pub(super) rate: f64,
    /// Its standard deviation.
    pub(super) std: f64,
}

impl Drift {
    /// Returns the drift of two clocks that have not been compared.
    pub(super) fn unknown() -> Self {
        Self { rate: 0.0, std: DRIFT_PRIOR_STD }
    }

    /// Returns the drift of two clocks whose comparison gave `rate` with the standard deviation `std`.
    fn posterior(rate: f64, std: f64) -> Self {
        let weight = DRIFT_PRIOR_STD.powi(2) / (DRIFT_PRIOR_STD.powi(2) + std.powi(2));
        Self { rate: weight * rate, std: weight.sqrt() * std }
    }
}

/// A frame: camera time c and arrival minus camera time y, s.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Point {
    /// c, s.
    pub(super) camera_s: f64,
    /// y, s.
    pub(super) seen_s: f64,
}

/// The envelope. Its memory is fixed.
#[derive(Clone, Copy, Debug)]
pub(super) struct Envelope {
    blocks: [Point; BLOCKS],
    length: usize,
    next: usize,
    /// Least point of the block that is being filled, and the arrival with which it began, s.
    newest: Point,
    begun_s: f64,
    /// Frames since the envelope was begun.
    frames: u64,
    drift: Drift,
    /// Mean delay above the envelope, s.
    delay_s: f64,
}

impl Envelope {
    /// Returns the envelope of one frame that arrived at `at_s`, with the drift of an earlier one.
    pub(super) fn begin(first: Point, at_s: f64, drift: Drift) -> Self {
        Self {
            blocks: [Point::default(); BLOCKS],
            length: 0,
            next: 0,
            newest: first,
            begun_s: at_s,
            frames: 1,
            drift,
            delay_s: 0.0,
        }
    }

    /// Returns the drift.
    pub(super) fn drift(&self) -> Drift {
        self.drift
    }

    /// Whether the least delay has hardly been met yet.
    pub(super) fn is_young(&self) -> bool {
        self.frames < 60
    }

    /// Blocks, oldest first.
    fn blocks(&self) -> impl Iterator<Item = &Point> {
        let first = (self.next + BLOCKS - self.length) % BLOCKS;
        (0..self.length).map(move |place| &self.blocks[(first + place) % BLOCKS])
    }

    /// Returns y at the camera time `camera_s`, and the age of the block that it touches, s.
    fn lowest(&self, camera_s: f64) -> (f64, f64) {
        let points = self.blocks().chain(std::iter::once(&self.newest));
        points.fold((f64::INFINITY, 0.0), |(least, age), point| {
            let since_s = camera_s - point.camera_s;
            let seen_s = point.seen_s + self.drift.rate * since_s;
            if seen_s < least { (seen_s, since_s) } else { (least, age) }
        })
    }

    /// Returns y at the camera time `camera_s`, s.
    pub(super) fn at(&self, camera_s: f64) -> f64 {
        self.lowest(camera_s).0
    }

    /// Returns the standard deviation of [`Self::at`] above the least latency, s: the drift since the block that it
    /// touches, and the least of n delays, which lies their mean over n above its bound where they are exponential.
    pub(super) fn std_s(&self, camera_s: f64) -> f64 {
        let frames = self.frames.min(60 * BLOCKS as u64) as f64;
        (self.drift.std * self.lowest(camera_s).1.abs()).hypot(self.delay_s / frames)
    }

    /// Takes a frame that arrived at `at_s`.
    pub(super) fn take(&mut self, point: Point, at_s: f64) {
        self.frames += 1;
        if at_s - self.begun_s >= BLOCK_S {
            self.blocks[self.next] = self.newest;
            self.next = (self.next + 1) % BLOCKS;
            self.length = (self.length + 1).min(BLOCKS);
            (self.newest, self.begun_s) = (point, at_s);
            self.estimate_drift();
        } else if point.seen_s
            <= self.newest.seen_s + self.drift.rate * (point.camera_s - self.newest.camera_s)
        {
            self.newest = point;
        }
        let above_s = (point.seen_s - self.at(point.camera_s)).clamp(0.0, 1.0);
        self.delay_s += MEMORY * (above_s - self.delay_s);
    }

    /// Estimates the drift from the blocks, once there are enough of them.
    fn estimate_drift(&mut self) {
        if self.length < BLOCKS_FOR_DRIFT {
            return;
        }
        let half = self.length / 2;
        let mut slopes = [0.0; BLOCKS / 2];
        let pairs = self.blocks().zip(self.blocks().skip(half));
        let mut count = 0;
        for (slope, (early, late)) in slopes.iter_mut().zip(pairs) {
            let apart_s = (late.camera_s - early.camera_s).max(0.5 * BLOCK_S);
            *slope = (late.seen_s - early.seen_s) / apart_s;
            count += 1;
        }
        let slopes = &mut slopes[..count];
        let rate = median(slopes);
        slopes.iter_mut().for_each(|slope| *slope = (*slope - rate).abs());
        // Of normal errors the median deviation is 0.6745 of the standard deviation, and the median's own error 1.2533 of
        // the mean's.
        let std = median(slopes) / 0.6745 * 1.2533 / (count as f64).sqrt();
        // Beyond the limit it is a load that rises or falls.
        if rate.abs() <= DRIFT_LIMIT {
            self.drift = Drift::posterior(rate, std.max(DRIFT_LEAST_STD));
        }
    }
}

/// Returns the median of some numbers, which are sorted for it; zero of none.
fn median(numbers: &mut [f64]) -> f64 {
    numbers.sort_unstable_by(f64::total_cmp);
    let middle = numbers.len() / 2;
    match numbers.len() % 2 {
        0 if numbers.is_empty() => 0.0,
        0 => 0.5 * (numbers[middle - 1] + numbers[middle]),
        _ => numbers[middle],
    }
}
