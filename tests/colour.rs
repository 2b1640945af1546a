//! The outline in the colour image, over the simulated USB camera and in virtual time: its lens stands 15 mm beside
//! that of the depth image, looks a quarter of a degree higher, and has a focal length of its own.

use meniscus::runtime::{FrameObservation, ProfileSensor};
use meniscus::surface::{self, Config, OutlineAssembler, POINTS};
use meniscus::units::Micros;
use meniscus::usb::frame::Stamp;
use meniscus::usb::uvc::Stream;
use meniscus_bags as bag;
use meniscus_bags::observe_images;
use meniscus_bags::{Calibration, Image, McapWriter};
use meniscus_data::recording::Recording;
use meniscus_hil::FaultList;
use meniscus_hil::device::{COLOUR_LENS_M, Device, FIRST_SHOT_US, Trouble};
use meniscus_platform::clock::NoClock;
use meniscus_service::setup::{Gather, Inspection, MeasuredGlass, Pair, SetupOrigin, inspect};
use meniscus_usb::buffer::Buffer;
use meniscus_usb::camera::{CameraError, Connected, Note, OutlineImage, Session, Settings, Sink};
use meniscus_virtual::render::SceneSettings;
use meniscus_virtual::usb::{RecordedGlass, SimulatedBus};
use std::path::Path;
use std::process::Command;

/// Frames that are looked at: four seconds of the shipped recording, whose glass moves in the first one.
const FRAMES: u32 = 240;

fn recording() -> Recording {
    let path = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../recordings/glycerine-unseen.safetensors"));
    Recording::load(path).expect("the shipped recording")
}

fn session(
    glass: RecordedGlass,
    outline: OutlineImage,
    trouble: Option<Trouble>,
) -> Result<Session<SimulatedBus>, CameraError> {
    let device = Device::new(Box::new(glass), trouble, FaultList::default(), 1);
    Session::connect(SimulatedBus::new(device), Settings { outline, ..Settings::default() })
}

/// Hands each payload to `take`, until it has had `left` of them.
struct Each<F> {
    left: u32,
    spare: Vec<Buffer>,
    bytes: usize,
    take: F,
}

impl<F: FnMut(Stream, &[u8])> Sink for Each<F> {
    fn wanted(&mut self) -> bool {
        self.left > 0
    }
    fn spare(&mut self) -> Option<Buffer> {
        Some(self.spare.pop().unwrap_or_else(|| Buffer::new(self.bytes)))
    }
    fn deliver(&mut self, stream: Stream, payload: Buffer) -> bool {
        self.left -= 1;
        (self.take)(stream, &payload);
        self.spare.push(payload);
        true
    }
    fn dropped(&mut self) {}
    fn note(&mut self, note: Note) {
        panic!("{note}");
    }
}

/// Every payload of the first frames; the camera.
fn stream(mut session: Session<SimulatedBus>, frames: u32, take: impl FnMut(Stream, &[u8])) -> Connected {
    let bytes = session.buffer_bytes();
    session.stream(&mut Each { left: 2 * frames, spare: vec![], bytes, take }).expect("no trouble");
    assert_eq!(session.transport().unread, 0);
    session.connected().clone()
}

/// Returns the observations of a sensor of the recording through this image.
fn observations(outline: OutlineImage) -> (Vec<FrameObservation>, Connected) {
    let session =
        session(RecordedGlass::new(recording(), SceneSettings::default()), outline, None).expect("connected");
    let connected = session.connected().clone();
    // The place of the lens that traces, as `meniscus setup` would find it.
    let [_, down, forward] = connected.colour.map_or([0.0; 3], |_| COLOUR_LENS_M);
    let place = surface::Settings::default();
    let place = surface::Settings {
        camera_height_m: place.camera_height_m - down,
        camera_distance_m: place.camera_distance_m - forward,
        ..place
    };
    let config = Config::new(place.with_optics(connected.optics())).expect("sound");
    let (mut depth, mut grey, mut colour) = (vec![0; 614_400], vec![0; 307_200], vec![0; 614_400]);
    let mut sensor = match connected.rectifier() {
        Some(rectifier) => ProfileSensor::with_colour(config, &mut depth, rectifier, &mut colour, &mut grey),
        None => ProfileSensor::new(config, &mut depth, &mut grey),
    };
    let mut observations = Vec::new();
    stream(session, FRAMES, |stream, payload| {
        observations.extend(sensor.accept(stream, payload, &mut NoClock));
    });
    assert_eq!((sensor.losses().1.frames(), sensor.solitary().infrared), (0, 0));
    (observations, connected)
}

