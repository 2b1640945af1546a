use super::*;
use crate::message::{Header, Quaternion, Stamp, Vector3};

const SAME: Quaternion = Quaternion { x: 0.0, y: 0.0, z: 0.0, w: 1.0 };
/// A quarter of a turn about z.
const QUARTER: Quaternion =
    Quaternion { x: 0.0, y: 0.0, z: std::f64::consts::FRAC_1_SQRT_2, w: std::f64::consts::FRAC_1_SQRT_2 };
const ONE: SenderId = SenderId([1; 16]);
const OTHER: SenderId = SenderId([2; 16]);

fn link(parent: &str, child: &str, ms: u64, x: f64, rotation: Quaternion) -> TransformStamped {
    TransformStamped {
        header: Header { stamp: Stamp::of_unix_ns(1_000_000 * ms), frame_id: parent.into() },
        child_frame_id: child.into(),
        translation: Vector3 { x, y: 0.0, z: 0.0 },
        rotation,
    }
}

fn tree() -> Transforms {
    let pair = FramePair { parent: "/world".into(), child: "glass".into() };
    Transforms::of(Some(&pair), StampClock::Host)
}

fn given(
    tree: &mut Transforms,
    from: SenderId,
    links: Vec<TransformStamped>,
) -> Vec<Result<(u64, f64), SampleFault>> {
    let mut all = Vec::new();
    tree.take(&TransformMessage { transforms: links }, from, &mut |given| {
        all.push(
            given.map(|sample| (sample.stamp_ns / 1_000_000, (1e9 * sample.position_m[0]).round() / 1e9)),
        );
    });
    all
}

#[test]
fn a_chain_is_composed_and_a_static_link_is_part_of_it() {
    let mut tree = tree();
    // x of the rail is y of the room, which is askew by a quarter turn to the world: together x of the world reversed.
    let fixed = vec![link("room", "world", 0, 0.0, QUARTER), link("room", "rail", 0, 0.5, SAME)];
    tree.take_static(&TransformMessage { transforms: fixed });
    assert_eq!(given(&mut tree, ONE, vec![link("rail", "cart", 10, 0.1, QUARTER)]), [], "not joined yet");
    assert!(!tree.is_joined());
    let mut all = Vec::new();
    let links = vec![link("rail", "cart", 20, 0.1, QUARTER), link("/cart", "/glass", 20, 0.2, SAME)];
    tree.take(&TransformMessage { transforms: links }, ONE, &mut |given| all.push(given.expect("a sample")));
    let [Sample { stamp_ns: 20_000_000, position_m: [x, y, _], .. }] = all[..] else { panic!("{all:?}") };
    // In the room the glass is at (0.5 + 0.1, 0.2): in the world at (0.2, -0.6).
    assert!((x - 0.2).abs() < 1e-12 && (y + 0.6).abs() < 1e-12, "{x} {y}");
    assert_eq!(tree.frames(), ["cart", "glass", "rail", "room", "world"]);
}

#[test]
fn the_slowest_link_gives_the_instants_and_the_others_are_interpolated() {
    let mut tree = tree();
    let mut all = Vec::new();
    for ms in (1000..1400).step_by(10) {
        let at = ms as f64 * 1e-3;
        all.extend(given(&mut tree, ONE, vec![link("cart", "glass", ms + 3, 2.0 * (at + 0.003), SAME)]));
        if ms % 40 == 0 {
            all.extend(given(&mut tree, OTHER, vec![link("world", "cart", ms, at, SAME)]));
        }
    }
    let slow: Vec<_> = all.into_iter().map(|given| given.expect("a sample")).skip(3).collect();
    assert!(slow.len() >= 6, "{slow:?}");
    for (ms, x) in slow {
        assert!(ms % 40 == 0 && (x - 3e-3 * ms as f64).abs() < 1e-9, "{ms} {x}");
    }
}

#[test]
fn a_second_publisher_a_late_transform_and_faults_are_handled() {
    let mut tree = tree();
    let of = |ms: u64, x: f64| vec![link("world", "glass", ms, x, SAME)];
    assert_eq!(given(&mut tree, ONE, of(10, 0.1)), [Ok((10, 0.1))]);
    assert_eq!(given(&mut tree, ONE, of(30, 0.3)), [Ok((30, 0.3))]);
    assert_eq!(given(&mut tree, ONE, of(20, 0.2)), [Ok((20, 0.2))], "late");
    assert_eq!(given(&mut tree, ONE, of(20, 0.2)), [], "repeated, as many publishers do");
    assert!(matches!(given(&mut tree, OTHER, of(40, 9.0))[..], [Err(SampleFault::SecondSender(_))]));
    let elsewhere = vec![link("moon", "glass", 40, 9.0, SAME)];
    assert!(matches!(given(&mut tree, OTHER, elsewhere)[..], [Err(SampleFault::SecondSender(_))]));
    tree.take_static(&TransformMessage { transforms: vec![link("moon", "glass", 0, 9.0, SAME)] });
    assert_eq!(given(&mut tree, ONE, of(40, 0.4)), [Ok((40, 0.4))], "the first one is heard on");
    assert_eq!(given(&mut tree, ONE, of(0, 0.5)), [Err(SampleFault::Unstamped)]);
    let tilted = |child: &str| vec![link("world", child, 50, 0.5, Quaternion { w: 0.5, ..SAME })];
    assert_eq!(given(&mut tree, ONE, tilted("glass")), [Err(SampleFault::Rotation(0.5))]);
    assert_eq!(given(&mut tree, ONE, tilted("bottle")), [], "another frame's matter");
    assert!(matches!(given(&mut tree, ONE, of(60, f64::NAN))[..], [Err(SampleFault::Malformed(_))]));
    // A stamp of the year 2036 goes on to the source, and no transform is made of it.
    assert_eq!(given(&mut tree, ONE, of(2_100_000_000_000, 0.7)), [Ok((2_100_000_000_000, 0.7))]);
    assert_eq!(given(&mut tree, ONE, of(70, 0.7)), [Ok((70, 0.7))]);
}

#[test]
fn frames_in_a_circle_are_not_joined() {
    let mut tree = tree();
    let links = vec![link("a", "glass", 10, 0.0, SAME), link("glass", "a", 10, 0.0, SAME)];
    assert_eq!(given(&mut tree, ONE, links), []);
    assert!(!tree.is_joined());
}
