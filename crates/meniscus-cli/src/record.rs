//! `meniscus record`: a camera, or another recording, into a file.

use super::kind::{Kind, expect};
use super::outputs::{Force, check_folder};
use super::{bus, glass};
use anyhow::{Context, bail, ensure};
use indicatif::{ProgressBar, ProgressStyle};
use meniscus::surface::{
    self, Config, ExtractionState, OutlineAssembler, Rectifier, Region, SurfaceProfile, extract,
};
use meniscus::usb::frame::{DepthFrame, OutlineFrame};
use meniscus::usb::uvc::{Assembler, AssemblyOutcome, DeviceClock, Stream};
use meniscus_bags as bag;
use meniscus_bags::{BagError, Calibration, FolderWriter, Image, McapWriter};
use meniscus_data::profiles::profiles_to_csv;
use meniscus_platform::files::write_whole;
use meniscus_service::setup::Setup;
use meniscus_usb::camera::{LinkSink, OutlineImage, Session, Settings};
use meniscus_usb::link::{Delivery, Received, WorkerEnd, link};
use meniscus_usb::transport::Transport;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

/// Payload buffers between camera and file: half a second of both streams.
const BUFFERS: usize = 64;

/// Record a camera's images, or convert a recording.
///
/// Depth and outline images are written with their times. --out FILE.mcap is a file that Foxglove opens (docs/formats.md), a
/// name without ending is a folder of PNG images, FILE.csv is a table of the measured surface profiles.
///
/// The file grows chunk by chunk. What was recorded before a full disk, Ctrl-C or a pulled plug stays readable. One second is
/// about 28 MB.
#[derive(clap::Args)]
#[command(
    after_help = "Examples:\n  meniscus record --out run.mcap --seconds 30\n  meniscus record --source simulated-usb --seconds 3 --out try.mcap\n  meniscus record --source old.bag --out old.mcap\n  meniscus record --source try.mcap --setup glass.toml --out profiles.csv"
)]
pub(crate) struct Arguments {
    /// Origin of the images: the camera on the bus, a simulated one, or a recording.
    ///
    /// simulated-usb takes a trouble by name or number. A recording is .mcap, a librealsense .bag or .db3, or a folder.
    #[arg(
        long,
        default_value = "usb",
        value_name = "usb|simulated-usb[:TROUBLE]|FILE",
        help_heading = "Images"
    )]
    source: PathBuf,
    /// Length, s: 10 for a camera, all of a recording by default.
    #[arg(long, help_heading = "Images")]
    seconds: Option<f64>,
    /// Image that is recorded beside the depth [default: that of --setup, or infrared].
    ///
    /// infrared is the left infrared image. colour is the luma of the colour image, rectified to the depth image, for a
    /// liquid that is clear in the near infrared.
    #[arg(long, value_name = "infrared|colour", help_heading = "Images")]
    outline: Option<OutlineImage>,
    /// Serial number of the only camera that is taken, as USB shows it.
    #[arg(long, help_heading = "Images")]
    serial: Option<String>,
    /// Glass and camera position, as `meniscus setup` wrote them, for --out FILE.csv.
    #[arg(long, value_name = "FILE.toml", help_heading = "Images")]
    setup: Option<PathBuf>,
    /// File or folder to write.
    #[arg(long, value_name = "FILE.mcap|FOLDER|FILE.csv", help_heading = "Output")]
    out: PathBuf,
    #[command(flatten)]
    force: Force,
}

/// Where images go.
enum Out {
    Mcap(Box<McapWriter>),
    Folder(FolderWriter),
    Profiles(Box<Profiles>),
}

/// The profiles of a recording.
struct Profiles {
    path: PathBuf,
    config: Config,
    state: ExtractionState,
    depth: Option<Image>,
    profiles: Vec<SurfaceProfile>,
}

impl Out {
    fn create(arguments: &Arguments, calibration: &Calibration) -> anyhow::Result<Self> {
        let (path, setup) = (&arguments.out, &arguments.setup);
        let profiles = path.extension().is_some_and(|extension| extension == "csv");
        ensure!(
            profiles || setup.is_none(),
            "--setup is for profiles (--out FILE.csv): images need no glass"
        );
        Ok(match path.extension().and_then(|extension| extension.to_str()) {
            Some("mcap") => Self::Mcap(Box::new(McapWriter::create(path, calibration)?)),
            Some("csv") => {
                let settings = match setup {
                    Some(setup) => Setup::read(setup)?.settings(calibration.optics()),
                    None => surface::Settings::default().with_optics(calibration.optics()),
                };
                let config = Config::new(settings).context("the recording's camera cannot see the glass")?;
                let (path, state) = (path.clone(), ExtractionState::new());
                Self::Profiles(Box::new(Profiles { path, config, state, depth: None, profiles: Vec::new() }))
            }
            None => Self::Folder(FolderWriter::create(path, calibration)?),
            Some(other) => bail!("--out ends in .{other}: .mcap, .csv or no ending (a folder) are written"),
        })
    }

