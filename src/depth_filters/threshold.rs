//! Depths outside of a range become holes: kept where `min <= units z <= max`, in single precision.
//! Source: librealsense 2.56.5, threshold filter, as measured.

/// Keeps depths from `min_m` to `max_m`, both included.
///
/// ```
/// let mut image = [99, 100, 4000, 4001];
/// meniscus::depth_filters::threshold(&mut image, 0.001, 0.1, 4.0);
/// assert_eq!(image, [0, 100, 4000, 0]);
/// ```
pub fn threshold(image: &mut [u16], depth_unit_m: f32, min_m: f32, max_m: f32) {
    for z in image {
        let metres = depth_unit_m * f32::from(*z);
        *z = if metres >= min_m && metres <= max_m { *z } else { 0 };
    }
}

#[cfg(test)]
mod tests {
    #[test]
    fn both_ends_are_kept() {
        let mut image = [0, 99, 100, 2000, 4000, 4001];
        super::threshold(&mut image, 0.001, 0.1, 4.0);
        assert_eq!(image, [0, 0, 100, 2000, 4000, 0]);
    }
}
