//! Times of the images of a folder: in a table beside them, or in their names.
//!
//! A table is the one `.csv` file of the folder. Its rows are a time, as many as there are images and in the order of
//! their names, or a time and the name of a file in either order. A heading may give the unit: `time_s`, `t [ms]`,
//! `timestamp_us`, `timestamp [ns]`. Without one a time of 18 digits or more is in nanoseconds, of 15 in microseconds,
//! of 12 in milliseconds, as times since 1970 are; any other is in seconds.
//!
//! In a name the last number is the time if it has a decimal point or 12 digits and more. A shorter one is the number of
//! a frame.

use super::error::PicturesError;
use std::path::{Path, PathBuf};

/// An image with its time, microseconds.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Timed {
    pub(super) file: PathBuf,
    pub(super) us: u64,
}

/// Unit of the times of a table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Unit {
    Seconds,
    Millis,
    Micros,
    Nanos,
}

impl Unit {
    /// By the heading of a column.
    fn of_heading(heading: &str) -> Option<Self> {
        let heading = heading.to_lowercase();
        let ends = |names: [&str; 2]| names.iter().any(|name| heading.ends_with(name));
        match () {
            () if ends(["_ns", "[ns]"]) => Some(Self::Nanos),
            () if ends(["_us", "[us]"]) => Some(Self::Micros),
            () if ends(["_ms", "[ms]"]) => Some(Self::Millis),
            () if ends(["_s", "[s]"]) => Some(Self::Seconds),
            () => None,
        }
    }

    /// By the digits before the decimal point.
    fn of_digits(digits: usize) -> Self {
        match digits {
            18.. => Self::Nanos,
            15.. => Self::Micros,
            12.. => Self::Millis,
            _ => Self::Seconds,
        }
    }

    fn decimals_of_micros(self) -> i32 {
        match self {
            Self::Seconds => 6,
            Self::Millis => 3,
            Self::Micros => 0,
            Self::Nanos => -3,
        }
    }
}

/// Microseconds of a number as it is written; exact, where a float would lose the end of a time since 1970.
fn micros(text: &str, unit: Option<Unit>) -> Option<u64> {
    let (whole, part) = text.split_once('.').unwrap_or((text, ""));
    let is_number = |digits: &str| digits.bytes().all(|byte| byte.is_ascii_digit());
    if whole.is_empty() || whole.len() > 25 || !is_number(whole) || !is_number(part) {
        return None;
    }
    let unit = unit.unwrap_or_else(|| Unit::of_digits(whole.trim_start_matches('0').len()));
    let (mut value, mut decimals) = (whole.parse::<u128>().ok()?, unit.decimals_of_micros());
    for digit in part.bytes().take(9) {
        value = value * 10 + u128::from(digit - b'0');
        decimals -= 1;
    }
    let scale = 10_u128.pow(decimals.unsigned_abs());
    let us = if decimals >= 0 { value.checked_mul(scale)? } else { (value + scale / 2) / scale };
    u64::try_from(us).ok()
}

/// Returns the time in a name, microseconds; `None` where it holds no number, or that of a frame alone.
pub(super) fn in_name(file: &Path) -> Option<u64> {
    let stem = file.file_stem()?.to_str()?;
    let is_part = |sign: char| sign.is_ascii_digit() || sign == '.';
    let end = stem.rfind(|sign: char| sign.is_ascii_digit())? + 1;
    let start = stem[..end]
        .rfind(|sign| !is_part(sign))
        .map_or(0, |at| at + stem[at..].chars().next().map_or(1, char::len_utf8));
    let number = stem[start..end].trim_start_matches('.');
    let digits = number.split('.').next().unwrap_or("").len();
    (number.matches('.').count() == 1 || (digits >= 12 && !number.contains('.')))
        .then(|| micros(number, None))?
}

