//! Friction of a mode in a viscous liquid: boundary layers at side and bottom, film, bulk.
//!
//! ```text
//! gamma = (1/2R) sqrt(nu w/2) [ (1 + m^2/xi^2)/(1 - m^2/xi^2) + 2kR(1 - h/R)/sinh 2kh ] + 2 nu k^2
//! ```
//! (Case and Parkinson 1957), the layers also lower the frequency by their part of gamma. An inextensible
//! film adds `f (1/2) sqrt(nu w/2) k coth kh`, f = 1; elastic ones reach about f = 2 (Miles 1967).
//!
//! Slip and viscoelastic relaxation change the layer, see `wall_impedance`. Beyond first order in the layer's depth the first mode
//! is corrected, see `finite_layer`.
//!
//! A generalised Newtonian liquid, `tau = tau0 + K rate^n` (Herschel and Bulkley 1926), has the viscosity
//! that loses as much in a cycle as it does (equivalent linearisation). A stress `c rate^p` at a rate of
//! amplitude r loses, against a Newtonian one of viscosity mu,
//! ```text
//! mu = c r^(p-1) e(p),     e(p) = 2 <|cos|^(p+1)>,     e(1) = 1,   e(0) = 4/pi
//! ```
//! with r = v k sqrt(2) s_b in the bulk and r = v s_w/delta, delta = sqrt(2 nu/w), in the layer, where v
//! is the amplitude `sqrt(v^2 + w^2 a^2)` of the rate at the wall and the s are means over the places.

use super::finite_layer::{between, film_factors, wall_excess};
use super::modes::{Cylinder, SloshMode};
use super::wall_impedance::{Maxwell, WallLayer};
use crate::math::{pow, sincos, sinh, sqrt, tanh};

/// Mean s_b of the bulk's rate of shear over `sqrt(2) k v` by the exponent p of the stress: the rate at which `c rate^p` loses as much
/// everywhere as it does over the bulk, `s_b^(p-1) = int s^(p+1)/int s^2`, by quadrature over the first mode of a deep cylinder. A
/// stress that hardly falls with the rate loses much where the rate is small.
pub(super) const BULK_PLACES: [f64; 5] = [0.577, 0.617, 0.650, 0.678, 0.702];

/// Exponents of [`BULK_PLACES`].
pub(super) const EXPONENTS: [f64; 5] = [0.0, 0.25, 0.5, 0.75, 1.0];

/// Mean of the rate of shear in the layer over `v/delta`.
const LAYER_PLACE: f64 = 0.6;

/// Least amplitude of a rate of shear, 1/s: below it a yield stress is a great viscosity.
const LEAST_RATE: f64 = 0.02;

/// Rheology of the liquid: shear stress as a function of the shear rate.
///
/// ```
/// use meniscus::reduced::Rheology;
///
/// // A Newtonian liquid has one viscosity at every rate of shear.
/// assert_eq!(Rheology::newtonian(0.95).equivalent(7.0), 0.95);
/// // A shear-thinning liquid of flow index 0.5 has half of it at four times the rate.
/// let thinning = Rheology { index: 0.5, ..Rheology::newtonian(0.95) };
/// assert!((thinning.equivalent(40.0) / thinning.equivalent(10.0) - 0.5).abs() < 1e-9);
/// assert!(!thinning.is_linear());
/// ```
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Rheology {
    /// Consistency K, Pa s^n.
    pub consistency: f64,
    /// Flow index n.
    pub index: f64,
    /// Yield stress tau0, Pa.
    pub yield_pa: f64,
    /// Slip length b at the wall, m.
    pub slip_m: f64,
    /// Film on the surface: 0 none, 1 inextensible.
    pub film: f64,
    /// Maxwell stress beside the viscous one. Not stored with a model.
    #[serde(skip)]
    pub maxwell: Maxwell,
    /// Share of the contact line that a sticking wall holds: 1 holds it, 0 lets it slide. Not stored with a model.
    #[serde(skip, default = "all")]
    pub held_line: f64,
}

impl Rheology {
    /// A liquid of constant viscosity (Pa s) that sticks to the wall and has no film.
    #[must_use]
    pub fn newtonian(viscosity_pa_s: f64) -> Self {
        Self {
            consistency: viscosity_pa_s,
            index: 1.0,
            yield_pa: 0.0,
            slip_m: 0.0,
            film: 0.0,
            maxwell: Maxwell::default(),
            held_line: all(),
        }
    }

    /// The viscosity (Pa s) that loses as much at a rate of amplitude `rate` (1/s).
    #[must_use]
    pub fn equivalent(&self, rate: f64) -> f64 {
        self.equivalent_of([rate; 2])
    }

