//! The liquids of the study, how they are moved, and what is asked of their correction.

/// One liquid of the study.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Course {
    /// Name in the study.
    pub name: &'static str,
    /// Its name among the liquids.
    pub liquid: &'static str,
    /// Motions that are learnt from, the last of several to stop by.
    pub learnt: &'static [&'static str],
    /// The motion that nothing was chosen by.
    pub unseen: &'static str,
    /// Largest and mean error that the unseen recording is to have after correction, per cent.
    pub target: [f64; 2],
}

/// Four recordings of a liquid, moved so far that it stays in the glass: water at 0.3 of the full way and blood at 0.4 throw
/// particles over the rim, as does beer in a hand at 0.3.
const WATER: &[&str] = &["strokes:301x0.25", "strokes:302x0.25", "strokes:303x0.25", "strokes:304x0.25"];
const BUTTER: &[&str] = &["strokes:301x0.4", "strokes:302x0.4", "strokes:303x0.4", "strokes:304x0.4"];
const BLOOD: &[&str] = &["strokes:301x0.3", "strokes:302x0.3", "strokes:303x0.3", "strokes:304x0.3"];

/// The liquids of the study: three that a machine moves along its line, four recordings to learn from, and four that a hand
/// moves, slightly out of line, one recording.
pub const COURSES: [Course; 7] = [
    course("water", "water", WATER, "strokes:1301x0.25", [4.0, 1.5]),
    course("butter", "butter", BUTTER, "strokes:1301x0.4", [1.5, 0.5]),
    course("blood", "blood", BLOOD, "strokes:1301x0.3", [2.5, 1.0]),
    course("beer", "beer", &["hand:401x0.25"], "hand:1401x0.25", BY_HAND),
    course("honey", "honey", &["hand:401"], "hand:1401", BY_HAND),
    course("gazpacho", "gazpacho", &["hand:401"], "hand:1401", BY_HAND),
    course("water_by_hand", "water", &["hand:401x0.25"], "hand:1401x0.25", BY_HAND),
];

/// Largest and mean error where a hand moves the glass, per cent.
const BY_HAND: [f64; 2] = [6.0, 2.0];

const fn course(
    name: &'static str,
    liquid: &'static str,
    learnt: &'static [&'static str],
    unseen: &'static str,
    target: [f64; 2],
) -> Course {
    Course { name, liquid, learnt, unseen, target }
}