/// Root mean square of the heights' errors and of the track's, mm; the track's mean is its origin.
fn errors(observations: &[FrameObservation]) -> (f64, f64, f64) {
    let truth = recording();
    let (mut squares, mut points) = (0.0, 0.0);
    let mut track = Vec::new();
    for observation in observations {
        let frame = ((observation.stamp.captured.0 - FIRST_SHOT_US) as f64 * 6e-5).round() as usize;
        let profile = observation.profile.unwrap_or_else(|why| panic!("frame {frame}: {why}"));
        for i in (0..POINTS).filter(|i| profile.valid[*i]) {
            squares += f64::from(profile.height_m[i] - truth.profile(frame)[i]).powi(2);
            points += 1.0;
        }
        track.push(f64::from(profile.glass_x_m.expect("tracked")) - truth.glass_x_m[frame]);
    }
    let mean = track.iter().sum::<f64>() / track.len() as f64;
    let scatter = (track.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / track.len() as f64).sqrt();
    assert!(
        points > 0.97 * (observations.len() * POINTS) as f64,
        "{points} points of {} frames",
        observations.len()
    );
    (1e3 * (squares / points).sqrt(), 1e3 * scatter, 1e3 * mean)
}

#[test]
fn the_surface_is_as_good_in_colour_as_in_infrared() {
    let (infrared, _) = observations(OutlineImage::Infrared);
    let (colour, connected) = observations(OutlineImage::Colour);
    assert_eq!((infrared.len(), colour.len()), (FRAMES as usize, FRAMES as usize));
    let [infrared, colour] = [errors(&infrared), errors(&colour)];
    println!(
        "infrared: heights {:.3} mm, track {:.4} mm, origin {:.3} mm",
        infrared.0, infrared.1, infrared.2
    );
    println!("colour:   heights {:.3} mm, track {:.4} mm, origin {:.3} mm", colour.0, colour.1, colour.2);
    assert!(colour.0 < 0.2 && colour.0 < 1.5 * infrared.0, "heights");
    assert!(colour.1 < 0.02, "track");
    // X is given relative to the lens that traces: the depth lens stands 14.8 mm to its right.
    assert!((colour.2 + f64::from(1e3 * COLOUR_LENS_M[0])).abs() < 0.1, "origin");
    let lens = connected.colour.expect("calibrated").lens;
    assert!((lens.intrinsics.fx - 612.4).abs() < 0.01 && (lens.intrinsics.ppy - 244.7).abs() < 0.01);
}

/// Without the lens' own place the walls would be looked for where they are not.
#[test]
fn the_place_of_the_lens_is_what_makes_it_so() {
    let session =
        session(RecordedGlass::new(recording(), SceneSettings::default()), OutlineImage::Colour, None)
            .expect("connected");
    let connected = session.connected().clone();
    let optics = surface::Optics { depth_lens_m: [-0.0148, 0.0, 0.0], ..connected.optics() };
    let config = Config::new(surface::Settings::default().with_optics(optics)).expect("sound");
    let (mut depth, mut grey, mut colour) = (vec![0; 614_400], vec![0; 307_200], vec![0; 614_400]);
    let rectifier = connected.rectifier().expect("in colour");
    let mut sensor = ProfileSensor::with_colour(config, &mut depth, rectifier, &mut colour, &mut grey);
    let mut seen = 0;
    stream(session, 30, |stream, payload| {
        let observation = sensor.accept(stream, payload, &mut NoClock);
        let points = observation
            .and_then(|observation| observation.profile.ok())
            .map(|profile| profile.valid.iter().filter(|v| **v).count());
        seen += points.unwrap_or(0);
    });
    assert!(seen < 30 * POINTS * 9 / 10, "{seen} points seen through the wrong place");
}

/// The colour imager is not exposed with the depth imagers; the edge is where it was at its own instant.
#[test]
fn the_time_of_a_pair_is_that_of_the_outline() {
    let [depth, outline] = [1_000_000, 1_005_000].map(|us| Stamp { sequence: 7, captured: Micros(us) });
    let with = |depth_lens_m| {
        let settings = surface::Settings { depth_lens_m, ..surface::Settings::default() };
        Config::new(settings).expect("sound").stamp_of(depth, outline)
    };
    assert_eq!(with([0.0; 3]), depth, "one lens, one instant: the depth image's books hold");
    assert_eq!(with([0.0148, 0.0, 0.0]), outline);
}

/// Returns the wizard's inspection of a glass at rest.
fn looked_at(outline: OutlineImage) -> (Inspection, Vec<Pair>, Connected) {
    let glass = RecordedGlass::new(recording(), SceneSettings::default()).resting();
    let session = session(glass, outline, None).expect("connected");
    let rectifier = session.connected().rectifier();
    let (mut depth, mut grey, mut colour) = (vec![0; 614_400], vec![0; 307_200], vec![0; 614_400]);
    let outline_of = match rectifier {
        Some(rectifier) => OutlineAssembler::colour(rectifier, &mut colour, &mut grey),
        None => OutlineAssembler::infrared(&mut grey),
    };
    let mut gather = Gather::new((640, 480), &mut depth, outline_of);
    let mut pairs = Vec::new();
    let connected = stream(session, 40, |stream, payload| pairs.extend(gather.take(stream, payload)));
    let said = MeasuredGlass::of([35.0, 70.0, 110.0]);
    let inspection = inspect(
        &pairs,
        connected.optics(),
        said,
        SetupOrigin { outline, camera: "a camera", made_by: "a test" },
    );
    (inspection, pairs, connected)
}

