//! Poses from corners that a projection written for the test makes.

use super::*;

const LENS: Intrinsics =
    Intrinsics { width: 640, height: 480, fx: 384.21, fy: 380.0, ppx: 319.5, ppy: 236.4 };
const SIZE_M: f64 = 0.04;

fn corners(rotation: &UnitQuaternion<f64>, position_m: &Vector3<f64>) -> [[f64; 2]; 4] {
    let half = 0.5 * SIZE_M;
    [[-half, -half], [half, -half], [half, half], [-half, half]].map(|[x, y]| {
        let at = rotation.transform_vector(&Vector3::new(x, y, 0.0)) + position_m;
        [319.5 + 384.21_f64 * at.x / at.z, 236.4 + 380.0 * at.y / at.z]
    })
}

fn turned(pitch: f64, yaw: f64, roll: f64) -> UnitQuaternion<f64> {
    UnitQuaternion::from_euler_angles(pitch, yaw, roll)
}

#[test]
fn exact_corners_give_the_pose_back() {
    for rotation in
        [turned(0.3, -0.5, 0.1), turned(-0.7, 0.2, 2.9), turned(0.0, 0.8, -0.4), turned(0.2, 0.0, 1.5)]
    {
        for position_m in [Vector3::new(0.05, -0.03, 0.4), Vector3::new(-0.1, 0.02, 0.25)] {
            let found = pose(&corners(&rotation, &position_m), SIZE_M, &LENS).expect("a pose");
            assert!((found.position_m - position_m).norm() < 1e-6, "{found:?}");
            let angles = [found.rotation.angle_to(&rotation)]
                .into_iter()
                .chain(found.other.map(|other| other.angle_to(&rotation)));
            assert!(angles.fold(f64::MAX, f64::min) < 1e-4, "{found:?}");
            assert!(found.rotation.angle_to(&rotation) < 1e-4, "the likelier one is the true one: {found:?}");
        }
    }
}

/// From 2 m away the corners have no perspective that 0.1 px shows.
#[test]
fn a_distant_tag_has_two_attitudes_and_the_one_before_decides() {
    let (rotation, position_m) = (turned(0.3, 0.0, 0.0), Vector3::new(0.0, 0.0, 1.0));
    let found = pose(&corners(&rotation, &position_m), SIZE_M, &LENS).expect("a pose");
    let other = found.other.expect("two attitudes");
    assert!((other.angle_to(&rotation) - 0.6).abs() < 0.1, "leaning the other way: {found:?}");
    assert!(found.nearer_to(&turned(-0.25, 0.0, 0.0)).rotation.angle_to(&other) < 1e-9);
    assert!(found.nearer_to(&turned(0.25, 0.0, 0.0)).rotation.angle_to(&rotation) < 1e-3);
}

#[test]
fn the_covariance_is_that_of_noisy_corners() {
    let (rotation, position_m) = (turned(0.4, 0.3, 0.0), Vector3::new(0.02, 0.0, 0.4));
    let exact = corners(&rotation, &position_m);
    let mut state = 1_u64;
    let mut uniform = move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as f64 / f64::from(1_u32 << 31) - 0.5
    };
    let mut noise = move || CORNER_STD_PX * (0..12).map(|_| uniform()).sum::<f64>();
    let (mut sums, mut claimed, mut count) = (Vector3::zeros(), Vector3::zeros(), 0.0);
    for _ in 0..2000 {
        let seen = exact.map(|corner| corner.map(|number| number + noise()));
        let Ok(found) = pose(&seen, SIZE_M, &LENS) else { continue };
        sums += (found.position_m - position_m).map(|error| error * error);
        claimed += Vector3::new(found.covariance[(3, 3)], found.covariance[(4, 4)], found.covariance[(5, 5)]);
        count += 1.0;
    }
    assert!(count > 1990.0, "{count}");
    for (is, due) in sums.iter().zip(&claimed) {
        assert!((is / due - 1.0).abs() < 0.15, "{sums} {claimed}");
    }
}

#[test]
fn corners_that_are_no_square_are_refused() {
    let mut seen = corners(&turned(0.2, 0.3, 0.0), &Vector3::new(0.0, 0.0, 0.4));
    seen[2][0] += 3.0;
    assert!(matches!(pose(&seen, SIZE_M, &LENS), Err(PoseFault::Unfit(px)) if px > 0.3));
    seen.swap(0, 1);
    assert!(pose(&seen, SIZE_M, &LENS).is_err(), "mirrored");
    assert!(pose(&[[1.0, 1.0]; 4], SIZE_M, &LENS).is_err(), "one point");
    assert!(pose(&[[f64::NAN, 1.0]; 4], SIZE_M, &LENS).is_err(), "no numbers");
}
