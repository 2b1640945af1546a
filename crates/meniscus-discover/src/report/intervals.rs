//! Drawing of the estimated sizes with their intervals.

use super::drawings::{mixed, opened};
use crate::findings::Estimate;
use meniscus_report::plot::{BLUE, GREY, ORANGE};
use std::fmt::Write;

/// Height of a line, width of the scale, and where it begins.
const ROW: usize = 30;
const WIDE: f64 = 420.0;
const BEGIN: f64 = 285.0;

/// Returns one line for each of `estimates`: interval, value, and a mark where the effect is absent. Each has a scale of
/// its own, which begins at the absent effect and holds the whole interval.
pub(super) fn intervals(estimates: &[Estimate]) -> String {
    let mut out = opened(800, ROW * estimates.len(), 14);
    for (i, estimate) in estimates.iter().enumerate() {
        let (least, largest) = estimate.interval;
        let (low, high) = (least.min(estimate.absent), largest.max(estimate.absent));
        let at = |value: f64| BEGIN + WIDE * (value - low) / (high - low).max(f64::MIN_POSITIVE);
        let y = ROW * i + 15;
        // Writing into a string cannot fail.
        let _ = writeln!(
            out,
            "<text x=\"275\" y=\"{}\" text-anchor=\"end\">{} {}</text><line x1=\"{:.1}\" x2=\"{:.1}\" y1=\"{y}\" \
             y2=\"{y}\" stroke=\"{}\" stroke-width=\"6\"/><circle cx=\"{:.1}\" cy=\"{y}\" r=\"6\" fill=\"{}\"/><line \
             x1=\"{absent:.1}\" x2=\"{absent:.1}\" y1=\"{}\" y2=\"{}\" stroke=\"{}\" stroke-width=\"3\"/>",
            y + 5,
            estimate.effect,
            estimate.parameter,
            at(least),
            at(largest),
            mixed(GREY, 1.0),
            at(estimate.value),
            mixed(BLUE, 1.0),
            y - 11,
            y + 11,
            mixed(ORANGE, 1.0),
            absent = at(estimate.absent),
        );
    }
    out + "</svg>"
}
