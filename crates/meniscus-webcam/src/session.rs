//! The session: opens the camera, streams, and brings it back when it fails.
//!
//! The rungs are those of the D435's ladder, as far as the kernel has them for a video device: requeue ends the stream and
//! starts it, renegotiate sets the mode anew between. Restart, reset and re-plug all close the device and open it again;
//! Video4Linux has no reset.

use crate::choice::choose;
use crate::error::WebcamError;
use crate::mode::Mode;
use crate::pack::Packer;
use crate::rate::Rate;
use crate::video::{Video, VideoError};
use crate::webcam::Webcam;
use meniscus::usb::uvc::Stream;
use meniscus_usb::camera::{CameraHealth, ClimbReport, Ladder, Note, Rung, Sink, Step, Trouble};
use std::time::Duration;

/// Longest sleep in the loop: how soon a stop is seen.
const TICK: Duration = Duration::from_millis(20);
/// Intervals without a frame that are trouble.
const SILENT_INTERVALS: f64 = 10.0;
/// Time for the first frame after a start: a webcam may adjust its exposure first.
const FIRST: Duration = Duration::from_secs(3);
/// Time that the session tries to get frames back before it gives up.
const PATIENCE: Duration = Duration::from_secs(60);
/// Name of the stream in notes.
const STREAM: &str = "colour";

/// A webcam at work.
#[derive(Debug)]
pub struct Session<V> {
    video: V,
    webcam: Webcam,
    packer: Packer,
    rate: Rate,
    patience: Duration,
    health: CameraHealth,
    /// When the last frame came, or the stream was started; whether a frame has come since.
    last: Duration,
    beats: bool,
}

impl<V: Video> Session<V> {
    /// Opens the camera at `path`, which `video` stands for, and agrees with it on a mode.
    ///
    /// # Errors
    /// [`WebcamError`], which says what to do.
    pub fn connect(mut video: V, path: &str) -> Result<Self, WebcamError> {
        let webcam = establish(&mut video, path, None)?;
        log::info!("connected: {}", webcam.line());
        Ok(Self {
            packer: Packer::new(webcam.mode),
            video,
            webcam,
            rate: Rate::default(),
            patience: PATIENCE,
            health: CameraHealth::default(),
            last: Duration::ZERO,
            beats: false,
        })
    }

    /// The camera.
    #[must_use]
    pub fn webcam(&self) -> &Webcam {
        &self.webcam
    }

    /// Counters so far.
    #[must_use]
    pub fn health(&self) -> CameraHealth {
        self.health
    }

    /// Bytes of a payload: the size of the buffers that a [`Sink`] gives.
    #[must_use]
    pub fn buffer_bytes(&self) -> usize {
        Packer::payload_bytes(self.webcam.mode)
    }

    /// The video device, for a look after the end.
    pub fn video(&mut self) -> &mut V {
        &mut self.video
    }

    /// Streams until the sink wants no more.
    ///
    /// # Errors
    /// [`WebcamError::GaveUp`] when frames did not come back in time.
    pub fn stream(&mut self, sink: &mut impl Sink) -> Result<(), WebcamError> {
        let mut ladder = Ladder::new(self.patience);
        let (mut trouble, mut report) = (self.start().err().map(trouble_of), ClimbReport::default());
        while sink.wanted() {
            if let Some(met) = trouble.take() {
                report.meet(met);
                let Step::Do(rung, pause) = ladder.climb(met, self.video.now()) else {
                    self.video.close();
                    return Err(WebcamError::GaveUp {
                        seconds: self.patience.as_secs(),
                        last: report.last(),
                    });
                };
                report.take(met, rung, sink);
                self.wait(pause, sink);
                if let Err(reason) = self.climb(rung) {
                    trouble = Some(report.fail(met, rung, reason.to_string(), sink));
                }
                continue;
            }
            match self.frame(sink) {
                Ok(Handed::Gone) | Err(VideoError::Ended) => break,
                Ok(Handed::Nothing) => trouble = self.silence(),
                Ok(Handed::Frame) => {
                    if ladder.good(self.video.now()) {
                        sink.note(Note::Recovered);
                    }
                }
                Err(error) => trouble = Some(trouble_of(error)),
            }
        }
        self.video.close();
        Ok(())
    }

