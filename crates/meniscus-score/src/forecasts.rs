//! Errors of the forecasts of a run against the truth of its recording.
//!
//! ```text
//! error = |z(t + lead) - forecast at t| / |z(t + lead) - z_rest|     norms over points and frames; a flat surface scores 1
//! ```
//! The memories of the estimator are kept during the run. The forecasts are made from them afterwards, so that no turn waits.

use crate::score::{Held, SurfaceError};
use meniscus::blob::Model;
use meniscus::runtime::{Forecast, Memory, Mode};
use meniscus::units::Micros;
use meniscus_data::recording::{Recording, frame_of};
use meniscus_service::sink::{TurnRecord, TurnSink};

/// Lead of the forecasts of a run: 250 ms, frames.
pub const LEAD: usize = 15;

/// Sums behind the error of the forecasts of one lead.
#[derive(Clone, Copy, Debug)]
pub struct ForecastError {
    lead: usize,
    /// Of the forecast.
    pub forecast: SurfaceError,
    /// Of the true surface at the time of the forecast, in its place.
    pub persistence: SurfaceError,
    /// Heights that lay within their interval.
    pub covered: Held,
}

impl ForecastError {
    /// Returns sums of nothing for forecasts `lead` frames ahead.
    #[must_use]
    pub fn new(lead: usize) -> Self {
        let (forecast, persistence) = (SurfaceError::default(), SurfaceError::default());
        Self { lead, forecast, persistence, covered: Held::default() }
    }

    /// Adds the forecast from `memory`, which is that after `frame`, under `plan` (see [`Forecast::new`]). A forecast beyond the
    /// end of the recording is left out.
    pub fn add(
        &mut self,
        model: &Model<'_>,
        memory: &Memory,
        recording: &Recording,
        frame: usize,
        plan: &[f64],
    ) {
        if frame + self.lead >= recording.frames() {
            return;
        }
        let (truth, rest_m) = (recording.profile(frame + self.lead), recording.glass.fill_m);
        let forecast = Forecast::new(model, memory, self.lead, plan);
        self.forecast.add(truth, &forecast.surface_m, rest_m);
        self.persistence.add(truth, recording.profile(frame), rest_m);
        self.covered.add(truth, &forecast.surface_m, &forecast.half_width_m);
    }
}

/// Memories of the estimator after the turns that tracked, as a sink of a run.
#[derive(Debug)]
pub struct KeptMemories(Vec<(Micros, Memory)>);

impl KeptMemories {
    /// Returns a sink with room for `turns` of them; later ones are left out.
    #[must_use]
    pub fn with_room(turns: usize) -> Self {
        Self(Vec::with_capacity(turns))
    }

    /// Returns the errors of the forecasts of [`LEAD`] on `recording`, whose first frame has the time `start`: with the motion to
    /// come as a plan, and without.
    #[must_use]
    pub fn forecasts(&self, model: &Model<'_>, recording: &Recording, start: Micros) -> RunForecasts {
        let motion = recording.delayed_acceleration_m_s2();
        let [mut planned, mut unplanned] = [ForecastError::new(LEAD); 2];
        for (time, memory) in &self.0 {
            let frame = frame_of(*time, start);
            planned.add(model, memory, recording, frame, motion.get(frame + 1..).unwrap_or_default());
            unplanned.add(model, memory, recording, frame, &[]);
        }
        RunForecasts { planned, unplanned }
    }
}

impl TurnSink for KeptMemories {
    fn accept(&mut self, record: &TurnRecord<'_>) {
        let turn = &record.logged.turn;
        if let Some(after) = record.after
            && turn.estimate.mode == Mode::Tracking
            && self.0.len() < self.0.capacity()
        {
            self.0.push((turn.time, after.memory.clone()));
        }
    }
}

/// Forecasts of a run.
#[derive(Clone, Copy, Debug)]
pub struct RunForecasts {
    /// With the true motion of the glass as a plan.
    pub planned: ForecastError,
    /// Without a plan.
    pub unplanned: ForecastError,
}
