//! Where a blurred step lies between pixels.
//!
//! Every pixel integrates over its area, so the sum of a blurred step does not depend on the blur:
//! with the tones `i_k` inside and `o` outside, the pixels `g_k` of a window hold
//!
//! `n = sum_k (g_k - o) / (i_k - o)`
//!
//! pixels of inside, whatever the point-spread function, if it fits into the window. Interpolating
//! the crossing of the half level instead is biased by up to 0.03 pixel, periodic in the sub-pixel
//! position, and all rows of an upright edge share that bias.
#![allow(
    clippy::manual_clamp,
    reason = "`clamp` keeps what is no number, `max` and `min` put a bound in its place"
)]

/// Pixels that give the tone inside, that hold the step, and that give the tone outside.
const INSIDE: usize = 5;
const WINDOW: usize = 6;
const OUTSIDE: usize = 3;

/// Share by which a pixel may lie beyond the two tones: noise does, the light of a projector's dot goes farther.
const BEYOND: f32 = 0.05;
/// Half width of the middle part of a step, pixels, and times that it is centred anew.
const MIDDLE: f32 = 1.25;
const ROUNDS: usize = 3;

/// Pixel in the middle of the inner ones.
const MIDDLE_PIXEL: f32 = (INSIDE / 2) as f32;

/// Length of a profile across an edge, from inside to outside.
pub(super) const SPAN: usize = INSIDE + WINDOW + OUTSIDE;
/// Pixels of a profile on the inner side of the coarse edge.
pub(super) const REACH: usize = INSIDE + WINDOW / 2;

/// Least squares line through the inner pixels of a profile.
struct InnerLine {
    /// Grey level in the middle of the inner pixels.
    mean: f32,
    /// Grey levels per pixel: `sum k g / sum k^2`, with `k` counted from the middle.
    slope: f32,
    /// `sum k^2`.
    squares: f32,
}

impl InnerLine {
    fn through(profile: &[f32; SPAN]) -> Self {
        let inner =
            || profile.iter().zip(0_u8..).take(INSIDE).map(|(&g, k)| (g, f32::from(k) - MIDDLE_PIXEL));
        let squares = inner().map(|(_, k)| k * k).sum::<f32>();
        Self {
            mean: inner().map(|(g, _)| g).sum::<f32>() / INSIDE as f32,
            slope: inner().map(|(g, k)| k * g).sum::<f32>() / squares,
            squares,
        }
    }
}

/// Pixels of inside in a profile that runs from inside to outside: the edge lies that far from the
/// outer side of its first pixel. `None` if the step is smaller than `least` grey levels, or the
/// edge is not inside the window.
///
/// The inner tone goes on along the line through the inner pixels: a cylinder darkens towards its limb.
pub(super) fn inside_pixels(profile: &[f32; SPAN], least: f32) -> Option<f32> {
    let inner = InnerLine::through(profile);
    let outside = profile.iter().rev().take(OUTSIDE).sum::<f32>() / OUTSIDE as f32;
    let mut n = 0.0;
    for (g, k) in profile.iter().zip(0_u8..).skip(INSIDE).take(WINDOW) {
        let step = inner.mean + inner.slope * (f32::from(k) - MIDDLE_PIXEL) - outside;
        // The line must not reach the tone outside within the window, nor the step be too small.
        if step.abs() < least {
            return None;
        }
        n += (g - outside) / step;
    }
    (0.0..=WINDOW as f32).contains(&n).then_some(INSIDE as f32 + n)
}

/// Tones on the two sides of a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Tones {
    pub(super) inside: f32,
    pub(super) outside: f32,
}

impl Tones {
    /// The tones at the two ends of a profile.
    pub(super) fn of(profile: &[f32; SPAN]) -> Self {
        let mean = |sum: f32, count: usize| sum / count as f32;
        Self {
            inside: mean(profile.iter().take(INSIDE).sum(), INSIDE),
            outside: mean(profile.iter().rev().take(OUTSIDE).sum(), OUTSIDE),
        }
    }

    /// The same as [`inside_pixels`] between these tones. A pixel counts for one at most, so that spots of light on
    /// either side move nothing.
    pub(super) fn inside_pixels(self, profile: &[f32; SPAN], least: f32) -> Option<f32> {
        let step = self.inside - self.outside;
        if step.abs() < least {
            return None;
        }
        let window = profile.iter().skip(INSIDE).take(WINDOW);
        let n = window.fold(0.0, |sum, g| sum + ((g - self.outside) / step).max(-BEYOND).min(1.0 + BEYOND));
        (0.0..=WINDOW as f32).contains(&n).then_some(INSIDE as f32 + n)
    }
}

/// Mean square of what the inner pixels of a profile deviate from a straight line, squares of grey levels: noise, and the
/// spots of a projector.
pub(super) fn spots(profile: &[f32; SPAN]) -> f32 {
    let InnerLine { mean, slope, squares } = InnerLine::through(profile);
    let off =
        profile.iter().take(INSIDE).map(|g| (g - mean) * (g - mean)).sum::<f32>() - slope * slope * squares;
    // A line takes two of them.
    off / (INSIDE - 2) as f32
}

