//! The estimator: one turn from a profile (or none) to an estimate of the whole liquid.
//!
//! [`Estimator`] is configuration and weights (`&self`), [`Memory`] what changes (`&mut`).

use super::budget::{Clock, DEADLINE_US, Lap, Stages, field_start_us};
use super::memory::Memory;
use super::mode::Mode;
use crate::blob::Model;
use crate::filter::PORT_LIMIT;
use crate::latent::decoder::Selection;
use crate::latent::generic::{Audit, LATENTS, Outcome};
use crate::runtime::health::count;
use crate::surface::{POINTS, SurfaceProfile};
use crate::uncertainty::discrepancy::Discrepancy;
use crate::uncertainty::error_model::Interval;
use serde::{Deserialize, Serialize};

/// Points of a profile that must be seen for it to be a measurement: two thirds of 21.
pub const POINTS_NEEDED: usize = 14;

/// Frames of a full window that must have been seen for the encoder to be trusted: half of 16.
const ROWS_NEEDED: usize = 8;

/// Where the motion of the glass is known from.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Drive {
    /// From the edges of the glass in the profile; while these are not seen, as [`Self::Unknown`].
    #[default]
    Seen,
    /// From an IMU or the robot's command: acceleration along x in m/s2.
    Known {
        /// Of one frame interval before the frame, as the places of the glass in the last three frames would tell
        /// it: it enters the port.
        before: f64,
        /// Of the instant of the frame: the inertial pressure follows it at once.
        now: f64,
    },
    /// From nowhere: it is found with the latents, from the heights alone.
    Unknown,
}

impl Drive {
    /// A motion that is said to be this, and is `gain` times as much; one that is seen is what it is.
    fn times(self, gain: f64) -> Self {
        match self {
            Self::Known { before, now } => Self::Known { before: gain * before, now: gain * now },
            other => other,
        }
    }
}

/// The model at work.
#[derive(Clone, Copy, Debug)]
pub struct Estimator<'m> {
    model: &'m Model<'m>,
    groups: Selection,
    deadline_us: u64,
}

/// What a turn knows, beside the full field in the caller's buffer.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Estimate {
    /// What the estimate is worth.
    pub mode: Mode,
    /// x after the correction.
    pub latent: [f64; LATENTS],
    /// The 21 heights of the surface, metres above the inner bottom.
    pub surface_m: [f32; POINTS],
    /// How far heights and field may be off, nine times out of ten.
    pub interval: Interval,
    /// Acceleration of the glass that entered the port, m/s2.
    pub acceleration_m_s2: f32,
    /// Port value of this instant that the decoder used: read off the window, or the one above.
    pub port: f32,
    /// H(x): slosh energy, joules.
    pub slosh_j: f64,
    /// s: heat since the start, joules.
    pub heat_j: f64,
    /// What the correction by the measurement did to H, joules; not part of the laws' books.
    pub corrected_j: f64,
    /// Books of the predicting step, in units of H.
    pub audit: Audit,
    /// Whether the full field was written this turn.
    pub field_fresh: bool,
    /// Where the time went.
    pub stages: Stages,
}

impl<'m> Estimator<'m> {
    /// An estimator on a checked model.
    #[must_use]
    pub fn new(model: &'m Model<'m>) -> Self {
        Self { model, groups: Selection::ALL, deadline_us: DEADLINE_US }
    }

    /// The same with no more of the field than `groups`: what a small board has time for, or nothing but the
    /// surface.
    #[must_use]
    pub fn only(self, groups: Selection) -> Self {
        Self { groups, ..self }
    }

    /// The same with another time that a turn may take than [`DEADLINE_US`], microseconds: where frames come faster
    /// than 60 times a second. The model's step stays 1/60 s.
    #[must_use]
    pub fn within(self, deadline_us: u64) -> Self {
        Self { deadline_us, ..self }
    }

    /// Numbers of the field that a turn writes.
    #[must_use]
    pub fn field_len(&self) -> usize {
        self.model.decoder.part_len(self.groups)
    }

    /// The model.
    #[must_use]
    pub fn model(&self) -> &'m Model<'m> {
        self.model
    }

