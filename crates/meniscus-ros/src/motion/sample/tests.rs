use super::super::MotionTopic;
use super::*;
use crate::message::{
    Header, Point, Pose, PoseWithCovariance, Quaternion, Stamp, Twist, TwistWithCovariance, Vector3,
};
use meniscus_service::commanded_motion::StampClock;

const UNSTATED: Vector3 = Vector3 { x: 0.0, y: 0.0, z: 0.0 };

/// A third of a turn about (1, 1, 1): x goes to y, y to z, z to x.
const THIRD: Quaternion = Quaternion { x: 0.5, y: 0.5, z: 0.5, w: 0.5 };

fn topic() -> MotionTopic {
    let joint = Some("slide".to_owned());
    let axis = [0.0, 3.0, 4.0];
    MotionTopic { topic: "/t".into(), frames: None, joint, axis, clock: StampClock::Host }
}

fn header() -> Header {
    Header { stamp: Stamp { sec: 7, nanosec: 5 }, frame_id: "world".into() }
}

fn given<M: MotionMessage>(reading: &mut Reading<'_>, message: M) -> Vec<Result<Sample, SampleFault>> {
    let mut all = Vec::new();
    message.read(SenderId([1; 16]), reading, &mut |given| all.push(given));
    all
}

fn near(a: [f64; 3], b: [f64; 3]) -> bool {
    a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-12)
}

fn odometry(linear: Vector3) -> Odometry {
    let pose = Pose { position: Point { x: 1.0, y: 2.0, z: 3.0 }, orientation: THIRD };
    let covariance = ([0.0; 32], [0.0; 4]);
    Odometry {
        header: header(),
        child_frame_id: "base".into(),
        pose: PoseWithCovariance { pose, covariance },
        twist: TwistWithCovariance { twist: Twist { linear, angular: UNSTATED }, covariance },
    }
}

#[test]
fn a_twist_is_turned_from_the_body_into_the_frame_of_the_pose_and_zeros_are_none() {
    let topic = topic();
    let mut reading = Reading::of(&topic);
    let still = given(&mut reading, odometry(UNSTATED));
    let position_m = [1.0, 2.0, 3.0];
    let stamp_ns = 7_000_000_005;
    assert_eq!(
        still,
        [Ok(Sample { stamp_ns, position_m, velocity_m_s: None, acceleration_m_s2: None })],
        "nothing was stated yet"
    );
    let moved = given(&mut reading, odometry(Vector3 { x: 0.5, y: 0.0, z: -1.0 }));
    let velocity = moved[0].as_ref().expect("a sample").velocity_m_s.expect("stated");
    assert!(near(velocity, [-1.0, 0.5, 0.0]), "{velocity:?}");
    let rest = given(&mut reading, odometry(UNSTATED));
    assert_eq!(rest[0].as_ref().expect("a sample").velocity_m_s, Some([0.0; 3]), "at rest again");
}

fn imu(orientation: Quaternion, force: Vector3) -> Imu {
    Imu {
        header: header(),
        orientation,
        orientation_covariance: [0.0; 9],
        angular_velocity: UNSTATED,
        angular_velocity_covariance: [0.0; 9],
        linear_acceleration: force,
        linear_acceleration_covariance: [0.0; 9],
    }
}

#[test]
fn gravity_is_removed_by_the_orientation_and_kept_without_one() {
    let topic = topic();
    let mut reading = Reading::of(&topic);
    // The sensor's y is up: at rest it feels gravity there, and 2 m/s2 along its z are along the world's x.
    let force = Vector3 { x: 0.0, y: GRAVITY, z: 2.0 };
    let of = |all: Vec<Result<Sample, SampleFault>>| {
        all[0].as_ref().expect("a sample").acceleration_m_s2.expect("stated")
    };
    let acceleration = of(given(&mut reading, imu(THIRD, force)));
    assert!(near(acceleration, [2.0, 0.0, 0.0]), "{acceleration:?}");
    assert_eq!(reading.notice, None);
    let mut alone = imu(Quaternion { x: 0.0, y: 0.0, z: 0.0, w: 0.0 }, force);
    alone.orientation_covariance[0] = -1.0;
    assert!(near(of(given(&mut reading, alone.clone())), [0.0, GRAVITY, 2.0]));
    assert!(reading.notice.take().is_some_and(|notice| notice.contains("states no orientation")));
    assert!(given(&mut reading, alone.clone())[0].is_ok() && reading.notice.is_none(), "said once");
    alone.linear_acceleration_covariance[0] = -1.0;
    assert!(matches!(given(&mut reading, alone)[0], Err(SampleFault::Malformed(_))));
    let zero = imu(Quaternion { x: 0.0, y: 0.0, z: 0.0, w: 0.0 }, force);
    assert_eq!(given(&mut reading, zero), [Err(SampleFault::Rotation(0.0))]);
}

#[test]
fn a_joint_moves_along_its_axis_and_others_do_not() {
    let topic = topic();
    let mut reading = Reading::of(&topic);
    let state = |name: &str, position: &[f64], velocity: &[f64]| JointState {
        header: header(),
        name: vec!["wrist".into(), name.into()],
        position: position.to_vec(),
        velocity: velocity.to_vec(),
        effort: vec![],
    };
    let moved = given(&mut reading, state("slide", &[9.0, 0.5], &[9.0, -1.0]));
    let sample = moved[0].as_ref().expect("a sample");
    assert!(near(sample.position_m, [0.0, 0.3, 0.4]), "{sample:?}");
    assert!(near(sample.velocity_m_s.expect("stated"), [0.0, -0.6, -0.8]), "{sample:?}");
    for velocity in [&[][..], &[9.0, f64::NAN]] {
        let all = given(&mut reading, state("slide", &[9.0, 0.5], velocity));
        assert_eq!(all[0].as_ref().expect("a sample").velocity_m_s, None, "{velocity:?}");
    }
    assert!(matches!(given(&mut reading, state("slide", &[9.0], &[]))[0], Err(SampleFault::Malformed(_))));
    assert_eq!(given(&mut reading, state("lift", &[9.0, 0.5], &[])), []);
    assert!(reading.joints.contains("lift") && reading.joints.contains("wrist"));
}

#[test]
fn stamps_and_quaternions_that_are_none_are_refused() {
    let topic = topic();
    let mut reading = Reading::of(&topic);
    let with = |stamp: Stamp, w: f64| {
        let pose = Pose { orientation: Quaternion { w, ..THIRD }, ..odometry(UNSTATED).pose.pose };
        PoseStamped { header: Header { stamp, frame_id: String::new() }, pose }
    };
    let stamp = header().stamp;
    assert!(given(&mut reading, with(stamp, 0.5))[0].is_ok());
    assert_eq!(given(&mut reading, with(Stamp::default(), 0.5)), [Err(SampleFault::Unstamped)]);
    let before = Stamp { sec: -1, nanosec: 0 };
    assert!(matches!(given(&mut reading, with(before, 0.5))[0], Err(SampleFault::Malformed(_))));
    assert!(matches!(given(&mut reading, with(stamp, 2.0))[0], Err(SampleFault::Rotation(_))));
}
