//! A folder of images: what `meniscus simulate --camera` writes, with the camera in `camera.json`.
//!
//! `frames.csv` has the columns `frame,time_s,depth,infrared`: a number, seconds, and the names of two PNG
//! files beside it, depth with 16 bits a pixel and infrared with 8. A folder without `camera.json` is one of
//! the simulated camera.

use super::budget::LONGEST;
use super::{BagError, Calibration, Image, Recording};
use image::codecs::png::{PngDecoder, PngEncoder};
use image::{ColorType, ExtendedColorType, ImageDecoder, ImageEncoder, ImageError};
use meniscus::units::Micros;
use meniscus::usb::frame::Stamp;
use meniscus::usb::uvc::Stream;
use meniscus_platform::files::{FolderLock, Links, create_anew, read_regular, write_whole};
use std::fs::File;
use std::io::{Cursor, ErrorKind, Write};
use std::path::{Path, PathBuf};

const TABLE: &str = "frames.csv";
const CAMERA: &str = "camera.json";
const HEADING: &str = "frame,time_s,depth,infrared";
/// Bytes of table and camera at the most, and lines of the table: an hour at 60 Hz has 216,000.
const TABLE_LONGEST: u64 = 32 << 20;
const CAMERA_LONGEST: u64 = 1 << 20;
const LINES_MAX: usize = 300_000;

/// Opens a folder; its table is read whole, its images one by one.
pub(super) fn open(folder: &Path) -> Result<Recording, BagError> {
    let table = folder.join(TABLE);
    let read = |path: &Path, longest| {
        let bytes = read_regular(path, longest, Links::Followed);
        bytes.map_err(|cause| BagError::Io { path: path.into(), doing: "read", cause })
    };
    let text = String::from_utf8(read(&table, TABLE_LONGEST)?)
        .map_err(|_| BagError::Damaged { path: table.clone(), why: "it is no text".into() })?;
    let calibration = match camera(&folder.join(CAMERA)) {
        Err(BagError::Io { cause, .. }) if cause.kind() == ErrorKind::NotFound => Calibration::simulated(),
        read => read?,
    };
    let files = rows(&text).map_err(|why| BagError::Damaged { path: table, why })?;
    let (folder, size) = (folder.to_owned(), calibration.size);
    let images = files.into_iter().map(move |(stream, stamp, name)| {
        let path = folder.join(name);
        let bytes = read(&path, LONGEST as u64)?;
        let pixels = png(&bytes, stream, size).map_err(|why| BagError::Damaged { path, why })?;
        Ok(Image { stream, stamp, pixels })
    });
    Ok(Recording { calibration, images: Box::new(images) })
}

/// Returns the camera in the file at `path`.
pub(super) fn camera(path: &Path) -> Result<Calibration, BagError> {
    let bytes = read_regular(path, CAMERA_LONGEST, Links::Followed);
    let bytes = bytes.map_err(|cause| BagError::Io { path: path.into(), doing: "read", cause })?;
    let read = serde_json::from_slice(&bytes).ok().filter(Calibration::is_sound);
    read.ok_or_else(|| BagError::Damaged { path: path.into(), why: "its camera cannot be".into() })
}

/// Most bytes of the description of a rosbag2.
const METADATA_LONGEST: u64 = 4 << 20;

/// Returns the file of a folder of rosbag2; none where the folder is of another kind.
pub(super) fn rosbag2(folder: &Path) -> Result<Option<PathBuf>, BagError> {
    if !folder.join("metadata.yaml").is_file() || folder.join(TABLE).exists() {
        return Ok(None);
    }
    let described = read_regular(&folder.join("metadata.yaml"), METADATA_LONGEST, Links::Followed);
    let described = String::from_utf8_lossy(&described.unwrap_or_default()).to_lowercase();
    if described.lines().any(|line| line.trim() == "compression_mode: message") {
        let why = "each of its messages is compressed: unpack it by 'ros2 bag convert' without compression";
        return Err(BagError::Topics { path: folder.into(), why: why.into() });
    }
    let listed = std::fs::read_dir(folder);
    let listed = listed.map_err(|cause| BagError::Io { path: folder.into(), doing: "read", cause })?;
    let is_bag = |path: &PathBuf| path.extension().is_some_and(|kind| kind == "mcap" || kind == "db3");
    let mut files: Vec<PathBuf> =
        listed.filter_map(|entry| entry.ok().map(|entry| entry.path())).filter(is_bag).collect();
    files.sort();
    match &files[..] {
        [one] => Ok(Some(one.clone())),
        [] => Err(BagError::Lacks {
            path: folder.into(),
            what: ".mcap or .db3 file: a file that ends in .zstd has to be unpacked by zstd -d",
        }),
        _ => Err(BagError::Topics {
            path: folder.into(),
            why: format!("it is in {} parts: give one of the files, as {}", files.len(), files[0].display()),
        }),
    }
}

