//! A plan: stamped positions of the glass to come, checked, and its accelerations at the turns of a forecast.
//!
//! | offset | type | field |
//! |---|---|---|
//! | 0 | 4 bytes | `MNSP` |
//! | 4 | u8 | version, 1 |
//! | 5 | u8 | flags: 1, the stamps are of this computer's wall clock |
//! | 6 | u16 | samples, 4 to 256 |
//! | 8 | u32 | sequence number of the plan |
//! | 12 | u64 and 3 f64 each | stamp, ns since 1970 UTC; position, m |
//!
//! ```text
//! X(t)    cubic through the samples, with the slopes of their differences; at rest before the first and behind the last
//! b_j = [ X(T + (j+1) h) - 2 X(T + j h) + X(T + (j-1) h) ] / h^2        j = 0, 1, ..: turns behind the instant T
//! ```

use super::plan_rules::{
    AHEAD_S, APART_S, LARGEST_M, LARGEST_M_S2, PAST_S, PLAN_SAMPLES_MAX, PLAN_VERSION, PlanFault, REST_M_S,
    check_count,
};
use crate::commanded_motion::in_datagram;
use meniscus::units::FRAME_INTERVAL_S;

/// First bytes of a plan.
const MAGIC: [u8; 4] = *b"MNSP";
/// Bytes before the samples, and of a sample.
const HEAD: usize = 12;
const SAMPLE: usize = 32;
/// Longest datagram, bytes: a token of 128 letters and a space before the largest plan.
pub(super) const LONGEST: usize = HEAD + SAMPLE * PLAN_SAMPLES_MAX + 130;

/// A plan that was accepted.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// Its sequence number.
    pub sequence: u32,
    /// Largest distance of its samples from the line, m: what the model leaves out.
    pub across_m: f64,
    /// Seconds after the first stamp, and position on the line, m.
    samples: Vec<(f64, f64)>,
    /// First stamp, ns since 1970.
    begin_ns: u64,
}

/// Returns the plan in a datagram; `None` where it is none or lacks the `token`.
pub(super) fn read(
    bytes: &[u8],
    token: Option<&str>,
    line: &[f64; 3],
    now_ns: u64,
) -> Option<Result<Plan, PlanFault>> {
    in_datagram(bytes, token, MAGIC).map(|frame| Plan::read(frame, line, now_ns))
}

impl Plan {
    /// Returns the bytes of a plan of stamps (ns since 1970) and positions (m).
    #[must_use]
    pub fn to_bytes(sequence: u32, samples: &[(u64, [f64; 3])]) -> Vec<u8> {
        let mut bytes = MAGIC.to_vec();
        bytes.extend([PLAN_VERSION, 1]);
        bytes.extend((samples.len() as u16).to_le_bytes());
        bytes.extend(sequence.to_le_bytes());
        for (stamp_ns, position_m) in samples {
            bytes.extend(stamp_ns.to_le_bytes());
            position_m.iter().for_each(|number| bytes.extend(number.to_le_bytes()));
        }
        bytes
    }

    /// Returns the plan in `bytes` along the direction `line`, as it is at `now_ns` since 1970.
    ///
    /// # Errors
    /// [`PlanFault`].
    pub fn read(bytes: &[u8], line: &[f64; 3], now_ns: u64) -> Result<Self, PlanFault> {
        let (head, rest) = bytes.split_first_chunk::<HEAD>().ok_or(PlanFault::Layout)?;
        let [_, _, _, _, version, flags, low, high, sequence @ ..] = *head;
        if version != PLAN_VERSION {
            return Err(PlanFault::Version(version));
        }
        let count = usize::from(u16::from_le_bytes([low, high]));
        check_count(count)?;
        if flags != 1 || rest.len() != count * SAMPLE {
            return Err(PlanFault::Layout);
        }
        let samples: Vec<(u64, [f64; 3])> = rest
            .chunks_exact(SAMPLE)
            .map(|sample| {
                let number = |at: usize| f64::from_le_bytes(std::array::from_fn(|k| sample[at + k]));
                let stamp_ns = u64::from_le_bytes(std::array::from_fn(|k| sample[k]));
                (stamp_ns, std::array::from_fn(|axis| number(8 + 8 * axis)))
            })
            .collect();
        Self::of(u32::from_le_bytes(sequence), &samples, line, now_ns)
    }

