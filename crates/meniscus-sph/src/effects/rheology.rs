//! The three effects of the liquid's own stress: they replace one number each of its law
//! ```text
//! tau = tau0 + k rate^n            (Herschel and Bulkley 1926; regularised as in `liquids::rheology`)
//! ```
//! and keep the others. A liquid that was Newtonian gets the usual cap of the viscosity.

use super::Laws;
use meniscus_data::liquids::{Liquid, Rheology};

/// `liquid` with the stress that the effects give it.
pub(crate) fn liquid_with(laws: &Laws, liquid: &Liquid) -> Liquid {
    let old = liquid.rheology;
    let consistency = laws.consistency.unwrap_or(old.consistency);
    let rheology = Rheology {
        consistency,
        index: laws.index.unwrap_or(old.index),
        yield_stress: laws.yield_stress_pa.unwrap_or(old.yield_stress),
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
        assert_eq!(liquid_with(&Laws::default(), &liquid), liquid);
        let laws = Laws { yield_stress_pa: Some(2.0), ..Laws::default() };
        let Rheology { consistency, index, yield_stress, largest } = liquid_with(&laws, &liquid).rheology;
        assert_eq!((consistency, index, yield_stress, largest), (0.95, 1.0, 2.0, 20.0));
        let ketchup = Liquid::load("ketchup").expect("a known liquid");
        let thick = liquid_with(&Laws { consistency: Some(1.0), ..Laws::default() }, &ketchup).rheology;
        assert_eq!(thick, Rheology { consistency: 1.0, ..ketchup.rheology });
    }
}
