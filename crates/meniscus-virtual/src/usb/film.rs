//! A recorded glass on film, for the rig that plugs the simulated camera into a kernel: the images that the
//! camera will show there, and what the same run comes to in process.
//!
//! The film holds shots of 640x480, depth then infrared, with nothing between them.

use super::{RecordedGlass, SimulatedBus};
use crate::render::SceneSettings;
use meniscus::blob::Model;
use meniscus::runtime::{Estimator, InputSource, ProfileSensor, Tracker};
use meniscus::surface;
use meniscus::surface::{Config, ConfigError};
use meniscus::usb::uvc::Stream;
use meniscus_data::recording::Recording;
use meniscus_hil::FaultList;
use meniscus_hil::device::{Device, Scenery};
use meniscus_platform::clock::NoClock;
use meniscus_service::timed_turn::TimedTurn;
use meniscus_usb::buffer::Buffer;
use meniscus_usb::camera::{CameraError, Note, Session, Settings, Sink};
use std::fmt;
use std::io::{self, Write};
use std::sync::{Arc, Mutex, PoisonError};

/// Why there is no film.
#[derive(Debug)]
pub enum FilmError {
    /// The session in process failed.
    Camera(CameraError),
    /// The camera cannot see the model's glass.
    Glass(ConfigError),
    /// The film cannot be written.
    Write(io::Error),
}

impl fmt::Display for FilmError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Camera(error) => write!(f, "{error}"),
            Self::Glass(error) => write!(f, "the camera cannot see the model's glass: {error}"),
            Self::Write(error) => write!(f, "the film cannot be written: {error}"),
        }
    }
}

impl std::error::Error for FilmError {}

/// Writes down what it shows.
struct Filming<W> {
    glass: RecordedGlass,
    frames: u64,
    /// The file, or why it cannot be written any more.
    film: Arc<Mutex<Result<W, io::Error>>>,
}

impl<W: Write + Send> Scenery for Filming<W> {
    fn look(&mut self, shot: u64, size: (u16, u16)) -> (&[u8], &[u8]) {
        let (depth, infrared) = self.glass.look(shot, size);
        let mut film = self.film.lock().unwrap_or_else(PoisonError::into_inner);
        if shot < self.frames
            && let Ok(file) = &mut *film
            && let Err(error) = file.write_all(depth).and_then(|()| file.write_all(infrared))
        {
            *film = Err(error);
        }
        (depth, infrared)
    }
}

/// Payloads straight into the turn, without a second thread and without a clock.
struct Direct<'m, 'b> {
    tracker: Tracker<'m, 'b>,
    field: Vec<f32>,
    turns: Vec<TimedTurn>,
    frames: usize,
    spare: Vec<Buffer>,
}

impl Sink for Direct<'_, '_> {
    fn wanted(&mut self) -> bool {
        self.turns.len() < self.frames
    }

    fn spare(&mut self) -> Option<Buffer> {
        self.spare.pop()
    }

    fn deliver(&mut self, stream: Stream, payload: Buffer) -> bool {
        let turns = &mut self.turns;
        self.tracker.accept(
            stream,
            &payload,
            InputSource::tracked,
            &mut NoClock,
            &mut self.field,
            |turn, _| {
                turns.push(TimedTurn::untimed(*turn));
            },
        );
        self.spare.push(payload);
        true
    }

    fn dropped(&mut self) {}

    fn note(&mut self, _: Note) {}
}

/// Films the first `frames` frames of a recording into `film`; the turns of the same frames in process come
/// back, through the session on a simulated bus in virtual time.
///
/// # Errors
/// [`FilmError`].
pub fn film<W: Write + Send + 'static>(
    model: &Model<'_>,
    recording: Recording,
    settings: SceneSettings,
    frames: usize,
    film: W,
) -> Result<(Vec<TimedTurn>, W), FilmError> {
    let glass = RecordedGlass::new(recording, settings);
    let film = Arc::new(Mutex::new(Ok(film)));
    let filming = Filming { glass, frames: frames as u64, film: Arc::clone(&film) };
    let device = Device::new(Box::new(filming), None, FaultList::default(), settings.seed);
    let mut session =
        Session::connect(SimulatedBus::new(device), Settings::default()).map_err(FilmError::Camera)?;
    let connected = session.connected();
    let header = &model.header;
    let glass = surface::Settings::for_glass(header.radius_m, header.fill_m, header.rim_m);
    let config = Config::new(glass.with_optics(connected.optics())).map_err(FilmError::Glass)?;
    let (width, height) = config.image_size();
    let (mut depth, mut infrared) = (vec![0; 2 * width * height], vec![0; width * height]);
    let mut direct = Direct {
        tracker: Tracker::new(Estimator::new(model), ProfileSensor::new(config, &mut depth, &mut infrared)),
        field: vec![0.0; model.field_len()],
        turns: Vec::with_capacity(frames),
        frames,
        spare: (0..4).map(|_| Buffer::new(session.buffer_bytes())).collect(),
    };
    session.stream(&mut direct).map_err(FilmError::Camera)?;
    let turns = direct.turns;
    drop(session);
    let written = Arc::into_inner(film).map(|film| film.into_inner().unwrap_or_else(PoisonError::into_inner));
    match written {
        Some(written) => written.map(|film| (turns, film)).map_err(FilmError::Write),
        None => Err(FilmError::Write(io::Error::other("the camera still holds it"))),
    }
}
