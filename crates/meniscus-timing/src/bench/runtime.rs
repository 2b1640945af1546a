//! A runtime with a paper-size blob: how much memory it takes, how soon it knows the liquid.
//!
//! Both are measured in a process of their own, which gets a blob and a file of payloads, and takes a frame every
//! 1/60 s as from a camera. The blob is the shipped one with a decoder of the paper's size: a trunk of 200, bases of
//! rank 120, 200, 1, 200, 200 (19 MB in f32).

use super::turn::Payloads;
use meniscus::blob::{LoadError, Model, Tensor};
use meniscus::runtime::{Estimator, InputSource, Mode, ProfileSensor, Tracker};
use meniscus::surface::{Config, Settings};
use meniscus::usb::uvc::Stream;
use meniscus_data::blob_file::read::parts;
use meniscus_data::blob_file::write::{Part, blob};
use meniscus_platform::clock::Monotonic;
use meniscus_platform::files::AlignedBytes;
use std::fs::File;
use std::io::{self, BufReader, Read};
use std::path::Path;
use std::time::{Duration, Instant};

/// Ranks of q, v, e, sigma, tau and the surface in the paper-size blob.
const RANKS: [usize; 6] = [120, 200, 1, 200, 200, 20];

/// Hidden units of its trunk.
const TRUNK: usize = 200;

/// Frames a second of the camera.
const RATE_HZ: f64 = 60.0;

/// `shipped` with a decoder of the paper's size.
///
/// # Errors
/// [`LoadError`], when `shipped` is refused.
pub fn paper_size(shipped: &[u8]) -> Result<Vec<u8>, LoadError> {
    let (header, mut all) = parts(shipped)?;
    let coefficients: usize = RANKS.iter().sum::<usize>() - 1;
    for part in &mut all {
        let (rows, columns) = match part.tensor {
            Tensor::TrunkLinear => (coefficients, part.columns),
            Tensor::TrunkPort | Tensor::TrunkBias(2) => (coefficients, 1),
            Tensor::TrunkWeight(0) => (TRUNK, part.columns),
            Tensor::TrunkWeight(1) => (TRUNK, TRUNK),
            Tensor::TrunkWeight(_) => (coefficients, TRUNK),
            Tensor::TrunkBias(_) => (TRUNK, 1),
            Tensor::GroupBasis(group) => (part.rows, RANKS[usize::from(group).min(5)]),
            _ => continue,
        };
        let number = |k: usize| 1e-3 * (((k * 7919) % 1009) as f32 / 1009.0 - 0.5);
        *part =
            Part { tensor: part.tensor, rows, columns, values: (0..rows * columns).map(number).collect() };
    }
    blob(header, &all).map_err(|_| LoadError::Header)
}

/// Payloads in a file: a byte for the stream, four for the length, the payload.
#[must_use]
pub fn payload_file(payloads: &Payloads) -> Vec<u8> {
    let mut bytes = Vec::new();
    for (stream, payload) in payloads {
        bytes.push(u8::from(*stream == Stream::Outline));
        bytes.extend_from_slice(&(payload.len() as u32).to_le_bytes());
        bytes.extend_from_slice(payload);
    }
    bytes
}

/// Memory and start-up time, measured by a process of its own.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Needs {
    /// Most memory that was resident, MiB.
    pub resident_mib: f64,
    /// From the start of the process to the first estimate that tracked, s.
    pub first_estimate_s: f64,
    /// The same less the time in which the window's 16 frames came.
    pub behind_window_s: f64,
}

/// Runs the blob in a file on the payloads in another, a frame every 1/60 s, until the first estimate that tracks.
///
/// # Errors
/// When a file cannot be read, the blob is refused, or no estimate came.
pub fn serve(blob: &Path, payloads: &Path, started: Instant) -> io::Result<Needs> {
    let other = |error: &dyn std::fmt::Display| io::Error::other(error.to_string());
    let bytes = AlignedBytes::read(blob).map_err(|error| other(&error))?;
    let model = Model::load(&bytes).map_err(|error| other(&error))?;
    let header = &model.header;
    let settings = Settings::for_glass(header.radius_m, header.fill_m, header.rim_m);
    let config = Config::new(settings).map_err(|error| other(&error))?;
    let (width, height) = config.image_size();
    let (mut depth, mut infrared) = (vec![0; 2 * width * height], vec![0; width * height]);
    let mut field = vec![0.0; model.field_len()];
    let sensor = ProfileSensor::new(config, &mut depth, &mut infrared);
    let mut tracker = Tracker::new(Estimator::new(&model), sensor);
    let mut clock = Monotonic::start();
    let mut file = BufReader::new(File::open(payloads)?);
    let mut payload = Vec::new();
    let (mut turns, mut first_turn) = (0_u32, None);
    let (mut head, mut done) = ([0; 5], None);
    while done.is_none() && file.read_exact(&mut head).is_ok() {
        let [stream, length @ ..] = head;
        payload.resize(u32::from_le_bytes(length) as usize, 0);
        file.read_exact(&mut payload)?;
        let stream = if stream == 1 { Stream::Outline } else { Stream::Depth };
        let mut turned = false;
        tracker.accept(stream, &payload, InputSource::tracked, &mut clock, &mut field, |turn, _| {
            turned = true;
            if turn.estimate.mode == Mode::Tracking {
                done = Some(Instant::now());
            }
        });
        if turned {
            turns += 1;
            let first = *first_turn.get_or_insert_with(Instant::now);
            let due = first + Duration::from_secs_f64(f64::from(turns) / RATE_HZ);
            std::thread::sleep(due.saturating_duration_since(Instant::now()));
        }
    }
    let done = done.ok_or_else(|| io::Error::other("the payloads ended before an estimate came"))?;
    let first_estimate_s = done.duration_since(started).as_secs_f64();
    let window_s = f64::from(turns.saturating_sub(1)) / RATE_HZ;
    Ok(Needs {
        resident_mib: resident_mib()?,
        first_estimate_s,
        behind_window_s: first_estimate_s - window_s,
    })
}

/// Most memory of this process that was resident, MiB, as the kernel tells.
fn resident_mib() -> io::Result<f64> {
    let status = std::fs::read_to_string("/proc/self/status")?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    let number = line.and_then(|line| line.split_whitespace().next()).and_then(|kib| kib.parse::<f64>().ok());
    number
        .map(|kib| kib / 1024.0)
        .ok_or_else(|| io::Error::other("the kernel does not tell the memory's peak"))
}
