//! The webcam's session before a real kernel's driver, inside the guest of `hil/run webcam`: the simulated camera is plugged
//! into vhci-hcd, uvcvideo makes a video device of its colour stream, and the heights are compared with the recording's.
//!
//! The film's infrared tones are shown as colour. The number of each shot stands in the first pixels of its image, so that
//! the comparison needs no clock. One JSON object is printed behind the word HIL.

use meniscus::runtime::ProfileSensor;
use meniscus::surface::{ColourLens, Config, Intrinsics, Optics, POINTS, Rectifier, Settings};
use meniscus::usb::uvc::Stream;
use meniscus_hil::FaultList;
use meniscus_hil::device::{Device, Film, INTRINSICS, Scenery};
use meniscus_hil::vhci::Plugged;
use meniscus_usb::buffer::Buffer;
use meniscus_usb::camera::{Note, Sink};
use meniscus_webcam::{Machine, PixelFormat, Session, Video};
use serde_json::{Value, json};
use std::error::Error;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Longest time until the kernel has made the video devices.
const ENUMERATION: Duration = Duration::from_secs(10);
/// Luma pixels that hold the number of a shot, a byte each.
const NUMBER: usize = 4;
/// Bytes of a payload's header.
const HEADER: usize = 46;
/// Error of the heights that is allowed, root mean square, mm.
const MOST_MM: f64 = 1.0;

/// A film whose infrared tones are its colours.
struct Coloured {
    film: Film,
    yuy2: Vec<u8>,
}

impl Scenery for Coloured {
    fn look(&mut self, shot: u64, size: (u16, u16)) -> (&[u8], &[u8]) {
        self.film.look(shot, size)
    }

    fn look_in_colour(&mut self, shot: u64) -> Option<(&[u8], &[u8])> {
        let (depth, infrared) = self.film.look(shot, (640, 480));
        self.yuy2.clear();
        self.yuy2.extend(infrared.iter().flat_map(|luma| [*luma, 128]));
        for (place, byte) in (shot as u32).to_le_bytes().into_iter().enumerate().take(NUMBER) {
            self.yuy2[2 * place] = byte;
        }
        Some((depth, &self.yuy2))
    }
}

/// Place of a shot on a film that goes there and back.
fn place(shot: usize, shots: usize) -> usize {
    let last = shots - 1;
    let on_the_way = shot % (2 * last).max(1);
    on_the_way.min(2 * last - on_the_way.min(2 * last))
}

/// Measures the payloads of a session for a time.
struct Measuring<'s, 'b> {
    until: Instant,
    bytes: usize,
    spare: Vec<Buffer>,
    sensor: &'s mut ProfileSensor<'b>,
    /// Heights of the recording, metres, shot after shot.
    truth: &'s [f32],
    found: Found,
    notes: Vec<String>,
}

/// Sums over the frames.
#[derive(Default)]
struct Found {
    frames: u64,
    unseen: u64,
    squares: f64,
    points: f64,
    worst_m: f64,
    shots: Option<[u64; 2]>,
    numbers: Option<[u64; 2]>,
}

/// Span that `value` extends.
fn extended(span: Option<[u64; 2]>, value: u64) -> Option<[u64; 2]> {
    span.map_or(Some([value; 2]), |[first, _]| Some([first, value]))
}

impl Sink for Measuring<'_, '_> {
    fn wanted(&mut self) -> bool {
        Instant::now() < self.until
    }

    fn spare(&mut self) -> Option<Buffer> {
        Some(self.spare.pop().unwrap_or_else(|| Buffer::new(self.bytes)))
    }

    fn deliver(&mut self, stream: Stream, payload: Buffer) -> bool {
        let shot = payload
            .get(HEADER..HEADER + 2 * NUMBER)
            .map_or(0, |pixels| u32::from_le_bytes([pixels[0], pixels[2], pixels[4], pixels[6]]));
        let seen = self.sensor.accept(stream, &payload, &mut Still);
        self.spare.push(payload);
        let Some(seen) = seen else { return true };
        let found = &mut self.found;
        found.frames += 1;
        found.shots = extended(found.shots, shot.into());
        found.numbers = extended(found.numbers, seen.stamp.sequence.into());
        let Ok(profile) = seen.profile else {
            found.unseen += 1;
            return true;
        };
        let at = place(shot as usize, self.truth.len() / POINTS) * POINTS;
        for (index, truth) in
            self.truth[at..at + POINTS].iter().enumerate().filter(|(i, _)| profile.valid[*i])
        {
            let error_m = f64::from(profile.height_m[index] - truth);
            found.squares += error_m * error_m;
            found.points += 1.0;
            found.worst_m = found.worst_m.max(error_m.abs());
        }
        true
    }

    fn dropped(&mut self) {}

    fn note(&mut self, note: Note) {
        self.notes.push(note.to_string());
    }
}

/// A clock that stands still: stages are not timed here.
struct Still;

impl meniscus::runtime::Clock for Still {
    fn now_us(&mut self) -> u64 {
        0
    }
}

