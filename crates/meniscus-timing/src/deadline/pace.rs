//! A camera of any pace: images that were rendered before, packed and handed over a frame every 1/rate s.

use meniscus::usb::uvc::Stream;
use meniscus_data::recording::Recording;
use meniscus_hil::{Camera, CameraSettings, Shot, Source};
use meniscus_platform::realtime::{Priority, become_realtime};
use meniscus_usb::link::CameraEnd;
use meniscus_virtual::camera::START;
use meniscus_virtual::looped_recording::{BACK, repeated};
use meniscus_virtual::render::{Images, Scene, SceneSettings};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// A round of a recording as images; 0.9 MB each, both streams.
#[derive(Clone, Debug)]
pub struct Film {
    depth: Vec<Vec<u8>>,
    infrared: Vec<Vec<u8>>,
}

/// When the last payload of a frame was due, and when it had been handed over.
#[derive(Clone, Copy, Debug)]
pub struct Handed {
    /// By the pace.
    pub due: Instant,
    /// By the thread that stands for the bus.
    pub sent: Instant,
}

impl Film {
    /// Renders the whole round of `recording` under `scene`; `progress` receives the share that is done
    /// after each image. `None` when `stop` was set.
    ///
    /// # Panics
    /// When the recording has no frame.
    #[must_use]
    pub fn render(
        recording: &Recording,
        scene: SceneSettings,
        stop: &AtomicBool,
        mut progress: impl FnMut(f64),
    ) -> Option<Self> {
        let (mut images, mut scene) = (Images::new(&scene), Scene::new(scene));
        let round = recording.frames() + BACK;
        let mut film = Self { depth: Vec::with_capacity(round), infrared: Vec::with_capacity(round) };
        for shot in 0..round {
            if stop.load(Ordering::Relaxed) {
                return None;
            }
            scene.render(&repeated(recording, shot as u64), shot as u64, &mut images);
            film.depth.push(images.depth.clone());
            film.infrared.push(images.infrared.clone());
            progress((shot + 1) as f64 / round as f64);
        }
        Some(film)
    }

    /// Capture time of `frame` in the film's own time, 60 Hz: what the reader and the model see, at any pace.
    #[must_use]
    pub fn captured_us(frame: usize) -> u64 {
        START.0 + (frame as u64 * 1_000_000 + 30) / 60
    }

    /// The frame that was captured at `captured_us`.
    #[must_use]
    pub fn frame_at(captured_us: u64) -> usize {
        ((captured_us.saturating_sub(START.0) * 60 + 500_000) / 1_000_000) as usize
    }

    /// Plays `frames` frames, round after round, each due 1/rate s after the one before whatever became of that; ends
    /// early when `stop` is set or the worker has gone. Gives when each was due and sent.
    pub fn play(
        &self,
        rate_hz: f64,
        frames: usize,
        priority: Priority,
        end: &CameraEnd,
        stop: &AtomicBool,
    ) -> Vec<Handed> {
        if priority == Priority::RealTime {
            // A refusal is reported by the worker, which asks for the same.
            let _refused = become_realtime();
        }
        let mut camera = Camera::new(CameraSettings::default());
        let mut handed = Vec::with_capacity(frames);
        let begun = Instant::now() + Duration::from_millis(50);
        let images = self.depth.iter().zip(&self.infrared).cycle();
        for (frame, (depth, infrared)) in images.take(frames).enumerate() {
            if stop.load(Ordering::Relaxed) {
                break;
            }
            let payloads = camera.expose(&Shot::infrared(depth, infrared, Self::captured_us(frame)));
            let due = begun + Duration::from_secs_f64(frame as f64 / rate_hz);
            std::thread::sleep(due.saturating_duration_since(Instant::now()));
            for payload in payloads {
                let stream = match payload.stream {
                    meniscus_hil::Stream::Depth => Stream::Depth,
                    meniscus_hil::Stream::Infrared | meniscus_hil::Stream::Colour => Stream::Outline,
                };
                if !end.send(stream, &payload.bytes) {
                    return handed;
                }
            }
            handed.push(Handed { due, sent: Instant::now() });
        }
        handed
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_frame_is_known_by_its_time() {
        assert!((0..100_000).all(|frame| Film::frame_at(Film::captured_us(frame)) == frame));
    }
}
