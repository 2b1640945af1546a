//! Camera recordings: round trips, torn files, and bags of librealsense.
//!
//! The bags here are made by small writers of this file, after the formats' descriptions; no file of a
//! physical camera has been read. (Bags that librealsense's own wheels 2.56.5 and 2.59.1 recorded from a
//! software device were read once, bit for bit; they are not kept here.)

mod recordings;

use meniscus::surface::{POINTS, SurfaceProfile};
use meniscus::units::Micros;
use meniscus_bags::{BagError, FolderWriter, Image, McapWriter, open};
use meniscus_data::profiles::{profiles_from_csv, profiles_to_csv};
use recordings::{Fold, calibration, db3, images, ros1, scratch};
use std::fs;

/// Reads a recording to its end: the images, and how it ended.
fn read(path: &std::path::Path) -> Result<(Vec<Image>, Option<BagError>), BagError> {
    let (mut images, mut ended) = (Vec::new(), None);
    for image in open(path)?.images {
        match image {
            Ok(image) => images.push(image),
            Err(error) => ended = Some(error),
        }
    }
    Ok((images, ended))
}

fn mcap(folder: &Fold, count: usize) -> std::path::PathBuf {
    let path = folder.0.join("a.mcap");
    let mut writer = McapWriter::create(&path, &calibration()).expect("a file");
    images(count).iter().for_each(|image| writer.write(image).expect("written"));
    assert_eq!(writer.finish().expect("closed"), count as u64);
    path
}

#[test]
fn mcap_gives_back_what_was_written() {
    let folder = scratch("mcap");
    let path = mcap(&folder, 20);
    assert_eq!(open(&path).expect("readable").calibration, calibration());
    let (found, ended) = read(&path).expect("readable");
    assert!(found == images(20) && ended.is_none());
    // Another reader of MCAP finds the schemas that it knows by name.
    let bytes = fs::read(&path).expect("bytes");
    let messages: Vec<_> =
        mcap::MessageStream::new(&bytes).expect("MCAP").map(|message| message.expect("sound")).collect();
    let schemas: Vec<_> =
        messages.iter().map(|m| m.channel.schema.as_ref().expect("a schema").name.clone()).collect();
    assert_eq!(messages.len(), 21);
    assert_eq!(schemas[..2], ["foxglove.CameraCalibration", "foxglove.RawImage"]);
}

/// Wherever the file ends, what comes out is the beginning of what was written.
#[test]
fn a_torn_mcap_keeps_its_beginning() {
    let folder = scratch("torn");
    let path = mcap(&folder, 40);
    let (whole, bytes) = (images(40), fs::read(&path).expect("bytes"));
    let mut random = 7_u64;
    let mut most = 0;
    for _ in 0..60 {
        random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        let length = (random >> 33) as usize % bytes.len();
        fs::write(&path, &bytes[..length]).expect("written");
        match read(&path) {
            Ok((found, ended)) => {
                assert!(found[..] == whole[..found.len()], "{length}");
                assert!(ended.is_some() || found.len() == whole.len(), "{length}: read as whole");
                most = most.max(found.len());
            }
            Err(error) => assert!(length < 3000, "{length}: {error}"),
        }
    }
    assert!(most >= 20, "{most}: nearly whole files give nearly everything");
}

#[test]
fn a_recording_that_is_not_finished_is_readable() {
    let folder = scratch("open");
    let path = folder.0.join("a.mcap");
    let mut writer = McapWriter::create(&path, &calibration()).expect("a file");
    images(40).iter().for_each(|image| writer.write(image).expect("written"));
    // The program dies here: neither index nor end are written.
    std::mem::forget(writer);
    let (found, ended) = read(&path).expect("readable");
    assert!(found.len() >= 30 && found[..] == images(40)[..found.len()], "{}", found.len());
    assert!(matches!(ended, Some(BagError::Torn { .. })), "{ended:?}");
}

/// `/dev/full` takes nothing: as a disk that is full.
#[test]
#[cfg(target_os = "linux")]
fn a_full_disk_ends_the_recording_in_words() {
    let writer = McapWriter::create(std::path::Path::new("/dev/full"), &calibration());
    let ended = writer.and_then(|mut writer| {
        images(40).iter().try_for_each(|image| writer.write(image))?;
        writer.finish().map(drop)
    });
    let text = ended.expect_err("no room").to_string();
    let said = ["/dev/full", "which are kept", "its disk is full"];
    assert!(said.iter().all(|words| text.contains(words)), "{text}");
}

