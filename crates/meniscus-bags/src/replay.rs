//! A recording in the camera's place: its images, packed into payloads again, at their own times.
//!
//! Everything behind the link is the real reader. The pace is that of the recorded times; a gap longer than
//! a second is played as one of a second.

use crate::{BagError, Image, Recording};
use meniscus::usb::uvc::Stream;
use meniscus_hil::{Image as Pixels, Stamp, pack};
use meniscus_usb::link::CameraEnd;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// Longest pause between two images.
const LONGEST_GAP: Duration = Duration::from_secs(1);

/// Plays images up to `seconds` of the recording, until `stop` is set or the worker has gone; gives the
/// number of images played.
///
/// # Errors
/// [`BagError`] of the recording; what came before it has been played.
pub fn play(recording: Recording, seconds: f64, end: &CameraEnd, stop: &AtomicBool) -> Result<u64, BagError> {
    let size = recording.calibration.size;
    let (mut due, mut last_us, mut played) = (Instant::now(), None::<u64>, 0);
    let mut first_us = None::<u64>;
    for image in recording.images {
        let image = image?;
        let us = image.stamp.captured.0;
        if us.saturating_sub(*first_us.get_or_insert(us)) as f64 > seconds * 1e6 {
            break;
        }
        let gap = Duration::from_micros(us.saturating_sub(last_us.unwrap_or(us)));
        due += gap.min(LONGEST_GAP);
        last_us = Some(us);
        std::thread::sleep(due.saturating_duration_since(Instant::now()));
        if stop.load(Ordering::Relaxed) || !end.send(image.stream, &payload(&image, size)) {
            break;
        }
        played += 1;
    }
    Ok(played)
}

/// Returns the payload that a camera would have sent for an image of `size` (width, height), its exposure taken as an
/// instant.
#[must_use]
pub fn payload(image: &Image, size: (u32, u32)) -> Vec<u8> {
    let (width, height) = size;
    let (us, counter) = (image.stamp.captured.0, image.stamp.sequence);
    let stamp = Stamp {
        fid: counter % 2 == 1,
        pts_us: us as u32,
        bus_frame: (us / 1000) as u16,
        counter,
        exposure_us: 0,
        interval_us: 16_667,
    };
    let format = u16::from(image.stream == Stream::Outline);
    let pixels = Pixels { pixels: &image.pixels, width: width as u16, height: height as u16, format };
    pack(&stamp, &pixels)
}