    /// Returns the plan of stamps (ns since 1970) and positions (m) along the direction `line`, as it is at `now_ns`.
    ///
    /// # Errors
    /// [`PlanFault`].
    pub fn of(
        sequence: u32,
        samples: &[(u64, [f64; 3])],
        line: &[f64; 3],
        now_ns: u64,
    ) -> Result<Self, PlanFault> {
        check_count(samples.len())?;
        let mut plan =
            Self { sequence, across_m: 0.0, samples: Vec::with_capacity(samples.len()), begin_ns: 0 };
        let mut first = None;
        for (index, (stamp_ns, position_m)) in samples.iter().enumerate() {
            if !position_m.iter().all(|x| x.abs() <= LARGEST_M) {
                return Err(PlanFault::Range(index));
            }
            let (begin_ns, origin_m) = *first.get_or_insert((*stamp_ns, *position_m));
            let from_m: [f64; 3] = std::array::from_fn(|axis| position_m[axis] - origin_m[axis]);
            let along_m: f64 = from_m.iter().zip(line).map(|(x, n)| x * n).sum();
            let square: f64 = from_m.iter().map(|x| x * x).sum();
            plan.across_m = plan.across_m.max((square - along_m * along_m).max(0.0).sqrt());
            plan.begin_ns = begin_ns;
            plan.samples.push((1e-9 * (i128::from(*stamp_ns) - i128::from(begin_ns)) as f64, along_m));
        }
        plan.check(now_ns).map(|()| plan)
    }

    /// Checks the times and the motion.
    fn check(&self, now_ns: u64) -> Result<(), PlanFault> {
        for (index, [(t0, _), (t1, _)]) in self.samples.array_windows().enumerate() {
            if !(1e-6..=APART_S).contains(&(t1 - t0)) {
                return Err(PlanFault::Spacing(index + 1));
            }
        }
        for (index, [(t0, x0), (t1, x1), (t2, x2)]) in self.samples.array_windows().enumerate() {
            let bend = (x2 - x1) / (t2 - t1) - (x1 - x0) / (t1 - t0);
            // Within a frame interval a corner of the course is a kick of it.
            if (2.0 * bend / (t2 - t0).max(FRAME_INTERVAL_S)).abs() > LARGEST_M_S2 {
                return Err(PlanFault::Range(index + 1));
            }
        }
        let begins_s = 1e-9 * (i128::from(self.begin_ns) - i128::from(now_ns)) as f64;
        if begins_s < -PAST_S {
            return Err(PlanFault::Past(-begins_s));
        }
        let ends_s = begins_s + self.length_s();
        if ends_s > AHEAD_S {
            return Err(PlanFault::Future(ends_s));
        }
        let [.., (t0, x0), (t1, x1)] = self.samples[..] else { return Err(PlanFault::TooFew(0)) };
        let speed = ((x1 - x0) / (t1 - t0)).abs();
        if speed > REST_M_S { Err(PlanFault::EndsMoving(speed)) } else { Ok(()) }
    }

    /// Returns the time from the first to the last sample, s.
    #[must_use]
    pub fn length_s(&self) -> f64 {
        self.samples.last().map_or(0.0, |(time_s, _)| *time_s)
    }

    /// Returns the time from `instant_ns` (since 1970) to the end of the plan, s; below zero when it has ended.
    #[must_use]
    pub fn left_s(&self, instant_ns: u64) -> f64 {
        1e-9 * (i128::from(self.begin_ns) - i128::from(instant_ns)) as f64 + self.length_s()
    }

    /// Writes the accelerations of the turns behind the instant `instant_ns` into `out`, the next one first, m/s2.
    pub fn accelerations(&self, instant_ns: u64, out: &mut [f64]) {
        let since_s = 1e-9 * (i128::from(instant_ns) - i128::from(self.begin_ns)) as f64;
        let h = FRAME_INTERVAL_S;
        for (ahead, out) in out.iter_mut().enumerate() {
            let [before, now, next] =
                [-1.0, 0.0, 1.0].map(|k| self.position(since_s + (ahead as f64 + k) * h));
            *out = (next - 2.0 * now + before) / (h * h);
        }
    }

    /// X at `time_s` after the first stamp, m.
    fn position(&self, time_s: f64) -> f64 {
        let after = self.samples.partition_point(|(t, _)| *t <= time_s);
        let (Some(low), Some((t1, x1))) = (after.checked_sub(1), self.samples.get(after)) else {
            let end = if after == 0 { self.samples.first() } else { self.samples.last() };
            return end.map_or(0.0, |(_, x)| *x);
        };
        let (t0, x0) = self.samples[low];
        let (span, share) = (t1 - t0, (time_s - t0) / (t1 - t0));
        let (m0, m1) = (self.slope(low) * span, self.slope(after) * span);
        // Cubic Hermite form.
        let (s2, s3) = (share * share, share * share * share);
        x0 * (2.0 * s3 - 3.0 * s2 + 1.0)
            + m0 * (s3 - 2.0 * s2 + share)
            + x1 * (3.0 * s2 - 2.0 * s3)
            + m1 * (s3 - s2)
    }

