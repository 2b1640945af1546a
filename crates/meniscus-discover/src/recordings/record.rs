//! Recording as discovery uses it: a few numbers per frame, and the motion of the glass.
//!
//! All waves of one azimuthal order look alike on the wall, so a profile holds a handful of numbers: with
//! s = x/R over the valid points,
//! ```text
//! z(s) - fill = level + slope s + bow (T2(s) - <T2>) + cubic part (not used),       T2 = 2 s^2 - 1
//! ```
//! by least squares over the valid points. A peak height is one number.

use meniscus::surface::{POINTS, SurfaceProfile, profile_abscissa};
use nalgebra::{SMatrix, SVector};

/// Meaning of a number that is measured in each frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Quantity {
    /// Mean height of the profile over the stated fill, m.
    Level,
    /// Height at s = 1 of its straight part, m.
    Slope,
    /// Its curvature, m.
    Bow,
    /// Position of the glass along x, from its start, m.
    Place,
    /// Height of the highest point of the surface over rest, m.
    Peak,
}

impl Quantity {
    /// Returns the channel's name in words.
    #[must_use]
    pub fn words(self) -> &'static str {
        match self {
            Self::Level => "level",
            Self::Slope => "slope",
            Self::Bow => "bow",
            Self::Place => "glass",
            Self::Peak => "peak",
        }
    }
}

/// Series of one number per frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Channel {
    /// Meaning of the number.
    pub quantity: Quantity,
    /// Values, m; `None` where it was not measured.
    pub value: Vec<Option<f64>>,
}

/// Motion of the glass, sampled evenly.
#[derive(Clone, Debug, PartialEq)]
pub struct Drive {
    /// Samples per second.
    pub rate_hz: f64,
    /// Specific force along x and y in an upright glass, m/s2.
    pub along_m_s2: Vec<[f64; 2]>,
    /// Additional force by the recorded inclination, m/s2.
    pub tilted_m_s2: Vec<[f64; 2]>,
    /// Recorded acceleration upwards, m/s2.
    pub lift_m_s2: Vec<f64>,
    /// Position along x, m.
    pub place_m: Vec<f64>,
}

impl Drive {
    /// Returns the values at `time_s` by linear interpolation: along, tilted, lift, position.
    #[must_use]
    pub fn at(&self, time_s: f64) -> ([f64; 2], [f64; 2], f64, f64) {
        let place = (time_s * self.rate_hz).clamp(0.0, (self.along_m_s2.len() - 1) as f64);
        let low = (place as usize).min(self.along_m_s2.len().saturating_sub(2));
        let part = place - low as f64;
        let mix = |a: f64, b: f64| a + (b - a) * part;
        let pair = |v: &[[f64; 2]]| [0, 1].map(|d| mix(v[low][d], v[low + 1][d]));
        (
            pair(&self.along_m_s2),
            pair(&self.tilted_m_s2),
            mix(self.lift_m_s2[low], self.lift_m_s2[low + 1]),
            mix(self.place_m[low], self.place_m[low + 1]),
        )
    }

    /// Returns whether an inclination, and whether a vertical acceleration, was recorded at all.
    #[must_use]
    pub fn holds(&self) -> [bool; 2] {
        let tilt = self.tilted_m_s2.iter().flatten().any(|a| a.abs() > 0.02);
        [tilt, self.lift_m_s2.iter().any(|a| a.abs() > 0.02)]
    }

    /// Returns whether the glass moves in a plane.
    #[must_use]
    pub fn is_planar(&self) -> bool {
        self.along_m_s2.iter().chain(&self.tilted_m_s2).all(|a| a[1] == 0.0)
    }

    /// Returns whether two drives are the same motion, to a hundredth of their strength.
    #[must_use]
    pub fn same(&self, other: &Self) -> bool {
        let strength = self.along_m_s2.iter().flatten().fold(0.05_f64, |m, a| m.max(a.abs()));
        let pairs = || self.along_m_s2.iter().flatten().zip(other.along_m_s2.iter().flatten());
        self.rate_hz == other.rate_hz
            && self.along_m_s2.len().abs_diff(other.along_m_s2.len()) < 8
            && pairs().all(|(a, b)| (a - b).abs() < 0.01 * strength)
    }
}