    fn write(&mut self, image: &Image) -> Result<(), BagError> {
        match self {
            Self::Mcap(writer) => writer.write(image),
            Self::Folder(writer) => writer.write(image),
            Self::Profiles(profiles) => {
                profiles.take(image);
                Ok(())
            }
        }
    }

    fn finish(self) -> anyhow::Result<String> {
        Ok(match self {
            Self::Mcap(writer) => format!("{} images", writer.finish()?),
            Self::Folder(writer) => format!("{} images", writer.finish()?),
            Self::Profiles(profiles) => {
                write_whole(&profiles.path, profiles_to_csv(&profiles.profiles).as_bytes())?;
                format!("{} profiles", profiles.profiles.len())
            }
        })
    }
}

impl Profiles {
    fn take(&mut self, image: &Image) {
        if image.stream == Stream::Depth {
            self.depth = Some(image.clone());
            return;
        }
        let near = |depth: &Image| depth.stamp.captured.0.abs_diff(image.stamp.captured.0) < 8_000;
        let Some(depth) = self.depth.take().filter(near) else { return };
        let (width, height) = self.config.image_size();
        let depth = DepthFrame { bytes: &depth.pixels, width, height, stamp: depth.stamp };
        let infrared = OutlineFrame { bytes: &image.pixels, width, height, stamp: image.stamp };
        self.profiles.extend(extract(&self.config, &mut self.state, depth, infrared).ok());
    }
}

/// Runs the verb.
pub(crate) fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let seconds = arguments.seconds.unwrap_or(10.0);
    if !(0.1..=86_400.0).contains(&seconds) {
        bail!("--seconds {seconds} is out of range: 0.1 to 86400");
    }
    check_out(arguments)?;
    let outline = match arguments.outline {
        Some(outline) => outline,
        None => glass::outline(arguments.setup.as_deref())?.unwrap_or_default(),
    };
    let wanted = Settings { serial: arguments.serial.clone(), outline, ..Settings::default() };
    let word = arguments.source.to_str().unwrap_or("");
    match word.split_once(':').unwrap_or((word, "")) {
        ("usb", "") => from_camera(arguments, Session::connect(bus::machine()?, wanted)?, seconds),
        ("simulated-usb", trouble) => {
            let bus = bus::recorded(trouble)?;
            from_camera(arguments, Session::connect(bus, wanted)?, seconds)
        }
        _ => from_recording(arguments),
    }
}

/// Refuses an output that would be replaced or cannot be written.
fn check_out(arguments: &Arguments) -> anyhow::Result<()> {
    let Arguments { out, force, .. } = arguments;
    match out.extension().and_then(|extension| extension.to_str()) {
        Some("mcap" | "csv") => force.check(out),
        Some(other) => bail!("--out ends in .{other}: .mcap, .csv or no ending (a folder) are written"),
        None => {
            force.check_absent(out)?;
            check_folder(out)
        }
    }
}

fn from_recording(arguments: &Arguments) -> anyhow::Result<()> {
    let source = arguments.source.as_path();
    expect(source, Kind::Camera, "a camera's recording")?;
    let recording = bag::open(source)?;
    let wanted =
        arguments.outline.map_or_else(|| glass::outline(arguments.setup.as_deref()), |one| Ok(Some(one)))?;
    glass::same_outline(wanted, source, recording.calibration.outline)?;
    let mut out = Out::create(arguments, &recording.calibration)?;
    let bar = crate::bars::spinner();
    bar.set_style(ProgressStyle::with_template("{spinner} {pos} images, {elapsed}")?);
    let (mut first, mut torn) = (None, None);
    for image in recording.images {
        match image {
            Ok(image) => {
                let us = image.stamp.captured.0;
                let passed_s = us.saturating_sub(*first.get_or_insert(us)) as f64 * 1e-6;
                if arguments.seconds.is_some_and(|seconds| passed_s > seconds) {
                    break;
                }
                out.write(&image)?;
                bar.inc(1);
            }
            // What could be read is kept; the rest is told.
            Err(error) => torn = Some(error),
        }
    }
    bar.finish_and_clear();
    println!("{}: {}", arguments.out.display(), out.finish()?);
    torn.map_or(Ok(()), |error| Err(error.into()))
}

/// Both streams of a camera as whole images.
struct ImageReader<'b> {
    depth: Assembler<'b>,
    outline: OutlineAssembler<'b>,
    whole: Region,
    clock: DeviceClock,
}