#[test]
fn a_glass_is_set_up_in_colour_and_its_recording_is_read_with_that_setup() {
    let (inspection, ..) = looked_at(OutlineImage::Infrared);
    let infrared = inspection.setup.expect("seen in infrared").view;
    let (inspection, pairs, connected) = looked_at(OutlineImage::Colour);
    let missed: Vec<_> = inspection.findings.iter().filter(|finding| finding.check.missed()).collect();
    assert!(missed.is_empty(), "{missed:?}");
    let setup = inspection.setup.expect("seen");
    assert_eq!(setup.view.outline, OutlineImage::Colour);
    // The colour lens stands 0.2 mm lower and 0.3 mm nearer.
    assert!(
        (setup.view.distance_mm - infrared.distance_mm + 0.3).abs() < 0.4,
        "{:?} {infrared:?}",
        setup.view
    );
    assert!((setup.view.height_mm - infrared.height_mm + 0.2).abs() < 0.4, "{:?} {infrared:?}", setup.view);
    assert!((setup.view.pitch_deg - infrared.pitch_deg).abs() < 0.2, "{:?} {infrared:?}", setup.view);

    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("colour");
    let _old = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).expect("a folder");
    let path = folder.join("colour.mcap");
    let calibration = Calibration::of(&connected.optics(), 0.05, "a test").with_outline(OutlineImage::Colour);
    write(&path, &calibration, &pairs);
    let bytes = std::fs::read(&path).expect("read");
    assert!(bytes.windows(19).any(|name| name == b"/camera/colour_luma"), "a topic of its own");
    let read = bag::open(&path).expect("opened");
    assert_eq!(read.calibration, calibration);
    let config = Config::new(setup.settings(read.calibration.optics())).expect("sound");
    let sightings = observe_images(read, config).expect("whole");
    let level = |profile: &surface::SurfaceProfile| profile.height_m.iter().sum::<f32>() / POINTS as f32;
    let levels: Vec<f32> = sightings.iter().flatten().map(level).collect();
    assert!(levels.len() >= 38 && levels.iter().all(|z| (z - 0.070).abs() < 5e-4), "{levels:?}");

    // The same by the commands; and a recording in infrared is refused with that setup.
    let meniscus = |arguments: &[&str]| {
        let program = env!("CARGO_BIN_EXE_meniscus-under-test");
        let output = Command::new(program).args(arguments).current_dir(&folder).output().expect("it starts");
        (output.status.success(), String::from_utf8_lossy(&output.stderr).into_owned())
    };
    let said = ["--yes", "--radius-mm", "35", "--fill-mm", "70", "--rim-mm", "110", "--pairs", "30"];
    let (ok, message) = meniscus(&[&["setup", "--source", "colour.mcap"], &said[..]].concat());
    assert!(ok, "{message}");
    let text = std::fs::read_to_string(folder.join("glass.toml")).expect("written");
    assert!(text.contains("outline = \"colour\""), "{text}");
    let to_table = |source: &str| {
        meniscus(&["record", "--source", source, "--setup", "glass.toml", "--out", "seen.csv", "--force"])
    };
    let (ok, message) = to_table("colour.mcap");
    assert!(ok, "{message}");
    let rows = std::fs::read_to_string(folder.join("seen.csv")).expect("written").lines().count();
    assert!(rows >= 38, "{rows}");
    write(&folder.join("infrared.mcap"), &calibration.with_outline(OutlineImage::Infrared), &pairs);
    let (ok, message) = to_table("infrared.mcap");
    assert!(!ok && message.contains("infrared.mcap has its outline in infrared"), "{message}");
}

fn write(path: &Path, calibration: &Calibration, pairs: &[Pair]) {
    let mut writer = McapWriter::create(path, calibration).expect("created");
    for Pair { depth, outline, stamp } in pairs {
        let depth = depth.as_ref().expect("a camera with depth");
        for (stream, pixels) in [(Stream::Depth, depth), (Stream::Outline, outline)] {
            writer.write(&Image { stream, stamp: *stamp, pixels: pixels.clone() }).expect("written");
        }
    }
    writer.finish().expect("ended");
}

#[test]
fn a_camera_that_cannot_do_it_says_so() {
    let refused = |name: &str| {
        let glass = RecordedGlass::new(recording(), SceneSettings::default());
        let trouble = Trouble::find(name);
        assert!(trouble.is_some(), "{name}");
        session(glass, OutlineImage::Colour, trouble).map(drop).expect_err("refused").to_string()
    };
    let slow = refused("usb2");
    assert!(slow.contains("too slow for depth and colour") && slow.contains("USB 3"), "{slow}");
    // The depth table is read first: a camera whose tables are damaged never comes to its colours.
    let damaged = refused("table-crc");
    assert!(damaged.contains("CRC-32"), "{damaged}");
}
