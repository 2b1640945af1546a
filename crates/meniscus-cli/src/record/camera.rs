//! A camera's images into a file.

use super::Arguments;
use super::out::{Came, Out};
use anyhow::Context;
use indicatif::ProgressBar;
use meniscus::surface::{OutlineAssembler, Rectifier, Region};
use meniscus::usb::uvc::{Assembler, AssemblyOutcome, DeviceClock, Stream};
use meniscus_bags::{BagError, Calibration, Image};
use meniscus_usb::camera::{LinkSink, NoteBook, OutlineImage, Session};
use meniscus_usb::link::{Delivery, Received, WorkerEnd, link};
use meniscus_usb::transport::Transport;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// Payload buffers between camera and file: half a second of both streams.
const BUFFERS: usize = 64;

/// Longest time from the start of the streams to the first image.
const PATIENCE: Duration = Duration::from_secs(60);

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

/// Part of a camera's images that is recorded.
struct Wanted<'a> {
    /// Length from the first image on, s.
    seconds: f64,
    beside: OutlineImage,
    /// Set to stop the camera.
    stop: &'a AtomicBool,
}

/// Writes every image until the time is up or the camera has gone. A file that takes no more stops the camera.
fn write_all(
    end: &WorkerEnd,
    reader: &mut ImageReader<'_>,
    out: &mut Out,
    wanted: &Wanted<'_>,
    bar: &ProgressBar,
) -> Result<Came, BagError> {
    let (mut written, mut came, mut first) =
        (Ok(()), Came { beside: wanted.beside, ..Came::default() }, None);
    loop {
        match end.receive(Instant::now() + Duration::from_millis(100)) {
            Received::Closed => return written.map(|()| came),
            Received::Silence => {}
            Received::Payload(delivery) => {
                // The buffers go round even after a failure: a camera that waits for one would not see `stop`.
                if let (Some(image), Ok(())) = (reader.take(&delivery), &written) {
                    let us = image.stamp.captured.0;
                    let passed_s = us.saturating_sub(*first.get_or_insert(us)) as f64 * 1e-6;
                    bar.set_position((1e3 * passed_s) as u64);
                    if passed_s < wanted.seconds {
                        written = out.write(&image);
                        came.count(image.stream);
                    } else {
                        wanted.stop.store(true, Ordering::Relaxed);
                    }
                }
                end.give_back(delivery.payload);
            }
        }
        if written.is_err() {
            wanted.stop.store(true, Ordering::Relaxed);
        }
        bar.set_message((came.depth + came.outline).to_string());
    }
}

/// Records a camera.
pub(super) fn from_camera(
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
    let (stop, notes) = (Arc::new(AtomicBool::new(false)), NoteBook::default());
    let interrupted = Arc::clone(&stop);
    ctrlc::set_handler(move || interrupted.store(true, Ordering::Relaxed))
        .context("cannot watch for Ctrl-C")?;
    // The time counts from the first image; a camera that brings none has the session's own patience.
    let until = Instant::now() + Duration::from_secs_f64(seconds) + PATIENCE;
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
        let written = write_all(&worker_end, &mut reader, &mut out, &Wanted { seconds, beside, stop }, &bar);
        (camera.join(), written)
    });
    bar.finish_and_clear();
    notes.after(0).iter().for_each(|note| println!("camera: {note}"));
    // A file that could not take an image has not room for an index either.
    let came = written?;
    let ended = ended.map_err(|_| anyhow::anyhow!("the camera's thread stopped on an error of its own"))?;
    if came.depth == 0 && came.outline == 0 {
        // The camera's own error says more than that nothing came.
        ended.clone()?;
    }
    let kept = out.finish(came, &arguments.out)?;
    println!(
        "{}: {kept}; lost: {} depth, {} {beside}, {} payloads dropped",
        arguments.out.display(),
        reader.depth.losses().frames(),
        reader.outline.losses().frames(),
        worker_end.dropped()
    );
    Ok(ended?)
}
