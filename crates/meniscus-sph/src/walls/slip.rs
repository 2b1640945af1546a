//! Slip at the wall with a slip length b (Navier 1823).
//!
//! ```text
//! u(0) = b du/dn        ->   u(y) = (b + y) s  near the wall, y the distance from it, s the shear rate
//! ```
//! Continued behind the wall this is `u(-y) = (b - y) s`: the image of a particle moves with the share
//! ```text
//! stick = y / (y + b)
//! ```
//! of what a wall asks for that the liquid sticks to, and with the rest of what a wall without shear stress
//! does (see `walls`). `stick` is 1 at b = 0 and 0 at b = infinity. All of the friction's power becomes heat:
//! what the liquid loses by sliding is dissipated at the wall.

/// A particle is never taken nearer to the wall than this, m.
const NEAREST_M: f64 = 1e-4;

/// The share by which liquid at the distance `y_m` sticks to a wall with the slip length `slip_m`.
pub(super) fn stick(slip_m: f64, y_m: f64) -> f64 {
    if slip_m.is_finite() {
        let y = y_m.max(NEAREST_M);
        y / (y + slip_m)
    } else {
        0.0
    }
}
