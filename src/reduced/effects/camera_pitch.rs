//! A pitch of the camera that is not known of: the near wall's points lie at depths `-R sqrt(1 - x^2/R^2)`,
//! so the profile bows by `theta R (1 - sqrt(1 - x^2/R^2))`, even in x, at rest too.

use super::{Class, Entry, Parameter, Slot};

pub(super) const ENTRY: Entry = Entry {
    name: "camera_pitch",
    class: Class::View,
    parameters: &[Parameter {
        name: "angle",
        unit: "rad",
        neutral: 0.0,
        range: (-0.35, 0.35),
        typical: 0.02,
        meaning: "pitch beyond the stated one, positive when the camera looks down",
    }],
    about: "the camera is pitched",
    source: "rotation about the camera's horizontal",
    slot: Slot::View(|[angle, _], view| view.pitch_rad += angle),
};
