//! A folder of images: what `meniscus simulate --camera` writes, with the camera in `camera.json`.
//!
//! `frames.csv` has the columns `frame,time_s,depth,infrared`: a number, seconds, and the names of two PNG
//! files beside it, depth with 16 bits a pixel and infrared with 8. A folder without `camera.json` is one of
//! the simulated camera.

use super::{BagError, Calibration, Image, Recording};
use image::codecs::png::{PngDecoder, PngEncoder};
use image::{ColorType, ExtendedColorType, ImageDecoder, ImageEncoder, ImageError};
use meniscus::units::Micros;
use meniscus::usb::frame::Stamp;
use meniscus::usb::uvc::Stream;
use meniscus_platform::files::write_whole;
use std::fmt::Write;
use std::io::Cursor;
use std::path::{Path, PathBuf};

const TABLE: &str = "frames.csv";
const CAMERA: &str = "camera.json";
const HEADING: &str = "frame,time_s,depth,infrared";

/// Opens a folder; its table is read whole, its images one by one.
pub(super) fn open(folder: &Path) -> Result<Recording, BagError> {
    let table = folder.join(TABLE);
    let text = std::fs::read_to_string(&table).map_err(|cause| BagError::Io {
        path: table.clone(),
        doing: "read",
        cause,
    })?;
    let camera = folder.join(CAMERA);
    let calibration = match std::fs::read(&camera) {
        Ok(bytes) => serde_json::from_slice(&bytes)
            .ok()
            .filter(Calibration::is_sound)
            .ok_or_else(|| BagError::Damaged { path: camera, why: "its camera cannot be".into() })?,
        Err(_) => Calibration::simulated(),
    };
    let files = rows(&text).map_err(|why| BagError::Damaged { path: table, why })?;
    let (folder, size) = (folder.to_owned(), calibration.size);
    let images = files.into_iter().map(move |(stream, stamp, name)| {
        let path = folder.join(name);
        let bytes = std::fs::read(&path).map_err(|cause| BagError::Io {
            path: path.clone(),
            doing: "read",
            cause,
        })?;
        let pixels = png(&bytes, stream, size).map_err(|why| BagError::Damaged { path, why })?;
        Ok(Image { stream, stamp, pixels })
    });
    Ok(Recording { calibration, images: Box::new(images) })
}

/// Lines of the table, two images each; a file outside of the folder is refused.
fn rows(text: &str) -> Result<Vec<(Stream, Stamp, PathBuf)>, String> {
    let mut files = Vec::new();
    let mut last = None;
    for (line, content) in text.lines().enumerate().map(|(i, l)| (i + 1, l.trim())) {
        if content.is_empty() || (line == 1 && content == HEADING) {
            continue;
        }
        let wrong = |why: &str| format!("line {line}: {why}: '{content}'");
        let fields: Vec<&str> = content.split(',').map(str::trim).collect();
        let [frame, time_s, depth, infrared] = fields[..] else {
            return Err(wrong("expected 'frame, seconds, depth file, infrared file'"));
        };
        let sequence = frame.parse().map_err(|_| wrong("the frame is no number"))?;
        let time_s: f64 = time_s.parse().map_err(|_| wrong("the time is no number"))?;
        if !(0.0..1e9).contains(&time_s) {
            return Err(wrong("the time must be finite and not negative"));
        }
        if last.is_some_and(|last| time_s <= last) {
            return Err(wrong("the time does not come after the one before"));
        }
        last = Some(time_s);
        let stamp = Stamp { sequence, captured: Micros((time_s * 1e6).round() as u64) };
        for (stream, name) in [(Stream::Depth, depth), (Stream::Outline, infrared)] {
            let inside = Path::new(name).file_name().is_some_and(|file| file == name);
            if !inside {
                return Err(wrong("a file must lie in the folder itself"));
            }
            files.push((stream, stamp, name.into()));
        }
    }
    Ok(files)
}

