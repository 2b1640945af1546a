//! The topics, and one turn on all of them.

use super::{Shared, camera, estimate, nanoseconds, scene, tracers};
use ::foxglove::messages::{
    CameraCalibration, CompressedImage, FrameTransform, PointCloud, SceneUpdate, Timestamp,
};
use ::foxglove::{Channel, PartialMetadata, RawChannel};
use meniscus::blob::{FieldGroup, Model};
use meniscus::runtime::Mode;
use meniscus::surface::Config;
use meniscus_service::snapshot::TurnSnapshot;
use meniscus_service::timed_turn::TimedTurn;
use std::sync::Arc;

/// A channel for each topic.
pub(super) struct Topics {
    infrared: Channel<CompressedImage>,
    calibration: Channel<CameraCalibration>,
    glass: Channel<FrameTransform>,
    tracers: Channel<PointCloud>,
    surface: Channel<SceneUpdate>,
    /// `None` if the schema were refused, which its test excludes.
    estimate: Option<Arc<RawChannel>>,
}

impl Topics {
    pub(super) fn new(context: &Shared) -> Self {
        Self {
            infrared: context.channel_builder("/camera/infrared").build(),
            calibration: context.channel_builder("/camera/calibration").build(),
            glass: context.channel_builder("/tf").build(),
            tracers: context.channel_builder("/liquid/tracers").build(),
            surface: context.channel_builder("/liquid/surface").build(),
            estimate: estimate::channel(context).ok(),
        }
    }

    /// Whether anybody takes any of them.
    pub(super) fn wanted(&self) -> bool {
        self.infrared.has_sinks()
            || self.calibration.has_sinks()
            || self.glass.has_sinks()
            || self.tracers.has_sinks()
            || self.surface.has_sinks()
            || self.estimate.as_ref().is_some_and(|channel| channel.has_sinks())
    }

    /// Hands a turn on to whoever takes its topics. `field` is room for the full field.
    pub(super) fn log(
        &self,
        model: &Model<'_>,
        config: &Config,
        snapshot: &TurnSnapshot,
        logged: &TimedTurn,
        field: &mut [f32],
    ) {
        let meta = PartialMetadata { log_time: Some(nanoseconds(logged)) };
        let stamp = timestamp(nanoseconds(logged));
        let estimate = &logged.turn.estimate;
        if let Some(channel) = &self.estimate
            && channel.has_sinks()
        {
            channel.log_with_meta(estimate::message(model, snapshot, logged).as_bytes(), meta);
        }
        if let Some(transform) = scene::glass(logged, stamp)
            && self.glass.has_sinks()
        {
            self.glass.log_with_meta(&transform, meta);
        }
        // A liquid of which nothing is known is not shown as if it were.
        if estimate.mode != Mode::Halted {
            let known = model.header.known();
            // Without positions there is no place for a tracer.
            if self.tracers.has_sinks() && known.contains(FieldGroup::Position) {
                let latent = estimate.latent.map(|x| x as f32);
                let coefficients = model.decoder.coefficients(&latent, estimate.port);
                model.decoder.part(known.selection(), &coefficients, estimate.heat_j as f32, field);
                self.tracers.log_with_meta(
                    &tracers::tracers(model.header.particles as usize, known, field, stamp),
                    meta,
                );
            }
            if self.surface.has_sinks() {
                self.surface.log_with_meta(&scene::surface(model, config, logged, stamp), meta);
            }
        }
        if let Some(image_of) = &snapshot.image_of {
            // With the images, so that who joins late learns it within a tenth of a second.
            let meta = PartialMetadata { log_time: Some(nanoseconds(image_of)) };
            let stamp = timestamp(nanoseconds(image_of));
            if self.glass.has_sinks() {
                self.glass.log_with_meta(&scene::stand(config, stamp), meta);
            }
            if self.calibration.has_sinks() {
                self.calibration.log_with_meta(&camera::calibration(config, stamp), meta);
            }
            if self.infrared.has_sinks()
                && let Some(image) = camera::infrared(config, &snapshot.infrared, stamp)
            {
                self.infrared.log_with_meta(&image, meta);
            }
        }
    }
}

/// `ns` as a message carries it.
fn timestamp(ns: u64) -> Timestamp {
    Timestamp::new((ns / 1_000_000_000) as u32, (ns % 1_000_000_000) as u32)
}