    /// The same where the yield stress and the power law lose as much as at these two `rates` (1/s).
    fn equivalent_of(&self, rates: [f64; 2]) -> f64 {
        let [plastic_rate, rate] = rates.map(|rate| rate.max(LEAST_RATE));
        let plastic = if self.yield_pa > 0.0 { self.yield_pa * loss(0.0) / plastic_rate } else { 0.0 };
        if self.index == 1.0 {
            return self.consistency + plastic;
        }
        self.consistency * pow(rate, self.index - 1.0) * loss(self.index) + plastic
    }

    /// Whether the friction is the same at every amplitude.
    #[must_use]
    pub fn is_linear(&self) -> bool {
        self.index == 1.0 && self.yield_pa == 0.0
    }
}

/// The whole of the contact line.
fn all() -> f64 {
    1.0
}

/// `e(p) = 2 <|cos|^(p+1)>` over a cycle, by the midpoint rule.
fn loss(p: f64) -> f64 {
    const POINTS: u32 = 16;
    let mean = |i: u32| {
        let (_, cos) = sincos(core::f64::consts::FRAC_PI_2 * (f64::from(i) + 0.5) / f64::from(POINTS));
        pow(cos, p + 1.0)
    };
    2.0 * (0..POINTS).map(mean).sum::<f64>() / f64::from(POINTS)
}

/// Returns damping gamma (1/s) and lowering of the frequency (1/s) of `mode` at amplitude `speed` (m/s) and frequency `w`
/// (1/s), in `glass`; of the first mode beyond layer theory.
#[must_use]
pub(super) fn friction(
    mode: &SloshMode,
    w: f64,
    speed: f64,
    liquid: &Rheology,
    glass: &Cylinder,
) -> (f64, f64) {
    let viscosities = viscosities(mode, w, speed, liquid, glass.density_kg_m3);
    let Layers { damping, lowering, film } = layers(mode, w, viscosities, liquid, glass);
    if !mode.is_first() {
        return (damping + film, lowering + film);
    }
    let x = layer_depth(viscosities.wall, w) / glass.radius_m;
    let more = wall_excess(x, &wall_layer(w, viscosities.wall, liquid, glass), liquid.held_line);
    let over = film_factors(x);
    (damping + w * more.damping + film * over.damping, lowering + w * more.lowering + film * over.lowering)
}

/// Kinematic viscosities that a mode gives the liquid, m2/s.
#[derive(Clone, Copy, Debug)]
pub(super) struct Viscosities {
    /// In the bulk.
    bulk: f64,
    /// In the layer at the wall.
    wall: f64,
}

/// Returns the viscosities that a `mode` of amplitude `speed` (m/s) and frequency `w` (1/s) gives the liquid.
pub(super) fn viscosities(
    mode: &SloshMode,
    w: f64,
    speed: f64,
    liquid: &Rheology,
    density: f64,
) -> Viscosities {
    let largest = speed * mode.k * core::f64::consts::SQRT_2;
    let rates = [0.0, liquid.index].map(|p| largest * between(&EXPONENTS, &BULK_PLACES, p));
    let bulk = liquid.equivalent_of(rates) / density;
    let mut wall = bulk;
    if !liquid.is_linear() {
        // The layer's depth and its viscosity determine one another; the rate falls as the depth grows,
        // so a few turns settle it.
        for _ in 0..6 {
            wall = liquid.equivalent(speed * LAYER_PLACE / layer_depth(wall, w)) / density;
        }
    }
    Viscosities { bulk, wall }
}

/// Returns damping and lowering (1/s) by layer theory where the viscosities are given: those that a stronger wave gives
/// the liquid, for one that rides on it.
pub(super) fn resistance(
    mode: &SloshMode,
    w: f64,
    viscosities: Viscosities,
    liquid: &Rheology,
    glass: &Cylinder,
) -> (f64, f64) {
    let Layers { damping, lowering, film } = layers(mode, w, viscosities, liquid, glass);
    (damping + film, lowering + film)
}

/// Layer theory of one mode, 1/s.
struct Layers {
    /// Damping by wall and bulk.
    damping: f64,
    /// Lowering of the frequency by the wall.
    lowering: f64,
    /// Damping by the film, and lowering.
    film: f64,
}

