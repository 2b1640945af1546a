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

/// Images that were played.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PlayedImages {
    /// Number of images of both streams.
    pub images: u64,
    /// Depth images a second by their own times; `None` of fewer than two.
    pub rate_hz: Option<f64>,
}

/// Plays images up to `seconds` of the recording, until `stop` is set or the worker has gone.
///
/// # Errors
/// [`BagError`] of the recording; what came before it has been played.
pub fn play(
    recording: Recording,
    seconds: f64,
    end: &CameraEnd,
    stop: &AtomicBool,
) -> Result<PlayedImages, BagError> {
    let size = recording.calibration.size;
    let (mut due, mut last_us, mut played) = (Instant::now(), None::<u64>, 0);
    let (mut first_us, mut depths) = (None::<u64>, Depths::default());
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
        if image.stream == Stream::Depth {
            depths.count(us);
        }
        played += 1;
    }
    Ok(PlayedImages { images: played, rate_hz: depths.rate_hz() })
}

/// Times of the depth images.
#[derive(Default)]
struct Depths {
    /// Times of the first and the last, us.
    span: Option<[u64; 2]>,
    number: u32,
}

impl Depths {
    fn count(&mut self, us: u64) {
        let [first, _] = *self.span.get_or_insert([us; 2]);
        self.span = Some([first, us]);
        self.number += 1;
    }

    fn rate_hz(&self) -> Option<f64> {
        let passed_s = self.span.map(|[first, last]| last.saturating_sub(first) as f64 * 1e-6)?;
        (passed_s > 0.0).then(|| f64::from(self.number - 1) / passed_s)
    }
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
