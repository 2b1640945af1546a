//! A clock and images of a resting glass that the eye can read.

use meniscus::runtime::Clock;

/// A clock that goes on by the same time at every reading.
pub(crate) struct Ticks {
    now_us: u64,
    step_us: u64,
}

impl Ticks {
    /// `step_us` from one reading to the next.
    pub(crate) fn every_us(step_us: u64) -> Self {
        Self { now_us: 0, step_us }
    }
}

impl Clock for Ticks {
    fn now_us(&mut self) -> u64 {
        self.now_us += self.step_us;
        self.now_us
    }
}

/// A dark cylinder in front of a bright wall, its surface flat at 70 mm: enough for the eye to see.
pub(crate) fn images() -> (Vec<u8>, Vec<u8>) {
    let (mut depth, mut infrared) = (vec![0; 640 * 480 * 2], vec![180; 640 * 480]);
    let (fx, ppx, ppy) = (384.21_f32, 319.48_f32, 236.35_f32);
    for row in 0..480 {
        for column in 0..640 {
            let (a, b) = ((column as f32 - ppx) / fx, (row as f32 - ppy) / fx);
            let discriminant = 0.4 * 0.4 - (1.0 + a * a) * (0.4 * 0.4 - 0.035 * 0.035);
            if discriminant <= 0.0 {
                continue;
            }
            let z = (0.4 - discriminant.sqrt()) / (1.0 + a * a);
            let height = 0.03 - b * z;
            if (0.0..0.07).contains(&height) {
                let index = row * 640 + column;
                infrared[index] = 40;
                depth[2 * index..2 * index + 2].copy_from_slice(&((z / 1e-4) as u16).to_le_bytes());
            }
        }
    }
    (depth, infrared)
}
