//! The head of a weight blob, as `firmware-config/SPEC.md` specifies it byte by byte.

use super::effect_validity::kept_by;
use super::embedded_effects::EmbeddedEffects;
use super::format::{MAX_SECTIONS, Section};
use super::{FilterConfig, KnownGroups, Variant};
use crate::reduced::effects::find;
use heapless::{String, Vec};
use serde::{Deserialize, Serialize};

/// Everything of a model but its tensors.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Header {
    /// Liquid the model was trained on.
    pub liquid: String<32>,
    /// The commands, seeds and revision that made the model.
    pub provenance: String<512>,
    /// Number of tracers.
    pub particles: u32,
    /// Time step of one turn, s.
    pub dt_s: f64,
    /// Inner radius of the glass, m.
    pub radius_m: f64,
    /// Height of the liquid at rest, m.
    pub fill_m: f64,
    /// Height of the rim, m.
    pub rim_m: f64,
    /// Feature scale: (height - fill) / `height_scale_m`.
    pub height_scale_m: f32,
    /// Feature and port scale: u = acceleration / `acceleration_scale`, m/s2.
    pub acceleration_scale: f32,
    /// Joules of one unit of H.
    pub energy_scale_j: f64,
    /// Slosh-relative surface error on the validation recordings, as trained.
    pub validation_slosh_rel: f32,
    /// The tensors, in blob order.
    pub sections: Vec<Section, MAX_SECTIONS>,
    /// Embedded effects. Not part of the header itself: they stand behind the list of elements, which has to be there
    /// with them.
    #[serde(skip)]
    pub embedded: Option<EmbeddedEffects>,
    /// Version of the model. Whatever makes a model from another one raises it; 0 where the format had none. Not part of
    /// the header itself, as are the next two: they stand in the [`Extension`].
    #[serde(skip)]
    pub model_version: u64,
    /// Field groups that the weights are valid for, as the blob states them. [`Header::known`] takes the embedded effects into
    /// account.
    #[serde(skip)]
    pub stated_known: KnownGroups,
    /// Settings of the filter.
    #[serde(skip)]
    pub filter: FilterConfig,
    /// Variant of the estimator that runs on the model. Not part of a blob: whoever loads the model chooses.
    #[serde(skip)]
    pub variant: Variant,
}

/// Fields that stand directly behind the header from format version 4 on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Extension {
    /// See [`Header::model_version`].
    pub model_version: u64,
    /// See [`Header::stated_known`].
    pub known: KnownGroups,
    /// See [`Header::filter`].
    pub filter: FilterConfig,
}

/// Text that a correction puts between its own command and the provenance of the model that it corrected.
pub const BEFORE: &str = "; before: ";

impl Header {
    /// Returns the field groups that the model is valid for, with its embedded effects, and that its variant estimates.
    #[must_use]
    pub fn known(&self) -> KnownGroups {
        let embedded = self.embedded.iter().flat_map(|embedded| &embedded.effects);
        let kept =
            embedded.map(|effect| find(&effect.name).map_or(KnownGroups::NONE, |entry| kept_by(entry.kind)));
        kept.fold(self.stated_known.both(self.variant.groups()), KnownGroups::both)
    }

    /// Whether the model was corrected from the free surface, by its provenance.
    #[must_use]
    pub fn corrected(&self) -> bool {
        let (text, mark) = (self.provenance.as_bytes(), BEFORE.as_bytes());
        (0..text.len()).any(|at| text.get(at..).is_some_and(|rest| rest.starts_with(mark)))
    }

    /// Returns the fields that a writer puts behind the header.
    #[must_use]
    pub fn extension(&self) -> Extension {
        Extension { model_version: self.model_version, known: self.stated_known, filter: self.filter }
    }
}
