//! Attacks by files that are made to exhaust memory, time or patience. The generators are here; no bomb is committed.

use crate::meet::{defused, judged, meet, pair};
use crate::support::Scratch;
use std::fs::{self, File};
use std::io::Write;
use std::os::unix::fs::symlink;
use std::path::Path;

fn text(bytes: &[u8]) -> Vec<u8> {
    [&(bytes.len() as u32).to_le_bytes()[..], bytes].concat()
}

/// A record of a ROS 1 bag.
fn record(fields: &[(&str, &[u8])], data: &[u8]) -> Vec<u8> {
    let head: Vec<u8> =
        fields.iter().flat_map(|(name, value)| text(&[name.as_bytes(), b"=", value].concat())).collect();
    [text(&head), text(data)].concat()
}

/// A compressed chunk of a ROS 1 bag.
fn chunk(records: &[u8]) -> Vec<u8> {
    let mut encoder = lz4_flex::frame::FrameEncoder::new(Vec::new());
    encoder.write_all(records).expect("memory");
    let (packed, size) = (encoder.finish().expect("memory"), (records.len() as u32).to_le_bytes());
    record(&[("op", &[5]), ("compression", b"lz4"), ("size", &size)], &packed)
}

fn bag(folder: &Path, chunks: impl Iterator<Item = Vec<u8>>) {
    let mut file = File::create(folder.join("bomb.bag")).expect("a file");
    file.write_all(b"#ROSBAG V2.0\n").expect("written");
    chunks.for_each(|chunk| file.write_all(&chunk).expect("written"));
}

/// A depth image of `side` by `side` zeros as a message of connection 0.
fn depth(side: u32) -> Vec<u8> {
    let pixels = vec![0; 2 * (side * side) as usize];
    let parts: [&[u8]; 6] =
        [&[0; 16], &side.to_le_bytes(), &side.to_le_bytes(), &text(b"mono16"), &[0; 5], &text(&pixels)];
    record(&[("op", &[2]), ("conn", &[0; 4]), ("time", &[0; 8])], &parts.concat())
}

fn depth_topic() -> Vec<u8> {
    let topic: &[u8] = b"/device_0/sensor_0/Depth_0/image/data";
    record(&[("op", &[7]), ("conn", &[0; 4]), ("topic", topic)], &text(b"type=x"))
}

/// A chunk of a PNG: length, kind, data, CRC-32.
fn png_chunk(kind: &[u8; 4], data: &[u8]) -> Vec<u8> {
    let body = [kind.as_slice(), data].concat();
    let crc = crc::Crc::<u32>::new(&crc::CRC_32_ISO_HDLC).checksum(&body);
    [&(data.len() as u32).to_be_bytes()[..], &body, &crc.to_be_bytes()].concat()
}

/// Zeros as zlib's stored and repeated blocks would be large; this is a real deflate stream of the `image` crate's encoder.
fn packed_zeros(side: u32) -> Vec<u8> {
    let mut png = Vec::new();
    let encoder = image::codecs::png::PngEncoder::new(&mut png);
    let pixels = vec![0; (side * side) as usize];
    image::ImageEncoder::write_image(encoder, &pixels, side, side, image::ExtendedColorType::L8)
        .expect("a PNG");
    let at = png.windows(4).position(|part| part == b"IDAT").expect("data");
    let length = u32::from_be_bytes(png[at - 4..at].try_into().expect("four")) as usize;
    png[at + 4..at + 4 + length].to_vec()
}

/// A PNG of this size with `extra` chunks before its data.
fn png(width: u32, height: u32, extra: &[u8], data: &[u8]) -> Vec<u8> {
    let head = [&width.to_be_bytes()[..], &height.to_be_bytes(), &[16, 0, 0, 0, 0]].concat();
    let parts: [&[u8]; 5] = [
        b"\x89PNG\r\n\x1a\n",
        &png_chunk(b"IHDR", &head),
        extra,
        &png_chunk(b"IDAT", data),
        &png_chunk(b"IEND", &[]),
    ];
    parts.concat()
}