impl ImageReader<'_> {
    /// Returns the image that this payload completes, if it completes one.
    fn take(&mut self, delivery: &Delivery) -> Option<Image> {
        let stream = delivery.stream;
        let (stamp, pixels) = match stream {
            Stream::Depth => match self.depth.push(&delivery.payload, &mut self.clock) {
                AssemblyOutcome::Frame(frame) => (frame.stamp, self.depth.pixels()),
                AssemblyOutcome::Partial | AssemblyOutcome::Lost(_) => return None,
            },
            Stream::Outline => {
                let stamp = self.outline.push(&delivery.payload, self.whole, &mut self.clock)?;
                (stamp, self.outline.pixels())
            }
        };
        Some(Image { stream, stamp, pixels: pixels.to_vec() })
    }
}

/// Writes every image until the camera has gone. A file that takes no more stops the camera.
fn write_all(
    end: &WorkerEnd,
    reader: &mut ImageReader<'_>,
    out: &mut Out,
    stop: &AtomicBool,
    bar: &ProgressBar,
) -> Result<(), BagError> {
    let (mut written, mut images) = (Ok(()), 0_u64);
    loop {
        match end.receive(Instant::now() + Duration::from_millis(100)) {
            Received::Closed => return written,
            Received::Silence => {}
            Received::Payload(delivery) => {
                // The buffers go round even after a failure: a camera that waits for one would not see `stop`.
                if let (Some(image), Ok(())) = (reader.take(&delivery), &written) {
                    written = out.write(&image);
                    images += 1;
                }
                end.give_back(delivery.payload);
            }
        }
        if written.is_err() {
            stop.store(true, Ordering::Relaxed);
        }
        bar.set_position(bar.elapsed().as_millis().try_into().unwrap_or(u64::MAX));
        bar.set_message(images.to_string());
    }
}

fn from_camera(
    arguments: &Arguments,
    mut session: Session<impl Transport + Send>,
    seconds: f64,
) -> anyhow::Result<()> {
    let connected = session.connected().clone();
    let name = format!("{:?} {}", connected.product, connected.identity.serial);
    let rectifier = connected.rectifier();
    let beside = if rectifier.is_some() { OutlineImage::Colour } else { OutlineImage::Infrared };
    let calibration =
        Calibration::of(&connected.optics(), connected.baseline_mm * 1e-3, name).with_outline(beside);
    let mut out = Out::create(arguments, &calibration)?;
    let (camera_end, worker_end) = link(BUFFERS, session.buffer_bytes());
    let (stop, notes) = (Arc::new(AtomicBool::new(false)), Mutex::new(Vec::new()));
    let interrupted = Arc::clone(&stop);
    ctrlc::set_handler(move || interrupted.store(true, Ordering::Relaxed))
        .context("cannot watch for Ctrl-C")?;
    let until = Instant::now() + Duration::from_secs_f64(seconds);
    let bar = crate::bars::bar((1e3 * seconds) as u64);
    bar.set_style(crate::bars::style("recording {wide_bar} {msg} images, {left}")?);
    let size = (connected.intrinsics.width, connected.intrinsics.height);
    let (mut depth, mut grey) = (vec![0; 2 * size.0 * size.1], vec![0; size.0 * size.1]);
    let mut colour = vec![0; rectifier.as_ref().map_or(0, Rectifier::colour_bytes)];
    let outline = match rectifier {
        Some(rectifier) => OutlineAssembler::colour(rectifier, &mut colour, &mut grey),
        None => OutlineAssembler::infrared(&mut grey),
    };
    let mut reader = ImageReader {
        depth: Assembler::new(&mut depth),
        outline,
        whole: Region::whole(size),
        clock: DeviceClock::default(),
    };
    let (ended, written) = std::thread::scope(|scope| {
        let (stop, notes) = (&*stop, &notes);
        let camera =
            scope.spawn(move || session.stream(&mut LinkSink { end: camera_end, stop, until, notes }));
        let written = write_all(&worker_end, &mut reader, &mut out, stop, &bar);
        (camera.join(), written)
    });
    bar.finish_and_clear();
    notes.into_inner().unwrap_or_default().iter().for_each(|note| println!("camera: {note}"));
    // A file that could not take an image has not room for an index either.
    written?;
    let kept = out.finish()?;
    println!(
        "{}: {kept}; lost: {} depth, {} {beside}, {} payloads dropped",
        arguments.out.display(),
        reader.depth.losses().frames(),
        reader.outline.losses().frames(),
        worker_end.dropped()
    );
    ended.map_err(|_| anyhow::anyhow!("the camera's thread stopped on an error of its own"))??;
    Ok(())
}
