//! The session: streams, watches the pulse, and climbs the ladder when a stream has none.
//!
//! In the completion path the spare buffer is queued before the filled one is handed on, so that the
//! number of transfers in flight never falls. Where there is no spare, the filled one goes back to the
//! queue and its payload is counted as dropped.

use super::climb_report::ClimbReport;
use super::connect::{Connected, connect};
use super::error::CameraError;
use super::health::CameraHealth;
use super::partners::Partners;
use super::plan::Plan;
use super::pulse::{Pulse, Verdict};
use super::recovery::{Ladder, Step, Trouble};
use super::settings::Settings;
use super::sink::{Note, Sink};
use crate::buffer::Buffer;
use crate::transport::{Completion, Pipe, Status, Transport, UsbError};
use meniscus::usb::d4xx::{DeviceError, ERROR};
use meniscus::usb::uvc::ControlChange;
use std::time::Duration;

/// Transfers in flight, a stream.
const IN_FLIGHT: usize = 4;
/// Longest sleep in the loop: how soon a stop is seen.
pub(super) const TICK: Duration = Duration::from_millis(20);
/// A stream without a new frame for this long is in trouble: ten intervals.
const SILENCE: Duration = Duration::from_millis(167);
/// Time for the first frames after the start.
const FIRST: Duration = Duration::from_secs(2);
/// Streams that beat without two frames of one instant for this long are in trouble.
const APART: Duration = Duration::from_secs(2);
/// Damaged transfers in a row that are trouble.
const DAMAGED: u32 = 3;
/// Failures of the interrupt endpoint after which it is left alone.
const INTERRUPT_FAILURES: u32 = 8;
/// Bytes of a status packet's buffer.
const STATUS_BYTES: usize = 64;

/// A camera at work.
#[derive(Debug)]
pub struct Session<T> {
    pub(super) transport: T,
    pub(super) settings: Settings,
    pub(super) connected: Connected,
    pub(super) plan: Plan,
    pulses: [Option<Pulse>; 2],
    partners: Partners,
    /// Longest time from the start of a stream to its first frame.
    pub(super) patience: Duration,
    pub(super) idle: Vec<Buffer>,
    interrupt_failures: u32,
    /// Last error that the camera reported.
    last_error: Option<DeviceError>,
    pub(super) health: CameraHealth,
}

impl<T: Transport> Session<T> {
    /// Finds, opens and sets a camera, and agrees with it on both streams.
    ///
    /// # Errors
    /// [`CameraError`], which says what to do.
    pub fn connect(mut transport: T, settings: Settings) -> Result<Self, CameraError> {
        let (connected, plan) = connect(&mut transport, &settings)?;
        log::info!("connected: {:?}", connected.device);
        log::debug!("streams: {plan:?}");
        // From now on it is this camera and no other.
        let serial = settings.serial.clone().or_else(|| connected.device.serial.clone());
        Ok(Self {
            transport,
            settings: Settings { serial, ..settings },
            connected,
            plan,
            pulses: [None; 2],
            partners: Partners::started(Duration::ZERO),
            patience: FIRST,
            idle: Vec::new(),
            interrupt_failures: 0,
            last_error: None,
            health: CameraHealth::default(),
        })
    }

    /// The camera.
    #[must_use]
    pub fn connected(&self) -> &Connected {
        &self.connected
    }

    /// Returns the plan of the streams.
    #[must_use]
    pub fn plan(&self) -> &Plan {
        &self.plan
    }

    /// Counters so far.
    #[must_use]
    pub fn health(&self) -> CameraHealth {
        self.health
    }

    /// Bytes of the largest transfer: the size of the buffers that a [`Sink`] gives.
    #[must_use]
    pub fn buffer_bytes(&self) -> usize {
        self.plan.streams.iter().map(super::StreamPlan::transfer_bytes).max().unwrap_or(0)
    }

    /// The transport, for a look after the end.
    pub fn transport(&mut self) -> &mut T {
        &mut self.transport
    }

