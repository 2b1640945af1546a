//! Small recordings, made without the reader's code.

use image::{ExtendedColorType, ImageEncoder, codecs::png::PngEncoder};
use meniscus::units::Micros;
use meniscus::usb::frame::Stamp;
use meniscus::usb::uvc::Stream;
use meniscus_bags::{Calibration, Image};
use meniscus_usb::camera::OutlineImage;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};

const SIZE: (u32, u32) = (64, 48);

/// A folder that goes with its test.
pub(crate) struct Fold(pub(crate) PathBuf);

impl Drop for Fold {
    fn drop(&mut self) {
        let _gone = std::fs::remove_dir_all(&self.0);
    }
}

pub(crate) fn scratch(name: &str) -> Fold {
    // Two tests of a program may take the same name at the same time.
    static COUNT: AtomicUsize = AtomicUsize::new(0);
    let number = COUNT.fetch_add(1, Ordering::Relaxed);
    let folder = std::env::temp_dir().join(format!("meniscus-bag-{name}-{}-{number}", std::process::id()));
    let _gone = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).expect("a temporary folder");
    Fold(folder)
}

pub(crate) fn calibration() -> Calibration {
    Calibration {
        size: SIZE,
        focal_px: [38.4, 38.5],
        centre_px: [31.9, 23.6],
        depth_unit_m: 1e-4,
        baseline_m: 0.05,
        camera: "a test".into(),
        outline: OutlineImage::Infrared,
        depth_lens_m: [0.0; 3],
    }
}

/// Depth and infrared in turn; noisy, so that a chunk holds few of them.
pub(crate) fn images(count: usize) -> Vec<Image> {
    let image = |index: usize| {
        let shot = (index / 2) as u32;
        let stream = if index.is_multiple_of(2) { Stream::Depth } else { Stream::Outline };
        let bytes = 64 * 48 * if index.is_multiple_of(2) { 2 } else { 1 };
        let mut random = index as u32 + 1;
        let noise = |_| {
            random = random.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (random >> 24) as u8
        };
        let captured = Micros(1_000_000 + u64::from(shot) * 16_000);
        Image {
            stream,
            stamp: Stamp { sequence: 100 + shot, captured },
            pixels: (0..bytes).map(noise).collect(),
        }
    };
    (0..count).map(image).collect()
}

fn text(bytes: &[u8]) -> Vec<u8> {
    [&(bytes.len() as u32).to_le_bytes()[..], bytes].concat()
}

/// A record of a ROS 1 bag.
fn record(fields: &[(&str, &[u8])], data: &[u8]) -> Vec<u8> {
    let head: Vec<u8> =
        fields.iter().flat_map(|(name, value)| text(&[name.as_bytes(), b"=", value].concat())).collect();
    [text(&head), text(data)].concat()
}

fn header(stamp: &Stamp) -> Vec<u8> {
    let us = stamp.captured.0;
    let (seconds, nanos) = ((us / 1_000_000) as u32, (us % 1_000_000) as u32 * 1000);
    [stamp.sequence.to_le_bytes(), seconds.to_le_bytes(), nanos.to_le_bytes(), [0; 4]].concat()
}

/// A ROS 1 bag: one chunk for the camera, one for each pair of images.
pub(crate) fn ros1(images: &[Image], compress: bool) -> Vec<u8> {
    let topics = [
        "/device_0/sensor_0/Depth_0/image/data",
        "/device_0/sensor_0/Infrared_1/image/data",
        "/device_0/sensor_0/Depth_0/info/camera_info",
        "/device_0/sensor_0/option/Depth_Units/value",
        "/device_0/sensor_0/Depth_0/tf/1",
    ];
    let id = |topic: usize| (topic as u32).to_le_bytes();
    let message =
        |topic: usize, data: &[u8]| record(&[("op", &[2]), ("conn", &id(topic)), ("time", &[0; 8])], data);
    let chunk = |records: &[u8]| {
        let size = (records.len() as u32).to_le_bytes();
        if !compress {
            return record(&[("op", &[5]), ("compression", b"none"), ("size", &size)], records);
        }
        let mut encoder = lz4_flex::frame::FrameEncoder::new(Vec::new());
        encoder.write_all(records).expect("memory");
        let packed = encoder.finish().expect("memory");
        record(&[("op", &[5]), ("compression", b"lz4"), ("size", &size)], &packed)
    };
    let mut bag = b"#ROSBAG V2.0\n".to_vec();
    bag.extend(record(
        &[("op", &[3]), ("index_pos", &[0; 8]), ("conn_count", &id(5)), ("chunk_count", &id(0))],
        &[b' '; 4027],
    ));
    let mut first: Vec<u8> = topics
        .iter()
        .enumerate()
        .flat_map(|(i, name)| {
            record(&[("op", &[7]), ("conn", &id(i)), ("topic", name.as_bytes())], &text(b"type=x"))
        })
        .collect();
    let k = [38.4_f32, 0.0, 31.9, 0.0, 38.5, 23.6, 0.0, 0.0, 1.0];
    let camera = [
        vec![0; 16],
        SIZE.1.to_le_bytes().to_vec(),
        SIZE.0.to_le_bytes().to_vec(),
        text(b"Brown Conrady"),
        5_u32.to_le_bytes().to_vec(),
        vec![0; 40],
        k.iter().flat_map(|value| f64::from(*value).to_le_bytes()).collect(),
        vec![0; 21 * 8 + 25],
    ];
    first.extend(message(2, &camera.concat()));
    first.extend(message(3, &1e-4_f32.to_le_bytes()));
    first.extend(message(4, &[0; 56]));
    bag.extend(chunk(&first));
    for pair in images.chunks(2) {
        let records: Vec<u8> = pair
            .iter()
            .flat_map(|image| {
                let infrared = image.stream == Stream::Outline;
                let (encoding, step): (&[u8], _) =
                    if infrared { (b"mono8", SIZE.0) } else { (b"mono16", 2 * SIZE.0) };
                let parts = [
                    header(&image.stamp),
                    SIZE.1.to_le_bytes().to_vec(),
                    SIZE.0.to_le_bytes().to_vec(),
                    text(encoding),
                    vec![0],
                    step.to_le_bytes().to_vec(),
                    text(&image.pixels),
                ];
                message(usize::from(infrared), &parts.concat())
            })
            .collect();
        bag.extend(chunk(&records));
    }
    bag
}

