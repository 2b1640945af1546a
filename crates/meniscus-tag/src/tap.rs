//! The thread between camera and worker that looks for the tag in each image of the outline, before the worker has it.

use crate::tracker::{Sighting, TagTracker, Wanted};
use meniscus::surface::{OutlineAssembler, Rectifier, Region};
use meniscus::usb::uvc::{DeviceClock, PayloadHeader, Stream};
use meniscus_platform::realtime::{Priority, become_realtime};
use meniscus_service::commanded_motion::CameraInlet;
use meniscus_usb::link::{Delivery, Tap, WorkerEnd};
use std::time::Instant;

/// Settings of the watch.
#[derive(Debug)]
pub struct TagWatch {
    /// The tag.
    pub wanted: Wanted,
    /// Rectification of the outline's image, where the camera sends it in colour.
    pub rectifier: Option<Rectifier>,
    /// Scheduling of the thread: that of the worker, which waits for it.
    pub priority: Priority,
    /// Where positions go.
    pub inlet: CameraInlet,
}

/// Returns the worker's end behind a thread that looks for the tag.
///
/// # Errors
/// The error of the operating system on the thread.
pub fn watch(end: WorkerEnd, watch: TagWatch) -> std::io::Result<WorkerEnd> {
    end.tapped("tag", move |tap| look_on(&tap, watch))
}

/// Looks for the tag until camera or worker has gone.
fn look_on(tap: &Tap, watch: TagWatch) {
    let TagWatch { wanted, rectifier, priority, mut inlet } = watch;
    if priority == Priority::RealTime {
        // The worker reports a refusal of the same request.
        let _refused = become_realtime();
    }
    // The detector's parallel parts run in this thread: on a busy machine another one would have to be waited for. Where the pool
    // cannot be made, the detector uses the common one.
    let _pool = rayon::ThreadPoolBuilder::new().num_threads(1).use_current_thread().build();
    let mut tracker = match TagTracker::new(wanted) {
        Ok(tracker) => tracker,
        Err(error) => {
            inlet.say(&format!("the tag is not looked for: {error}"));
            while tap.pass(|_| ()) {}
            return;
        }
    };
    let (width, height) = (wanted.lens.width, wanted.lens.height);
    let mut grey = vec![0; width * height];
    let mut colour = vec![0; rectifier.as_ref().map_or(0, Rectifier::colour_bytes)];
    let outline = match rectifier {
        Some(rectifier) => OutlineAssembler::colour(rectifier, &mut colour, &mut grey),
        None => OutlineAssembler::infrared(&mut grey),
    };
    let mut images =
        Images { outline, clock: DeviceClock::default(), region: Region::whole((width, height)) };
    while tap.pass(|delivery| images.take(delivery, &mut tracker, &mut inlet)) {}
}

/// Images of the outline from payloads.
struct Images<'b> {
    outline: OutlineAssembler<'b>,
    clock: DeviceClock,
    region: Region,
}

impl Images<'_> {
    fn take(&mut self, delivery: &Delivery, tracker: &mut TagTracker, inlet: &mut CameraInlet) {
        if delivery.stream == Stream::Depth {
            // Both streams have one clock: it has to be that of the worker, which reads both.
            if let Some(pts) =
                PayloadHeader::split(&delivery.payload).ok().and_then(|(header, _)| header.pts())
            {
                let _time = self.clock.time(pts);
            }
            return;
        }
        let begun = Instant::now();
        let Some(stamp) = self.outline.push(&delivery.payload, self.region, &mut self.clock) else { return };
        match tracker.look(stamp.captured, self.outline.pixels()) {
            Ok(Sighting::Seen { pose, is_first }) => {
                if is_first {
                    inlet.begin_anew();
                }
                let std_m = pose.std_along_m(&inlet.line().into());
                inlet.take(stamp.captured, pose.position_m.into(), std_m);
            }
            Ok(sighting) => inlet.lack(stamp.captured, &sighting.to_string()),
            Err(error) => inlet.lack(stamp.captured, &error.to_string()),
        }
        tracker.took(begun.elapsed());
        inlet.count(tracker.counts());
    }
}
