//! ROS 2 bags (SQLite) as librealsense 2.59 records them: images as PNG in `sensor_msgs/msg/CompressedImage`,
//! the camera, the depth unit and each frame's number and time as texts of `name=value;`.

use super::budget::{Budget, LONGEST, TIME};
use super::cdr::Fields;
use super::folder::png;
use super::{BagError, Calibration, Image, Recording, image_bytes};
use meniscus::units::Micros;
use meniscus::usb::frame::Stamp;
use meniscus::usb::uvc::Stream;
use meniscus_usb::camera::OutlineImage;
use rusqlite::config::DbConfig;
use rusqlite::limits::Limit;
use rusqlite::{Connection, OpenFlags, OptionalExtension};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

/// Begin of every PNG.
const PNG: &[u8] = b"\x89PNG\r\n\x1a\n";
/// A depth image has twelve bytes before its PNG (`compressedDepth`).
const BEFORE: usize = 12;

/// Topics end so.
const STREAMS: [(&str, Stream); 2] =
    [("/Depth_0/image/", Stream::Depth), ("/Infrared_1/image/", Stream::Outline)];

/// Cost of a row at the least, bytes: each is a query of its own.
const ROW: u64 = 4096;

/// Steps of SQLite's machine between two looks at the clock.
const STEPS: i32 = 10_000;

/// A file of somebody else's, in which nothing runs but the queries here. Its schema is a program that the database would
/// follow: views may recurse for ever, and columns may be made up of what is not in the file.
struct Database {
    connection: Connection,
    /// Instant at which a query is interrupted, microseconds from `begun`.
    until_us: Arc<AtomicU64>,
    begun: Instant,
}

impl Database {
    fn open(path: &Path) -> rusqlite::Result<Self> {
        let mut connection = Connection::open_with_flags(path, OpenFlags::SQLITE_OPEN_READ_ONLY)?;
        for (config, on) in [
            (DbConfig::SQLITE_DBCONFIG_TRUSTED_SCHEMA, false),
            (DbConfig::SQLITE_DBCONFIG_ENABLE_VIEW, false),
            (DbConfig::SQLITE_DBCONFIG_ENABLE_TRIGGER, false),
            (DbConfig::SQLITE_DBCONFIG_DEFENSIVE, true),
        ] {
            connection.set_db_config(config, on)?;
        }
        for (limit, most) in [
            (Limit::SQLITE_LIMIT_LENGTH, LONGEST as i32),
            (Limit::SQLITE_LIMIT_SQL_LENGTH, 100_000),
            (Limit::SQLITE_LIMIT_COLUMN, 100),
            (Limit::SQLITE_LIMIT_ATTACHED, 0),
        ] {
            connection.set_limit(limit, most)?;
        }
        let (until_us, begun) = (Arc::new(AtomicU64::new(u64::MAX)), Instant::now());
        let until = Arc::clone(&until_us);
        let late = move || begun.elapsed().as_micros() as u64 > until.load(Ordering::Relaxed);
        connection.progress_handler(STEPS, Some(late))?;
        Ok(Self { connection, until_us, begun })
    }

    /// Gives queries `time` from now on.
    fn allow(&self, time: Duration) {
        let until = self.begun.elapsed() + time;
        self.until_us.store(until.as_micros() as u64, Ordering::Relaxed);
    }

    /// Whether `messages` and `topics` are tables of the file itself: neither views nor virtual tables, which have no page,
    /// and without columns that are computed.
    fn is_plain(&self) -> rusqlite::Result<bool> {
        let tables = "SELECT count(*) FROM sqlite_schema WHERE name IN ('messages', 'topics') AND type = 'table' \
                      AND rootpage > 0";
        let computed = "SELECT count(*) FROM pragma_table_xinfo(?1) WHERE hidden > 0";
        let count = |sql: &str, name: &[&str]| -> rusqlite::Result<i64> {
            self.connection.query_row(sql, rusqlite::params_from_iter(name), |row| row.get(0))
        };
        Ok(count(tables, &[])? == 2
            && count(computed, &["messages"])? == 0
            && count(computed, &["topics"])? == 0)
    }
}

