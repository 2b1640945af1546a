//! Counters of the images in which a tag was looked for.

/// Images by their outcome, and the course of the tag.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize)]
pub struct TagCounts {
    /// Images that were looked at.
    pub images: u64,
    /// Images whose pose was taken.
    pub seen: u64,
    /// Images of them in which two attitudes explain the corners; the position is nearly the same in both.
    pub ambiguous: u64,
    /// Images in whose searched part there was no tag.
    pub missing: u64,
    /// Images with tags of other numbers alone.
    pub other_number: u64,
    /// Images with two tags of the number.
    pub doubled: u64,
    /// Images whose corners are not those of a plane square, or whose two attitudes differ in position.
    pub unfit: u64,
    /// Images whose pose is too far from the one before.
    pub jumps: u64,
    /// Mean and longest time of the work on an image, us.
    pub image_us_mean: u64,
    /// The longest.
    pub image_us_max: u64,
    /// Course since the rest; `None` where the tag was never at rest.
    pub travel: Option<TagTravel>,
}

/// Largest distances of the tag from where it was at rest, with the standard deviation of a single image.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize)]
pub struct TagTravel {
    /// Along the camera's x, mm.
    pub along_mm: f64,
    /// Towards the camera or away from it, level, mm.
    pub away_mm: f64,
    /// Up or down, mm.
    pub lift_mm: f64,
    /// Angle between its normals, degrees; of images whose attitude is not ambiguous.
    pub inclination_deg: f64,
    /// Standard deviation of a position along x, across it and in depth, the largest of all images, mm.
    pub position_std_mm: f64,
    /// Standard deviation of an attitude, the largest of the same images, degrees.
    pub attitude_std_deg: f64,
}
