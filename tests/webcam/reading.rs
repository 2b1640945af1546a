//! Payloads of the session through the reader, and the errors of the profiles.

use crate::rendered::{FIRST_US, RECORDED_HZ, Rendered, recording};
use meniscus::runtime::{FrameObservation, ProfileSensor};
use meniscus::surface::{Config, POINTS, Settings};
use meniscus::usb::uvc::{Losses, Stream};
use meniscus_platform::clock::NoClock;
use meniscus_service::setup::StatedLens;
use meniscus_usb::buffer::Buffer;
use meniscus_usb::camera::{Note, Sink};
use meniscus_webcam::{Mode, Session, WebcamError};

/// Hands each payload to `take` until it has had `left` of them; keeps the notes.
pub(crate) struct Each<F> {
    pub(crate) left: usize,
    pub(crate) bytes: usize,
    pub(crate) take: F,
    pub(crate) notes: Vec<Note>,
}

impl<F: FnMut(&[u8])> Sink for Each<F> {
    fn wanted(&mut self) -> bool {
        self.left > 0
    }
    fn spare(&mut self) -> Option<Buffer> {
        Some(Buffer::new(self.bytes))
    }
    fn deliver(&mut self, stream: Stream, payload: Buffer) -> bool {
        assert_eq!(stream, Stream::Outline);
        self.left -= 1;
        (self.take)(&payload);
        true
    }
    fn dropped(&mut self) {}
    fn note(&mut self, note: Note) {
        self.notes.push(note);
    }
}

pub(crate) fn connect(video: Rendered) -> Session<Rendered> {
    Session::connect(video, "/dev/video7").expect("connected")
}

/// Streams `payloads` payloads; returns the notes.
pub(crate) fn stream(
    session: &mut Session<Rendered>,
    payloads: usize,
    take: impl FnMut(&[u8]),
) -> (Vec<Note>, Result<(), WebcamError>) {
    let bytes = session.buffer_bytes();
    let mut sink = Each { left: payloads, bytes, take, notes: Vec::new() };
    let ended = session.stream(&mut sink);
    (sink.notes, ended)
}

/// Observations of a stream by the reader.
pub(crate) struct Seen {
    pub(crate) observations: Vec<FrameObservation>,
    pub(crate) losses: Losses,
    pub(crate) notes: Vec<Note>,
}

/// Reads `payloads` payloads with a lens and a configuration.
pub(crate) fn read(
    session: &mut Session<Rendered>,
    lens: StatedLens,
    config: Config,
    payloads: usize,
) -> Seen {
    let (width, height) = config.image_size();
    let (mut colour, mut grey) = (vec![0; lens.rectifier().colour_bytes()], vec![0; width * height]);
    let mut sensor = ProfileSensor::of_outline(config, lens.rectifier(), &mut colour, &mut grey);
    let mut observations = Vec::new();
    let (notes, ended) = stream(session, payloads, |payload| {
        observations.extend(sensor.accept(Stream::Outline, payload, &mut NoClock));
    });
    ended.expect("no trouble at the end");
    Seen { observations, losses: sensor.losses().1, notes }
}

/// Errors of a run of profiles.
#[derive(Debug)]
pub(crate) struct Errors {
    pub(crate) heights_rms_mm: f64,
    pub(crate) inside: f64,
    pub(crate) track_rms_mm: f64,
    pub(crate) points: f64,
}

pub(crate) fn errors(observations: &[FrameObservation]) -> Errors {
    let truth = recording();
    let (mut squares, mut points, mut inside) = (0.0, 0.0, 0.0);
    let mut track = Vec::new();
    let first_us = FIRST_US % (1 << 32);
    for observation in observations {
        let since_s = (observation.stamp.captured.0 - first_us) as f64 * 1e-6;
        let frame = (since_s * f64::from(RECORDED_HZ)).round() as usize;
        let profile = observation.profile.unwrap_or_else(|why| panic!("frame {frame}: {why}"));
        for i in (0..POINTS).filter(|i| profile.valid[*i]) {
            let error = f64::from(profile.height_m[i] - truth.profile(frame)[i]);
            squares += error * error;
            points += 1.0;
            inside += f64::from(u8::from(error.abs() <= f64::from(profile.interval_m(i).expect("valid"))));
        }
        track.push(f64::from(profile.glass_x_m.expect("tracked")) - truth.glass_x_m[frame]);
    }
    let mean = track.iter().sum::<f64>() / track.len() as f64;
    let scatter = (track.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / track.len() as f64).sqrt();
    Errors {
        heights_rms_mm: 1e3 * (squares / points).sqrt(),
        inside: inside / points,
        track_rms_mm: 1e3 * scatter,
        points: points / (observations.len() * POINTS) as f64,
    }
}

pub(crate) fn lens_of(mode: Mode, focal_px: f32) -> StatedLens {
    StatedLens::of_focal(mode.size, focal_px.into()).expect("a lens")
}

pub(crate) fn config_of(lens: StatedLens, place: Settings) -> Config {
    Config::new(place.with_optics(lens.optics())).expect("sound")
}
