//! Pairs of effects in the liquid that are hidden at once, each at its reference size.

use crate::study::cases::{Hidden, STATED, VISCOSITY_PA_S};
use crate::study::motions::MotionKind;
use crate::study::truth::Truth;
use meniscus::reduced::effects::EffectKind::{
    self, ContactLine, Foam, PinnedLine, ShearThinning, SurfaceTension, Viscoelastic, Viscosity, WallSlip,
    YieldStress,
};
use meniscus_data::effects::Effects;

/// Packing of the glasses that were looked at while rules were made, and the pairs in them.
const LOOKED_AT: (u64, [(EffectKind, EffectKind); 6]) = (
    7,
    [
        (YieldStress, SurfaceTension),
        (ShearThinning, ContactLine),
        (Viscosity, Foam),
        (PinnedLine, YieldStress),
        (WallSlip, SurfaceTension),
        (Viscoelastic, Foam),
    ],
);

/// The same of glasses that were held out.
const HELD_OUT: (u64, [(EffectKind, EffectKind); 6]) = (
    71,
    [
        (YieldStress, ContactLine),
        (ShearThinning, SurfaceTension),
        (Viscosity, PinnedLine),
        (Foam, SurfaceTension),
        (WallSlip, ContactLine),
        (ShearThinning, Foam),
    ],
);

/// Two hidden effects.
#[derive(Clone, Debug)]
pub struct HiddenPair {
    /// Effects with their first coordinate in the reduced model.
    pub effects: [(EffectKind, f64); 2],
    /// The glass.
    pub truth: Truth,
    /// Whether it was held out while rules were made.
    pub held_out: bool,
}

/// Returns all pairs, those that were looked at first.
#[must_use]
pub fn pairs() -> Vec<HiddenPair> {
    let of = |held_out: bool, (packing, pairs): (u64, [(EffectKind, EffectKind); 6])| {
        pairs.into_iter().filter_map(move |(a, b)| {
            let mut effects = Effects::default();
            let mut values = [0.0; 2];
            for (kind, value) in [a, b].into_iter().zip(&mut values) {
                let hidden = Hidden::of(kind)?;
                *value = hidden.value(1.0);
                let parameter = hidden.effect.parameters.first()?;
                effects = effects.with(kind, parameter.to_value(*value, &STATED));
            }
            let kind = MotionKind::Single;
            let truth = Truth { viscosity_pa_s: VISCOSITY_PA_S, packing, effects, kind };
            Some(HiddenPair { effects: [(a, values[0]), (b, values[1])], truth, held_out })
        })
    };
    of(false, LOOKED_AT).chain(of(true, HELD_OUT)).collect()
}