#[test]
fn a_folder_gives_back_what_was_written() {
    let folder = scratch("folder");
    let mut writer = FolderWriter::create(&folder.0, &calibration()).expect("a folder");
    images(10).iter().for_each(|image| writer.write(image).expect("written"));
    assert_eq!(writer.finish().expect("closed"), 10);
    let (found, ended) = read(&folder.0).expect("readable");
    assert!(ended.is_none() && found.len() == 10);
    for (found, wanted) in found.iter().zip(images(10)) {
        // Times count from the first pair.
        assert_eq!(found.stamp.captured.0, wanted.stamp.captured.0 - 1_000_000);
        assert_eq!((found.stream, &found.pixels), (wanted.stream, &wanted.pixels));
    }
    let refused = |table: &str| {
        fs::write(folder.0.join("frames.csv"), format!("frame,time_s,depth,infrared\n{table}"))
            .expect("written");
        open(&folder.0).map(drop).expect_err("refused").to_string()
    };
    assert!(refused("0,nan,a.png,b.png\n").contains("line 2: the time must be finite"));
    assert!(refused("0,0,a.png,b.png\n1,0,a.png,b.png\n").contains("line 3: the time does not come after"));
    assert!(refused("0,0,../a.png,b.png\n").contains("line 2: a file must lie in the folder"));
    assert!(refused("0,0,a.png\n").contains("line 2: expected"));
}

#[test]
fn a_ros_1_bag_is_read_plain_and_compressed_and_torn() {
    let folder = scratch("ros1");
    let path = folder.0.join("a.bag");
    for compress in [false, true] {
        let bytes = ros1(&images(12), compress);
        fs::write(&path, &bytes).expect("written");
        let camera = open(&path).expect("readable").calibration;
        assert_eq!((camera.size, camera.focal_px, camera.depth_unit_m), ((64, 48), [38.4, 38.5], 1e-4));
        let (found, ended) = read(&path).expect("readable");
        assert!(found == images(12) && ended.is_none(), "{compress}: {ended:?}");
        fs::write(&path, &bytes[..bytes.len() - 1000]).expect("written");
        let (found, ended) = read(&path).expect("readable");
        assert!((6..12).contains(&found.len()) && found[..] == images(12)[..found.len()]);
        assert!(matches!(ended, Some(BagError::Torn { .. })), "{ended:?}");
    }
    fs::write(&path, b"#ROSBAG V1.2\n").expect("written");
    assert!(open(&path).map(drop).expect_err("refused").to_string().contains("no ROS bag of version 2.0"));
}

#[test]
fn a_ros_2_bag_is_read() {
    let folder = scratch("db3");
    let path = folder.0.join("a.db3");
    db3(&path, &images(12));
    let camera = open(&path).expect("readable").calibration;
    assert_eq!((camera.size, camera.centre_px, camera.depth_unit_m), ((64, 48), [31.9, 23.6], 1e-4));
    assert!((camera.baseline_m - 0.05).abs() < 1e-9);
    let (found, ended) = read(&path).expect("readable");
    assert!(found == images(12) && ended.is_none(), "{ended:?}");
    let bytes = fs::read(&path).expect("bytes");
    fs::write(&path, &bytes[..bytes.len() / 2]).expect("written");
    let message = match read(&path) {
        Ok((found, ended)) => {
            assert!(found[..] == images(12)[..found.len()]);
            ended.expect("it is not whole").to_string()
        }
        Err(error) => error.to_string(),
    };
    assert!(message.contains("damaged"), "{message}");
}

#[test]
fn what_is_no_recording_is_named() {
    let folder = scratch("none");
    let path = folder.0.join("a.txt");
    fs::write(&path, b"text").expect("written");
    assert!(open(&path).map(drop).expect_err("refused").to_string().contains("is no recording"));
    let path = folder.0.join("a.mcap");
    fs::write(&path, b"text").expect("written");
    assert!(open(&path).is_err());
}

#[test]
fn profiles_go_through_csv_and_nonsense_is_refused_with_its_line() {
    let profile = |frame: u32| {
        let mut valid = [true; POINTS];
        valid[frame as usize % POINTS] = false;
        SurfaceProfile {
            height_m: std::array::from_fn(|i| if valid[i] { 0.07 + 1e-4 * (i as f32) } else { 0.0 }),
            variance_m2: std::array::from_fn(|i| if valid[i] { 4e-8 } else { 0.0 }),
            valid,
            glass_x_m: (frame != 1).then_some(-0.0125),
            sequence: frame,
            captured: Micros(1_000_000 + 16_667 * u64::from(frame)),
        }
    };
    let profiles: Vec<_> = (0..4).map(profile).collect();
    let text = profiles_to_csv(&profiles);
    let found = profiles_from_csv(&text).expect("readable");
    for (found, wanted) in found.iter().zip(&profiles) {
        let near = found.variance_m2.iter().zip(&wanted.variance_m2).all(|(a, b)| (a - b).abs() < 1e-13);
        assert!(near && SurfaceProfile { variance_m2: wanted.variance_m2, ..*found } == *wanted);
    }
    let refused = |from: &str, to: &str| profiles_from_csv(&text.replacen(from, to, 1)).expect_err("refused");
    let nan = refused("0.0701,", "NaN,");
    assert!(nan.line == 2 && nan.why.contains("not finite"), "{nan}");
    assert!(refused("1033334", "1000000").why.contains("does not come after"));
    assert!(refused("0.0701,", ",").why.contains("needs a height and a deviation"));
    assert_eq!(refused("0.0701,", "").line, 2);
}
