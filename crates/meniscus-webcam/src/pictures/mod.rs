//! A folder of images with their times in the place of a webcam: what another program or another camera has recorded.
//!
//! The images are handed on at their own pace. Of images that come faster than 62 a second so many are left out that the
//! rest do not.

mod error;
mod times;

use crate::mode::{Mode, PixelFormat};
use crate::video::{Offers, RatePriority, Video, VideoError, VideoFrame};
pub use error::PicturesError;
use image::{ImageReader, Limits};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};
use times::Timed;

/// Shortest time between two images that are handed on, microseconds: the rate that the model takes and an eighth.
const SHORTEST_US: u64 = 14_800;
/// Endings of images.
const ENDINGS: [&str; 3] = ["png", "jpg", "jpeg"];
/// Most bytes of a table, and of an image in memory.
const TABLE_LONGEST: u64 = 32 << 20;
const IMAGE_LONGEST: u64 = 256 << 20;
/// Longest pause between two images, in intervals: a longer one is played as this, and a camera's would be trouble.
const LONGEST_GAP: u32 = 8;

/// Images of a folder.
#[derive(Debug)]
pub struct Pictures {
    folder: PathBuf,
    images: Vec<Timed>,
    size: [u16; 2],
    interval: [u32; 2],
    next: usize,
    /// When the next image is due.
    due: Duration,
    yuyv: Vec<u8>,
    started: Instant,
}

/// Whether a folder has images, and is of no other kind of recording.
#[must_use]
pub fn holds_pictures(folder: &Path) -> bool {
    let other = ["frames.csv", "metadata.yaml"].iter().any(|name| folder.join(name).exists());
    !other
        && std::fs::read_dir(folder)
            .is_ok_and(|entries| entries.flatten().any(|entry| is_image(&entry.path())))
}

fn is_image(path: &Path) -> bool {
    let ending = path.extension().and_then(|ending| ending.to_str()).map(str::to_lowercase);
    ending.is_some_and(|ending| ENDINGS.contains(&&*ending))
}

impl Pictures {
    /// Opens a folder and reads all of its times.
    ///
    /// # Errors
    /// [`PicturesError`], which names the file and what is wrong with it.
    pub fn open(folder: &Path) -> Result<Self, PicturesError> {
        let failed = |error| PicturesError::Read(folder.into(), error);
        let entries = std::fs::read_dir(folder).map_err(failed)?;
        let mut all: Vec<PathBuf> = entries.flatten().map(|entry| entry.path()).collect();
        all.sort();
        let is_table = |path: &&PathBuf| path.extension().is_some_and(|ending| ending == "csv");
        let tables: Vec<&PathBuf> = all.iter().filter(is_table).collect();
        let files: Vec<PathBuf> = all.iter().filter(|path| is_image(path)).cloned().collect();
        if files.len() < 2 {
            return Err(PicturesError::NoImages(folder.into()));
        }
        let images = match tables[..] {
            [] => by_names(folder, files)?,
            [table] => times::in_table(table, &text(table)?, &files)?,
            _ => return Err(PicturesError::Tables(folder.into())),
        };
        for pair in images.windows(2) {
            if let [before, after] = pair
                && after.us <= before.us
            {
                let seconds = |timed: &Timed| timed.us as f64 * 1e-6;
                let (time_s, before_s) = (seconds(after), seconds(before));
                return Err(PicturesError::NotRising { file: after.file.clone(), time_s, before_s });
            }
        }
        let images = thinned(images);
        let (width, height) = reader(&images[0].file)?
            .into_dimensions()
            .map_err(|why| PicturesError::Image(images[0].file.clone(), why.to_string()))?;
        let narrow =
            |pixels: u32| u16::try_from(pixels).map_err(|_| PicturesError::Size(images[0].file.clone()));
        let size = [narrow(width)?, narrow(height)?];
        Ok(Self {
            folder: folder.into(),
            interval: [u32::try_from(median_us(&images)).unwrap_or(u32::MAX), 1_000_000],
            images,
            size,
            next: 0,
            due: Duration::ZERO,
            yuyv: Vec::new(),
            started: Instant::now(),
        })
    }

    /// Number of images.
    #[must_use]
    pub fn count(&self) -> usize {
        self.images.len()
    }

    /// Decodes an image to its luma, with even colours between.
    fn decode(&mut self, file: &Path) -> Result<(), PicturesError> {
        let decoded = reader(file)?.decode();
        let luma = decoded.map_err(|why| PicturesError::Image(file.into(), why.to_string()))?.into_luma8();
        if (luma.width(), luma.height()) != (self.size[0].into(), self.size[1].into()) {
            return Err(PicturesError::Size(file.into()));
        }
        self.yuyv.clear();
        self.yuyv.extend(luma.as_raw().iter().flat_map(|luma| [*luma, 128]));
        Ok(())
    }
}