    /// Hands the next frame on.
    fn frame(&mut self, sink: &mut impl Sink) -> Result<Handed, VideoError> {
        let Self { video, webcam, packer, rate, health, .. } = self;
        let Some(frame) = video.next(TICK)? else { return Ok(Handed::Nothing) };
        health.completed += 1;
        if frame.damaged {
            health.damaged += 1;
        } else {
            health.frames += 1;
        }
        let agreed_hz = webcam.mode.rate_hz();
        let fallen = rate.fallen(frame.captured_us, agreed_hz);
        let wanted = match sink.spare() {
            None => {
                health.starved += 1;
                sink.dropped();
                true
            }
            Some(mut payload) => {
                packer.pack(&frame, &mut payload);
                sink.deliver(Stream::Outline, payload)
            }
        };
        if let Some(hz) = fallen {
            sink.note(Note::Remark(format!(
                "the camera brings {hz:.0} of {agreed_hz:.0} images a second: {}",
                webcam.remedy_of_a_low_rate()
            )));
        }
        (self.last, self.beats) = (self.video.now(), true);
        Ok(if wanted { Handed::Frame } else { Handed::Gone })
    }

    fn silence(&self) -> Option<Trouble> {
        let limit = if self.beats {
            Duration::from_secs_f64(SILENT_INTERVALS / self.webcam.mode.rate_hz().max(1.0))
        } else {
            FIRST
        };
        (self.video.now().saturating_sub(self.last) > limit).then_some(Trouble::Silence(STREAM))
    }

    fn start(&mut self) -> Result<(), VideoError> {
        (self.last, self.beats, self.rate) = (self.video.now(), false, Rate::default());
        self.video.start()
    }

    /// Takes a rung.
    fn climb(&mut self, rung: Rung) -> Result<(), WebcamError> {
        self.health.rungs[rung as usize] += 1;
        let path = self.webcam.path.clone();
        let failed = |error| WebcamError::of(&path, error);
        match rung {
            Rung::Requeue => self.video.stop(),
            Rung::Renegotiate => {
                self.video.stop();
                agree(&mut self.video, &path, self.webcam.mode)?;
            }
            Rung::Restart | Rung::Reset | Rung::Replug => {
                self.video.close();
                self.webcam = establish(&mut self.video, &path, Some(&self.webcam))?;
            }
        }
        self.start().map_err(failed)
    }

    /// Waits, and sees a stop.
    fn wait(&mut self, time: Duration, sink: &mut impl Sink) {
        let until = self.video.now() + time;
        while sink.wanted() && self.video.now() < until {
            let left = until.saturating_sub(self.video.now());
            self.video.pause(left.min(TICK));
        }
    }
}

/// Result of a look for the next frame.
enum Handed {
    Frame,
    Nothing,
    /// The sink wants no more.
    Gone,
}

/// The trouble that an error of the device is for the ladder.
fn trouble_of(error: VideoError) -> Trouble {
    match error {
        VideoError::Ended
        | VideoError::Gone
        | VideoError::NotThere
        | VideoError::NotCapture
        | VideoError::NoAccess => Trouble::Gone,
        VideoError::Busy | VideoError::NoBandwidth | VideoError::System { .. } => Trouble::Damaged(STREAM),
    }
}

/// Opens the camera and agrees on a mode: the best one, or that of the camera `before`.
fn establish(video: &mut impl Video, path: &str, before: Option<&Webcam>) -> Result<Webcam, WebcamError> {
    let failed = |error| WebcamError::of(path, error);
    let name = video.open().map_err(failed)?;
    if let Some(before) = before.filter(|before| before.name != name) {
        video.close();
        return Err(WebcamError::OtherCamera { path: path.into(), was: before.name.clone(), is: name });
    }
    let mode = match before {
        Some(before) => before.mode,
        None => choose(&video.offers().map_err(failed)?, path)?,
    };
    agree(video, path, mode)?;
    let rate = video.hold_rate();
    Ok(Webcam { path: path.into(), name, mode, rate })
}

/// Sets the mode; another answer than that mode is an error.
fn agree(video: &mut impl Video, path: &str, wanted: Mode) -> Result<(), WebcamError> {
    let got = match video.set(wanted).map_err(|error| WebcamError::of(path, error))? {
        Ok(got) if got.size == wanted.size && got.format == wanted.format && near(got, wanted) => {
            return Ok(());
        }
        Ok(got) => got.to_string(),
        Err(code) => code.escape_ascii().to_string(),
    };
    Err(WebcamError::NoAgreement { path: path.into(), wanted, got })
}

fn near(got: Mode, wanted: Mode) -> bool {
    (got.rate_hz() / wanted.rate_hz() - 1.0).abs() < 0.1
}