    /// Slope at sample `index`, m/s: that of the parabola through it and its neighbours; at the ends zero.
    fn slope(&self, index: usize) -> f64 {
        let at = |index: usize| self.samples.get(index).copied();
        let (Some((t0, x0)), Some((t1, x1)), Some((t2, x2))) =
            (index.checked_sub(1).and_then(at), at(index), at(index + 1))
        else {
            return 0.0;
        };
        let (early, late) = (t1 - t0, t2 - t1);
        ((x1 - x0) / early * late + (x2 - x1) / late * early) / (early + late)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BEGIN_NS: u64 = 1_790_000_000_000_000_000;
    const X: [f64; 3] = [1.0, 0.0, 0.0];

    /// A move by 50 mm in half a second that begins and ends at rest: x = d (10 s^3 - 15 s^4 + 6 s^5).
    fn course(t: f64) -> f64 {
        let s = (t / 0.5).clamp(0.0, 1.0);
        0.05 * s * s * s * (10.0 - 15.0 * s + 6.0 * s * s)
    }

    fn samples(count: u64) -> Vec<(u64, [f64; 3])> {
        let at = |k: u64| (BEGIN_NS + k * 10_000_000, [course(k as f64 * 0.01), 0.0, 0.0]);
        (0..count).map(at).collect()
    }

    fn read(samples: &[(u64, [f64; 3])], now_ns: u64) -> Result<Plan, PlanFault> {
        Plan::read(&Plan::to_bytes(3, samples), &X, now_ns)
    }

    #[test]
    fn accelerations_are_the_second_differences_of_the_course() {
        let plan = read(&samples(52), BEGIN_NS).expect("a sound plan");
        let (from_s, h) = (0.113, FRAME_INTERVAL_S);
        let mut is = [0.0; 40];
        plan.accelerations(BEGIN_NS + 113_000_000, &mut is);
        for (j, is) in is.iter().enumerate() {
            let t = from_s + j as f64 * h;
            let due = (course(t + h) - 2.0 * course(t) + course(t - h)) / (h * h);
            assert!((is - due).abs() < 0.02, "{j}: {is} for {due}");
        }
        assert_eq!(is[39], 0.0, "at rest behind its end");
        assert!((plan.left_s(BEGIN_NS + 500_000_000) - 0.01).abs() < 1e-9);
    }

    #[test]
    fn what_is_no_plan_is_refused_by_name() {
        let good = samples(52);
        assert_eq!(
            read(&good[..30], BEGIN_NS).map(|_| ()).map_err(PlanFault::code),
            Err(9),
            "ends while moving"
        );
        assert!(
            matches!(read(&good, BEGIN_NS + 300_000_000), Err(PlanFault::Past(s)) if (s - 0.3).abs() < 1e-6)
        );
        assert!(matches!(read(&good, BEGIN_NS - 3_000_000_000), Err(PlanFault::Future(_))));
        assert_eq!(read(&samples(300), BEGIN_NS), Err(PlanFault::TooMany(300)));
        assert_eq!(read(&good[..3], BEGIN_NS), Err(PlanFault::TooFew(3)));
        let mut swapped = good.clone();
        swapped.swap(7, 8);
        assert_eq!(read(&swapped, BEGIN_NS), Err(PlanFault::Spacing(8)));
        let mut jump = good.clone();
        jump[20].1[0] += 0.03;
        assert!(matches!(read(&jump, BEGIN_NS), Err(PlanFault::Range(19..=21))));
        let mut nan = good.clone();
        nan[5].1[2] = f64::NAN;
        assert_eq!(read(&nan, BEGIN_NS), Err(PlanFault::Range(5)));
        let mut bytes = Plan::to_bytes(3, &good);
        bytes.pop();
        assert_eq!(Plan::read(&bytes, &X, BEGIN_NS), Err(PlanFault::Layout));
        bytes[4] = 9;
        assert_eq!(Plan::read(&bytes, &X, BEGIN_NS), Err(PlanFault::Version(9)));
    }

    #[test]
    fn what_is_across_the_line_is_stated() {
        let mut beside = samples(52);
        beside[30].1[1] = 0.004;
        let plan = read(&beside, BEGIN_NS).expect("accepted");
        assert!((plan.across_m - 0.004).abs() < 1e-12);
    }
}
