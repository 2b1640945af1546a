//! A drawn law: an unnamed force on the first mode, as a curve of its height and a curve of its rate.
//!
//! ```text
//! m v' = ... - f(a) - G(u) v,      u = sqrt(v^2 + w^2 a^2),      D(u) = G(u) u >= 0
//! U(a) = int_0^a f,                energy + U,                   heat' + G v^2 >= 0
//! ```
//! `f` stores energy and `D`, the drag in a cycle whose rate reaches `u`, makes heat. A step takes the chord
//! `(U(a1) - U(a0))/(a1 - a0)` in place of `f` (Gonzalez 1996), so that energy is exact for any table, and `D` is
//! refused where it is negative, so that entropy cannot fall. `f` acts along x, the line on which the glass goes; the
//! friction acts in both directions.

/// Heights of the table of the conservative force, evenly from minus its reach to plus its reach.
pub const LAW_HEIGHTS: usize = 33;

/// Rates of the table of the drag, evenly from zero to the fastest.
pub const LAW_RATES: usize = 25;

/// Shortest way over which a chord is taken as a quotient, m.
const SHORTEST_M: f64 = 1e-12;

/// Tables of a drawn law.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LawTables {
    /// Height at the wall up to which `f` is drawn, m; beyond it the force stays.
    pub reach_m: f64,
    /// Conservative force f, N, towards rest where it has the sign of the height.
    pub force_n: [f64; LAW_HEIGHTS],
    /// Amplitude of the rate up to which the drag is drawn, m/s; beyond it the friction stays.
    pub fastest_m_s: f64,
    /// Drag D, N; zero at rest.
    pub drag_n: [f64; LAW_RATES],
}

/// A drawn law, ready for steps.
///
/// ```
/// use meniscus::reduced::{DrawnLaw, LAW_HEIGHTS, LAW_RATES, LawTables};
///
/// // A spring of 2 N/m and a friction of 0.1 N s/m.
/// let force_n = core::array::from_fn(|i| 2.0 * 0.01 * (i as f64 / 16.0 - 1.0));
/// let drag_n = core::array::from_fn(|i| 0.1 * 0.3 * i as f64 / 24.0);
/// let tables = LawTables { reach_m: 0.01, force_n, fastest_m_s: 0.3, drag_n };
/// let law = DrawnLaw::new(tables).unwrap();
/// assert!((law.chord_n(0.002, 0.004) - 2.0 * 0.003).abs() < 1e-12);
/// assert!((law.friction(0.2) - 0.1).abs() < 1e-12);
/// // A drag that would drive the liquid is refused.
/// assert!(DrawnLaw::new(LawTables { drag_n: [-1e-9; LAW_RATES], ..tables }).is_none());
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DrawnLaw {
    tables: LawTables,
    /// Energy U at the heights of the table, J.
    stored_j: [f64; LAW_HEIGHTS],
}

/// Interval of an even table, and the part of it that is passed.
struct Place {
    low: usize,
    part: f64,
}

impl Place {
    /// Returns the place of `share` (0 to 1) in a table of `count` numbers.
    fn of(share: f64, count: usize) -> Self {
        let place = share.clamp(0.0, 1.0) * (count - 1) as f64;
        let low = (place as usize).min(count - 2);
        Self { low, part: place - low as f64 }
    }

    /// Returns the two numbers of `table` between which it lies.
    fn ends(&self, table: &[f64]) -> (f64, f64) {
        let at = |i: usize| table.get(i).copied().unwrap_or(0.0);
        (at(self.low), at(self.low + 1))
    }

    /// Returns the number of `table` there, on a straight line.
    fn read(&self, table: &[f64]) -> f64 {
        let (low, high) = self.ends(table);
        low + (high - low) * self.part
    }
}

impl DrawnLaw {
    /// The law of `tables`; none where a number is not finite, an extent not positive, the drag negative or not zero at rest.
    #[must_use]
    pub fn new(tables: LawTables) -> Option<Self> {
        let LawTables { reach_m, force_n, fastest_m_s, drag_n } = &tables;
        let extents = [*reach_m, *fastest_m_s].iter().all(|x| x.is_finite() && *x > 0.0);
        let forces = force_n.iter().all(|f| f.is_finite());
        let drags = drag_n.iter().all(|d| d.is_finite() && *d >= 0.0) && drag_n.first() == Some(&0.0);
        if !(extents && forces && drags) {
            return None;
        }
        let step = 2.0 * reach_m / (LAW_HEIGHTS - 1) as f64;
        let mut stored_j = [0.0; LAW_HEIGHTS];
        let (mut sum, mut before) = (0.0, force_n.first().copied().unwrap_or(0.0));
        for (u, f) in stored_j.iter_mut().zip(force_n) {
            // Counted from anywhere: the energy at rest is taken off below.
            sum += 0.5 * step * (f + before);
            (*u, before) = (sum, *f);
        }
        let rest = stored_j.get(LAW_HEIGHTS / 2).copied().unwrap_or(0.0);
        stored_j.iter_mut().for_each(|u| *u -= rest);
        Some(Self { tables, stored_j })
    }

