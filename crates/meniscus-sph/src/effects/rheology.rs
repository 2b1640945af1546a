//! The three effects of the liquid's own stress: they replace one number each of its law
//! ```text
//! tau = tau0 + k rate^n            (Herschel and Bulkley 1926; regularised as in `liquids::rheology`)
//! ```
//! and keep the others. A liquid that was Newtonian gets the usual cap of the viscosity.

use meniscus_data::effects::Effects;
use meniscus_data::liquids::{Liquid, Rheology};

/// `liquid` with the stress that the effects give it.
pub(crate) fn liquid_with(effects: &Effects, liquid: &Liquid) -> Liquid {
    let old = liquid.rheology;
    let consistency = effects.viscosity.unwrap_or(old.consistency);
    let rheology = Rheology {
        consistency,
        index: effects.shear_thinning.unwrap_or(old.index),
        yield_stress: effects.yield_stress.unwrap_or(old.yield_stress),
        largest: if old.is_newtonian() { Rheology::newtonian(consistency).largest } else { old.largest },
    };
    Liquid { rheology, ..liquid.clone() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_number_is_replaced_alone() {
        let liquid = Liquid::load("glycerine").expect("a known liquid");
        assert_eq!(liquid_with(&Effects::default(), &liquid), liquid);
        let effects = Effects { yield_stress: Some(2.0), ..Effects::default() };
        let Rheology { consistency, index, yield_stress, largest } = liquid_with(&effects, &liquid).rheology;
        assert_eq!((consistency, index, yield_stress, largest), (0.95, 1.0, 2.0, 20.0));
        let ketchup = Liquid::load("ketchup").expect("a known liquid");
        let thick = liquid_with(&Effects { viscosity: Some(1.0), ..Effects::default() }, &ketchup).rheology;
        assert_eq!(thick, Rheology { consistency: 1.0, ..ketchup.rheology });
    }
}
