//! Field groups that a model knows for its liquid, for a person.

use crate::recording::group_names;
use meniscus::blob::{FieldGroup, Header, KnownGroups, Variant};

/// Groups that a model knows, and the sentence that goes with the others.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Validity {
    /// Known groups.
    pub known: KnownGroups,
    /// Reason for the groups that are not known, with the remedy; `None` where all are.
    pub sentence: Option<String>,
}

impl Validity {
    /// Returns the validity of the model of `header`.
    #[must_use]
    pub fn of(header: &Header) -> Self {
        let known = header.known();
        let unknown: Vec<&str> =
            FieldGroup::ALL.into_iter().filter(|group| !known.contains(*group)).map(words).collect();
        Self { known, sentence: (!unknown.is_empty()).then(|| sentence(header, &unknown)) }
    }

    /// Returns the names of the known groups, as in files.
    #[must_use]
    pub fn names(&self) -> Vec<&'static str> {
        group_names(self.known)
    }
}

/// Returns the words for a group.
fn words(group: FieldGroup) -> &'static str {
    match group {
        FieldGroup::Position => "position",
        FieldGroup::Velocity => "velocity",
        FieldGroup::InternalEnergy => "internal energy",
        FieldGroup::NormalStress => "normal stress",
        FieldGroup::ShearStress => "shear stress",
        FieldGroup::Surface => "surface",
    }
}

/// Returns the cause, the groups that are not known, and the remedy.
fn sentence(header: &Header, unknown: &[&str]) -> String {
    if header.variant == Variant::Small {
        return "The small estimator has the surface alone: --variant full estimates the field.".into();
    }
    let cause = if header.corrected() && header.stated_known != KnownGroups::ALL {
        "This model was corrected from the free surface alone."
    } else if header.embedded.is_some() {
        "This model carries an inserted effect, and its decoder is that of the liquid without it."
    } else {
        "This model states that it does not cover every field group."
    };
    if unknown == [words(FieldGroup::InternalEnergy)] && !header.corrected() && header.embedded.is_none() {
        // Nothing to remedy: a training on the liquid itself could not tell it.
        return "This model does not know the internal energy: the heat of a slosh in this liquid is too small to tell."
            .into();
    }
    let (last, before) = unknown.split_last().map_or(("", &[][..]), |(last, before)| (*last, before));
    let list = if before.is_empty() { last.into() } else { format!("{} and {last}", before.join(", ")) };
    let verb = if before.is_empty() { "is" } else { "are" };
    let mut list = list.chars();
    let capital = list.next().map(|first| first.to_uppercase().collect::<String>()).unwrap_or_default();
    format!(
        "{cause} {capital}{} {verb} not known for this liquid. Learn it: meniscus learn LIQUID --out DIR",
        list.as_str()
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use meniscus::blob::{BEFORE, Model};
    use meniscus_platform::files::AlignedBytes;

    fn header(known: KnownGroups, provenance: &str) -> Header {
        let bytes = AlignedBytes::copy(meniscus_shipped::MODEL);
        let header = Model::load(&bytes).expect("the shipped model").header;
        Header { stated_known: known, provenance: provenance.try_into().expect("short"), ..header }
    }

    #[test]
    fn a_model_that_knows_all_has_no_sentence() {
        let validity = Validity::of(&header(KnownGroups::ALL, "meniscus train"));
        assert_eq!((validity.sentence.clone(), validity.names().len()), (None, 6));
    }

    #[test]
    fn the_small_estimator_is_the_cause_before_any_other() {
        let header = header(KnownGroups::ALL, "meniscus train");
        let validity = Validity::of(&Header { variant: Variant::Small, ..header });
        assert_eq!(validity.names(), ["surface"]);
        assert!(validity.sentence.is_some_and(|sentence| sentence.contains("--variant full")));
    }

    #[test]
    fn a_sentence_has_the_cause_the_groups_and_the_remedy() {
        let corrected = header(KnownGroups::KINEMATICS, &format!("meniscus correct{BEFORE}meniscus train"));
        let validity = Validity::of(&corrected);
        assert_eq!(validity.names(), ["q", "surface"]);
        assert_eq!(
            validity.sentence.as_deref(),
            Some(
                "This model was corrected from the free surface alone. Velocity, internal energy, normal stress and shear \
                 stress are not known for this liquid. Learn it: meniscus learn LIQUID --out DIR"
            )
        );
        let all_but_one = KnownGroups::KINEMATICS
            .with(FieldGroup::Velocity)
            .with(FieldGroup::NormalStress)
            .with(FieldGroup::ShearStress);
        let stated = Validity::of(&header(all_but_one, "meniscus train")).sentence.expect("one is not known");
        assert!(
            stated.contains("does not know the internal energy") && !stated.contains("Learn it"),
            "{stated}"
        );
        let stress_too = KnownGroups::KINEMATICS.with(FieldGroup::Velocity);
        let stated =
            Validity::of(&header(stress_too, "meniscus train")).sentence.expect("three are not known");
        assert!(
            stated.contains("every field group. Internal energy, normal stress and shear stress are"),
            "{stated}"
        );
    }
}