/// Returns the message of an error of the database.
fn explained(why: &rusqlite::Error) -> String {
    match why.sqlite_error_code() {
        Some(rusqlite::ErrorCode::OperationInterrupted) => {
            format!("it takes longer than {} s to find an image in it", TIME.as_secs())
        }
        Some(rusqlite::ErrorCode::TooBig) => {
            format!("a message in it is longer than {} MiB", LONGEST >> 20)
        }
        _ => why.to_string(),
    }
}

/// Opens a bag.
pub(super) fn open(path: &Path) -> Result<Recording, BagError> {
    let wrong = |why: String| BagError::Damaged { path: path.into(), why };
    let damaged = |why: rusqlite::Error| wrong(explained(&why));
    let database = Database::open(path).map_err(damaged)?;
    database.allow(TIME);
    if !database.is_plain().map_err(damaged)? {
        return Err(wrong("its messages and topics are no plain tables".into()));
    }
    let text = |topic: &str| -> Result<Option<String>, BagError> {
        let sql =
            "SELECT data FROM messages WHERE topic_id IN (SELECT id FROM topics WHERE name LIKE ?1) LIMIT 1";
        let found: Option<Vec<u8>> =
            database.connection.query_row(sql, [topic], |row| row.get(0)).optional().map_err(damaged)?;
        Ok(found.and_then(|data| Fields::cdr(&data)?.text().map(str::to_owned)))
    };
    let camera = text("%/Depth_0/camera_info")?;
    let camera =
        camera.ok_or(BagError::Lacks { path: path.into(), what: "depth camera (Depth_0/camera_info)" })?;
    let number =
        |name: &str| value(&camera, name).and_then(|text| text.parse::<f32>().ok()).unwrap_or(f32::NAN);
    let unit = text("%/option/Depth_Units/value")?.and_then(|text| text.trim().parse().ok());
    let baseline_mm =
        text("%/option/Stereo_Baseline/value")?.and_then(|text| text.trim().parse::<f32>().ok());
    let calibration = Calibration {
        size: (number("width") as u32, number("height") as u32),
        focal_px: [number("fx"), number("fy")],
        centre_px: [number("ppx"), number("ppy")],
        depth_unit_m: unit.unwrap_or(0.001),
        baseline_m: baseline_mm.map_or(0.0, |mm| mm.abs() * 1e-3),
        camera: "librealsense bag".into(),
        outline: OutlineImage::Infrared,
        depth_lens_m: [0.0; 3],
    };
    if !calibration.is_sound() {
        return Err(BagError::Damaged { path: path.into(), why: format!("its camera cannot be: {camera}") });
    }
    let reader = Reader {
        path: path.into(),
        database,
        calibration: calibration.clone(),
        row: i64::MIN,
        budget: Budget::new(),
        held: [None, None],
        images: 0,
        ended: false,
    };
    Ok(Recording { calibration, images: Box::new(reader) })
}

/// The value of `name` in `name=value;name=value`.
fn value<'t>(text: &'t str, name: &str) -> Option<&'t str> {
    text.split(';')
        .filter_map(|pair| pair.split_once('='))
        .find(|(key, _)| *key == name)
        .map(|(_, value)| value)
}

struct Reader {
    path: PathBuf,
    database: Database,
    calibration: Calibration,
    /// The row that was read last.
    row: i64,
    /// Work until the next image.
    budget: Budget,
    /// Images that wait for the text with their number and time, which comes behind them.
    held: [Option<Image>; 2],
    images: u64,
    ended: bool,
}

impl Reader {
    fn damaged(&self, why: impl std::fmt::Display) -> BagError {
        BagError::Damaged { path: self.path.clone(), why: format!("{why}, behind {} images", self.images) }
    }