/// Pixels of a PNG: 16 bits as little-endian depth, 8 bits as infrared, of the size that must be.
pub(super) fn png(bytes: &[u8], stream: Stream, size: (u32, u32)) -> Result<Vec<u8>, String> {
    let decoder = PngDecoder::new(Cursor::new(bytes)).map_err(|why| why.to_string())?;
    let wanted = if stream == Stream::Depth { ColorType::L16 } else { ColorType::L8 };
    if (decoder.dimensions(), decoder.color_type()) != (size, wanted) {
        let (has, kind) = (decoder.dimensions(), decoder.color_type());
        return Err(format!("an image of {has:?} {kind:?} instead of {size:?} {wanted:?}"));
    }
    let mut pixels = vec![0; decoder.total_bytes() as usize];
    decoder.read_image(&mut pixels).map_err(|why| why.to_string())?;
    if stream == Stream::Depth {
        // The decoder gives samples of the machine's own order.
        for pixel in pixels.as_chunks_mut().0 {
            *pixel = u16::from_ne_bytes(*pixel).to_le_bytes();
        }
    }
    Ok(pixels)
}

/// Returns `pixels` of an image `size` (width, height) as PNG.
fn encoded(pixels: &[u8], stream: Stream, size: (u32, u32)) -> Result<Vec<u8>, ImageError> {
    let (width, height) = size;
    let mut bytes = Vec::new();
    let encoder = PngEncoder::new(&mut bytes);
    if stream == Stream::Depth {
        let own: Vec<u8> =
            pixels.as_chunks().0.iter().flat_map(|z| u16::from_le_bytes(*z).to_ne_bytes()).collect();
        encoder.write_image(&own, width, height, ExtendedColorType::L16)?;
    } else {
        encoder.write_image(pixels, width, height, ExtendedColorType::L8)?;
    }
    Ok(bytes)
}

/// A folder that grows by pairs; its table is written at the end and after every second of images.
#[derive(Debug)]
pub struct FolderWriter {
    folder: PathBuf,
    calibration: Calibration,
    table: String,
    /// The depth image that waits for its partner.
    depth: Option<Image>,
    /// Time of the first pair, which counts as zero.
    start: Option<Micros>,
    pairs: u64,
}

impl FolderWriter {
    /// Begins a folder.
    ///
    /// # Errors
    /// [`BagError`] when it cannot be written.
    pub fn create(folder: &Path, calibration: &Calibration) -> Result<Self, BagError> {
        let text = serde_json::to_vec_pretty(calibration).unwrap_or_default();
        let writer = Self {
            folder: folder.into(),
            calibration: calibration.clone(),
            table: format!("{HEADING}\n"),
            depth: None,
            start: None,
            pairs: 0,
        };
        writer.put(CAMERA, &text)?;
        Ok(writer)
    }

    fn put(&self, name: &str, bytes: &[u8]) -> Result<(), BagError> {
        let path = self.folder.join(name);
        write_whole(&path, bytes).map_err(|why| BagError::Stopped {
            path,
            images: 2 * self.pairs,
            why: why.to_string(),
        })
    }

    /// Adds an image; it is written with its partner. One whose partner never comes is left out.
    ///
    /// # Errors
    /// [`BagError::Stopped`]; the pairs before stay.
    pub fn write(&mut self, image: &Image) -> Result<(), BagError> {
        if image.stream == Stream::Depth {
            self.depth = Some(image.clone());
            return Ok(());
        }
        let near = |depth: &Image| depth.stamp.captured.0.abs_diff(image.stamp.captured.0) < 8_000;
        let Some(depth) = self.depth.take().filter(near) else { return Ok(()) };
        let number = self.pairs;
        let names = [format!("depth-{number:04}.png"), format!("infrared-{number:04}.png")];
        for (name, image) in names.iter().zip([&depth, image]) {
            let bytes = encoded(&image.pixels, image.stream, self.calibration.size);
            let path = self.folder.join(name);
            let bytes = bytes.map_err(|why| BagError::Damaged { path, why: why.to_string() })?;
            self.put(name, &bytes)?;
        }
        let start = *self.start.get_or_insert(depth.stamp.captured);
        let time_s = depth.stamp.captured.since(start) as f64 * 1e-6;
        // Writing into a string cannot fail.
        let _ = writeln!(self.table, "{},{time_s:.6},{},{}", depth.stamp.sequence, names[0], names[1]);
        self.pairs += 1;
        if self.pairs.is_multiple_of(60) { self.put(TABLE, self.table.as_bytes()) } else { Ok(()) }
    }

    /// Ends the folder; gives the number of images.
    ///
    /// # Errors
    /// [`BagError::Stopped`].
    pub fn finish(self) -> Result<u64, BagError> {
        self.put(TABLE, self.table.as_bytes())?;
        Ok(2 * self.pairs)
    }
}
