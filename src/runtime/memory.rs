//! State of the estimator from turn to turn, and the mode that it leads to.

use super::mode::Mode;
use super::motion::{CARRY_FRAMES, Motion};
use super::turn_input::InputSource;
use crate::blob::FilterConfig;
use crate::filter::Filter;
use crate::latent::generic::{Latent, LatentState};
use crate::latent::window::Window;
use crate::runtime::health::{Health, count};
use crate::surface::SurfaceProfile;
use crate::uncertainty::disagreement::Disagreement;

/// State of the estimator from turn to turn. One memory belongs to one model.
#[derive(Clone, Debug, Default)]
pub struct Memory {
    pub(super) window: Window,
    pub(super) state: LatentState,
    pub(super) filter: Filter,
    pub(super) motion: Motion,
    /// Profiles since the sides of the glass were seen.
    unseen: u32,
    pub(super) mode: Mode,
    missed: u32,
    pub(super) disagreement: Disagreement,
    /// Turns in a row without heights and without a known motion of the glass.
    pub(super) blind_turns: u32,
    /// Counters since the start.
    pub health: Health,
}

impl Memory {
    /// Returns `source`, or [`InputSource::Unobserved`] where the sides of the glass have not been seen for longer than an
    /// acceleration is carried on.
    pub(super) fn resolve_source(
        &mut self,
        source: InputSource,
        profile: Option<&SurfaceProfile>,
    ) -> InputSource {
        if let Some(profile) = profile {
            self.unseen = if profile.glass_x_m.is_some() { 0 } else { self.unseen.saturating_add(1) };
        }
        if source == InputSource::Tracked && self.unseen > CARRY_FRAMES {
            return InputSource::Unobserved;
        }
        source
    }

    /// Y: amplitude of the cross-axis slosh, at the point of the glass nearest to the camera, m
    /// ([`crate::uncertainty::cross_axis`]).
    #[must_use]
    pub fn lateral_m(&self) -> f64 {
        self.filter.lateral_m()
    }

    /// rho: mean square of the errors that the camera sees in the estimated surface, over what the intervals say. One where they are
    /// right, more where they are too narrow (`crate::uncertainty::disagreement`).
    #[must_use]
    pub fn disagreement(&self) -> f64 {
        self.disagreement.rho()
    }

    /// Counts the turn among those without heights and without a known motion, or ends their row.
    pub(super) fn update_blind_turns(&mut self, source: InputSource, has_heights: bool) {
        if has_heights {
            self.blind_turns = 0;
        } else if !matches!(source, InputSource::Measured { .. }) {
            self.blind_turns = self.blind_turns.saturating_add(1);
        }
    }

    /// Moves to the mode of this turn and counts it.
    pub(super) fn update_mode(&mut self, config: &FilterConfig, measured: bool) {
        self.missed = if measured { 0 } else { self.missed.saturating_add(1) };
        let next = self.mode.next(measured, self.missed);
        if next == Mode::Halted && self.mode != Mode::Halted {
            // After a long gap the liquid has nothing to do with the state that was left.
            self.window.clear();
            self.motion = Motion::default();
            self.disagreement = Disagreement::default();
            self.state.latent = Latent::zeros();
            self.state.held = Default::default();
            self.filter = Filter::new(config);
        }
        self.mode = next;
        count(match next {
            Mode::Filling => &mut self.health.filling,
            Mode::Tracking => &mut self.health.tracking,
            Mode::Coasting => &mut self.health.coasting,
            Mode::Halted => &mut self.health.halted,
        });
    }
}