/// CDR: little-endian, texts with their zero, numbers at multiples of four.
struct Cdr(Vec<u8>);

impl Cdr {
    fn new() -> Self {
        Self(vec![0, 1, 0, 0])
    }

    fn number(mut self, value: u32) -> Self {
        self.0.resize(self.0.len().next_multiple_of(4), 0);
        self.0.extend(value.to_le_bytes());
        self
    }

    fn bytes(self, bytes: &[u8]) -> Self {
        let mut longer = self.number(bytes.len() as u32);
        longer.0.extend(bytes);
        longer
    }

    fn text(self, text: &str) -> Self {
        self.bytes(&[text.as_bytes(), &[0]].concat())
    }
}

/// A ROS 2 bag.
pub(crate) fn db3(path: &Path, images: &[Image]) {
    let bag = rusqlite::Connection::open(path).expect("a database");
    bag.execute_batch(
        "BEGIN; CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT NOT NULL, type TEXT NOT NULL,
           serialization_format TEXT NOT NULL, offered_qos_profiles TEXT NOT NULL);
         CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER NOT NULL, timestamp INTEGER NOT NULL,
           data BLOB NOT NULL);",
    )
    .expect("tables");
    let topics = [
        "/device_0/sensor_0/Depth_0/camera_info",
        "/device_0/sensor_0/option/Depth_Units/value",
        "/device_0/sensor_0/option/Stereo_Baseline/value",
        "/device_0/sensor_0/Depth_0/image/data/compressedDepth",
        "/device_0/sensor_0/Depth_0/image/metadata",
        "/device_0/sensor_0/Infrared_1/image/data/compressed",
        "/device_0/sensor_0/Infrared_1/image/metadata",
    ];
    for (id, name) in topics.iter().enumerate() {
        let sql = "INSERT INTO topics VALUES (?1, ?2, 'x', 'cdr', '')";
        bag.execute(sql, (id as i64, name)).expect("a topic");
    }
    let put = |topic: usize, message: Cdr| {
        let sql = "INSERT INTO messages(topic_id, timestamp, data) VALUES (?1, 0, ?2)";
        bag.execute(sql, (topic as i64, message.0)).expect("a message");
    };
    let camera = "width=64;height=48;fx=38.4;ppx=31.9;fy=38.5;ppy=23.6;model=Brown Conrady;coeffs=0,0,0,0,0";
    put(0, Cdr::new().text(camera));
    put(1, Cdr::new().text("0.000100"));
    put(2, Cdr::new().text("50.000000"));
    for image in images {
        let infrared = image.stream == Stream::Outline;
        let mut png = Vec::new();
        let (pixels, kind) = if infrared {
            (image.pixels.clone(), ExtendedColorType::L8)
        } else {
            png.extend([0; 12]);
            let own = image.pixels.as_chunks().0.iter().flat_map(|z| u16::from_le_bytes(*z).to_ne_bytes());
            (own.collect(), ExtendedColorType::L16)
        };
        PngEncoder::new(&mut png).write_image(&pixels, SIZE.0, SIZE.1, kind).expect("a PNG");
        let message =
            Cdr::new().number(0).number(1172).text("Depth").text("16UC1; compressedDepth png").bytes(&png);
        put(if infrared { 5 } else { 3 }, message);
        let (number, millis) = (image.stamp.sequence, image.stamp.captured.0 as f64 * 1e-3);
        let metadata =
            format!("Frame number={number};timestamp_domain=Hardware Clock;timestamp={millis:.6};");
        put(if infrared { 6 } else { 4 }, Cdr::new().text(&metadata));
    }
    bag.execute_batch("COMMIT").expect("written");
}
