//! The wanted tag from image to image: which pose is accepted, and why another is not.

use crate::finder::{FinderError, SeenTag, TagFinder, is_small};
use crate::parts::Parts;
use crate::pose::{PoseFault, TagPose, pose};
use crate::rest::Rest;
use meniscus::surface::Intrinsics;
use meniscus::units::Micros;
use meniscus_service::commanded_motion::TagCounts;
use std::time::Duration;

/// Largest speed of a tag that is accepted, m/s, and what its error may add, m.
const FASTEST_M_S: f64 = 3.0;
const SLACK_M: f64 = 0.005;
/// Time without an accepted pose after which the next one is accepted wherever it is, s.
const FORGOTTEN_S: f64 = 0.25;
/// Depth of a tag that is accepted, m.
const DEPTHS_M: [f64; 2] = [0.05, 5.0];

/// The tag that is looked for, and the camera before it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wanted {
    /// Number in the family 36h11.
    pub number: u32,
    /// Width of its black border, m.
    pub size_m: f64,
    /// Lens of the image.
    pub lens: Intrinsics,
    /// Pitch of the camera, rad, positive when it looks up.
    pub pitch_rad: f64,
}

/// Outcome of an image.
#[derive(Clone, Debug, PartialEq)]
pub enum Sighting {
    /// Its pose is accepted. `is_first` where it does not go on from an earlier one.
    Seen {
        /// The pose.
        pose: Box<TagPose>,
        /// Whether there was no accepted pose shortly before.
        is_first: bool,
    },
    /// There is no tag in the part that was searched, or only one of a smaller size, whose corners come with the next image.
    Missing,
    /// There is a tag of this number alone.
    OtherNumber(u32),
    /// There are two of its number.
    Doubled,
    /// Its corners have no pose.
    Unfit(PoseFault),
    /// It is this far from the one before, m.
    Jump(f64),
}

/// The last accepted pose.
#[derive(Clone, Copy, Debug)]
struct Last {
    at: Micros,
    pose: TagPose,
    corners_px: [[f64; 2]; 4],
}

/// Follows one tag.
#[derive(Debug)]
pub struct TagTracker {
    wanted: Wanted,
    finder: TagFinder,
    parts: Parts,
    /// Corners that were seen in a smaller size in the image before, px: where they are to be looked for in the whole one.
    hint_px: Option<[[f64; 2]; 4]>,
    last: Option<Last>,
    /// Centre of the tag where it was seen last, px.
    place_px: Option<[f64; 2]>,
    rest: Rest,
    counts: TagCounts,
    /// Time of all images together, us.
    total_us: u64,
}

impl std::fmt::Display for Sighting {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Seen { .. } => f.write_str("the tag is seen"),
            Self::Missing => f.write_str(
                "no tag in the image, which is searched a part at a time; it has to be sharp, whole with its white margin, and 27 \
                 pixels wide",
            ),
            Self::OtherNumber(number) => write!(f, "the tag in the image has the number {number}"),
            Self::Doubled => {
                f.write_str("two tags of this number are in the image: cover one, or print another number")
            }
            Self::Unfit(fault) => write!(f, "the tag has no pose: {fault}"),
            Self::Jump(m) => write!(f, "the tag was {:.0} mm away from where it can be", 1e3 * m),
        }
    }
}

impl TagTracker {
    /// Returns a tracker that has seen nothing yet.
    ///
    /// # Errors
    /// [`FinderError`].
    pub fn new(wanted: Wanted) -> Result<Self, FinderError> {
        let finder = TagFinder::new((wanted.lens.width, wanted.lens.height))?;
        let (rest, counts) = (Rest::unknown(wanted.pitch_rad), TagCounts::default());
        let parts = Parts::default();
        Ok(Self {
            wanted,
            finder,
            parts,
            hint_px: None,
            last: None,
            place_px: None,
            rest,
            counts,
            total_us: 0,
        })
    }

    /// Returns the counters so far.
    #[must_use]
    pub fn counts(&self) -> TagCounts {
        TagCounts { travel: self.rest.travel(), ..self.counts }
    }

    /// Notes the time that the work on the last image took.
    pub fn took(&mut self, time: Duration) {
        let us = u64::try_from(time.as_micros()).unwrap_or(u64::MAX);
        self.total_us = self.total_us.saturating_add(us);
        self.counts.image_us_max = self.counts.image_us_max.max(us);
        self.counts.image_us_mean = self.total_us / self.counts.images.max(1);
    }