/// Returns the parts of layer theory.
fn layers(mode: &SloshMode, w: f64, viscosities: Viscosities, liquid: &Rheology, glass: &Cylinder) -> Layers {
    let Viscosities { bulk, wall } = viscosities;
    let (k, kh) = (mode.k, mode.k * glass.depth_m);
    let around = f64::from(mode.order * mode.order) / (mode.xi * mode.xi);
    let side = (1.0 + around) / (1.0 - around);
    let bottom = 2.0 * k * glass.radius_m * (1.0 - glass.depth_m / glass.radius_m) / sinh(2.0 * kh);
    let sticking = sqrt(0.5 * wall * w) / (2.0 * glass.radius_m) * (side + bottom);
    let impedance = wall_layer(w, wall, liquid, glass).impedance();
    Layers {
        damping: sticking * impedance.damping + 2.0 * bulk * k * k,
        lowering: sticking * impedance.lowering,
        film: liquid.film * 0.5 * sqrt(0.5 * wall * w) * k / tanh(kh),
    }
}

/// Returns the layer of `liquid` of a kinematic viscosity (m2/s) at the wall, at the frequency `w` (1/s).
fn wall_layer(w: f64, viscosity_m2_s: f64, liquid: &Rheology, glass: &Cylinder) -> WallLayer {
    WallLayer {
        slip: liquid.slip_m / layer_depth(viscosity_m2_s, w),
        relaxing: liquid.maxwell.over(viscosity_m2_s * glass.density_kg_m3, w),
    }
}

/// Depth of Stokes's layer, m.
fn layer_depth(viscosity_m2_s: f64, w: f64) -> f64 {
    sqrt(2.0 * viscosity_m2_s / w)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reduced::Wave;
    use crate::units::GRAVITY_M_S2;

    /// Layer theory alone.
    fn thin(mode: &SloshMode, w: f64, liquid: &Rheology, glass: &Cylinder) -> (f64, f64) {
        resistance(mode, w, viscosities(mode, w, 0.1, liquid, glass.density_kg_m3), liquid, glass)
    }

    fn damping(liquid: &Rheology, density: f64, radius_m: f64, depth_m: f64) -> f64 {
        let glass = Cylinder { radius_m, depth_m, density_kg_m3: density };
        let mode = SloshMode::new(&glass, Wave::First(0));
        let w = sqrt(mode.square(GRAVITY_M_S2));
        thin(&mode, w, liquid, &glass).0 / w
    }

    #[test]
    fn water_in_the_measured_cylinder_has_the_damping_of_case_and_parkinson_and_of_a_film() {
        // 0.32 % of critical for a clean wall, 0.62 % with an inextensible film: facts of the field.
        let clean = damping(&Rheology::newtonian(1.0e-3), 998.0, 0.049, 0.078);
        assert!((clean - 0.0032).abs() < 1e-4, "{clean}");
        let film = Rheology { film: 1.0, ..Rheology::newtonian(1.0e-3) };
        let film = damping(&film, 998.0, 0.049, 0.078);
        assert!((film - 0.0062).abs() < 1e-4, "{film}");
    }

    #[test]
    fn a_wall_that_slips_freely_leaves_the_bulk_alone() {
        let glass = Cylinder { radius_m: 0.035, depth_m: 0.07, density_kg_m3: 1261.0 };
        let mode = SloshMode::new(&glass, Wave::First(0));
        let w = sqrt(mode.square(GRAVITY_M_S2));
        let of = |slip_m: f64| {
            let liquid = Rheology { slip_m, ..Rheology::newtonian(0.2) };
            thin(&mode, w, &liquid, &glass)
        };
        let (damping, lowering) = of(1e9);
        assert!((damping / (2.0 * 0.2 / 1261.0 * mode.k * mode.k) - 1.0).abs() < 1e-6 && lowering < 1e-6);
        // More slip, less damping, without a jump.
        let mut last = of(0.0).0;
        for slip in [1e-4, 1e-3, 1e-2, 1e-1] {
            let now = of(slip).0;
            assert!(now < last && now > 0.0);
            last = now;
        }
    }

    #[test]
    fn equivalent_viscosities_lose_as_much_as_their_stress() {
        assert!((loss(1.0) - 1.0).abs() < 1e-9, "{}", loss(1.0));
        assert!((loss(0.0) - 4.0 / core::f64::consts::PI).abs() < 2e-3, "{}", loss(0.0));
        let thinning = Rheology { index: 0.5, ..Rheology::newtonian(0.2) };
        // Four times the rate, half the viscosity.
        assert!((thinning.equivalent(40.0) / thinning.equivalent(10.0) - 0.5).abs() < 1e-9);
        assert_eq!(Rheology::newtonian(0.2).equivalent(7.0), 0.2);
    }
}