    /// Streams until the sink wants no more.
    ///
    /// # Errors
    /// [`CameraError::GaveUp`] when frames did not come back in time.
    pub fn stream(&mut self, sink: &mut impl Sink) -> Result<(), CameraError> {
        let mut ladder = Ladder::new(self.settings.patience);
        let mut report = ClimbReport::default();
        self.patience = FIRST;
        let mut trouble = self.start().err();
        while sink.wanted() {
            if let Some(met) = trouble.take() {
                if let Trouble::Submit(error @ UsbError::NoMemory) = met {
                    self.stop();
                    return Err(CameraError::Usb { doing: "queue the camera's transfers", error });
                }
                report.meet(met);
                let Step::Do(rung, pause) = ladder.climb(met, self.transport.now()) else {
                    self.stop();
                    return Err(CameraError::GaveUp {
                        seconds: self.settings.patience.as_secs(),
                        last: report.last(),
                    });
                };
                report.take(met, rung, sink);
                self.wait_before(rung, pause, sink);
                if let Err(reason) = self.climb(rung, sink) {
                    trouble = Some(report.fail(met, rung, reason.to_string(), sink));
                }
                continue;
            }
            let ended = self.transport.reap(TICK);
            trouble = match ended {
                Some(completion) => match self.complete(completion, sink) {
                    Ok(()) => self.look(),
                    Err(Some(trouble)) => Some(trouble),
                    Err(None) => break,
                },
                None => self.look(),
            };
            let beating = self.pulses.iter().flatten().all(|pulse| pulse.beats);
            if trouble.is_none() && beating && self.partners.met {
                self.patience = SILENCE;
                if ladder.good(self.transport.now()) {
                    sink.note(Note::Recovered);
                }
            }
        }
        self.stop();
        Ok(())
    }

    /// Clears the halts and queues every transfer.
    pub(super) fn start(&mut self) -> Result<(), Trouble> {
        let now = self.transport.now();
        for place in 0..self.plan.streams.len() {
            let stream = self.plan.streams[place];
            self.transport.clear_halt(stream.endpoint).map_err(|error| match error {
                UsbError::NoDevice => Trouble::Gone,
                _ => Trouble::Halted(stream.name()),
            })?;
            self.pulses[place] = Some(Pulse::started(self.pulses[place], now));
        }
        self.partners = Partners::started(now);
        let bytes = self.buffer_bytes();
        self.idle.retain(|buffer| buffer.size() == bytes);
        for place in 0..self.plan.streams.len() {
            for _ in 0..IN_FLIGHT {
                let buffer = self.idle.pop().unwrap_or_else(|| Buffer::new(bytes));
                self.submit(Pipe::Bulk, self.plan.streams[place].endpoint, buffer)?;
            }
        }
        self.interrupt_failures = 0;
        match self.plan.interrupt {
            Some(endpoint) => self.submit(Pipe::Interrupt, endpoint, Buffer::new(STATUS_BYTES)),
            None => Ok(()),
        }
    }

    fn submit(&mut self, pipe: Pipe, endpoint: u8, buffer: Buffer) -> Result<(), Trouble> {
        self.transport.submit(pipe, endpoint, buffer).map_err(|refused| {
            self.idle.push(refused.buffer);
            match refused.error {
                UsbError::NoDevice => Trouble::Gone,
                error => Trouble::Submit(error),
            }
        })
    }