    /// The next message: its topic and bytes.
    fn message(&mut self) -> Result<Option<(String, Vec<u8>)>, BagError> {
        let sql = "SELECT messages.id, topics.name, data FROM messages JOIN topics ON topics.id = topic_id \
                   WHERE messages.id > ?1 ORDER BY messages.id LIMIT 1";
        let begun = Instant::now();
        self.database.allow(self.budget.time_left());
        let read = self.database.connection.prepare_cached(sql).and_then(|mut statement| {
            let row = |row: &rusqlite::Row<'_>| Ok((row.get(0)?, row.get(1)?, row.get(2)?));
            statement.query_row([self.row], row).optional()
        });
        let found: Option<(i64, String, Vec<u8>)> = read.map_err(|why| self.damaged(explained(&why)))?;
        let Some((row, topic, data)) = found else { return Ok(None) };
        self.budget.take(topic.len() + data.len(), ROW, begun).map_err(|why| self.damaged(why))?;
        // In a damaged file the rows may lead back.
        if row <= self.row {
            return Err(self.damaged("its rows are out of order"));
        }
        self.row = row;
        Ok(Some((topic, data)))
    }

    /// Takes a message; gives an image if one is complete with it.
    fn take(&mut self, topic: &str, data: &[u8]) -> Result<Option<Image>, BagError> {
        let Some((stem, stream)) = STREAMS.into_iter().find(|(stem, _)| topic.contains(stem)) else {
            return Ok(None);
        };
        let place = usize::from(stream == Stream::Outline);
        let kind = topic.split(stem).last().unwrap_or("");
        if kind.starts_with("data") {
            let size = self.calibration.size;
            let image =
                compressed(data, stream, size).ok_or_else(|| self.damaged("an image cannot be decoded"))?;
            if image.pixels.len() != image_bytes(&self.calibration, stream) {
                return Err(self.damaged("an image has another size than its camera"));
            }
            // One whose text never came keeps the time of its message.
            return Ok(self.held[place].replace(image));
        }
        if kind != "metadata" {
            return Ok(None);
        }
        let text = Fields::cdr(data).and_then(|mut fields| fields.text()).unwrap_or("");
        let mut image = self.held[place].take();
        if let Some(image) = &mut image {
            let number = value(text, "Frame number").and_then(|number| number.parse().ok());
            let millis = value(text, "timestamp").and_then(|millis| millis.parse::<f64>().ok());
            image.stamp.sequence = number.unwrap_or(image.stamp.sequence);
            if let Some(millis) = millis.filter(|millis| millis.is_finite() && *millis >= 0.0) {
                image.stamp.captured = Micros((millis * 1e3).round() as u64);
            }
        }
        Ok(image)
    }
}

/// `sensor_msgs/msg/CompressedImage`: stamp, frame, format, bytes.
fn compressed(data: &[u8], stream: Stream, size: (u32, u32)) -> Option<Image> {
    let mut fields = Fields::cdr(data)?;
    let (seconds, nanos) = (fields.u32()?, fields.u32()?);
    let (_frame, _format) = (fields.run()?, fields.run()?);
    let bytes = fields.run()?;
    let bytes = if bytes.starts_with(PNG) { bytes } else { bytes.get(BEFORE..)? };
    let captured = Micros(u64::from(seconds) * 1_000_000 + u64::from(nanos) / 1000);
    Some(Image { stream, stamp: Stamp { sequence: 0, captured }, pixels: png(bytes, stream, size).ok()? })
}

impl Iterator for Reader {
    type Item = Result<Image, BagError>;

    fn next(&mut self) -> Option<Self::Item> {
        while !self.ended {
            let image = match self.message() {
                Ok(Some((topic, data))) => self.take(&topic, &data),
                Ok(None) => {
                    self.ended = true;
                    break;
                }
                Err(error) => Err(error),
            };
            match image {
                Ok(None) => {}
                Ok(Some(image)) => {
                    self.images += 1;
                    self.budget = Budget::new();
                    return Some(Ok(image));
                }
                Err(error) => {
                    self.ended = true;
                    return Some(Err(error));
                }
            }
        }
        self.held.iter_mut().find_map(Option::take).map(Ok)
    }
}