/// The video device that has YUYV: the simulated camera's colour stream; and what each device before it answered.
fn colour_device() -> Result<(PathBuf, Vec<String>), Box<dyn Error>> {
    let begun = Instant::now();
    loop {
        let mut others = Vec::new();
        for path in
            (0..16).map(|number| PathBuf::from(format!("/dev/video{number}"))).filter(|path| path.exists())
        {
            let mut machine = Machine::new(path.clone());
            let answer = match machine.open().and_then(|_| machine.offers()) {
                Ok(offers) if offers.formats.contains(&PixelFormat::Yuyv.code()) => {
                    return Ok((path, others));
                }
                Ok(offers) => offers.formats.iter().map(|code| code.escape_ascii().to_string()).collect(),
                Err(error) => error.to_string(),
            };
            others.push(format!("{}: {answer}", path.display()));
        }
        if begun.elapsed() > ENUMERATION {
            return Err(format!("no video device has YUYV: {others:?}").into());
        }
        std::thread::sleep(Duration::from_millis(20));
    }
}

fn measure(film: &Path, truth: &Path, seconds: f64) -> Result<Value, Box<dyn Error>> {
    let truth: Vec<f32> =
        std::fs::read(truth)?.as_chunks().0.iter().map(|one| f32::from_le_bytes(*one)).collect();
    let scenery = Coloured { film: Film::open(film)?, yuy2: Vec::new() };
    let plugged = Plugged::new(Device::new(Box::new(scenery), None, FaultList::default(), 1))?;
    let (path, others) = colour_device()?;
    let mut session = Session::connect(Machine::new(path.clone()), &path.display().to_string())?;
    let [fx, fy, ppx, ppy] = INTRINSICS;
    let optics = Optics::default();
    let optics = Optics { intrinsics: Intrinsics { fx, fy, ppx, ppy, ..optics.intrinsics }, ..optics };
    let rotation = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let lens = ColourLens { intrinsics: optics.intrinsics, distortion: [0.0; 5], rotation };
    let rectifier = Rectifier::new(lens, optics.intrinsics);
    let config = Config::new(Settings::default().with_optics(optics))?;
    let (mut colour, mut grey) = (vec![0; rectifier.colour_bytes()], vec![0; rectifier.grey_bytes()]);
    let mut sensor = ProfileSensor::of_outline(config, rectifier, &mut colour, &mut grey);
    let begun = Instant::now();
    let mut measuring = Measuring {
        until: begun + Duration::from_secs_f64(seconds),
        bytes: session.buffer_bytes(),
        spare: Vec::new(),
        sensor: &mut sensor,
        truth: &truth,
        found: Found::default(),
        notes: Vec::new(),
    };
    session.stream(&mut measuring)?;
    let (found, notes) = (measuring.found, measuring.notes);
    let (losses, webcam) = (sensor.losses().1, session.webcam().line());
    drop(session);
    let busy = second_opener(&path);
    plugged.unplug()?;
    // Every shot from the first to the last one is a frame that was handed on, or one on the books.
    let shots = found.shots.map_or(0, |[first, last]| last - first + 1);
    let unbooked = shots.abs_diff(found.frames + u64::from(losses.frames()));
    let rms_mm = 1e3 * (found.squares / found.points).sqrt();
    let least = (0.95 * seconds * 60.0).floor();
    let check = |name: &str, value: f64, unit: &str, target: String, ok: bool| json!({ "name": name, "value": value, "unit": unit, "target": target, "ok": ok });
    Ok(json!({
        "webcam": webcam,
        "other_devices": others,
        "not_seen": found.unseen,
        "losses": losses,
        "numbers": found.numbers,
        "shots": found.shots,
        "heights_worst_mm": 1e3 * found.worst_m,
        "points": found.points,
        "notes": notes,
        "second_opener": busy,
        "checks": [
            check("webcam_frames", found.frames as f64, "1", format!(">= {least}"), found.frames as f64 >= least),
            check("webcam_frames_lost", f64::from(losses.frames()), "1", "informational".into(), true),
            check("webcam_frames_unbooked", unbooked as f64, "1", "0".into(), unbooked == 0),
            check("webcam_heights_rms_mm", rms_mm, "mm", format!("<= {MOST_MM}"), rms_mm <= MOST_MM),
            check("webcam_not_seen", found.unseen as f64, "1", "0".into(), found.unseen == 0),
            check("webcam_busy_named", 1.0, "1", "1".into(), busy.contains("another program streams")),
        ],
    }))
}

/// Answer to a second program while a first one streams.
fn second_opener(path: &Path) -> String {
    let connected = || Session::connect(Machine::new(path.into()), &path.display().to_string());
    let mut first = match connected() {
        Ok(first) => first,
        Err(error) => return format!("the first: {error}"),
    };
    if let Err(error) = first.video().start() {
        return format!("the first cannot start: {error}");
    }
    let answer = connected().map(|_| "it connects".to_owned()).unwrap_or_else(|error| error.to_string());
    first.video().close();
    answer
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [film, truth, seconds] = &arguments[..] else {
        return Err("usage: real_kernel FILM TRUTH SECONDS".into());
    };
    let facts = measure(film.as_ref(), truth.as_ref(), seconds.parse()?);
    println!("HIL {}", facts.unwrap_or_else(|error| json!({ "error": error.to_string() })));
    Ok(())
}
