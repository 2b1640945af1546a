//! Datagrams whose first bytes are right, and descriptors that follow each other as they should.

use crate::bytes::configuration;
use crate::containers::{ListEdit, list_edits, relisted};
use crate::mutation::{cases, edited, edits};
use meniscus::usb::uvc::Topology;
use meniscus::usb::uvc::descriptor::{Descriptors, check, interfaces};
use meniscus::usb::uvc::format::video_modes;
use meniscus_service::commanded_motion::{MotionFrame, StampClock};
use meniscus_service::controller::Plan;
use meniscus_usb::camera::{OutlineImage, Plan as CameraPlan};
use proptest::prelude::*;

/// 2001, ns since 1970.
const NOW_NS: u64 = 1_000_000_000_000_000_000;

fn frame() -> MotionFrame {
    MotionFrame {
        clock: StampClock::Sender,
        sequence: 7,
        stamp_ns: NOW_NS,
        position_m: [0.1, 0.0, 0.0],
        velocity_m_s: Some([0.1; 3]),
        acceleration_m_s2: Some([1.5, 0.0, 0.0]),
    }
}

/// A plan of a glass that moves and comes to rest.
pub(crate) fn plan() -> Vec<u8> {
    let point = |n: u64| {
        let s = (n as f64 / 30.0).min(1.0);
        (NOW_NS + n * 16_000_000, [0.1 * s * s * (3.0 - 2.0 * s), 0.0, 0.0])
    };
    Plan::to_bytes(3, &(0..40).map(point).collect::<Vec<_>>())
}

/// The camera's configuration with changes of whole descriptors: each states its own length, and the first the total.
pub(crate) fn descriptors(changes: &[ListEdit]) -> Vec<u8> {
    let sound = configuration();
    let list =
        Descriptors::new(&sound).map_while(Result::ok).map(|one| (one.bytes[1], one.bytes[2..].to_vec()));
    let one = |(kind, body): &(u8, Vec<u8>)| {
        let body = &body[..body.len().min(253)];
        [&[body.len() as u8 + 2, *kind][..], body].concat()
    };
    let mut all: Vec<u8> = relisted(list.collect(), changes).iter().flat_map(one).collect();
    if all.len() >= 4 && all[1] == 2 {
        let total = (all.len() as u16).to_le_bytes();
        all[2..4].copy_from_slice(&total);
    }
    all
}

proptest! {
    #![proptest_config(cases(20_000))]

    #[test]
    fn motion_frames(edits in edits()) {
        // Magic and version stay: behind them the frame is read.
        let mut bytes = frame().to_bytes();
        let rest = edited(&bytes.split_off(5), &edits);
        bytes.extend(rest);
        if let Ok(frame) = MotionFrame::read(&bytes) {
            let all = [Some(frame.position_m), frame.velocity_m_s, frame.acceleration_m_s2];
            prop_assert!(all.into_iter().flatten().flatten().all(|x: f64| x.is_finite() && x.abs() <= 200.0));
            prop_assert_eq!(frame.to_bytes(), bytes);
        }
    }
}

proptest! {
    #![proptest_config(cases(4_000))]

    #[test]
    fn plans(edits in edits(), count in prop::option::of(any::<u16>())) {
        let mut bytes = plan();
        let head = bytes.len() - 40 * 32;
        let mut rest = edited(&bytes.split_off(head), &edits);
        // Whole samples, and as many as the head says.
        rest.truncate(rest.len() / 32 * 32);
        let count = count.unwrap_or((rest.len() / 32) as u16);
        bytes[6..8].copy_from_slice(&count.to_le_bytes());
        bytes.extend(rest);
        if let Ok(plan) = Plan::read(&bytes, &[1.0, 0.0, 0.0], NOW_NS) {
            let mut out = [0.0; 64];
            plan.accelerations(NOW_NS, &mut out);
            prop_assert!(out.iter().all(|a| a.is_finite() && a.abs() <= 1000.0), "{out:?}");
            prop_assert!(plan.length_s().is_finite() && plan.length_s() > 0.0);
        }
    }

    #[test]
    fn descriptor_lists(changes in list_edits()) {
        let bytes = descriptors(&changes);
        let _checked = check(&bytes);
        for interface in interfaces(&bytes) {
            let _topology = Topology::of(&interface);
            prop_assert!(video_modes(&interface).all(|mode| mode.intervals().count() <= 255));
        }
        for outline in [OutlineImage::Infrared, OutlineImage::Colour] {
            if let Ok(plan) = CameraPlan::read(&bytes, (640, 480), outline) {
                for stream in plan.streams {
                    prop_assert!(stream.endpoint & 0x80 != 0);
                    prop_assert!(stream.transfer_bytes() <= 1 << 20, "{} bytes", stream.transfer_bytes());
                }
            }
        }
    }
}
