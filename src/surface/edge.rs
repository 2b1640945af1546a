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

/// Pixels that give the tone inside, that hold the step, and that give the tone outside.
const INSIDE: usize = 5;
const WINDOW: usize = 6;
const OUTSIDE: usize = 3;

/// Length of a profile across an edge, from inside to outside.
pub(super) const SPAN: usize = INSIDE + WINDOW + OUTSIDE;
/// Pixels of a profile on the inner side of the coarse edge.
pub(super) const REACH: usize = INSIDE + WINDOW / 2;

/// Continuation of the inner tone towards the edge.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Tone {
    /// As the mean of the inner pixels.
    Level,
    /// Along the line through the inner pixels: a cylinder darkens towards its limb.
    Line,
}

/// Pixels of inside in a profile that runs from inside to outside: the edge lies that far from the
/// outer side of its first pixel. `None` if the step is smaller than `least` grey levels, or the
/// edge is not inside the window.
pub(super) fn inside_pixels(profile: &[f32; SPAN], tone: Tone, least: f32) -> Option<f32> {
    // Least squares line through the inner pixels, k counted from their middle: slope = sum k g / sum k^2.
    let middle = (INSIDE / 2) as f32;
    let inner = || profile.iter().zip(0_u8..).take(INSIDE).map(|(&g, k)| (g, f32::from(k) - middle));
    let inside = inner().map(|(g, _)| g).sum::<f32>() / INSIDE as f32;
    let slope = match tone {
        Tone::Level => 0.0,
        Tone::Line => inner().map(|(g, k)| k * g).sum::<f32>() / inner().map(|(_, k)| k * k).sum::<f32>(),
    };
    let outside = profile.iter().rev().take(OUTSIDE).sum::<f32>() / OUTSIDE as f32;
    let mut n = 0.0;
    for (g, k) in profile.iter().zip(0_u8..).skip(INSIDE).take(WINDOW) {
        let step = inside + slope * (f32::from(k) - middle) - outside;
        // The line must not reach the tone outside within the window, nor the step be too small.
        if step.abs() < least {
            return None;
        }
        n += (g - outside) / step;
    }
    (0.0..=WINDOW as f32).contains(&n).then_some(INSIDE as f32 + n)
}

#[cfg(test)]
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
            let n = inside_pixels(&blurred(at, |_| 40.0, 150.0), Tone::Level, 50.0);
            assert!((n.unwrap() - at).abs() < 0.01, "{at}: {n:?}");
            let n = inside_pixels(&blurred(at, |x| 60.0 - 2.0 * x, 150.0), Tone::Line, 50.0);
            assert!((n.unwrap() - at).abs() < 0.06, "{at}: {n:?}");
        }
    }

    #[test]
    fn a_small_step_or_none_has_no_place() {
        assert_eq!(inside_pixels(&[90.0; SPAN], Tone::Level, 50.0), None);
        assert_eq!(inside_pixels(&blurred(8.0, |_| 100.0, 130.0), Tone::Level, 50.0), None);
        assert_eq!(inside_pixels(&[f32::NAN; SPAN], Tone::Line, 50.0), None);
    }
}
