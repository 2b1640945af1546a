//! Columns of a motion table: their names, each with its unit.

use std::fmt;

/// Names of the coordinates in SI units, in the order of [`super::Pivoted::channels`].
const NAMES: [&str; 4] = ["x_m", "y_m", "z_m", "tilt_rad"];

/// Names of the time, each with its unit in seconds.
const TIMES: [(&str, f64); 6] =
    [("t", 1.0), ("t_s", 1.0), ("time", 1.0), ("time_s", 1.0), ("t_ms", 1e-3), ("time_ms", 1e-3)];

/// Names of the coordinates in other units: index in [`NAMES`], and the unit in that one's.
const OTHERS: [(&str, usize, f64); 9] = [
    ("x_mm", 0, 1e-3),
    ("y_mm", 1, 1e-3),
    ("z_mm", 2, 1e-3),
    ("x_cm", 0, 1e-2),
    ("y_cm", 1, 1e-2),
    ("z_cm", 2, 1e-2),
    ("position_m", 0, 1.0),
    ("position_mm", 0, 1e-3),
    ("tilt_deg", 3, std::f64::consts::PI / 180.0),
];

/// Meaning and unit of each column of a table.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Columns {
    /// Unit of the time, s.
    time_s: f64,
    /// Coordinate and its unit, column by column behind the time.
    rest: Vec<(usize, f64)>,
    /// The names, for messages.
    heading: String,
}

impl Default for Columns {
    /// The columns of a table without a heading.
    fn default() -> Self {
        Self { time_s: 1.0, rest: vec![(0, 1.0)], heading: "t, x_m".into() }
    }
}

impl Columns {
    /// Returns the columns that a heading names, or why it is refused.
    pub(super) fn named(fields: &[&str]) -> Result<Self, String> {
        let heading = fields.join(", ");
        let Some((_, time_s)) = TIMES.iter().find(|(name, _)| *name == fields[0]) else {
            return Err(format!(
                "'{heading}' is no heading: the first column is the time and is called t (s), time_s or t_ms, not '{}'; {}",
                fields[0],
                known()
            ));
        };
        if fields.len() < 2 {
            return Err(format!(
                "'{heading}' is no heading: a coordinate is missing behind the time; {}",
                known()
            ));
        }
        let mut rest: Vec<(usize, f64)> = Vec::new();
        for name in &fields[1..] {
            let Some(column) = coordinate(name) else {
                return Err(format!(
                    "'{heading}' is no heading: '{name}' names no coordinate with a unit; {}",
                    known()
                ));
            };
            if rest.iter().any(|(taken, _)| *taken == column.0) {
                return Err(format!(
                    "'{heading}' is no heading: each coordinate at most once, '{name}' is a second one"
                ));
            }
            rest.push(column);
        }
        Ok(Self { time_s: *time_s, rest, heading })
    }

    /// Number of columns.
    pub(super) fn count(&self) -> usize {
        self.rest.len() + 1
    }

    /// Indices of the coordinates in [`NAMES`].
    pub(super) fn coordinates(&self) -> impl Iterator<Item = usize> {
        self.rest.iter().map(|(index, _)| *index)
    }

    /// Returns time and coordinates of a row in SI units.
    pub(super) fn si(&self, row: &[f64]) -> (f64, [f64; 4]) {
        let mut place = [0.0; 4];
        for ((index, unit), number) in self.rest.iter().zip(&row[1..]) {
            place[*index] = unit * number;
        }
        (self.time_s * row[0], place)
    }
}

impl fmt::Display for Columns {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.heading)
    }
}

/// Returns index and unit of the coordinate `name`.
fn coordinate(name: &str) -> Option<(usize, f64)> {
    let other = || OTHERS.iter().find(|(known, ..)| *known == name).map(|(_, index, unit)| (*index, *unit));
    NAMES.iter().position(|known| *known == name).map(|index| (index, 1.0)).or_else(other)
}

/// The names that a heading may use, for messages.
fn known() -> String {
    let others: Vec<&str> = OTHERS.iter().map(|(name, ..)| *name).collect();
    format!(
        "separate columns by commas and take names of {}, {}; for seconds and millimetres write t,x_mm",
        NAMES.join(", "),
        others.join(", ")
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    fn named(heading: &str) -> Result<Columns, String> {
        Columns::named(&heading.split(',').collect::<Vec<_>>())
    }

    #[test]
    fn every_name_has_its_unit() {
        let columns = named("time_ms,tilt_deg,x_mm").expect("known names");
        let (time_s, place) = columns.si(&[500.0, 90.0, 20.0]);
        assert!((time_s - 0.5).abs() < 1e-12 && (place[0] - 0.02).abs() < 1e-12, "{time_s} {place:?}");
        assert!((place[3] - std::f64::consts::FRAC_PI_2).abs() < 1e-12);
        assert_eq!(columns.coordinates().collect::<Vec<_>>(), [3, 0]);
        let (time_s, place) = Columns::default().si(&[0.1, 0.02]);
        assert_eq!((time_s, place), (0.1, [0.02, 0.0, 0.0, 0.0]));
    }

    #[test]
    fn a_name_without_a_unit_is_refused_with_the_names_that_are_known() {
        for (heading, word) in [
            ("time,pos", "'pos' names no coordinate with a unit"),
            ("t,v", "'v' names no coordinate"),
            ("time,x", "'x' names no coordinate"),
            ("frame,x_m", "not 'frame'"),
            ("t", "a coordinate is missing"),
            ("t,x_m,x_mm", "'x_mm' is a second one"),
            ("t,x_m,roll", "'t, x_m, roll' is no heading"),
        ] {
            let why = named(heading).expect_err(heading);
            assert!(why.contains(word), "{why}");
            assert!(why.contains("second one") || why.contains("x_m, y_m, z_m, tilt_rad, x_mm"), "{why}");
        }
    }
}
