//! Rectangles of an image, and parts that are searched in a smaller size.

/// Share of its size that is looked at around a tag, for the white margin and a tag that comes near.
const MARGIN: f64 = 0.4;

/// A rectangle of pixels, ends exclusive.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Region {
    pub(crate) left: usize,
    pub(crate) right: usize,
    pub(crate) top: usize,
    pub(crate) bottom: usize,
}

/// A part of an image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Part {
    /// Its pixels.
    pub(crate) region: Region,
    /// Pixels along each axis whose mean is one pixel of the part.
    pub(crate) scale: usize,
}

/// Returns the least and the largest coordinate of some corners along an axis, px.
pub(crate) fn span_px(corners_px: &[[f64; 2]; 4], axis: usize) -> [f64; 2] {
    let along = corners_px.iter().map(|corner| corner[axis]);
    along.fold([f64::MAX, f64::MIN], |[least, most], at| [least.min(at), most.max(at)])
}

impl Part {
    /// Returns its width in its own pixels.
    pub(crate) fn columns(&self) -> usize {
        (self.region.right - self.region.left) / self.scale
    }
}

impl Region {
    /// Returns the distance of its centre from `place`, px.
    pub(crate) fn distance_px(&self, [x, y]: [f64; 2]) -> f64 {
        let middle = |from: usize, to: usize| 0.5 * (from + to) as f64;
        (middle(self.left, self.right) - x).hypot(middle(self.top, self.bottom) - y)
    }

    /// Returns the region with a tag and its margin, and `reach_px` around that.
    pub(crate) fn around(corners_px: &[[f64; 2]; 4], (width, height): (usize, usize), reach_px: f64) -> Self {
        let ends = |axis: usize, length: usize| {
            let [least, most] = span_px(corners_px, axis);
            let margin = reach_px + MARGIN * (most - least);
            let inside = |value: f64| value.clamp(0.0, length as f64) as usize;
            (inside((least - margin).floor()), inside((most + margin).ceil() + 1.0))
        };
        let ((left, right), (top, bottom)) = (ends(0, width), ends(1, height));
        Self { left, right, top, bottom }
    }
}