/// Lines of the table, two images each; a file outside of the folder is refused.
fn rows(text: &str) -> Result<Vec<(Stream, Stamp, PathBuf)>, String> {
    let mut files = Vec::new();
    let mut last = None;
    // A program that was killed may have left a part of a line: it has no end, and not the last file's whole name.
    let (before, rest) = text.rsplit_once('\n').unwrap_or(("", text));
    let whole = if rest.ends_with(".png") { text } else { before };
    for (line, content) in whole.lines().enumerate().map(|(i, l)| (i + 1, l.trim())) {
        if content.is_empty() || (line == 1 && content == HEADING) {
            continue;
        }
        if line > LINES_MAX {
            return Err(format!("it has more than {LINES_MAX} lines: cut the recording into parts"));
        }
        let wrong = |why: &str| {
            let shown: String = content.chars().take(80).collect();
            format!("line {line}: {why}: '{shown}'")
        };
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
    let mut limits = image::Limits::no_limits();
    limits.max_alloc = Some(LONGEST as u64);
    (limits.max_image_width, limits.max_image_height) = (Some(size.0), Some(size.1));
    let decoder = PngDecoder::with_limits(Cursor::new(bytes), limits).map_err(|why| why.to_string())?;
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

/// A folder that grows by pairs. A pair is in the table as soon as both images are written, so that the folder can be opened
/// at any time: after a full disk, and after a program that was killed.
#[derive(Debug)]
pub struct FolderWriter {
    folder: PathBuf,
    calibration: Calibration,
    table: File,
    /// Bytes of the table that are whole lines.
    table_bytes: u64,
    /// The depth image that waits for its partner.
    depth: Option<Image>,
    /// Time of the first pair, which counts as zero.
    start: Option<Micros>,
    pairs: u64,
    /// Nobody else writes into the folder.
    _alone: FolderLock,
}

impl FolderWriter {
    /// Begins a folder.
    ///
    /// # Errors
    /// [`BagError`] when it cannot be written, or another program writes into it.
    pub fn create(folder: &Path, calibration: &Calibration) -> Result<Self, BagError> {
        let alone = FolderLock::take(folder).map_err(|error| BagError::Io {
            path: error.path,
            doing: error.doing,
            cause: error.cause,
        })?;
        let text = serde_json::to_vec_pretty(calibration).unwrap_or_default();
        let stopped = |path: PathBuf, why: String| BagError::Stopped { path, images: 0, why };
        let camera = folder.join(CAMERA);
        write_whole(&camera, &text).map_err(|why| stopped(camera, why.to_string()))?;
        let path = folder.join(TABLE);
        let table = create_anew(&path).and_then(|mut table| {
            writeln!(table, "{HEADING}")?;
            Ok(table)
        });
        let table = table.map_err(|why| stopped(path, why.to_string()))?;
        Ok(Self {
            folder: folder.into(),
            calibration: calibration.clone(),
            table,
            table_bytes: HEADING.len() as u64 + 1,
            depth: None,
            start: None,
            pairs: 0,
            _alone: alone,
        })
    }

    /// Returns the error of a file of the folder that cannot be written.
    fn stopped(&self, path: PathBuf, why: impl std::fmt::Display) -> BagError {
        BagError::Stopped { path, images: 2 * self.pairs, why: why.to_string() }
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
        let start = *self.start.get_or_insert(depth.stamp.captured);
        let time_s = depth.stamp.captured.since(start) as f64 * 1e-6;
        let line = format!("{},{time_s:.6},{},{}\n", depth.stamp.sequence, names[0], names[1]);
        let written = self.put(&names, [&depth, image]).and_then(|()| self.append(&line));
        if written.is_err() {
            // Half a pair is of no use, and takes room on a full disk; that it cannot be removed adds nothing.
            names.iter().for_each(|name| drop(std::fs::remove_file(self.folder.join(name))));
        }
        written?;
        self.pairs += 1;
        Ok(())
    }

    /// Writes the images of a pair.
    fn put(&self, names: &[String; 2], images: [&Image; 2]) -> Result<(), BagError> {
        for (name, image) in names.iter().zip(images) {
            let path = self.folder.join(name);
            let bytes = encoded(&image.pixels, image.stream, self.calibration.size)
                .map_err(|why| BagError::Damaged { path: path.clone(), why: why.to_string() })?;
            write_whole(&path, &bytes).map_err(|why| self.stopped(path, why))?;
        }
        Ok(())
    }

    /// Adds a line to the table, whole or not at all.
    fn append(&mut self, line: &str) -> Result<(), BagError> {
        if let Err(why) = self.table.write_all(line.as_bytes()) {
            // Cutting off takes no room.
            let _cut = self.table.set_len(self.table_bytes);
            return Err(self.stopped(self.folder.join(TABLE), why));
        }
        self.table_bytes += line.len() as u64;
        Ok(())
    }

    /// Removes what was written, and the folder if nothing else is in it.
    pub fn discard(self) {
        let Self { folder, pairs, table, .. } = self;
        drop(table);
        let names = (0..pairs).flat_map(|n| [format!("depth-{n:04}.png"), format!("infrared-{n:04}.png")]);
        // What cannot be removed stays: there is nobody left who could do more about it.
        for name in names.chain([CAMERA.into(), TABLE.into()]) {
            let _removed = std::fs::remove_file(folder.join(name));
        }
        let _removed = std::fs::remove_dir(folder);
    }

    /// Ends the folder; gives the number of images.
    ///
    /// # Errors
    /// [`BagError::Stopped`].
    pub fn finish(self) -> Result<u64, BagError> {
        self.table.sync_all().map_err(|why| self.stopped(self.folder.join(TABLE), why))?;
        Ok(2 * self.pairs)
    }
}
