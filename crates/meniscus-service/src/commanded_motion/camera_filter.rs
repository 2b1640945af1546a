//! Acceleration from noisy positions of the camera's frames: a Kalman filter of the motion along the line.
//!
//! The second difference of positions of 0.01 mm is an acceleration of 0.1 m/s2, and is that of the frame before. The filter knows
//! that a glass moves smoothly: its snap is white. With the state (x, v, a, j), the time h between two frames and snap s,
//!
//! ```text
//! x+ = F x + g s,   F_ik = h^(k-i)/(k-i)!,   g = (h^4/24, h^3/6, h^2/2, h),   z = x + e,   <s^2> = S^2,  <e^2> = sigma^2
//! S_z = P-_xx + sigma^2,   x^ = x- + P- h_x (z - x-)/S_z,   P = P- - P- h_x h_x^T P-/S_z      h_x = (1, 0, 0, 0)
//! a^_n-1|n = a^_n-1 + [P_n-1 F^T]_ax (z - x-)/S_z                              one step of smoothing, for the frame before
//! ```
//! (Bar-Shalom, Li & Kirubarajan, Estimation with Applications to Tracking and Navigation, 2001, 5.2 and 6.2, one derivative more.)

use super::samples::Accelerations;
use nalgebra::{Matrix4, Vector4};

/// S: standard deviation of the snap from frame to frame, m/s4. A motion of 10 mm at 3 Hz has 900.
const SNAP_M_S4: f64 = 2000.0;
/// Standard deviations before the first position: m/s, m/s2, m/s3.
const AT_FIRST: [f64; 3] = [0.5, 5.0, 100.0];
/// Positions from which on the acceleration is known.
const SETTLED: u32 = 8;

/// The filter.
#[derive(Clone, Copy, Debug)]
pub(super) struct CameraFilter {
    time_s: f64,
    state: Vector4<f64>,
    covariance: Matrix4<f64>,
    positions: u32,
}

impl CameraFilter {
    /// Begins with a position of standard deviation `std_m`.
    pub(super) fn begin(time_s: f64, position_m: f64, std_m: f64) -> Self {
        let [v, a, j] = AT_FIRST;
        let covariance = Matrix4::from_diagonal(&Vector4::new(std_m, v, a, j).map(|std| std * std));
        Self { time_s, state: Vector4::new(position_m, 0.0, 0.0, 0.0), covariance, positions: 1 }
    }

    /// Takes the next position. Returns the accelerations, where they are known by now.
    pub(super) fn take(&mut self, time_s: f64, position_m: f64, std_m: f64) -> Option<Accelerations> {
        let h = time_s - self.time_s;
        let (h2, h3) = (h * h / 2.0, h * h * h / 6.0);
        #[rustfmt::skip]
        let step = Matrix4::new(
            1.0, h, h2, h3,
            0.0, 1.0, h, h2,
            0.0, 0.0, 1.0, h,
            0.0, 0.0, 0.0, 1.0,
        );
        let snap = Vector4::new(h3 * h / 4.0, h3, h2, h) * SNAP_M_S4;
        let predicted = step * self.state;
        let crossed = self.covariance * step.transpose();
        let covariance = step * crossed + snap * snap.transpose();
        let innovation = (position_m - predicted.x) / (covariance.m11 + std_m * std_m);
        let before = self.state.z + crossed[(2, 0)] * innovation;
        let column: Vector4<f64> = covariance.column(0).into();
        self.state = predicted + column * innovation;
        self.covariance = covariance - column * column.transpose() / (covariance.m11 + std_m * std_m);
        self.time_s = time_s;
        self.positions = self.positions.saturating_add(1);
        (self.positions >= SETTLED).then_some(Accelerations { before, now: self.state.z })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// X(t) = 0.008 sin(14 t) with an error of 0.02 mm: its acceleration of the frame before is nearer to the truth than the
    /// second difference, and its present one no farther than that difference held.
    #[test]
    fn the_filter_beats_the_second_difference() {
        let (h, std_m) = (1.0 / 60.0, 2e-5);
        let mut random = 1_u64;
        let mut noise = || {
            let mut uniform = || {
                random =
                    random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                (random >> 33) as f64 / f64::from(1_u32 << 31) - 0.5
            };
            std_m * (0..12).map(|_| uniform()).sum::<f64>()
        };
        let acceleration = |t: f64| -0.008 * 14.0 * 14.0 * (14.0 * t).sin();
        let places: Vec<f64> = (0..600).map(|n| 0.008 * (14.0 * h * f64::from(n)).sin() + noise()).collect();
        let mut filter = CameraFilter::begin(0.0, places[0], std_m);
        let (mut now, mut before, mut held, mut bent, mut count) = (0.0, 0.0, 0.0, 0.0, 0.0);
        for n in 1..600 {
            let t = h * n as f64;
            let found = filter.take(t, places[n], std_m);
            assert_eq!(found.is_some(), n + 1 >= SETTLED as usize);
            let Some(found) = found.filter(|_| n > 30) else { continue };
            let second = (places[n] - 2.0 * places[n - 1] + places[n - 2]) / (h * h);
            now += (found.now - acceleration(t)).powi(2);
            before += (found.before - acceleration(t - h)).powi(2);
            held += (second - acceleration(t)).powi(2);
            bent += (second - acceleration(t - h)).powi(2);
            count += 1.0;
        }
        let [now, before, held, bent] = [now, before, held, bent].map(|sum: f64| (sum / count).sqrt());
        println!("now {now:.3} m/s2, held {held:.3}; before {before:.3}, second difference {bent:.3}");
        assert!(now < held && before < 0.75 * bent, "{now} {held} {before} {bent}");
    }

    #[test]
    fn a_frame_that_is_missing_changes_no_straight_motion() {
        let mut filter = CameraFilter::begin(0.0, 0.1, 1e-5);
        let times = (1..60).filter(|n| n % 7 != 0).map(|n| f64::from(n) / 60.0);
        let last = times.filter_map(|t| filter.take(t, 0.1 + 0.3 * t, 1e-5)).last().expect("settled");
        assert!(last.now.abs() < 0.01 && last.before.abs() < 0.01, "{last:?}");
    }
}
