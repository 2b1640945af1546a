//! Sound bytes with some of them changed, cut, put in or repeated, whatever they mean.

use crate::mutation::{cases, edited, edits};
use crate::recordings;
use meniscus::blob::Model;
use meniscus::surface::{POINTS, SurfaceProfile};
use meniscus::units::Micros;
use meniscus::usb::d4xx;
use meniscus::usb::d4xx::{Command, DepthTable, Identity, Table};
use meniscus::usb::uvc::descriptor::{Descriptors, check, interfaces};
use meniscus::usb::uvc::format::video_modes;
use meniscus::usb::uvc::{Assembler, AssemblyOutcome, ControlChange, DeviceClock, Probe, Topology};
use meniscus_bags::{McapWriter, open};
use meniscus_data::profiles::{profiles_from_csv, profiles_to_csv};
use meniscus_data::recording::Recording;
use meniscus_hil::device::{Device, Reply, TestCard};
use meniscus_hil::{FaultList, Image, Stamp, pack};
use meniscus_platform::files::AlignedBytes;
use meniscus_usb::camera::{OutlineImage, Plan};
use proptest::prelude::*;
use std::path::Path;

fn camera() -> Device {
    Device::new(Box::new(TestCard::default()), None, FaultList::default(), 1)
}

pub(crate) fn configuration() -> Vec<u8> {
    match camera().control(0, [0x80, 6, 0, 2, 0, 0], &[]) {
        Reply::Data(bytes) => bytes,
        other => panic!("{other:?}"),
    }
}

/// The simulated camera's answer to a command.
pub(crate) fn answer(command: &Command<'_>) -> Vec<u8> {
    let (mut device, mut message) = (camera(), [0; d4xx::MESSAGE]);
    command.write(&mut message);
    device.control(0, [0x21, 1, 0, 1, 0, 3], &message);
    match device.control(0, [0xa1, 0x81, 0, 1, 0, 3], &[]) {
        Reply::Data(bytes) => bytes,
        other => panic!("{other:?}"),
    }
}

pub(crate) fn payload(shot: u32) -> Vec<u8> {
    let stamp = Stamp {
        fid: shot % 2 == 1,
        pts_us: shot * 16_667,
        bus_frame: shot as u16,
        counter: shot,
        exposure_us: 4_000,
        interval_us: 16_667,
    };
    pack(&stamp, &Image { pixels: &[shot as u8; 64], width: 8, height: 4, format: 0 })
}

proptest! {
    #![proptest_config(cases(20_000))]

    #[test]
    fn payloads(all in prop::collection::vec((0..20_u32, edits()), 1..12), whole: bool) {
        let mut buffer = [0; 64];
        let (mut assembler, mut clock) = (Assembler::new(&mut buffer), DeviceClock::default());
        let mut out = 0;
        for (shot, edits) in &all {
            let bytes = edited(&payload(*shot), edits);
            let outcome = if whole { assembler.whole(&bytes, &mut clock) } else { assembler.push(&bytes, &mut clock) };
            if let AssemblyOutcome::Frame(frame) = outcome {
                prop_assert_eq!(frame.pixels.len(), 64);
                out += 1;
            }
        }
        prop_assert!(out <= all.len());
    }

    #[test]
    fn descriptors(edits in edits()) {
        let bytes = edited(&configuration(), &edits);
        let walked: usize = Descriptors::new(&bytes).map_while(Result::ok).map(|d| d.bytes.len()).sum();
        prop_assert_eq!(check(&bytes).is_ok(), walked == bytes.len());
        for interface in interfaces(&bytes) {
            let _topology = Topology::of(&interface);
            let _endpoints = interface.endpoints().count();
            for mode in video_modes(&interface) {
                let listed: Vec<u32> = mode.intervals().collect();
                prop_assert!(listed.len() <= 255);
                let _found = mode.interval_of(60);
            }
        }
        if let Ok(plan) = Plan::read(&bytes, (640, 480), OutlineImage::Infrared) {
            for stream in plan.streams {
                prop_assert!(stream.endpoint & 0x80 != 0);
                prop_assert!(stream.transfer_bytes() >= stream.frame_bytes as usize + 1024);
            }
        }
    }

    #[test]
    fn monitor_answers(edits in edits(), which in 0..4) {
        let commands = [Identity::COMMAND, Table::command(25), d4xx::recommended::COMMAND, DepthTable::COMMAND];
        let command = commands[which as usize];
        let message = edited(&answer(&command), &edits);
        let _identity = Identity::read(&message);
        let _depth = DepthTable::read(&message);
        if let Ok(payload) = command.answer(&message, 0) {
            prop_assert!(payload.len() <= message.len());
            if let Ok(table) = Table::read(payload, 25) {
                let _baseline = d4xx::baseline_mm(&table).map(|mm| assert!(mm.is_finite()));
                let found = d4xx::coefficients(&table, (640, 480));
                prop_assert!(found.is_err() || found.is_ok_and(|i| i.fx.is_finite() && i.fx > 0.0));
            }
            let found = d4xx::recommended::read(payload, (640, 480));
            prop_assert!(found.is_err() || found.is_ok_and(|i| i.ppy.is_finite() && i.fy > 0.0));
        }
    }

    #[test]
    fn raw_bytes(bytes in prop::collection::vec(any::<u8>(), 0..1100)) {
        let _status = ControlChange::read(&bytes);
        let _probe = Probe::read(&bytes, bytes.len());
        let _identity = Identity::read(&bytes);
        let _table = Table::read(&bytes, 25);
        for outline in [OutlineImage::Infrared, OutlineImage::Colour] {
            let _plan = Plan::read(&bytes, (640, 480), outline);
        }
        if let Ok(colour) = d4xx::colour(&Table { bytes: &bytes }, (640, 480)) {
            let (u, v) = colour.lens.pixel_of(0.0, 0.0);
            prop_assert!(u.is_finite() && v.is_finite());
        }
    }
}

