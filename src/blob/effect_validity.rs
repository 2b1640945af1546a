//! Field groups that stay valid when an effect is embedded in a model.
//!
//! The weights stay as they are: an embedded effect changes the step, and the decoder goes on to decode the trained liquid.
//! A group stays known where its relation to the latents does not involve what the effect changes.
//!
//! | effect | lost | reason |
//! |---|---|---|
//! | geometry, gain, timing, camera | nothing | it changes what reaches the model, or where the model stands, and no law of the liquid |
//! | law of the liquid | e, sigma, tau | the stress at a given flow is another one, and with it the heat |
//! | layer at wall or surface | v, e, sigma, tau | the flow at a given surface is another one: the basis of v has the trained layers |
//! | force along the edge or on the surface | e, sigma | the flow at a given surface and its shear stress stay; the force appears in the pressure, and its heat arises at the edge |
//!
//! This is an argument from the equations; the errors have not been measured by simulation.

use super::{FieldGroup, KnownGroups};
use crate::reduced::effects::EffectKind;

/// Returns the groups of a model that stay known with an effect of `kind` in it.
pub(super) const fn kept_by(kind: EffectKind) -> KnownGroups {
    match kind {
        EffectKind::ContainerTilt
        | EffectKind::VerticalAcceleration
        | EffectKind::ActuationGain
        | EffectKind::ActuationDelay
        | EffectKind::Fill
        | EffectKind::Radius
        | EffectKind::CameraLatency
        | EffectKind::CameraPitch
        | EffectKind::CameraSlope
        | EffectKind::DepthScale => KnownGroups::ALL,
        EffectKind::Viscosity
        | EffectKind::ShearThinning
        | EffectKind::YieldStress
        | EffectKind::Viscoelastic => KnownGroups::KINEMATICS.with(FieldGroup::Velocity),
        EffectKind::ContactLine
        | EffectKind::StuckLine
        | EffectKind::Foam
        | EffectKind::SurfaceTension
        | EffectKind::HeldTension
        | EffectKind::PinnedLine => {
            KnownGroups::KINEMATICS.with(FieldGroup::Velocity).with(FieldGroup::ShearStress)
        }
        // No blob embeds detuning and swirl, whose flow the latents do not represent.
        EffectKind::WallSlip | EffectKind::SurfaceFilm | EffectKind::Detuning | EffectKind::Swirl => {
            KnownGroups::KINEMATICS
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every effect keeps the surface, which the camera sees, and the positions that follow from it.
    #[test]
    fn an_effect_of_the_liquid_takes_its_stress_and_one_of_the_camera_takes_nothing() {
        for kind in EffectKind::ALL {
            assert_eq!(kept_by(kind).both(KnownGroups::KINEMATICS), KnownGroups::KINEMATICS);
        }
        for kind in [EffectKind::ActuationGain, EffectKind::Fill, EffectKind::CameraSlope] {
            assert_eq!(kept_by(kind), KnownGroups::ALL);
        }
        let viscosity = kept_by(EffectKind::Viscosity);
        assert!(viscosity.slosh_energy() && !viscosity.heat());
        for lost in [FieldGroup::NormalStress, FieldGroup::ShearStress] {
            assert!(!viscosity.contains(lost));
        }
        assert!(!kept_by(EffectKind::WallSlip).contains(FieldGroup::Velocity));
        assert!(kept_by(EffectKind::ContactLine).contains(FieldGroup::ShearStress));
    }
}