/// A ROS 1 bag cannot exhaust memory before it has described its camera.
///
/// 70 LZ4 chunks of one large depth image each, and no camera.
#[test]
fn a_bag_of_images_without_a_camera() {
    defused("images.bag", "has no depth camera", |folder| {
        let image = chunk(&depth(4096));
        bag(folder, std::iter::once(chunk(&depth_topic())).chain((0..70).map(|_| image.clone())));
    });
}

/// A ROS 1 bag cannot exhaust time by records of nothing.
///
/// Chunks of two million empty records each, which compress to a few kilobytes.
#[test]
fn a_bag_of_empty_records() {
    defused("empty.bag", "without an image", |folder| {
        let empty = chunk(&[0; 8].repeat(2_000_000));
        bag(folder, (0..100).map(|_| empty.clone()));
    });
}

/// A ROS 1 bag cannot claim a chunk beyond the limit.
///
/// A chunk whose header says 4 GiB, and one whose data unpack to 400 MiB.
#[test]
fn a_bag_with_a_chunk_that_is_too_long() {
    defused("claim.bag", "has no depth camera", |folder| {
        let zeros = chunk(&vec![0; 400 << 20]);
        let mut claim = zeros.clone();
        let at = claim.windows(5).position(|part| part == b"size=").expect("its size") + 5;
        claim[at..at + 4].fill(0xff);
        bag(folder, [zeros, claim].into_iter());
    });
}

/// A ROS bag of another program cannot exhaust memory or time.
///
/// bzip2 chunks of 400 MiB of zeros and of two million empty records, 70 large depth images without a camera, an image that says
/// 65,000 by 65,000 pixels.
#[test]
fn a_bag_of_another_program() {
    let topic = || {
        let name: &[u8] = b"/cam/depth/image_rect_raw";
        record(&[("op", &[7]), ("conn", &[0; 4]), ("topic", name)], &text(b"type=sensor_msgs/Image"))
    };
    let bzip2 = |records: &[u8]| {
        let mut encoder = bzip2::write::BzEncoder::new(Vec::new(), bzip2::Compression::fast());
        encoder.write_all(records).expect("memory");
        let (packed, size) = (encoder.finish().expect("memory"), (records.len() as u32).to_le_bytes());
        record(&[("op", &[5]), ("compression", b"bz2"), ("size", &size)], &packed)
    };
    defused("zeros.bz2", "has no depth camera", |folder| {
        let zeros = bzip2(&vec![0; 400 << 20]);
        bag(folder, std::iter::once(zeros));
    });
    defused("empty.bz2", "without an image", |folder| {
        let empty = bzip2(&[0; 8].repeat(2_000_000));
        bag(folder, std::iter::once(chunk(&topic())).chain((0..100).map(|_| empty.clone())));
    });
    defused("foreign images", "it has no grey images", |folder| {
        let image = chunk(&depth(4096));
        bag(folder, std::iter::once(chunk(&topic())).chain((0..70).map(|_| image.clone())));
    });
    defused("foreign size", "it has no grey images", |folder| {
        let side = 65_000_u32.to_le_bytes();
        let parts: [&[u8]; 6] = [&[0; 16], &side, &side, &text(b"mono16"), &[0; 5], &text(&[0; 100])];
        let image = record(&[("op", &[2]), ("conn", &[0; 4]), ("time", &[0; 8])], &parts.concat());
        bag(folder, [chunk(&topic()), chunk(&image)].into_iter());
    });
}

