//! `meniscus record`: a camera, or another recording, into a file.

mod camera;
mod out;
mod ros;

use super::kind::{Kind, expect};
use super::outline::Outline;
use super::outputs::{Force, check_folder};
use super::webcam::Eye;
use super::{bus, glass};
use anyhow::bail;
use camera::from_camera;
use indicatif::ProgressStyle;
use meniscus_bags as bag;
use meniscus_usb::camera::{Session, Settings};
use out::{Came, Out};
use ros::Topics;
use std::path::PathBuf;

/// Record a camera's images, or convert a recording.
///
/// Depth and outline images are written with their times. --out FILE.mcap is a file that Foxglove opens (docs/formats.md), a
/// name without ending is a folder of PNG images, FILE.csv is a table of the measured surface profiles.
///
/// A ROS bag of another program is converted from its sensor_msgs/Image and CameraInfo; where it is not clear which topics are the
/// camera's, the command lists them and says what to choose.
///
/// The file grows chunk by chunk. What was recorded before a full disk, Ctrl-C or a pulled plug stays readable. One second is
/// about 28 MB.
#[derive(clap::Args)]
#[command(
    after_help = "Examples:\n  meniscus record --out run.mcap --seconds 30\n  meniscus record --source simulated-usb --seconds 3 --out try.mcap\n  meniscus record --source old.bag --out old.mcap\n  meniscus record --source rosbag2_folder --depth-topic /camera/depth/image_rect_raw --out mine.mcap\n  meniscus record --source try.mcap --setup glass.toml --out profiles.csv"
)]
pub(crate) struct Arguments {
    /// Origin of the images: a camera, a simulated one, or a recording.
    ///
    /// simulated-usb takes a trouble by name or number. A recording is .mcap, .bag or .db3 of librealsense or of ROS, a folder of
    /// images, or a folder of rosbag2.
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
    /// Image beside the depth [default: that of --setup, or infrared].
    ///
    /// infrared is the left infrared image. colour is the luma of the colour image, rectified to the depth image, for a
    /// liquid that is clear in the near infrared. clear is the infrared image, and --out FILE.csv reads the contact line of
    /// clear water in it: it needs a white card behind the glass and light of 850 nm (docs/clear.md).
    #[arg(long, value_name = "infrared|colour|clear", help_heading = "Images")]
    outline: Option<Outline>,
    /// Serial number of the only camera that is taken, as USB shows it.
    #[arg(long, help_heading = "Images")]
    serial: Option<String>,
    /// Glass and camera position by `meniscus setup`, for --out FILE.csv.
    #[arg(long, value_name = "FILE.toml", help_heading = "Images")]
    setup: Option<PathBuf>,
    #[command(flatten)]
    topics: Topics,
    /// File or folder to write.
    #[arg(long, value_name = "FILE.mcap|FOLDER|FILE.csv", help_heading = "Output")]
    out: PathBuf,
    #[command(flatten)]
    force: Force,
}

/// Runs the verb.
pub(crate) fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let seconds = arguments.seconds.unwrap_or(10.0);
    if !(0.1..=86_400.0).contains(&seconds) {
        bail!("--seconds {seconds} is out of range: 0.1 to 86400");
    }
    check_out(arguments)?;
    if let Some(Eye::Device(device)) = Eye::of(&arguments.source)? {
        bail!(
            "a webcam has no depth, and recordings are of pairs of images: write the images of {} into a folder by another \
             program, with times.csv beside them, and give that to --source",
            device.display()
        );
    }
    let outline = match arguments.outline {
        Some(outline) => outline.image(),
        None => glass::outline(arguments.setup.as_deref())?.unwrap_or_default(),
    };
    let wanted = Settings { serial: arguments.serial.clone(), outline, ..Settings::default() };
    let word = arguments.source.to_str().unwrap_or("");
    if matches!(word.split_once(':').unwrap_or((word, "")).0, "usb" | "simulated-usb") {
        arguments.topics.refuse(word)?;
    }
    match word.split_once(':').unwrap_or((word, "")) {
        ("usb", "") => from_camera(arguments, Session::connect(bus::machine()?, wanted)?, seconds),
        ("simulated-usb", trouble) => {
            let bus = bus::recorded(trouble)?;
            from_camera(arguments, Session::connect(bus, wanted)?, seconds)
        }
        ("shipped", "") => bail!(
            "--source shipped is a recording of the simulator, which has no images: take simulated-usb, usb, or a camera's \
             recording"
        ),
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
    let recording = bag::open_chosen(source, &arguments.topics.choice()?)?;
    let wanted = arguments
        .outline
        .map_or_else(|| glass::outline(arguments.setup.as_deref()), |one| Ok(Some(one.image())))?;
    glass::same_outline(wanted, source, recording.calibration.outline)?;
    let mut out = Out::create(arguments, &recording.calibration)?;
    let bar = crate::bars::spinner();
    bar.set_style(ProgressStyle::with_template("{spinner} {pos} images, {elapsed}")?);
    let beside = recording.calibration.outline;
    let (mut first, mut torn, mut came) = (None, None, Came { beside, ..Came::default() });
    for image in recording.images {
        match image {
            Ok(image) => {
                let us = image.stamp.captured.0;
                let passed_s = us.saturating_sub(*first.get_or_insert(us)) as f64 * 1e-6;
                if arguments.seconds.is_some_and(|seconds| passed_s > seconds) {
                    break;
                }
                out.write(&image)?;
                came.count(image.stream);
                bar.inc(1);
            }
            // What could be read is kept; the rest is reported.
            Err(error) => torn = Some(error),
        }
    }
    bar.finish_and_clear();
    let kept = out.finish(came, &arguments.out);
    // A recording that is torn says so before it is said that nothing came of it.
    match (kept, torn) {
        (Ok(kept), torn) => {
            println!("{}: {kept}", arguments.out.display());
            torn.map_or(Ok(()), |error| Err(error.into()))
        }
        (Err(_), Some(error)) => Err(error.into()),
        (Err(nothing), None) => Err(nothing),
    }
}
