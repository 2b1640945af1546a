//! What the study hides, and the clean glasses that it is held against.

use super::truth::Truth;
use crate::study::motion_plans::Kind;

/// Viscosity of the liquid that effects are hidden in, Pa s: 1.6e-4 m2/s, well above the simulator's own.
pub const VISCOSITY_PA_S: f64 = 0.2;

/// Packings of the glasses that effects are hidden in; no reference has them. While thresholds and rules
/// were made, the first was looked at; the second was not.
pub const HIDDEN_PACKINGS: [u64; 2] = [7, 37];

/// The clean glasses of the single jolts: liquids and packings.
const SINGLE: [(f64, u64); 12] = [
    (0.20, 0),
    (0.20, 1),
    (0.17, 3),
    (0.235, 5),
    (0.20, 2),
    (0.17, 4),
    (0.235, 6),
    (0.20, 8),
    (0.17, 9),
    (0.235, 10),
    (0.20, 11),
    (0.20, 12),
];

/// The clean glasses of the other courses.
const OTHER: [(f64, u64); 6] = [(0.20, 0), (0.20, 1), (0.17, 3), (0.235, 5), (0.20, 2), (0.17, 4)];

/// The clean glasses of a kind of course: the references, and in the clean trials the tested ones too.
#[must_use]
pub fn clean(kind: Kind) -> Vec<Truth> {
    let glasses: &[(f64, u64)] = match kind {
        Kind::Single | Kind::Asked => &SINGLE,
        Kind::Double | Kind::Slow => &OTHER,
    };
    let one =
        |&(viscosity_pa_s, packing): &(f64, u64)| Truth { viscosity_pa_s, packing, effects: vec![], kind };
    glasses.iter().map(one).collect()
}

/// An effect that the study hides.
#[derive(Clone, Copy, Debug)]
pub struct Hidden {
    /// Its name in the library.
    pub name: &'static str,
    /// The simulator's spelling, where the simulator carries it; the study's hands put in the others.
    pub simulator: Option<Simulated>,
    /// Value at reference size, in the unit of the library; of gain and scale, what is over one.
    pub reference: f64,
}

/// How the simulator is told.
#[derive(Clone, Copy, Debug)]
pub struct Simulated {
    /// The simulator's name of the effect.
    pub name: &'static str,
    /// The simulator's value from the hidden size.
    pub value: fn(f64) -> f64,
    /// What else must be set.
    pub beside: Option<(&'static str, f64)>,
}

const fn by(name: &'static str, value: fn(f64) -> f64) -> Option<Simulated> {
    Some(Simulated { name, value, beside: None })
}

/// What is hidden, one line each.
pub const HIDDEN: [Hidden; 18] = [
    Hidden { name: "viscosity", simulator: by("viscosity", |s| VISCOSITY_PA_S * s), reference: 1.3 },
    Hidden { name: "wall_slip", simulator: by("wall_slip", |s| s), reference: 0.003 },
    Hidden { name: "shear_thinning", simulator: by("shear_thinning", |s| s), reference: 0.5 },
    Hidden { name: "yield_stress", simulator: by("yield_stress", |s| s), reference: 3.0 },
    Hidden { name: "contact_line", simulator: by("contact_line", |s| s), reference: 0.03 },
    Hidden { name: "foam", simulator: by("foam", |s| s), reference: 0.1 },
    Hidden { name: "surface_tension", simulator: by("surface_tension", |s| s), reference: 0.2 },
    Hidden {
        name: "pinned_line",
        simulator: Some(Simulated {
            name: "contact_line",
            value: |s| 0.02 * s,
            beside: Some(("contact_line_reach", 0.02)),
        }),
        reference: 10.0,
    },
    Hidden { name: "viscoelastic", simulator: by("viscoelastic", |s| s), reference: 5.0 },
    Hidden { name: "container_tilt", simulator: by("container_tilt", |s| s), reference: 0.035 },
    Hidden { name: "vertical_acceleration", simulator: by("vertical_acceleration", |s| s), reference: 0.5 },
    Hidden { name: "fill", simulator: by("fill", |s| 0.07 + s), reference: 0.003 },
    Hidden { name: "actuation_gain", simulator: None, reference: 0.08 },
    Hidden { name: "actuation_delay", simulator: None, reference: 0.033 },
    Hidden { name: "camera_latency", simulator: None, reference: 0.033 },
    Hidden { name: "depth_scale", simulator: None, reference: 0.05 },
    Hidden { name: "camera_pitch", simulator: None, reference: 0.035 },
    Hidden { name: "camera_slope", simulator: None, reference: 0.052 },
];

/// Sizes at which each is hidden, as parts of the reference size.
pub const SIZES: [f64; 3] = [1.0, 2.0, 0.5];

impl Hidden {
    /// The value at `size` times the reference size. Factors and exponents count from one.
    #[must_use]
    pub fn value(&self, size: f64) -> f64 {
        match self.name {
            "viscosity" => 1.0 + (self.reference - 1.0) * size,
            "actuation_gain" | "depth_scale" => 1.0 + self.reference * size,
            // 1 - n halves and doubles; beyond 0.8 nothing is left to thin.
            "shear_thinning" => 1.0 - (0.5 * size).min(0.8),
            _ => self.reference * size,
        }
    }

    /// The glass with this effect at `size`, of this `packing`, taken through `kind`; a clean one where the
    /// simulator does not carry it.
    #[must_use]
    pub fn truth(&self, size: f64, packing: u64, kind: Kind) -> Truth {
        let mut effects = Vec::new();
        if let Some(simulated) = self.simulator {
            effects.push((simulated.name, (simulated.value)(self.value(size))));
            effects.extend(simulated.beside);
        }
        Truth { viscosity_pa_s: VISCOSITY_PA_S, packing, effects, kind }
    }
}

/// Pairs that are hidden at once, at reference size.
pub const PAIRS: [(&str, &str); 6] = [
    ("yield_stress", "camera_pitch"),
    ("viscosity", "actuation_gain"),
    ("surface_tension", "camera_latency"),
    ("contact_line", "camera_pitch"),
    ("vertical_acceleration", "camera_pitch"),
    ("foam", "camera_latency"),
];

/// Everything that is simulated before the study starts, the most needed first.
#[must_use]
pub fn truths() -> Vec<Truth> {
    let [known, fresh] = HIDDEN_PACKINGS;
    let sized =
        |size: f64, packing: u64| HIDDEN.iter().map(move |hidden| hidden.truth(size, packing, Kind::Single));
    let mut all: Vec<Truth> = clean(Kind::Single);
    all.extend(sized(1.0, known));
    all.extend([Kind::Double, Kind::Slow].into_iter().flat_map(clean));
    all.extend(sized(1.0, fresh));
    all.extend(clean(Kind::Asked));
    all.extend(SIZES.into_iter().skip(1).flat_map(|size| sized(size, known)));
    let mut out: Vec<Truth> = Vec::new();
    for truth in all {
        if !out.contains(&truth) {
            out.push(truth);
        }
    }
    out
}
