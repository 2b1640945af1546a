//! An inclined glass: gravity leaves `g sin theta` along the surface. Under a constant angle the surface is
//! level in the room and `tan theta` in the glass: at rest the same in a profile as a rolled camera. A wave tells
//! the two apart, because in a glass that leans it carries waves of other shapes along (`slosh::SecondOrder`).
//! Beside it the part of the recorded inclination that the model was not told of, which acts as a push.

use super::{Class, Entry, Parameter, Slot};

pub(super) const ENTRY: Entry = Entry {
    name: "container_tilt",
    class: Class::View,
    parameters: &[
        Parameter {
            name: "angle",
            unit: "rad",
            neutral: 0.0,
            range: (-0.35, 0.35),
            typical: 0.03,
            meaning: "constant inclination towards +x",
        },
        Parameter {
            name: "share",
            unit: "1",
            neutral: 0.0,
            range: (-0.2, 1.5),
            typical: 0.5,
            meaning: "part of the recorded inclination that acts beyond what the model was told",
        },
    ],
    about: "the container is tilted",
    source: "gravity turned into the frame of the glass",
    slot: Slot::Port(|[angle, share], port| {
        port.tilt_rad += angle;
        port.tilt_share += share;
    }),
};