/// Times of `files`, which are in the order of their names, by the rows of a table.
pub(super) fn in_table(table: &Path, text: &str, files: &[PathBuf]) -> Result<Vec<Timed>, PicturesError> {
    let (mut unit, mut rows) = (None, Vec::new());
    let lines = text.lines().enumerate().map(|(index, line)| (index + 1, line.trim()));
    for (line, content) in lines.filter(|(_, content)| !content.is_empty()) {
        let fields: Vec<&str> = content.split([',', ';', '\t']).map(str::trim).collect();
        let row = match fields[..] {
            [time] => micros(time, unit).map(|us| (None, us)),
            [first, second] => {
                let named = |name: &str, time: &str| micros(time, unit).map(|us| (Some(name.to_owned()), us));
                // The column that is a file of the folder is the name, though it may look like a number.
                let is_file =
                    |name: &str| files.iter().any(|file| file.file_name().is_some_and(|own| own == name));
                if is_file(first) { named(first, second) } else { named(second, first) }
            }
            _ => None,
        };
        match row {
            Some((name, us)) => rows.push((line, name, us)),
            None if rows.is_empty()
                && unit.is_none()
                && !content.starts_with(|sign: char| sign.is_ascii_digit()) =>
            {
                unit = fields.iter().find_map(|heading| Unit::of_heading(heading)).or(unit);
            }
            None => {
                let shown: String = content.chars().filter(|sign| !sign.is_control()).take(80).collect();
                return Err(PicturesError::Row { table: table.into(), line, shown });
            }
        }
    }
    let fewer = |times| PicturesError::Fewer { table: table.into(), times, images: files.len() };
    if rows.iter().all(|(_, name, _)| name.is_none()) {
        if rows.len() != files.len() {
            return Err(fewer(rows.len()));
        }
        return Ok(files
            .iter()
            .zip(rows)
            .map(|(file, (_, _, us))| Timed { file: file.clone(), us })
            .collect());
    }
    let folder = table.parent().unwrap_or(Path::new(""));
    let mut timed = Vec::with_capacity(rows.len());
    for (line, name, us) in rows {
        let file = name.map(|name| folder.join(name)).filter(|file| files.contains(file));
        let file = file.ok_or_else(|| PicturesError::NoFile { table: table.into(), line })?;
        timed.push(Timed { file, us });
    }
    if timed.len() < files.len() {
        return Err(fewer(timed.len()));
    }
    Ok(timed)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_holds_a_time_or_the_number_of_a_frame() {
        for (name, us) in [
            ("1305031102.175304.png", Some(1_305_031_102_175_304)),
            ("1403636579763555584.png", Some(1_403_636_579_763_556)),
            ("1700000000123.jpg", Some(1_700_000_000_123_000)),
            ("frame_0012_t0.400.png", Some(400_000)),
            ("cam0-12.5.jpeg", Some(12_500_000)),
            ("frame0001.png", None),
            ("2024.png", None),
            ("1.2.3.png", None),
            ("glass.png", None),
        ] {
            assert_eq!(in_name(Path::new(name)), us, "{name}");
        }
    }

    fn files(names: &[&str]) -> Vec<PathBuf> {
        names.iter().map(|name| Path::new("/f").join(name)).collect()
    }

    fn times(text: &str, names: &[&str]) -> Result<Vec<u64>, String> {
        let timed = in_table(Path::new("/f/times.csv"), text, &files(names));
        timed.map(|timed| timed.iter().map(|one| one.us).collect()).map_err(|error| error.to_string())
    }

    #[test]
    fn a_table_has_times_alone_or_beside_names_in_any_unit() {
        let names = ["a.png", "b.png"];
        assert_eq!(times("0.5\n0.6\n", &names), Ok(vec![500_000, 600_000]));
        assert_eq!(times("t_ms\n500\n533.4\n", &names), Ok(vec![500_000, 533_400]));
        assert_eq!(times("file,time_us\na.png,7\nb.png,9\n", &names), Ok(vec![7, 9]));
        let euroc = "#timestamp [ns],filename\n1403636579763555584,a.png\n1403636579813555456,b.png\n";
        assert_eq!(times(euroc, &names), Ok(vec![1_403_636_579_763_556, 1_403_636_579_813_555]));
        // Names that are numbers: the column of the files is known by the names in the folder.
        assert_eq!(times("1.png;0.1\n2.png;0.2\n", &["1.png", "2.png"]), Ok(vec![100_000, 200_000]));
    }

    #[test]
    fn a_table_that_does_not_fit_is_refused_with_its_line() {
        let names = ["a.png", "b.png"];
        let refused = |text: &str| times(text, &names).expect_err("refused");
        assert!(refused("0.5\n").contains("1 times for 2 images"), "{}", refused("0.5\n"));
        assert!(refused("a.png,0.5\n").contains("1 times for 2 images"));
        assert!(refused("0.5\nnan\n").contains("line 2"), "{}", refused("0.5\nnan\n"));
        assert!(refused("0.5\n-1\n").contains("line 2"));
        assert!(
            refused("a.png,0.5\nc.png,0.6\n").contains("line 2"),
            "{}",
            refused("a.png,0.5\nc.png,0.6\n")
        );
        assert!(refused("").contains("0 times for 2 images"));
        assert!(refused("a,b,c,d\n1,2,3,4\n").contains("line 2"));
    }
}