proptest! {
    #![proptest_config(cases(48))]

    #[test]
    fn blobs(edits in edits()) {
        let sound = meniscus_shipped::MODEL;
        let bytes = edited(sound, &edits);
        let blob = AlignedBytes::copy(&bytes);
        // A blob that still loads is the sound one: its CRC covers every byte.
        prop_assert!(Model::load(&blob).is_err() || bytes == sound);
    }

    #[test]
    fn blob_headers(edits in edits()) {
        let sound = meniscus_shipped::MODEL;
        let (head, rest) = sound.split_at(512);
        let bytes = [edited(head, &edits), rest.to_vec()].concat();
        prop_assert!(Model::load(&AlignedBytes::copy(&bytes)).is_err() || bytes == sound);
    }

    #[test]
    fn recordings(edits in edits()) {
        let sound = meniscus_shipped::RECORDING;
        let (head, rest) = sound.split_at(4096);
        let bytes = [edited(head, &edits), rest.to_vec()].concat();
        if let Ok(recording) = Recording::from_bytes(Path::new("mutated"), &bytes) {
            prop_assert!(recording.frames() > 0);
        }
    }
}

/// Bytes of a sound recording of each kind.
pub(crate) fn sound_recording(kind: &str) -> Vec<u8> {
    let folder = recordings::scratch(&format!("fuzz-sound-{kind}"));
    let path = folder.0.join(format!("a.{kind}"));
    let images = recordings::images(6);
    match kind {
        "mcap" => {
            let mut writer = McapWriter::create(&path, &recordings::calibration()).expect("a file");
            images.iter().for_each(|image| writer.write(image).expect("written"));
            writer.finish().expect("closed");
        }
        "db3" => recordings::db3(&path, &images),
        _ => return recordings::ros1(&images, kind == "lz4"),
    }
    std::fs::read(path).expect("bytes")
}

/// Whatever comes out of a mutated recording is of the size that it says, and there is an end.
pub(crate) fn read_recording(name: &str, bytes: &[u8]) -> Result<(), TestCaseError> {
    let folder = recordings::scratch(&format!("fuzz-{name}"));
    let path = folder.0.join(name);
    std::fs::write(&path, bytes).expect("written");
    if let Ok(recording) = open(&path) {
        let camera = recording.calibration;
        prop_assert!(camera.focal_px.iter().all(|f| f.is_finite() && *f > 0.0));
        let mut count = 0;
        for image in recording.images {
            count += 1;
            prop_assert!(count < 100, "no end");
            prop_assert!(image.is_err() || image.is_ok_and(|image| image.pixels.len() <= 2 * 4096 * 4096));
        }
    }
    Ok(())
}

proptest! {
    #![proptest_config(cases(64))]

    #[test]
    fn mcap_recordings(edits in edits()) {
        read_recording("a.mcap", &edited(&sound_recording("mcap"), &edits))?;
    }

    #[test]
    fn ros_1_bags(edits in edits(), packed: bool) {
        let sound = sound_recording(if packed { "lz4" } else { "plain" });
        read_recording("a.bag", &edited(&sound, &edits))?;
    }

    #[test]
    fn ros_2_bags(edits in edits()) {
        read_recording("a.db3", &edited(&sound_recording("db3"), &edits))?;
    }

    #[test]
    fn profile_tables(edits in edits()) {
        let profile = SurfaceProfile {
            height_m: [0.07; POINTS],
            variance_m2: [1e-8; POINTS],
            valid: [true; POINTS],
            glass_x_m: Some(0.01),
            sequence: 7,
            captured: Micros(99),
        };
        let bytes = edited(profiles_to_csv(&[profile]).as_bytes(), &edits);
        if let Ok(profiles) = profiles_from_csv(&String::from_utf8_lossy(&bytes)) {
            let finite = |p: &SurfaceProfile| p.height_m.iter().chain(&p.variance_m2).all(|x| x.is_finite());
            prop_assert!(profiles.iter().all(finite));
        }
    }
}