fn reader(file: &Path) -> Result<ImageReader<std::io::BufReader<std::fs::File>>, PicturesError> {
    let opened = ImageReader::open(file).and_then(ImageReader::with_guessed_format);
    let mut reader = opened.map_err(|error| PicturesError::Read(file.into(), error))?;
    let mut limits = Limits::default();
    limits.max_alloc = Some(IMAGE_LONGEST);
    reader.limits(limits);
    Ok(reader)
}

fn text(table: &Path) -> Result<String, PicturesError> {
    let failed = |error| PicturesError::Read(table.into(), error);
    let bytes = meniscus_platform::files::read_regular(
        table,
        TABLE_LONGEST,
        meniscus_platform::files::Links::Followed,
    );
    let no_text = |_| std::io::Error::new(std::io::ErrorKind::InvalidData, "it is no text");
    String::from_utf8(bytes.map_err(failed)?).map_err(no_text).map_err(failed)
}

/// Images in the order of the times in their names.
fn by_names(folder: &Path, files: Vec<PathBuf>) -> Result<Vec<Timed>, PicturesError> {
    let mut images = Vec::with_capacity(files.len());
    for file in files {
        let Some(us) = times::in_name(&file) else {
            let name = file.file_name().unwrap_or_default().to_string_lossy();
            let example = name.chars().filter(|sign| !sign.is_control()).collect();
            return Err(PicturesError::NoTimes { folder: folder.into(), example });
        };
        images.push(Timed { file, us });
    }
    // Names sort as text: 10.5 before 9.5.
    images.sort_by_key(|image| image.us);
    Ok(images)
}

/// Leaves out images that follow the one before too soon.
fn thinned(images: Vec<Timed>) -> Vec<Timed> {
    let mut kept: Vec<Timed> = Vec::with_capacity(images.len());
    for image in images {
        if kept.last().is_none_or(|last| image.us - last.us >= SHORTEST_US) {
            kept.push(image);
        }
    }
    kept
}

/// Median time from image to image, microseconds.
fn median_us(images: &[Timed]) -> u64 {
    let mut gaps: Vec<u64> = images.windows(2).map(|pair| pair[1].us - pair[0].us).collect();
    gaps.sort_unstable();
    gaps.get(gaps.len() / 2).copied().unwrap_or(u64::MAX)
}

impl Video for Pictures {
    fn open(&mut self) -> Result<String, VideoError> {
        Ok(format!("{} images", self.images.len()))
    }

    fn offers(&mut self) -> Result<Offers, VideoError> {
        let format = PixelFormat::Yuyv;
        let mode = Mode { format, size: self.size, interval: self.interval };
        Ok(Offers { formats: vec![format.code()], modes: vec![mode] })
    }

    fn set(&mut self, mode: Mode) -> Result<Result<Mode, [u8; 4]>, VideoError> {
        Ok(Ok(mode))
    }

    fn hold_rate(&mut self) -> RatePriority {
        RatePriority::Unknown
    }

    fn start(&mut self) -> Result<(), VideoError> {
        self.due = self.now();
        Ok(())
    }

    fn next(&mut self, limit: Duration) -> Result<Option<VideoFrame<'_>>, VideoError> {
        let Some(image) = self.images.get(self.next).cloned() else { return Err(VideoError::Ended) };
        let wait = self.due.saturating_sub(self.now());
        if wait > limit {
            self.pause(limit);
            return Ok(None);
        }
        self.pause(wait);
        let sequence = u32::try_from(self.next).unwrap_or(u32::MAX);
        self.next += 1;
        if let Some(after) = self.images.get(self.next) {
            let longest = LONGEST_GAP * Duration::from_micros(self.interval[0].into());
            self.due += Duration::from_micros(after.us - image.us).min(longest);
        }
        // One that cannot be read is a damaged frame, and is booked as such.
        let damaged = match self.decode(&image.file) {
            Ok(()) => false,
            Err(error) => {
                log::warn!("{}: {error}", self.folder.display());
                true
            }
        };
        let bytes_per_row = 2 * usize::from(self.size[0]);
        Ok(Some(VideoFrame { bytes: &self.yuyv, bytes_per_row, captured_us: image.us, sequence, damaged }))
    }

    fn stop(&mut self) {}

    fn close(&mut self) {}

    fn now(&self) -> Duration {
        self.started.elapsed()
    }

    fn pause(&mut self, time: Duration) {
        std::thread::sleep(time);
    }
}
