//! A rendered webcam before the shipped recording, in virtual time.

use image::ExtendedColorType;
use image::codecs::jpeg::JpegEncoder;
use meniscus::surface::{Intrinsics, Settings};
use meniscus_data::recording::Recording;
use meniscus_virtual::render::{Images, Liquid, Scene, SceneSettings};
use meniscus_webcam::{Mode, Offers, PixelFormat, RatePriority, Video, VideoError, VideoFrame};
use std::path::Path;
use std::time::Duration;

/// Frames of the shipped recording that are shown: eight seconds.
pub(crate) const SHOWN: usize = 480;
/// Rate of the recording, Hz.
pub(crate) const RECORDED_HZ: u32 = 60;
/// Driver's time of the first frame, microseconds: the clock of a machine that has been up for two hours, past the
/// rollover of 32 bits.
pub(crate) const FIRST_US: u64 = 7_200_000_000;

pub(crate) fn recording() -> Recording {
    let path = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../recordings/glycerine-unseen.safetensors"));
    Recording::load(path).expect("the shipped recording")
}

pub(crate) const fn mode(format: PixelFormat, size: [u16; 2], hz: u32) -> Mode {
    Mode { format, size, interval: [1, hz] }
}

pub(crate) const USUAL: Mode = mode(PixelFormat::Yuyv, [640, 480], 30);

/// Troubles of a rendered webcam.
#[derive(Clone, Debug, Default)]
pub(crate) struct Troubles {
    /// Numbers of frames that the driver never hands on.
    pub(crate) lost: Vec<u32>,
    /// Numbers of frames that it calls damaged.
    pub(crate) damaged: Vec<u32>,
    /// It is unplugged after so many frames, and for so long.
    pub(crate) unplugged: Option<(u32, Duration)>,
    /// It is another camera after it was unplugged.
    pub(crate) replaced: bool,
    /// Every second frame is missing from this number on, and the numbers go on by one: a rate that falls in the dark.
    pub(crate) dark_from: Option<u32>,
}

/// A webcam before the shipped recording.
pub(crate) struct Rendered {
    pub(crate) recording: Recording,
    pub(crate) scene: Scene,
    pub(crate) images: Images,
    pub(crate) offers: Offers,
    pub(crate) mode: Mode,
    pub(crate) troubles: Troubles,
    pub(crate) rests: bool,
    pub(crate) now: Duration,
    /// When it was last started, number of the next frame, frames of the recording before the start.
    pub(crate) shown: u32,
    pub(crate) sequence: u32,
    pub(crate) next_at: Duration,
    pub(crate) back_at: Option<Duration>,
    pub(crate) open: bool,
    pub(crate) bytes: Vec<u8>,
}

/// Bytes behind each row of YUYV, as some drivers have them.
pub(crate) const ROW_GAP: usize = 32;

impl Rendered {
    pub(crate) fn new(mode: Mode, focal_px: f32, place: Settings, troubles: Troubles) -> Self {
        let recording = recording();
        let [width, height] = mode.size.map(usize::from);
        let middle = |pixels: usize| 0.5 * (pixels as f32 - 1.0);
        let (ppx, ppy) = (middle(width), middle(height));
        let intrinsics = Intrinsics { width, height, fx: focal_px, fy: focal_px, ppx, ppy };
        // In the light of the room, without a projector.
        let settings = SceneSettings {
            dots: 0.0,
            camera: Settings { intrinsics, ..place },
            ..SceneSettings::of(&recording.glass)
        };
        Self {
            recording,
            scene: Scene::new(settings),
            images: Images::new(&settings),
            offers: Offers { formats: vec![mode.format.code()], modes: vec![mode] },
            mode,
            troubles,
            rests: false,
            now: Duration::ZERO,
            shown: 0,
            sequence: 0,
            next_at: Duration::ZERO,
            back_at: None,
            open: false,
            bytes: Vec::new(),
        }
    }