    /// Returns the tables.
    #[must_use]
    pub fn tables(&self) -> &LawTables {
        &self.tables
    }

    fn place(&self, height_m: f64) -> Place {
        Place::of(0.5 * (height_m / self.tables.reach_m + 1.0), LAW_HEIGHTS)
    }

    /// Returns the conservative force f at a height, N.
    #[must_use]
    pub fn force_n(&self, height_m: f64) -> f64 {
        self.place(height_m).read(&self.tables.force_n)
    }

    /// Returns the energy U at a height, J: the exact integral of the straight lines of the table.
    #[must_use]
    pub fn energy_j(&self, height_m: f64) -> f64 {
        let reach = self.tables.reach_m;
        // No `clamp`, which would panic at bounds that are no order.
        let inside = height_m.max(-reach).min(reach);
        let place = self.place(inside);
        let (low, high) = place.ends(&self.tables.force_n);
        let step = 2.0 * reach / (LAW_HEIGHTS - 1) as f64;
        let part = place.part;
        let stored = self.stored_j.get(place.low).copied().unwrap_or(0.0);
        let within = stored + step * part * (low + 0.5 * (high - low) * part);
        within + self.force_n(inside) * (height_m - inside)
    }

    /// Returns `(U(a1) - U(a0))/(a1 - a0)`, N.
    #[must_use]
    pub fn chord_n(&self, from_m: f64, to_m: f64) -> f64 {
        let way = to_m - from_m;
        if way.abs() < SHORTEST_M {
            return self.force_n(0.5 * (from_m + to_m));
        }
        (self.energy_j(to_m) - self.energy_j(from_m)) / way
    }

    /// Returns the friction G at an amplitude of the rate (m/s), N s/m; never negative.
    #[must_use]
    pub fn friction(&self, speed_m_s: f64) -> f64 {
        let fastest = self.tables.fastest_m_s;
        // The drag is a straight line from rest to the first rate of the table.
        let slowest = fastest / (LAW_RATES - 1) as f64;
        let speed = speed_m_s.max(slowest).min(fastest);
        Place::of(speed / fastest, LAW_RATES).read(&self.tables.drag_n) / speed
    }

    /// Returns the height at which a spring of `stiffness` (N/m) and the law hold `force` (N), m.
    pub(super) fn balance_m(&self, stiffness: f64, force: f64) -> f64 {
        let mut height = force / stiffness;
        for _ in 0..SETTLING {
            height = (force - self.force_n(height)) / stiffness;
        }
        height
    }
}

/// Repetitions of a balance at rest.
const SETTLING: usize = 40;

#[cfg(test)]
#[allow(clippy::disallowed_methods, reason = "a test may take the platform's functions")]
mod tests {
    extern crate std;

    use super::*;
    use crate::reduced::effects::tests::{DT, model};
    use crate::reduced::{Forcing, ReducedState, step};
    use std::{assert, vec::Vec};

    /// A lopsided spring that is not smooth, and a drag that falls with the rate.
    fn tables() -> LawTables {
        let force = |i: usize| {
            let x = i as f64 / 16.0 - 1.0;
            0.05 * x + 0.04 * x * x - if x > 0.5 { 0.08 * (x - 0.5) } else { 0.0 }
        };
        let drag = |i: usize| if i == 0 { 0.0 } else { 0.01 / (1.0 + 0.2 * i as f64) };
        LawTables {
            reach_m: 0.006,
            force_n: core::array::from_fn(force),
            fastest_m_s: 0.15,
            drag_n: core::array::from_fn(drag),
        }
    }

    #[test]
    fn the_energy_is_the_integral_of_the_force() {
        let law = DrawnLaw::new(tables()).expect("sound");
        for (from, to) in [(-0.009, 0.008), (0.0, 0.0031), (0.0055, -0.0012)] {
            let n = 40_000;
            let width = (to - from) / f64::from(n);
            let sum: f64 = (0..n).map(|i| law.force_n(from + (f64::from(i) + 0.5) * width) * width).sum();
            assert!((law.energy_j(to) - law.energy_j(from) - sum).abs() < 1e-10, "{from} to {to}");
        }
        assert!(law.energy_j(0.0) == 0.0);
    }