    /// One turn. Call it once a frame interval, with `None` where no frame came or no liquid was
    /// seen. `surface_us` is what the way from the image to the profile has taken of this turn.
    ///
    /// The field goes into `field` ([`Self::field_len`] numbers, SI units; with any other length
    /// it is left out) unless the turn is late ([`field_shed`](crate::runtime::health::Health::field_shed)) or halted ([`Mode::Halted`]).
    pub fn turn<C: Clock>(
        &self,
        memory: &mut Memory,
        profile: Option<&SurfaceProfile>,
        surface_us: u64,
        clock: &mut C,
        field: &mut [f32],
    ) -> Estimate {
        self.driven(memory, profile, Drive::Seen, surface_us, clock, field)
    }

    /// [`Self::turn`] with the motion of the glass from `drive`.
    pub fn driven<C: Clock>(
        &self,
        memory: &mut Memory,
        profile: Option<&SurfaceProfile>,
        drive: Drive,
        surface_us: u64,
        clock: &mut C,
        field: &mut [f32],
    ) -> Estimate {
        let mut lap = Lap::start(clock);
        let mut stages = Stages { surface_us, ..Stages::default() };
        count(&mut memory.health.turns);
        memory.filter.prime(&self.model.header.filter);
        let lens = self.model.lens.as_ref();
        let straight = lens.zip(profile).map(|(lens, profile)| lens.straighten(profile));
        let profile = straight.as_ref().or(profile);
        let drive = lens.map_or(drive, |lens| drive.times(lens.gain));
        let drive = memory.known(drive, profile);

        let scale = f64::from(self.model.header.acceleration_scale);
        let slosh_before = self.slosh(memory);
        let motion = self.drive(memory, drive, profile);
        let (placed, entered) = (self.slosh(memory), memory.filter.push());
        let audit = self.predict(memory, entered, placed);
        let predicted = self.slosh(memory);
        if let Drive::Known { now, .. } = drive {
            let now = self.clip(memory, now) / scale;
            memory.filter.told(&self.model.header.filter, now);
        }
        stages.predict_us = lap.lap_us();

        let mut usable = profile.filter(|profile| profile.seen() >= POINTS_NEEDED);
        let settled = memory.mode == Mode::Tracking;
        if let Some(profile) = usable {
            let Memory { filter, state, .. } = memory;
            if !filter.heights(self.model, &mut state.latent, profile, (predicted, settled)) {
                count(&mut memory.health.measurement_refused);
                usable = None;
            }
        }
        stages.correct_us = lap.lap_us();
        // The encoder has learnt what a glass on its line shows.
        let in_line = usable.map(|profile| self.model.transverse.in_line(profile, memory.filter.aside_m()));
        memory.window.push(self.model.scale().row(in_line.as_ref(), motion as f32));
        let tracked = usable.is_some() && memory.window.is_full() && memory.window.seen() >= ROWS_NEEDED;
        if tracked && drive != Drive::Unknown {
            self.read(memory, (predicted, settled));
        }
        let port = memory.filter.push();
        stages.encode_us = lap.lap_us();
        memory.settle(&self.model.header.filter, tracked);
        let slosh = self.slosh(memory);
        let joules = self.model.header.energy_scale_j;
        let latent: [f64; LATENTS] = memory.state.latent.into();
        let coefficients = self.model.decoder.coefficients(&latent.map(|x| x as f32), port as f32);
        let mut surface_m = self.model.decoder.surface(&coefficients);
        self.model.transverse.raise(&mut surface_m, memory.filter.aside_m());
        let mut taken = Discrepancy::NONE;
        if let Some(profile) = usable {
            taken = Discrepancy::of(&self.model.spread, profile, slosh);
            taken.put_back(&mut surface_m, profile);
        }
        if let Some(lens) = lens {
            lens.raise(&mut surface_m);
        }
        let raised =
            self.model.transverse.variance(&memory.filter.aside(self.model), &self.model.spread.surface);
        let interval = self.model.spread.interval(
            &memory.filter.covariance(),
            (&raised, &taken),
            slosh,
            memory.state.heat,
            joules,
        );
        stages.correct_us = stages.correct_us.saturating_add(lap.lap_us());

        let heat_j = joules * memory.state.heat;
        let field_fresh = memory.mode != Mode::Halted
            && self.groups != Selection::NONE
            && field.len() == self.field_len()
            && self.in_time(memory, &lap, surface_us);
        if field_fresh {
            self.model.decoder.part(self.groups, &coefficients, heat_j as f32, field);
        }
        stages.field_us = lap.lap_us();
        if stages.total_us() > self.deadline_us {
            count(&mut memory.health.deadline_missed);
        }
        Estimate {
            mode: memory.mode,
            latent,
            surface_m,
            interval,
            acceleration_m_s2: (scale * entered) as f32,
            port: port as f32,
            slosh_j: joules * slosh,
            heat_j,
            corrected_j: joules * (slosh - predicted + placed - slosh_before),
            audit,
            field_fresh,
            stages,
        }
    }

