//! A liquid as a TOML file, with a source beside every number.

use meniscus_data::liquids::Liquid;

/// Sources of the numbers of a liquid: a stated one, or a fit with its interval.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Sources {
    /// Source of the density.
    pub density: String,
    /// Source of viscosity or consistency.
    pub viscosity: String,
    /// Source of the flow index.
    pub index: String,
    /// Source of the yield stress.
    pub yield_stress: String,
}

impl Sources {
    /// One source for all.
    #[must_use]
    pub fn one(text: &str) -> Self {
        let text = String::from(text);
        Self { density: text.clone(), viscosity: text.clone(), index: text.clone(), yield_stress: text }
    }
}

/// Returns `liquid` as the text of a liquid file.
#[must_use]
pub fn liquid_text(liquid: &Liquid, sources: &Sources) -> String {
    let law = &liquid.rheology;
    let mut text = format!("name = {}\n", quoted(&liquid.name));
    let mut number = |name: &str, value: f64, source: &str| {
        // Debug keeps a point in whole numbers, which TOML wants of a float, and every digit.
        text += &format!("{name} = {{ value = {value:?}, source = {} }}\n", quoted(source));
    };
    number("density_kg_m3", liquid.density_kg_m3, &sources.density);
    if law.is_newtonian() {
        number("viscosity_pa_s", law.consistency, &sources.viscosity);
    } else {
        number("consistency_pa_sn", law.consistency, &sources.viscosity);
        number("index", law.index, &sources.index);
        number("yield_stress_pa", law.yield_stress, &sources.yield_stress);
        number("largest_viscosity_pa_s", law.largest, "cap of the regularised law");
    }
    let effects = liquid.effects.on();
    if !effects.is_empty() {
        text += "\n[effects]\n";
        for (parameter, value) in effects {
            text += &format!("{} = {{ value = {value:?}, source = \"as stated\" }}\n", parameter.spelling);
        }
    }
    text
}

/// Returns `text` as a basic string of TOML.
fn quoted(text: &str) -> String {
    let safe = |letter: char| match letter {
        '"' | '\\' => format!("\\{letter}"),
        _ if letter.is_control() => String::from(" "),
        _ => letter.to_string(),
    };
    format!("\"{}\"", text.chars().map(safe).collect::<String>())
}

#[cfg(test)]
mod tests {
    use super::*;
    use meniscus_data::liquids::{Rheology, known};

    /// Every known liquid, and one with effects and an awkward name, reads back as itself.
    #[test]
    fn a_written_liquid_is_read_as_the_same() {
        let mut all: Vec<Liquid> = known().map(|name| Liquid::load(name).expect("known")).collect();
        let mut odd = all[0].clone();
        odd.name = "a \"thick\" one\\".into();
        odd.effects.set("surface_tension", 0.063).expect("in range");
        odd.rheology = Rheology { consistency: 1.0 / 3.0, index: 0.7, yield_stress: 2.0, largest: 20.0 };
        all.push(odd);
        for liquid in all {
            let text = liquid_text(&liquid, &Sources::one("0.95 (roughly 0.9 to 1.0)"));
            let again = Liquid::parse("written", &text).expect("a liquid file");
            assert_eq!(again, liquid, "{text}");
        }
    }
}