    #[test]
    fn a_step_with_a_law_keeps_the_books_and_heat_never_falls() {
        let law = DrawnLaw::new(tables()).expect("sound");
        let plain = model(0.01, &[]);
        let with = plain.clone().with_law(law);
        let (mut state, mut other) = (ReducedState::default(), ReducedState::default());
        let (mut least, mut worst) = (f64::INFINITY, 0.0_f64);
        let mut run = Vec::new();
        for n in 0..1200 {
            let along = if n < 480 { 1.5 * (0.047 * f64::from(n)).sin() } else { 0.0 };
            let push = Forcing { along_m_s2: [along, 0.3 * along], lift_m_s2: 0.0 };
            let balance = step(&with, &mut state, &push);
            step(&plain, &mut other, &push);
            least = least.min(balance.heat_j);
            worst = worst.max(balance.residue_j.abs());
            run.push(state.height[0][0]);
        }
        let largest = run.iter().fold(0.0_f64, |m, a| m.max(a.abs()));
        assert!(largest > 0.006, "beyond the table too: {largest}");
        assert!(least >= 0.0, "{least}");
        assert!(worst < 1e-12 * (1.0 + with.energy(&state)), "{worst}");
        // The law does something: the same acceleration without it ends elsewhere.
        assert!((state.heat_j / other.heat_j - 1.0).abs() > 0.01, "{} {}", state.heat_j, other.heat_j);
    }

    #[test]
    fn a_linear_spring_raises_the_frequency_and_a_linear_drag_the_damping_as_they_should() {
        let plain = model(1e-7, &[]);
        let (w, _) = plain.frequency_and_damping(0).expect("the first mode");
        let (k, g) = (0.21 * plain.mass_kg() * w * w, 0.5 * plain.mass_kg());
        let law = DrawnLaw::new(LawTables {
            reach_m: 0.01,
            force_n: core::array::from_fn(|i| k * 0.01 * (i as f64 / 16.0 - 1.0)),
            fastest_m_s: 0.3,
            drag_n: core::array::from_fn(|i| g * 0.3 * i as f64 / 24.0),
        });
        let with = plain.clone().with_law(law.expect("sound"));
        assert!((with.first_mode_friction(0.1) - plain.first_mode_friction(0.1) - g).abs() < 1e-9);
        let mut state = ReducedState::default();
        state.height[0][0] = 0.005;
        let (mut crossings, mut last) = (Vec::new(), 0.005);
        let start = with.energy(&state);
        let steps = 480;
        for n in 0..steps {
            step(&with, &mut state, &Forcing::default());
            let here = state.height[0][0];
            if last * here < 0.0 {
                crossings.push((f64::from(n) - here / (here - last)) * DT);
            }
            last = here;
        }
        let found = std::f64::consts::PI * (crossings.len() - 1) as f64
            / (crossings[crossings.len() - 1] - crossings[0]);
        // w^2 (1 + 0.21), less (g/2m)^2, which is small.
        assert!((found / (1.1 * w) - 1.0).abs() < 0.01, "{found} for {}", 1.1 * w);
        let left = with.energy(&state) / start;
        let wanted = (-0.5 * f64::from(steps) * DT).exp();
        assert!((left / wanted - 1.0).abs() < 0.08, "{left} for {wanted}");
    }

    #[test]
    fn tables_without_a_meaning_are_refused() {
        let sound = tables();
        let mut negative = sound;
        negative.drag_n[3] = -1e-6;
        let mut lost = sound;
        lost.force_n[2] = f64::NAN;
        let mut stuck = sound;
        stuck.drag_n[0] = 1e-3;
        for refused in [negative, lost, stuck, LawTables { reach_m: 0.0, ..sound }] {
            assert!(DrawnLaw::new(refused).is_none());
        }
    }

    #[test]
    fn rest_under_a_constant_acceleration_balances_spring_and_law() {
        let with = model(0.01, &[]).with_law(DrawnLaw::new(tables()).expect("sound"));
        let push = Forcing { along_m_s2: [0.2, 0.0], lift_m_s2: 0.0 };
        let mut state = with.rest(&push);
        let start = state.height[0][0];
        for _ in 0..60 {
            step(&with, &mut state, &push);
        }
        assert!((state.height[0][0] - start).abs() < 1e-4 * start.abs(), "{start}");
    }
}
