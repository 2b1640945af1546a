//! `/liquid/plan`: the predicted surface under a planned motion, from the newest turn on.

use crate::counters::{Counters, count};
use crate::message::{PlanRequest, PlanResponse, Stamp, SurfaceForecast};
use futures::channel::oneshot::Receiver;
use futures::future::{Either, select};
use futures::{StreamExt, pin_mut};
use meniscus::blob::Model;
use meniscus::runtime::Mode;
use meniscus::units::FRAME_INTERVAL_S;
use meniscus_service::controller::{Course, Plan, PlanFault, SharedPlan};
use meniscus_service::snapshot::{ImageSchedule, SnapshotOutlet};
use ros2_client::Server;
use std::time::{SystemTime, UNIX_EPOCH};

/// The service.
pub(crate) struct PlanService<'p> {
    pub(crate) server: &'p Server<PlanRequest, PlanResponse>,
    pub(crate) snapshots: &'p SnapshotOutlet,
    pub(crate) plan: &'p SharedPlan,
    /// Direction of the line of the model in the axes of the plans, of length one.
    pub(crate) line: [f64; 3],
    pub(crate) counters: &'p Counters,
}

/// Reason for which there is no forecast.
#[derive(Debug)]
enum Refusal {
    /// The plan.
    Plan(PlanFault),
    /// A stamp before 1970, or with too many nanoseconds, at the sample.
    Stamp(usize),
    /// No turn came within a tenth of a second.
    NoTurn,
    /// The camera has given no usable frame for a second.
    Halted,
    /// The instant of the turn on the host's clock is not known.
    NoClock,
}

impl Refusal {
    fn answer(&self) -> PlanResponse {
        let (fault, reason) = match self {
            Self::Plan(fault) => (fault.code(), fault.to_string()),
            Self::Stamp(index) => (0, format!("the stamp of sample {index} is none")),
            Self::NoTurn => (0, "no turn came: the camera sends nothing, or the run has ended".into()),
            Self::Halted => (0, "no usable frame for a second: there is no estimate to begin at".into()),
            Self::NoClock => (0, "the camera's clock is not mapped yet: ask again".into()),
        };
        PlanResponse { fault, reason, ..PlanResponse::default() }
    }
}

impl PlanService<'_> {
    /// Answers requests until `stop` comes, or its sender has gone.
    pub(crate) async fn attend(&self, model: &Model<'_>, mut stop: Receiver<()>) {
        let requests = self.server.receive_request_stream();
        pin_mut!(requests);
        loop {
            let (request, stopped) = match select(requests.next(), stop).await {
                Either::Left((Some(request), stopped)) => (request, stopped),
                Either::Left((None, _)) | Either::Right(_) => break,
            };
            stop = stopped;
            // A request that cannot be read has nobody to answer to; the middleware has counted it.
            let Ok((id, request)) = request else { continue };
            let answer = self.answer(model, &request).unwrap_or_else(|refusal| refusal.answer());
            match self.server.async_send_response(id, answer).await {
                Ok(()) => count(&self.counters.plans),
                Err(_) => count(&self.counters.refused),
            }
        }
    }

    /// Returns the answer to a request.
    fn answer(&self, model: &Model<'_>, request: &PlanRequest) -> Result<PlanResponse, Refusal> {
        let plan = self.read(request);
        if request.follow {
            match &plan {
                Ok(plan) => self.plan.take(Ok(plan.clone())),
                Err(Refusal::Plan(fault)) => self.plan.take(Err(*fault)),
                Err(_) => {}
            }
        }
        let plan = plan?;
        let (snapshot, logged) = self.snapshots.take(&mut ImageSchedule::default()).ok_or(Refusal::NoTurn)?;
        if logged.turn.estimate.mode == Mode::Halted {
            return Err(Refusal::Halted);
        }
        let host = logged.host.ok_or(Refusal::NoClock)?;
        // A plan that ended between its check and this turn lies in the past.
        let course = Course::of(&plan, Some(host)).ok_or(Refusal::Plan(PlanFault::Past(plan.length_s())))?;
        let (spill, points) = course.forecast(model, &snapshot.memory);
        let seconds = |turns: u32| f64::from(turns) * FRAME_INTERVAL_S;
        let profiles = points.iter().map(|point| SurfaceForecast {
            after: seconds(point.ahead),
            heights: point.surface_m,
            half_widths: point.half_width_m,
        });
        Ok(PlanResponse {
            accepted: true,
            fault: 0,
            reason: String::new(),
            stamp: Stamp::of_unix_ns(host.unix_ns),
            camera_time: logged.turn.time.0,
            across: plan.across_m,
            profiles: profiles.collect(),
            crest: f64::from(spill.crest_m),
            crest_half_width: f64::from(spill.crest_half_m),
            crest_after: seconds(spill.crest_turn),
            spill_probability: f64::from(spill.probability),
            horizon: seconds(spill.horizon),
            planned: seconds(spill.planned),
        })
    }

    /// Returns the plan of a request.
    fn read(&self, request: &PlanRequest) -> Result<Plan, Refusal> {
        let mut samples = Vec::with_capacity(request.samples.len());
        for (index, sample) in request.samples.iter().enumerate() {
            let stamp_ns = sample.stamp.unix_ns().ok_or(Refusal::Stamp(index))?;
            let position = sample.position;
            samples.push((stamp_ns, [position.x, position.y, position.z]));
        }
        let now_ns = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |now| now.as_nanos() as u64);
        Plan::of(request.sequence, &samples, &self.line, now_ns).map_err(Refusal::Plan)
    }
}