/// One recording.
#[derive(Clone, Debug, PartialEq)]
pub struct Record {
    /// Name, for people.
    pub name: String,
    /// Seconds between frames.
    pub interval_s: f64,
    /// Measured channels.
    pub channels: Vec<Channel>,
    /// Motion of the glass.
    pub drive: Drive,
    /// Frames before the glass moves.
    pub rest_frames: usize,
}

impl Record {
    /// Returns the number of frames.
    #[must_use]
    pub fn frames(&self) -> usize {
        self.channels.first().map_or(0, |channel| channel.value.len())
    }
}

/// Returns the mean of T2 over the points of a whole profile.
#[must_use]
pub fn mean_bow() -> f64 {
    (0..POINTS).map(|i| 2.0 * profile_abscissa(i).powi(2) - 1.0).sum::<f64>() / POINTS as f64
}

/// Returns level, slope, bow and cubic part of `heights` over the points of a whole profile.
#[must_use]
pub fn parts(heights: impl Iterator<Item = (usize, f64)>) -> Option<[f64; 4]> {
    let mean = mean_bow();
    let mut square = SMatrix::<f64, 4, 4>::zeros();
    let mut right = SVector::<f64, 4>::zeros();
    let mut seen = 0;
    for (point, height) in heights {
        let s = profile_abscissa(point);
        let row = SVector::from([1.0, s, 2.0 * s * s - 1.0 - mean, s * s * s - 0.6 * s]);
        square += row * row.transpose();
        right += row * height;
        seen += 1;
    }
    if seen < POINTS / 2 {
        return None;
    }
    square.cholesky().map(|factor| factor.solve(&right).into())
}

/// Returns the channels of a recording of profiles, `None` where a frame has none; `fill_m` is the stated fill.
#[must_use]
pub fn channels(profiles: &[Option<SurfaceProfile>], fill_m: f64) -> Vec<Channel> {
    let reduce = |profile: &Option<SurfaceProfile>| {
        let profile = profile.as_ref()?;
        let seen = |i: usize| profile.valid[i].then(|| (i, f64::from(profile.height_m[i]) - fill_m));
        parts((0..POINTS).filter_map(seen))
    };
    let reduced: Vec<_> = profiles.iter().map(reduce).collect();
    let mut out: Vec<Channel> = [Quantity::Level, Quantity::Slope, Quantity::Bow]
        .into_iter()
        .enumerate()
        .map(|(i, quantity)| Channel { quantity, value: reduced.iter().map(|r| r.map(|r| r[i])).collect() })
        .collect();
    let place: Vec<Option<f64>> =
        profiles.iter().map(|p| p.as_ref().and_then(|p| p.glass_x_m).map(f64::from)).collect();
    if place.iter().filter(|p| p.is_some()).count() > place.len() / 2 {
        let start =
            place.iter().flatten().take(8).sum::<f64>() / place.iter().flatten().take(8).count() as f64;
        let value = place.iter().map(|p| p.map(|p| p - start)).collect();
        out.push(Channel { quantity: Quantity::Place, value });
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_profile_is_taken_apart_with_holes_too() {
        let height = |i: usize| {
            let s = profile_abscissa(i);
            1e-3 + 5e-3 * s + 2e-3 * (2.0 * s * s - 1.0 - mean_bow())
        };
        for skip in [100, 2, 3] {
            let got =
                parts((0..POINTS).filter(|i| i % skip != 1).map(|i| (i, height(i)))).expect("points enough");
            for (part, wanted) in got.iter().zip([1e-3, 5e-3, 2e-3, 0.0]) {
                assert!((part - wanted).abs() < 1e-12, "{part} for {wanted}");
            }
        }
        assert_eq!(parts((0..4).map(|i| (i, height(i)))), None);
    }
}
