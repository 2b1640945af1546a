//! Effective gravity: a glass that is accelerated upwards by a has `g + a`. A constant one, and the part
//! of the recorded vertical acceleration that the model was not told of. It acts where the glass's motion
//! does, but what it changes is what pulls the surface back.

use super::{Class, Entry, Parameter, Slot};

pub(super) const ENTRY: Entry = Entry {
    name: "vertical_acceleration",
    class: Class::Stiffness,
    parameters: &[
        Parameter {
            name: "lift",
            unit: "m/s2",
            neutral: 0.0,
            range: (-5.0, 20.0),
            typical: 0.3,
            meaning: "constant acceleration upwards",
        },
        Parameter {
            name: "share",
            unit: "1",
            neutral: 0.0,
            range: (-0.2, 1.5),
            typical: 0.5,
            meaning: "part of the recorded vertical acceleration that acts beyond what the model was told",
        },
    ],
    about: "gravity is not what it seems: the glass is accelerated vertically",
    source: "equivalence of gravity and acceleration",
    slot: Slot::Port(|[lift, share], port| {
        port.lift_m_s2 += lift;
        port.lift_share += share;
    }),
};
