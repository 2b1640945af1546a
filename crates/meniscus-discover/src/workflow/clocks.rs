//! Alignment of recordings whose clocks are not those of their motions, the same for the program and for the study.

use crate::baseline::calibrate::Calibration;
use crate::baseline::clock::{Clock, clock, moved};
use crate::recordings::record::Record;
use crate::recordings::stated::Known;
use rayon::prelude::*;

/// Time by which a recording that claims its own clock may be off, s.
pub const RANGE_S: (f64, f64) = (-0.5, 0.5);

/// Time below which a motion is left where it is, s: the lag of each recording is fitted all the same.
const LEAST_S: f64 = 0.005;

/// Alignment of one recording.
#[derive(Clone, Debug, PartialEq)]
pub struct AlignedClock {
    /// Recording.
    pub recording: String,
    /// Its alignment.
    pub clock: Clock,
}

impl AlignedClock {
    /// Returns why the recording was left out, in words.
    #[must_use]
    pub fn refusal(&self) -> Option<String> {
        let rival = self.clock.rival.filter(|_| self.clock.is_ambiguous())?;
        let best = self.clock.best;
        Some(format!(
            "{}: its clock is ambiguous: with the motion {:+.3} s later the model leaves {:.2} mm, with {:+.3} s {:.2} mm; \
             record a rest before the motion and all of the motion, or align the clocks by a mark of both",
            self.recording,
            best.late_s,
            1e3 * best.error_m,
            rival.late_s,
            1e3 * rival.error_m
        ))
    }
}

/// Recordings on the clocks of their motions.
#[derive(Clone, Debug, Default)]
pub struct Aligned {
    /// Recordings whose alignment is certain.
    pub records: Vec<Record>,
    /// Alignment of every recording; those that are ambiguous are not among `records`.
    pub clocks: Vec<AlignedClock>,
}

/// Aligns `records` of the liquid `known` within `range_s`.
///
/// What is withheld of a recorded motion may be what is missing, so the clock may fit with it or without it.
#[must_use]
pub fn aligned(records: &[Record], known: &Known, range_s: (f64, f64)) -> Aligned {
    let theta = Calibration::blind(records, 0.0).mean;
    let mut liquids = vec![*known, Known { motion_share: [1.0; 2], ..*known }];
    liquids.dedup();
    let found: Vec<(&Record, Clock)> = records
        .par_iter()
        .filter_map(|record| Some((record, clock(record, &liquids, &theta, range_s)?)))
        .collect();
    let mut out = Aligned::default();
    for (record, clock) in found {
        let late_s = clock.best.late_s;
        if !clock.is_ambiguous() {
            out.records.push(if late_s.abs() < LEAST_S { record.clone() } else { moved(record, late_s) });
        }
        out.clocks.push(AlignedClock { recording: record.name.clone(), clock });
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::baseline::clock::Alignment;

    #[test]
    fn an_ambiguous_clock_is_refused_with_both_times_and_a_certain_one_is_not() {
        let at = |late_s: f64, error_m: f64| Alignment { late_s, error_m };
        let clock = |rival: f64| Clock { best: at(0.12, 4.0e-3), rival: Some(at(-0.21, rival)) };
        let of = |clock: Clock| AlignedClock { recording: "swing".into(), clock }.refusal();
        assert_eq!(of(clock(8.0e-3)), None);
        let words = of(clock(4.1e-3)).expect("hardly better");
        for part in ["swing:", "+0.120 s", "4.00 mm", "-0.210 s", "4.10 mm"] {
            assert!(words.contains(part), "{words}");
        }
    }
}
