//! Commanded and tracked motions that agree, or do not.

use super::*;

const H: f64 = FRAME_INTERVAL_S;

/// Position of the glass: 12 mm at 2.5 Hz and 5 mm at 1.1 Hz.
fn place(t: f64) -> f64 {
    0.3 + 0.012 * (15.7 * t).sin() + 0.005 * (6.9 * t).cos()
}

/// Plays `seconds`, with the motion that `commanded(n, true second difference)` says; gives the frames used.
fn play(seconds: f64, commanded: impl Fn(u32, f64) -> (f64, f64)) -> (u32, Trust) {
    let (mut agreement, mut used) = (Agreement::default(), 0);
    let mut noise = 12345_u64;
    for n in 0..(seconds / H) as u32 {
        let (t, at) = (f64::from(n) * H, Micros(1_000 + u64::from(n) * 16_667));
        let true_before = (place(t) - 2.0 * place(t - H) + place(t - 2.0 * H)) / (H * H);
        let (before, now) = commanded(n, true_before);
        used += u32::from(agreement.trust() == Trust::Used);
        agreement.commanded(at, Accelerations { before, now }, |_| None);
        noise = noise.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        let noise_m = 6e-4 * ((noise >> 40) as f64 / (1_u64 << 24) as f64 - 0.5);
        agreement.tracked(at, Some(place(t) + noise_m));
    }
    (used, agreement.trust())
}

fn truth(n: u32) -> (f64, f64) {
    let t = f64::from(n) * H;
    let before = (place(t) - 2.0 * place(t - H) + place(t - 2.0 * H)) / (H * H);
    let now = (place(t + H) - 2.0 * place(t) + place(t - H)) / (H * H);
    (before, now)
}

#[test]
fn a_true_motion_is_used_although_late_biased_and_stretched() {
    let (used, trust) = play(10.0, |n, _| truth(n));
    assert!(used > 570 && trust == Trust::Used, "{used}");
    let (used, trust) = play(10.0, |n, _| {
        // A frame late, 10 % too large, on a sensor inclined by 1.7 degrees.
        let (before, now) = truth(n.saturating_sub(1));
        (1.1 * before + 0.3, 1.1 * now + 0.3)
    });
    assert!(used > 570 && trust == Trust::Used, "{used}");
}

#[test]
fn zeros_a_reversed_motion_and_alternating_values_are_not_used() {
    type Lie = fn(u32, f64) -> (f64, f64);
    let lies: [(&str, Lie); 5] = [
        ("zero", |_, _| (0.0, 0.0)),
        ("reversed", |n, _| (-truth(n).0, -truth(n).1)),
        ("alternating", |n, _| if n % 2 == 0 { (150.0, -150.0) } else { (-150.0, 150.0) }),
        ("alternating now", |n, b| (b, if n % 2 == 0 { 150.0 } else { -150.0 })),
        ("half a second late", |n, _| truth(n.saturating_sub(30))),
    ];
    for (name, lie) in lies {
        let (used, trust) = play(10.0, lie);
        assert!(used < 20 && trust == Trust::Contradicted, "{name}: {used} frames, {trust:?}");
    }
}

#[test]
fn a_motion_that_turns_false_is_dropped_within_a_second_and_one_that_mends_is_used_again() {
    let (used, trust) = play(4.0, |n, b| if n < 120 { truth(n) } else { (b + 20.0 * f64::from(n % 7), 0.0) });
    assert!((100..170).contains(&used) && trust == Trust::Contradicted, "{used}");
    let (used, trust) = play(8.0, |n, _| if (60..120).contains(&n) { (30.0, -30.0) } else { truth(n) });
    assert!(used > 200 && trust == Trust::Used, "{used}");
}

/// Verdict on a motion of 0.7 s whose every 15th turn and the two behind it are left out; `ago` is their motion.
fn with_gaps(commanded: impl Fn(u32) -> Accelerations, known: bool) -> Trust {
    let mut agreement = Agreement::default();
    for n in (0..42).filter(|n| n % 15 < 12) {
        let at = Micros(1_000 + u64::from(n) * 16_667);
        let ago = |ago_s: f64| known.then(|| commanded(n - (ago_s / H).round() as u32));
        agreement.commanded(at, commanded(n), ago);
        agreement.tracked(at, Some(place(f64::from(n) * H)));
    }
    agreement.trust()
}

#[test]
fn turns_that_are_left_out_are_filled_in_where_their_motion_is_known() {
    let accelerations = |(before, now)| Accelerations { before, now };
    assert_eq!(with_gaps(|n| accelerations(truth(n)), true), Trust::Used);
    assert_eq!(with_gaps(|_| Accelerations::default(), true), Trust::Contradicted);
    assert_eq!(with_gaps(|n| accelerations(truth(n)), false), Trust::Untried);
}

#[test]
fn turns_that_went_on_in_a_silence_are_replaced_by_those_of_its_frames() {
    let mut agreement = Agreement::default();
    let mut turn = |n: u32, is_seen: bool| {
        let ((before, now), at) = (truth(n), Micros(1_000 + u64::from(n) * 16_667));
        agreement.commanded(at, Accelerations { before, now }, |_| None);
        agreement.tracked(at, is_seen.then(|| place(f64::from(n) * H)));
        agreement.trust()
    };
    // Silence from turn 8 on; its frames come all at once.
    (0..8).for_each(|n| assert_eq!(turn(n, true), Trust::Untried));
    (8..13).for_each(|n| assert_eq!(turn(n, false), Trust::Untried));
    (8..19).for_each(|n| assert_eq!(turn(n, true), Trust::Untried));
    assert_eq!(turn(19, true), Trust::Used);
}

#[test]
fn without_a_tracked_glass_nothing_is_denied() {
    let mut agreement = Agreement::default();
    for n in 0..100 {
        agreement.commanded(Micros(n * 16_667), Accelerations { before: 1.0, now: 1.0 }, |_| None);
        agreement.tracked(Micros(n * 16_667), None);
    }
    assert_eq!(agreement.trust(), Trust::Used);
}