/// Distance from `edge` outwards to the centre of the steepest part of a step; both count from the outer side of the
/// profile's first pixel.
///
/// Between `e - w` and `e + w` the step falls from `g_i` to `g_o`; by its area `A` it lies at `e - w + (A - 2 w g_o) / (g_i - g_o)`.
/// For a symmetric blur that is the edge itself. A tail on one side, as of a liquid that shines through, moves the
/// centre of the whole step, and this one hardly.
pub(super) fn lead(profile: &[f32; SPAN], edge: f32) -> Option<f32> {
    let at = |x: f32| {
        let x = (x - 0.5).max(0.0);
        let (index, share) = (x as usize, x - (x as usize) as f32);
        Some(profile.get(index)? * (1.0 - share) + profile.get(index + 1)? * share)
    };
    let area = |from: f32, to: f32| {
        let pixels = profile.iter().zip(0_u8..).map(|(g, k)| {
            let left = f32::from(k);
            g * (to.min(left + 1.0) - from.max(left)).max(0.0)
        });
        pixels.sum::<f32>()
    };
    let mut centre = edge;
    for _ in 0..ROUNDS {
        let (from, to) = (centre - MIDDLE, centre + MIDDLE);
        let (inner, outer) = (at(from)?, at(to)?);
        let fall = inner - outer;
        if fall.abs() < 1.0 {
            return None;
        }
        centre = from + ((area(from, to) - 2.0 * MIDDLE * outer) / fall).max(0.0).min(2.0 * MIDDLE);
    }
    Some(centre - edge)
}

#[cfg(test)]
#[allow(clippy::disallowed_methods, reason = "a test may take the platform's functions")]
mod tests {
    use super::*;

    /// A profile whose edge lies `at` pixels from the outer side of its first pixel, blurred by a box
    /// of two pixels on top of the pixel's own.
    fn blurred(at: f32, inside: impl Fn(f32) -> f32, outside: f32) -> [f32; SPAN] {
        let mut profile = [0.0; SPAN];
        for (index, pixel) in profile.iter_mut().enumerate() {
            let fine = 300;
            for step in 0..fine {
                let x = index as f32 + 3.0 * (step as f32 + 0.5) / fine as f32 - 1.0;
                *pixel += if x < at { inside(x) } else { outside } / fine as f32;
            }
        }
        profile
    }

    #[test]
    fn the_place_of_a_step_does_not_depend_on_its_phase() {
        for phase in 0..20 {
            let at = REACH as f32 - 0.5 + 0.05 * phase as f32;
            let level = blurred(at, |_| 40.0, 150.0);
            let n = Tones::of(&level).inside_pixels(&level, 50.0);
            assert!((n.unwrap() - at).abs() < 0.01, "{at}: {n:?}");
            let n = inside_pixels(&blurred(at, |x| 60.0 - 2.0 * x, 150.0), 50.0);
            assert!((n.unwrap() - at).abs() < 0.06, "{at}: {n:?}");
        }
    }

    #[test]
    fn a_small_step_or_none_has_no_place() {
        for profile in [[90.0; SPAN], blurred(8.0, |_| 100.0, 130.0), [f32::NAN; SPAN]] {
            assert_eq!(inside_pixels(&profile, 50.0), None);
            assert_eq!(Tones::of(&profile).inside_pixels(&profile, 50.0), None);
        }
    }

    #[test]
    fn the_steepest_part_leads_before_a_tail_and_not_without() {
        for phase in 0..20 {
            let at = REACH as f32 - 0.5 + 0.05 * phase as f32;
            let clean = blurred(at, |_| 40.0, 150.0);
            let found = Tones::of(&clean).inside_pixels(&clean, 50.0).unwrap();
            assert!(lead(&clean, found).unwrap().abs() < 0.06, "{at}");
            // A bright liquid that loses 30 % of its step over a pixel before its end.
            let tailed = blurred(at, |x| 200.0 - 0.3 * 120.0 * (x - at).exp(), 80.0);
            let found = Tones::of(&tailed).inside_pixels(&tailed, 50.0).unwrap();
            let led = found + lead(&tailed, found).unwrap();
            assert!(at - found > 0.12 && led - found > 0.015 && led < at, "{at}: {found} {led}");
        }
    }

    #[test]
    fn a_dot_beside_the_edge_is_a_spot_and_a_slope_is_none() {
        let sloped = |k: usize| 180.0 - 3.0 * k as f32;
        let mut profile: [f32; SPAN] = core::array::from_fn(sloped);
        assert!(spots(&profile) < 1e-3, "{}", spots(&profile));
        // Deviations of one of five from their line: d^2 (1 - 1/5) of a dot in the middle, over 3.
        profile[2] += 60.0;
        assert!((spots(&profile) - 960.0).abs() < 0.1, "{}", spots(&profile));
    }

    #[test]
    fn a_spot_of_light_beyond_the_step_moves_nothing() {
        let mut profile = blurred(8.0, |_| 40.0, 150.0);
        let tones = Tones::of(&profile);
        let clean = tones.inside_pixels(&profile, 50.0).unwrap();
        profile[9] += 100.0;
        profile[10] += 60.0;
        let spotted = tones.inside_pixels(&profile, 50.0).unwrap();
        assert!((spotted - clean).abs() < 0.11, "{clean} {spotted}");
    }
}