/// An MCAP file cannot exhaust time by chunks without an image.
///
/// 3 GiB of zeros on another topic, behind a sound record of a camera.
#[test]
fn an_mcap_of_zeros() {
    defused("zeros.mcap", "without an image", |folder| {
        let calibration =
            meniscus_bags::Calibration::of(&meniscus::surface::Optics::default(), 0.05, "a test");
        let file = File::create(folder.join("bomb.mcap")).expect("a file");
        let options =
            mcap::WriteOptions::new().compression(Some(mcap::Compression::Lz4)).chunk_size(Some(32 << 20));
        let mut writer = options.create(std::io::BufWriter::new(file)).expect("a writer");
        let text = serde_json::to_string(&calibration).expect("JSON");
        let metadata = [("calibration".to_owned(), text)].into();
        writer
            .write_metadata(&mcap::records::Metadata { name: "meniscus.camera".into(), metadata })
            .expect("written");
        let channel = writer.add_channel(0, "/zeros", "x", &Default::default()).expect("a channel");
        let zeros = vec![0; 16 << 20];
        for sequence in 0..192 {
            let header =
                mcap::records::MessageHeader { channel_id: channel, sequence, log_time: 0, publish_time: 0 };
            writer.write_to_known_channel(&header, &zeros).expect("written");
        }
        writer.finish().expect("finished");
    });
}

/// A PNG cannot unpack to more than its camera's image.
///
/// A PNG of 60000 x 60000 points; one of the right size whose data, and one whose colour profile, unpack to much more.
#[test]
fn a_png_that_unpacks_to_more_than_it_says() {
    let zeros = packed_zeros(20_000);
    let profile = png_chunk(b"iCCP", &[b"x\0\0".as_slice(), &zeros].concat());
    let words = png_chunk(b"zTXt", &[b"x\0\0".as_slice(), &zeros].concat());
    for (name, bytes) in [
        ("huge.png", png(60_000, 60_000, &[], &zeros)),
        ("data.png", png(848, 480, &[], &zeros)),
        ("profile.png", png(848, 480, &[profile, words].concat(), &zeros[..100])),
    ] {
        defused(name, "is damaged", |folder| {
            pair(folder, |folder| fs::write(folder.join("depth.png"), &bytes).expect("written"));
        });
    }
}

/// A table of a folder cannot exhaust memory.
///
/// Two million lines.
#[test]
fn a_table_of_too_many_lines() {
    defused("lines.csv", "more than 300000 lines", |folder| {
        fs::create_dir(folder.join("bomb")).expect("a folder");
        let lines: String = (0..2_000_000).map(|line| format!("1,{line},a,b\n")).collect();
        fs::write(folder.join("bomb/frames.csv"), lines).expect("written");
    });
}

/// A recording of the simulator cannot exhaust memory by its header.
///
/// A header of 2^63 bytes, one of 70 MB of JSON, a sparse file of 100 GB, a link to /dev/zero.
#[test]
fn a_recording_with_a_false_header() {
    let start = |length: u64, text: &[u8]| [&length.to_le_bytes()[..], text].concat();
    let many: String = (0..1_000_000)
        .map(|n| format!("\"t{n}\":{{\"dtype\":\"F32\",\"shape\":[0],\"data_offsets\":[0,0]}},"))
        .collect();
    let header = format!("{{{many}\"__metadata__\":{{\"format\":\"meniscus recording 2\"}}}}");
    type Bomb<'b> = (&'b str, Box<dyn Fn(&Path) + 'b>);
    let bombs: [Bomb<'_>; 4] = [
        (
            "length",
            Box::new(|path| {
                fs::write(path, start(1 << 63, b"{\"a\":1} meniscus recording")).expect("written");
            }),
        ),
        (
            "json",
            Box::new(|path| fs::write(path, start(header.len() as u64, header.as_bytes())).expect("written")),
        ),
        (
            "sparse",
            Box::new(|path| {
                fs::write(path, start(20, b"{} meniscus recording")).expect("written");
                let file = File::options().write(true).open(path).expect("a file");
                file.set_len(100 << 30).expect("sparse");
            }),
        ),
        ("zero", Box::new(|path| symlink("/dev/zero", path).expect("a link"))),
    ];
    for (name, make) in bombs {
        let scratch = Scratch::new(&format!("bomb-safetensors-{name}"));
        make(&scratch.0.join("bomb.safetensors"));
        let met = meet(&scratch.0, &["run", "--seconds", "2", "--source", "bomb.safetensors"]);
        judged(&met, &format!("{name}.safetensors"), "bomb.safetensors");
    }
}
