//! Estimator: one turn from a profile (or none) to an estimate of the whole liquid.
//!
//! [`Estimator`] is configuration and weights (`&self`), [`Memory`] what changes (`&mut`). The stages of a turn, in their
//! order, are functions of `predict.rs`, `correct.rs` and `decode.rs`.

use super::budget::{Clock, DEADLINE_US, Lap, Stages};
use super::estimate::Estimate;
use super::memory::Memory;
use super::turn_input::TurnInput;
use crate::blob::Model;
use crate::latent::decoder::Selection;
use crate::real::{Precision, Real};
use crate::runtime::health::count;

/// Points of a profile that must be seen for it to be a measurement: two thirds of 21.
pub const POINTS_NEEDED: usize = 14;

/// Estimator on a checked model.
///
/// ```
/// use meniscus::blob::Model;
/// use meniscus::runtime::{Clock, Estimator, InputSource, Memory, Mode, TurnInput};
/// use meniscus::surface::{POINTS, SurfaceProfile};
/// use meniscus::units::Micros;
///
/// // Weights are read in place, on a boundary of 64 bytes.
/// #[repr(C, align(64))]
/// struct Aligned<T: ?Sized>(T);
/// static BLOB: &Aligned<[u8]> =
///     &Aligned(*include_bytes!(concat!(env!("CARGO_MANIFEST_DIR"), "/models/glycerine.blob")));
///
/// struct NoClock;
/// impl Clock for NoClock {
///     fn now_us(&mut self) -> u64 {
///         0
///     }
/// }
///
/// let model = Model::load(&BLOB.0)?;
/// let (estimator, mut memory) = (Estimator::new(&model), Memory::default());
/// let mut field = vec![0.0; estimator.field_len()];
/// // A glass at rest that is seen 20 times.
/// let profile = SurfaceProfile {
///     height_m: [model.header.fill_m as f32; POINTS],
///     variance_m2: [1e-8; POINTS],
///     valid: [true; POINTS],
///     glass_x_m: Some(0.0),
///     sequence: 0,
///     captured: Micros(0),
/// };
/// for _ in 0..20 {
///     estimator.turn(&mut memory, TurnInput::tracked(&profile), &mut NoClock, &mut field);
/// }
/// // Then the camera fails, while an IMU reports a push.
/// let source = InputSource::Measured { before: 0.5, now: 0.5 };
/// let input = TurnInput { source, ..TurnInput::default() };
/// let estimate = estimator.turn(&mut memory, input, &mut NoClock, &mut field);
/// assert_eq!(estimate.mode, Mode::Coasting);
/// assert!(estimate.field_fresh && estimate.audit.heat >= 0.0);
/// assert!((estimate.surface_m[10] - model.header.fill_m as f32).abs() < 1e-3);
/// # Ok::<(), meniscus::blob::LoadError>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Estimator<'m> {
    pub(super) model: &'m Model<'m>,
    pub(super) groups: Selection,
    pub(super) precision: Precision,
    pub(super) deadline_us: u64,
}

impl<'m> Estimator<'m> {
    /// Returns an estimator on a checked model, of the variant that its header names.
    #[must_use]
    pub fn new(model: &'m Model<'m>) -> Self {
        let variant = model.header.variant;
        let groups = variant.groups().selection();
        Self { model, groups, precision: variant.precision(), deadline_us: DEADLINE_US }
    }

    /// Limits the field to `groups`: what a board has time for, or nothing but the surface.
    #[must_use]
    pub fn only(self, groups: Selection) -> Self {
        Self { groups: self.groups.both(groups), ..self }
    }

    /// Sets another time that a turn may take than [`DEADLINE_US`], microseconds: for frames that come faster than 60
    /// times a second. The model's step stays 1/60 s.
    #[must_use]
    pub fn within(self, deadline_us: u64) -> Self {
        Self { deadline_us, ..self }
    }

    /// Numbers of the field that a turn writes.
    #[must_use]
    pub fn field_len(&self) -> usize {
        self.model.decoder.part_len(self.groups)
    }

    /// Model of the estimator.
    #[must_use]
    pub fn model(&self) -> &'m Model<'m> {
        self.model
    }

    /// Takes one turn. Call it once a frame interval, without a profile where no frame came or no liquid was seen.
    ///
    /// The field goes into `field` ([`Self::field_len`] numbers, SI units; with any other length it is left out) unless the
    /// turn is late ([`field_shed`](crate::runtime::health::Health::field_shed)) or halted ([`super::Mode::Halted`]).
    pub fn turn<C: Clock>(
        &self,
        memory: &mut Memory,
        input: TurnInput<'_>,
        clock: &mut C,
        field: &mut [f32],
    ) -> Estimate {
        match self.precision {
            Precision::Double => self.turn_in::<f64, C>(memory, input, clock, field),
            Precision::Single => self.turn_in::<f32, C>(memory, input, clock, field),
        }
    }

    /// [`Self::turn`] in the precision `R`.
    fn turn_in<R: Real, C: Clock>(
        &self,
        memory: &mut Memory,
        input: TurnInput<'_>,
        clock: &mut C,
        field: &mut [f32],
    ) -> Estimate {
        let mut lap = Lap::start(clock);
        let mut stages = Stages { surface_us: input.surface_us, ..Stages::default() };
        count(&mut memory.health.turns);
        memory.filter.prime(&self.model.header.filter);

        let observation = self.resolve_input(memory, &input);
        let prior = self.step::<R>(memory, &observation);
        stages.predict_us = lap.lap_us();

        let linearisation = observation.measurement().map(|_| self.linearise(memory));
        let measured = self.update::<R>(memory, &observation, linearisation.as_ref(), &prior);
        stages.correct_us = lap.lap_us();
        let tracked = self.read_window::<R>(memory, &observation, measured, &prior);
        stages.encode_us = lap.lap_us();

        memory.update_blind_turns(observation.source, measured.is_some());
        memory.update_mode(&self.model.header.filter, tracked);
        let posterior = self.decode::<R>(memory, measured);
        let seen = input.profile.filter(|_| measured.is_some());
        let interval = self.interval::<R>(memory, &posterior, seen);
        stages.correct_us = stages.correct_us.saturating_add(lap.lap_us());

        let field_fresh = self.write_field(memory, &posterior, &lap, &stages, field);
        stages.field_us = lap.lap_us();
        if stages.total_us() > self.deadline_us {
            count(&mut memory.health.deadline_missed);
        }
        Estimate { interval, field_fresh, stages, ..self.audit(memory, &prior, &posterior) }
    }
}
