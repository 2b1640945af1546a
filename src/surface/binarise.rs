//! Liquid or background: Otsu's threshold on the histogram of the region.
//!
//! Source: N. Otsu, A threshold selection method from gray-level histograms, IEEE Trans. SMC 9 (1979).

use super::region::{Grey, Region};
use super::settings::Liquid;

/// The threshold between two classes of pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Threshold {
    /// Half-way between the classes' means, grey levels.
    level: f32,
    /// Difference between the classes' means, grey levels.
    pub(super) contrast: f32,
    liquid: Liquid,
}

impl Threshold {
    /// Otsu's threshold: the `t` that maximises the variance between the classes,
    ///
    /// `w0 w1 (m0 - m1)^2`, with `w` the shares and `m` the means of the pixels at most and above `t`.
    ///
    /// `None` if all pixels are equal, or there are none.
    pub(super) fn of(image: Grey<'_>, region: Region, liquid: Liquid) -> Option<Self> {
        let mut histogram = [0_u32; 256];
        for row in region.top..region.bottom {
            for &grey in image.row(row, region.left, region.right) {
                if let Some(count) = histogram.get_mut(usize::from(grey)) {
                    *count = count.saturating_add(1);
                }
            }
        }
        let graded = || histogram.iter().zip(0_u16..).map(|(&n, grey)| (n as f32, f32::from(grey)));
        let (all, sum) = graded().fold((0.0, 0.0), |(all, sum), (n, grey)| (all + n, sum + n * grey));
        let (mut below, mut below_sum) = (0.0, 0.0);
        let mut best: Option<(f32, f32, f32)> = None;
        for (n, grey) in graded() {
            below += n;
            below_sum += n * grey;
            let above = all - below;
            if below > 0.0 && above > 0.0 {
                let (dark, bright) = (below_sum / below, (sum - below_sum) / above);
                let between = below * above * (bright - dark) * (bright - dark);
                if best.is_none_or(|(most, _, _)| between > most) {
                    best = Some((between, dark, bright));
                }
            }
        }
        best.map(|(_, dark, bright)| Self { level: 0.5 * (dark + bright), contrast: bright - dark, liquid })
    }

    /// Returns whether a pixel belongs to the liquid.
    pub(super) fn is_liquid(&self, grey: u8) -> bool {
        match self.liquid {
            Liquid::Dark | Liquid::Clear => f32::from(grey) < self.level,
            Liquid::Bright => f32::from(grey) > self.level,
        }
    }
}