    pub(crate) fn resting(self) -> Self {
        Self { rests: true, ..self }
    }

    pub(crate) fn interval(&self) -> Duration {
        Duration::from_secs_f64(1.0 / self.mode.rate_hz())
    }

    /// Renders the next frame of the recording as the wire has it.
    pub(crate) fn render(&mut self) {
        let step = RECORDED_HZ / self.mode.interval[1];
        let frame = if self.rests { 0 } else { (self.shown * step) as usize % self.recording.frames() };
        self.scene.render(&Liquid::of(&self.recording, frame), self.shown.into(), &mut self.images);
        let [width, height] = self.mode.size;
        self.bytes.clear();
        match self.mode.format {
            PixelFormat::Yuyv => {
                for row in self.images.infrared.chunks_exact(width.into()) {
                    self.bytes.extend(row.iter().flat_map(|luma| [*luma, 118]));
                    self.bytes.resize(self.bytes.len() + ROW_GAP, 0xee);
                }
            }
            PixelFormat::Mjpg => {
                let mut encoder = JpegEncoder::new_with_quality(&mut self.bytes, 85);
                let coloured: Vec<u8> = self.images.infrared.iter().flat_map(|luma| [*luma; 3]).collect();
                encoder
                    .encode(&coloured, width.into(), height.into(), ExtendedColorType::Rgb8)
                    .expect("encoded");
            }
        }
    }
}

impl Video for Rendered {
    fn open(&mut self) -> Result<String, VideoError> {
        if self.back_at.is_some_and(|back| self.now < back) {
            return Err(VideoError::NotThere);
        }
        self.open = true;
        let other = self.troubles.replaced && self.back_at.is_some();
        Ok(if other { "Another Webcam" } else { "Rendered Webcam" }.into())
    }

    fn offers(&mut self) -> Result<Offers, VideoError> {
        Ok(self.offers.clone())
    }

    fn set(&mut self, mode: Mode) -> Result<Result<Mode, [u8; 4]>, VideoError> {
        Ok(Ok(mode))
    }

    fn hold_rate(&mut self) -> RatePriority {
        if self.troubles.dark_from.is_some() { RatePriority::MayFall } else { RatePriority::Held }
    }

    fn start(&mut self) -> Result<(), VideoError> {
        assert!(self.open);
        self.sequence = 0;
        self.next_at = self.now + self.interval();
        Ok(())
    }

    fn next(&mut self, limit: Duration) -> Result<Option<VideoFrame<'_>>, VideoError> {
        if self.back_at.is_none() && self.troubles.unplugged.is_some_and(|(after, _)| self.shown >= after) {
            self.back_at = self.troubles.unplugged.map(|(_, time)| self.now + time);
            self.open = false;
        }
        if !self.open {
            return Err(VideoError::Gone);
        }
        if self.next_at > self.now + limit {
            self.now += limit;
            return Ok(None);
        }
        self.now = self.now.max(self.next_at);
        self.render();
        let (sequence, shown) = (self.sequence, self.shown);
        let since_us = u64::from(shown) * 1_000_000 / u64::from(self.mode.interval[1]);
        let dark = self.troubles.dark_from.is_some_and(|from| shown >= from);
        let step = if dark { 2 } else { 1 };
        self.shown += step;
        self.sequence += 1;
        self.next_at += step * self.interval();
        if self.troubles.lost.contains(&sequence) {
            return Ok(None);
        }
        Ok(Some(VideoFrame {
            bytes: &self.bytes,
            bytes_per_row: 2 * usize::from(self.mode.size[0]) + ROW_GAP,
            captured_us: FIRST_US + since_us,
            sequence,
            damaged: self.troubles.damaged.contains(&sequence),
        }))
    }

    fn stop(&mut self) {}

    fn close(&mut self) {
        self.open = false;
    }

    fn now(&self) -> Duration {
        self.now
    }

    fn pause(&mut self, time: Duration) {
        self.now += time;
    }
}
