//! A contact line that is held by a spring and does not slide: force `k_c u cos theta` per length,
//! so every mode of azimuthal order one gains `k_c R int cos^2 = pi R k_c`, and all of them move against
//! it as one (Benjamin and Scott 1979; Hocking 1987 for the elastic line).

use super::{Branch, Class, Entry, Parameter, Relax, Slot};
use core::f64::consts::PI;

pub(super) const ENTRY: Entry = Entry {
    name: "pinned_line",
    class: Class::Stiffness,
    parameters: &[Parameter {
        name: "spring",
        unit: "N/m2",
        neutral: 0.0,
        range: (0.0, 500.0),
        typical: 5.0,
        meaning: "spring of the line, force per length for each metre of its way",
    }],
    about: "the contact line is pinned",
    source: "Benjamin and Scott 1979; Hocking 1987",
    slot: Slot::Catch(|[spring, _], glass| Branch {
        stiffness: PI * glass.radius_m * spring,
        relax: Relax::Never,
    }),
};
