//! Next crest of a recording, as a forecast of it is judged.

/// A crest counts from this height over the fill, m.
pub const CREST_M: f64 = 0.003;

/// Frames between two looks for the next crest.
pub const EVERY: usize = 3;

/// Frames within which it is looked for: half a second.
pub const WITHIN: usize = 30;

/// Returns the frame of the first crest after `frame`, if one comes in time: a maximum over time of `highest_m`, the highest
/// point of each frame's surface, metres above the inner bottom.
///
/// ```
/// use meniscus_score::crests::next;
///
/// let highest_m = [0.070, 0.071, 0.0705, 0.072, 0.076, 0.074];
/// // The first maximum is 1 mm over the fill of 70 mm, which counts as none.
/// assert_eq!(next(&highest_m, 0.070, 0), Some(4));
/// assert_eq!(next(&highest_m, 0.070, 4), None);
/// ```
#[must_use]
pub fn next(highest_m: &[f32], fill_m: f64, frame: usize) -> Option<usize> {
    let window = frame + 1..(frame + WITHIN).min(highest_m.len().saturating_sub(1));
    let is_top = |n: &usize| highest_m[*n] > highest_m[n - 1] && highest_m[*n] >= highest_m[n + 1];
    window.into_iter().find(|n| is_top(n) && counts(highest_m[*n], fill_m))
}

/// Whether a crest of this height counts. A forecast one that does not is none of those that [`next`] finds.
#[must_use]
pub fn counts(height_m: f32, fill_m: f64) -> bool {
    f64::from(height_m) - fill_m > CREST_M
}
