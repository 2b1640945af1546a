//! Payloads of a film in a file, for the board that has no camera: healthy ones, and some that are damaged.

use super::Failure;
use meniscus_hil::device::{FIRST_SHOT_US, Film, Scenery};
use meniscus_hil::{Camera, CameraSettings, FaultInjector, Shot, Source, Stream};
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::Path;

/// Faults of the wire: a lost, a torn and an erroneous frame, a skipped number, a frame that comes twice.
const FAULTS: &str = "drop@30,tear@40,err@50,gap@55,duplicate@60,length2@65";

/// Writes the payloads of the first `frames` shots: stream and length as little-endian words, then the bytes.
pub(crate) fn write(film: &str, frames: &str, out: &str) -> Result<bool, Failure> {
    let frames: u64 = frames.parse().map_err(|_| format!("{frames}: no number of frames"))?;
    let mut film = Film::open(Path::new(film)).map_err(|error| format!("{film}: {error}"))?;
    let mut camera = FaultInjector::new(Camera::new(CameraSettings::default()), FAULTS.parse()?, 1);
    let beside = format!("{out}.part");
    let mut file = BufWriter::new(File::create(&beside)?);
    for shot in 0..frames {
        let captured_us = FIRST_SHOT_US + (shot * 1_000_000 + 30) / 60;
        let (depth, infrared) = film.look(shot, (640, 480));
        for payload in camera.expose(&Shot::infrared(depth, infrared, captured_us)) {
            let stream = u32::from(payload.stream == Stream::Infrared);
            file.write_all(&stream.to_le_bytes())?;
            file.write_all(&u32::try_from(payload.bytes.len())?.to_le_bytes())?;
            file.write_all(&payload.bytes)?;
        }
    }
    file.flush()?;
    std::fs::rename(&beside, out)?;
    Ok(true)
}