    /// Looks for the tag in the grey image that was taken at `at`.
    ///
    /// # Errors
    /// [`FinderError`].
    pub fn look(&mut self, at: Micros, image: &[u8]) -> Result<Sighting, FinderError> {
        let passed_s = |last: &Last| (at.0 as f64 - last.at.0 as f64) * 1e-6;
        self.last = self.last.filter(|last| (0.0..=FORGOTTEN_S).contains(&passed_s(last)));
        let sighting = match self.find(image)? {
            Ok(seen) => self.judge(at, &seen),
            Err(sighting) => sighting,
        };
        let counts = &mut self.counts;
        counts.images += 1;
        let counter = match &sighting {
            Sighting::Seen { pose, .. } => {
                counts.ambiguous += u64::from(pose.other.is_some());
                &mut counts.seen
            }
            Sighting::Missing => &mut counts.missing,
            Sighting::OtherNumber(_) => &mut counts.other_number,
            Sighting::Doubled => &mut counts.doubled,
            Sighting::Unfit(_) => &mut counts.unfit,
            Sighting::Jump(_) => &mut counts.jumps,
        };
        *counter += 1;
        if let Sighting::Seen { pose, .. } = &sighting {
            self.rest.take(pose);
        }
        Ok(sighting)
    }

    /// Finds the one wanted tag: near its last place, where a part of the image is searched for another one of its number, or else
    /// in a part of the image.
    fn find(&mut self, image: &[u8]) -> Result<Result<SeenTag, Sighting>, FinderError> {
        let number = self.wanted.number;
        let size = (self.wanted.lens.width, self.wanted.lens.height);
        let hint = self.hint_px.take();
        if let Some(corners_px) = hint.or(self.last.map(|last| last.corners_px)) {
            match only(self.finder.nearby(image, &corners_px)?, number) {
                Ok(tag) => {
                    let part = self.parts.beside(size, &tag.corners_px);
                    let others = part.map(|part| self.finder.beside(image, part, &tag)).transpose()?;
                    let another = others.into_iter().flatten().any(|other| other.number == number);
                    return Ok(if another { Err(Sighting::Doubled) } else { Ok(tag) });
                }
                Err(Sighting::Doubled) => return Ok(Err(Sighting::Doubled)),
                Err(_) => {}
            }
        }
        let part = self.parts.search(size, self.place_px);
        let found = match only(self.finder.within(image, part)?, number) {
            Ok(found) => found,
            Err(sighting) => return Ok(Err(sighting)),
        };
        if part.scale > 1 {
            // Its corners in the whole size are work for the next image.
            self.hint_px = Some(found.corners_px);
            return Ok(Err(Sighting::Missing));
        }
        if !is_small(&found.corners_px) {
            return Ok(Ok(found));
        }
        Ok(only(self.finder.nearby(image, &found.corners_px)?, number).or(Ok(found)))
    }

    /// Accepts the pose of a tag, or says why not.
    fn judge(&mut self, at: Micros, seen: &SeenTag) -> Sighting {
        let Wanted { size_m, lens, .. } = &self.wanted;
        let pose = match pose(&seen.corners_px, *size_m, lens) {
            Ok(pose) => pose,
            Err(fault) => return Sighting::Unfit(fault),
        };
        if !(DEPTHS_M[0]..=DEPTHS_M[1]).contains(&pose.position_m.z) {
            return Sighting::Jump(pose.position_m.norm());
        }
        let before = self.last;
        let pose = before.map_or(pose, |last| pose.nearer_to(&last.pose.rotation));
        if let Some(last) = before {
            let passed_s = at.0.saturating_sub(last.at.0) as f64 * 1e-6;
            let away_m = (pose.position_m - last.pose.position_m).norm();
            if away_m > FASTEST_M_S * passed_s + SLACK_M {
                return Sighting::Jump(away_m);
            }
        }
        self.last = Some(Last { at, pose, corners_px: seen.corners_px });
        self.place_px = Some(seen.centre_px());
        Sighting::Seen { pose: Box::new(pose), is_first: before.is_none() }
    }
}

/// Returns the one tag of `number`, or why there is none.
fn only(found: &[SeenTag], number: u32) -> Result<SeenTag, Sighting> {
    let mut of_number = found.iter().filter(|tag| tag.number == number);
    match (of_number.next(), of_number.next(), found.first()) {
        (Some(tag), None, _) => Ok(*tag),
        (Some(_), Some(_), _) => Err(Sighting::Doubled),
        (None, _, Some(other)) => Err(Sighting::OtherNumber(other.number)),
        (None, _, None) => Err(Sighting::Missing),
    }
}