    /// H(x), in units of the model's energy.
    fn slosh(&self, memory: &Memory) -> f64 {
        self.model.generic.potential.value(&memory.state.latent)
    }

    /// Tells the filter how the glass has moved, and gives its acceleration as the encoder reads it, m/s2, clipped to what
    /// the model can have seen: off the last three places, as it was told, or as the filter takes it to be.
    fn drive(&self, memory: &mut Memory, drive: Drive, profile: Option<&SurfaceProfile>) -> f64 {
        let scale = f64::from(self.model.header.acceleration_scale);
        let place = profile.and_then(|profile| profile.glass_x_m).map(f64::from).filter(|x| x.is_finite());
        if place.is_none() {
            count(&mut memory.health.glass_not_seen);
        }
        let seen = memory.motion.update(place);
        let Memory { filter, state, .. } = memory;
        let acceleration = match (drive, place) {
            (Drive::Seen, place) => {
                if let Some(x_m) = place {
                    filter.place(self.model, &mut state.latent, x_m);
                }
                seen
            }
            (Drive::Known { before, .. }, _) => before,
            (Drive::Unknown, _) => {
                filter.misplace(&self.model.header.filter);
                scale * filter.push()
            }
        };
        let clipped = self.clip(memory, acceleration);
        if let Drive::Known { .. } = drive {
            memory.filter.told(&self.model.header.filter, clipped / scale);
        }
        clipped
    }

    /// `acceleration` within what the model can have seen; zero for what is no number.
    fn clip(&self, memory: &mut Memory, acceleration: f64) -> f64 {
        let limit = PORT_LIMIT * f64::from(self.model.header.acceleration_scale);
        let clipped = if acceleration.is_finite() { acceleration.max(-limit).min(limit) } else { 0.0 };
        if clipped != acceleration {
            count(&mut memory.health.acceleration_clipped);
        }
        clipped
    }

    /// The GENERIC step of this turn under the port value `u`, from a slosh of energy `slosh`.
    fn predict(&self, memory: &mut Memory, u: f64, slosh: f64) -> Audit {
        memory.filter.predict(self.model, slosh);
        let audit = self.model.generic.step(&mut memory.state, u);
        match audit.outcome {
            Outcome::Solved => {}
            Outcome::Unconverged => count(&mut memory.health.step_unconverged),
            Outcome::Backtracked => count(&mut memory.health.step_backtracked),
            Outcome::Held => count(&mut memory.health.step_held),
        }
        audit
    }

    /// What the encoder reads off the window goes to the filter, unless it is no number.
    fn read(&self, memory: &mut Memory, slosh: (f64, bool)) {
        let readings = self.model.encoder.encode(memory.window.rows());
        let [latent @ .., port] = readings.map(f64::from);
        let finite = readings.iter().all(|x| x.is_finite());
        let Memory { filter, state, .. } = memory;
        if !finite || !filter.reading(self.model, &mut state.latent, (&latent.into(), port), slosh) {
            count(&mut memory.health.measurement_refused);
        }
    }

    /// Whether the full field can still be written this turn; counts it when not.
    fn in_time<C: Clock>(&self, memory: &mut Memory, lap: &Lap<'_, C>, surface_us: u64) -> bool {
        let in_time = lap.elapsed_us().saturating_add(surface_us) <= field_start_us(self.deadline_us);
        if !in_time {
            count(&mut memory.health.field_shed);
        }
        in_time
    }
}
