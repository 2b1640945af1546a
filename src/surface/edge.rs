//! Where a blurred step lies between pixels.
//!
//! Every pixel integrates over its area, so the sum of a blurred step does not depend on the blur:
//! with the levels `i` inside and `o` outside, the pixels `g_k` of a window hold
//!
//! `n = sum_k (g_k - o) / (i - o)`
//!
//! pixels of inside, whatever the point-spread function, if it fits into the window. Interpolating
//! the crossing of the half level instead is biased by up to 0.03 pixel, periodic in the sub-pixel
//! position, and all rows of an upright edge share that bias.

/// Pixels of a profile on either side of the coarse edge.
pub(super) const REACH: usize = 6;
/// Length of a profile across an edge: from inside to outside, the coarse edge in the middle.
pub(super) const SPAN: usize = 2 * REACH;
/// Pixels at either end that give the level of their side.
const LEVEL: usize = 3;

/// Pixels of inside in a profile that runs from inside to outside: the edge lies that far from the
/// outer side of its first pixel. `None` if the step is smaller than `least` grey levels, or the
/// edge is not between the level pixels.
pub(super) fn inside_pixels(profile: &[f32; SPAN], least: f32) -> Option<f32> {
    let inside = profile.iter().take(LEVEL).sum::<f32>() / LEVEL as f32;
    let outside = profile.iter().rev().take(LEVEL).sum::<f32>() / LEVEL as f32;
    let step = inside - outside;
    if step.abs() < least {
        return None;
    }
    let window = profile.iter().skip(LEVEL).take(SPAN - 2 * LEVEL);
    let n = window.map(|g| (g - outside) / step).sum::<f32>();
    let room = (SPAN - 2 * LEVEL) as f32;
    (0.0..=room).contains(&n).then_some(LEVEL as f32 + n)
}