    /// Takes the end of a transfer. `Err(None)` when the sink has gone.
    fn complete(&mut self, ended: Completion, sink: &mut impl Sink) -> Result<(), Option<Trouble>> {
        let Completion { endpoint, status, buffer } = ended;
        let Some(place) = self.plan.stream_of(endpoint) else {
            return self.interrupt(endpoint, status, buffer, sink).map_err(Some);
        };
        let (stream, now) = (self.plan.streams[place], self.transport.now());
        let counter = match status {
            Status::Completed => &mut self.health.completed,
            Status::Error => &mut self.health.errors,
            Status::TimedOut => &mut self.health.timed_out,
            Status::Cancelled => &mut self.health.cancelled,
            Status::Stall => &mut self.health.stalls,
            Status::NoDevice => &mut self.health.no_device,
            Status::Overflow => &mut self.health.overflows,
        };
        *counter += 1;
        match status {
            Status::Completed => {}
            Status::NoDevice => {
                self.idle.push(buffer);
                return Err(Some(Trouble::Gone));
            }
            Status::Stall => {
                self.idle.push(buffer);
                return Err(Some(Trouble::Halted(stream.name())));
            }
            Status::Error | Status::Overflow | Status::TimedOut | Status::Cancelled => {
                let pulse = self.pulses[place].get_or_insert_with(|| Pulse::started(None, now));
                pulse.damaged_transfers += 1;
                if pulse.damaged_transfers >= DAMAGED {
                    self.idle.push(buffer);
                    return Err(Some(Trouble::Damaged(stream.name())));
                }
                return self.submit(Pipe::Bulk, endpoint, buffer).map_err(Some);
            }
        }
        let spare = sink.spare().or_else(|| self.idle.pop());
        let queued = match spare {
            Some(spare) => self.submit(Pipe::Bulk, endpoint, spare),
            None => {
                self.health.starved += 1;
                sink.dropped();
                self.judge(place, &buffer, now);
                return self.submit(Pipe::Bulk, endpoint, buffer).map_err(Some);
            }
        };
        self.judge(place, &buffer, now);
        if !sink.deliver(stream.stream, buffer) {
            return Err(None);
        }
        queued.map_err(Some)
    }

    fn judge(&mut self, place: usize, payload: &[u8], now: Duration) {
        let pulse = self.pulses[place].get_or_insert_with(|| Pulse::started(None, now));
        pulse.damaged_transfers = 0;
        match pulse.judge(payload, self.plan.streams[place].frame_bytes as usize, now) {
            Verdict::Whole(pts) => {
                self.health.frames += 1;
                self.partners.saw(place, pts, now);
            }
            Verdict::Part => {}
            Verdict::Repeated => self.health.repeated += 1,
            Verdict::Damaged => self.health.damaged += 1,
        }
    }

    /// A status packet, or the end of its endpoint; the images do not need it.
    fn interrupt(
        &mut self,
        endpoint: u8,
        status: Status,
        buffer: Buffer,
        sink: &mut impl Sink,
    ) -> Result<(), Trouble> {
        if status == Status::NoDevice {
            self.health.no_device += 1;
            return Err(Trouble::Gone);
        }
        let change = ControlChange::read(&buffer).filter(|_| status == Status::Completed);
        let error = change.filter(|c| (c.originator, c.selector) == (self.plan.unit, ERROR));
        match (change, error) {
            (None, _) => {
                self.health.interrupt_errors += 1;
                self.interrupt_failures += 1;
            }
            (_, Some(error)) if error.value != 0 => {
                self.health.pushed_errors += 1;
                // One that repeats itself is noted once.
                let error = DeviceError(error.value);
                if !error.start_failed() && self.last_error.replace(error) != Some(error) {
                    sink.note(Note::Reported(error));
                }
            }
            _ => {}
        }
        // An endpoint that only fails is left alone: it would keep this thread busy.
        let resubmitted = if self.interrupt_failures < INTERRUPT_FAILURES {
            self.submit(Pipe::Interrupt, endpoint, buffer)
        } else {
            Ok(())
        };
        let error = error.map(|error| DeviceError(error.value));
        match error.filter(|error| error.start_failed()) {
            Some(error) => Err(Trouble::Start(error)),
            None => resubmitted,
        }
    }

    /// The stream that has had no new frame for too long, or both when none of their frames are of one instant.
    fn look(&mut self) -> Option<Trouble> {
        let now = self.transport.now();
        let pulses = self.plan.streams.iter().zip(&self.pulses);
        let quiet = pulses.filter_map(|(stream, pulse)| pulse.map(|pulse| (stream, pulse))).find_map(
            |(stream, pulse)| {
                let limit = if pulse.beats { SILENCE } else { self.patience };
                (now.saturating_sub(pulse.last) > limit).then_some(Trouble::Silence(stream.name()))
            },
        );
        let limit = if self.partners.met { APART } else { APART + self.patience };
        quiet.or_else(|| (now.saturating_sub(self.partners.last) > limit).then_some(Trouble::Apart))
    }
}
