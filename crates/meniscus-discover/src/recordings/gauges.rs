//! Tables of gauges: heights of the surface at a few places of the wall, with names that have their units.
//!
//! ```text
//! time_s,height_mm@x=-30mm,height_mm@x=0mm,height_mm@x=30mm
//! ```
//! `height` counts from the inner bottom, `rise` from rest; x runs along the motion from the axis of the glass. A place stands for
//! the point of the wall at this x. Level, slope and bow are fitted to three places or more, as to a profile
//! (`record`); two opposite places give the slope, because half of the sum of two heights is not the level where the surface bows.

use super::error::TableError;
use super::record::{Channel, Quantity, mean_bow};
use nalgebra::{DMatrix, DVector};

/// Fewest rows: half a second at 60 Hz.
const LEAST_ROWS: usize = 30;

/// Most rows: ten minutes at 60 Hz.
const MOST_ROWS: usize = 36_000;

/// Most gauges.
const MOST_GAUGES: usize = 64;

/// Largest step between rows relative to the mean one, as a deviation from it.
const UNEVEN: f64 = 0.3;

/// Difference of places, in radii, from which they are two.
const APART: f64 = 0.05;

/// Units of length by their names, m.
const UNITS: [(&str, f64); 3] = [("mm", 1e-3), ("cm", 1e-2), ("m", 1.0)];

/// Heading that shows what is expected.
const EXAMPLE: &str = "time_s,height_mm@x=-30mm,height_mm@x=0mm,height_mm@x=30mm";

/// One gauge.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Gauge {
    /// Place along the motion, in radii from the axis.
    s: f64,
    /// Unit of its numbers, m.
    unit_m: f64,
    /// Height of zero over rest, m.
    zero_m: f64,
}

/// Reads the name of a column.
fn gauge(name: &str, radius_m: f64, fill_m: f64) -> Result<Gauge, String> {
    let (what, place) = name.split_once("@x=").ok_or("it names no place behind @x=")?;
    let (kind, unit) = what.split_once('_').ok_or("its height has no unit")?;
    let zero_m = match kind {
        "height" => -fill_m,
        "rise" => 0.0,
        _ => return Err("it is called neither height (from the inner bottom) nor rise (from rest)".into()),
    };
    let unit_m = UNITS.iter().find(|(known, _)| *known == unit).map(|(_, unit_m)| *unit_m);
    let unit_m = unit_m.ok_or("its height has none of the units m, cm and mm")?;
    let split = place.find(|c: char| c.is_ascii_alphabetic() && c != 'e' && c != 'E').unwrap_or(place.len());
    let (number, unit) = place.split_at(split);
    let scale = UNITS.iter().find(|(known, _)| *known == unit).map(|(_, unit_m)| *unit_m);
    let scale = scale.ok_or("its place has none of the units m, cm and mm")?;
    let x: f64 = number.trim().parse().map_err(|_| "its place is no number")?;
    let s = x * scale / radius_m;
    if s.is_nan() || s.abs() > 1.0 {
        return Err(format!(
            "its place lies outside of the glass, whose inner radius is {:.1} mm",
            1e3 * radius_m
        ));
    }
    Ok(Gauge { s, unit_m, zero_m })
}

/// Reads the heading.
fn gauges(heading: &str, radius_m: f64, fill_m: f64) -> Result<Vec<Gauge>, TableError> {
    let refused = |name: &str, why: String| TableError::Heading { name: name.into(), why, example: EXAMPLE };
    let mut names = heading.split(',').map(str::trim);
    match names.next() {
        Some("time_s") => {}
        other => return Err(refused(other.unwrap_or_default(), "the first column is time_s".into())),
    }
    let all: Vec<Gauge> = names
        .take(MOST_GAUGES)
        .map(|name| gauge(name, radius_m, fill_m).map_err(|why| refused(name, why)))
        .collect::<Result<_, _>>()?;
    let mut places: Vec<f64> = all.iter().map(|gauge| gauge.s).collect();
    places.sort_by(f64::total_cmp);
    places.dedup_by(|a, b| (*a - *b).abs() < APART);
    let opposite = |places: &[f64]| (places[0] + places[1]).abs() < APART;
    match places.len() {
        3.. => Ok(all),
        2 if opposite(&places) => Ok(all),
        count => {
            let why = format!(
                "its {count} places are too few: give two opposite ones, or three that are a twentieth of the radius apart"
            );
            Err(refused(heading, why))
        }
    }
}

/// Returns the interval, s, and the channels of a table of gauges in a glass of `radius_m` filled to `fill_m`.
pub(super) fn read(text: &str, radius_m: f64, fill_m: f64) -> Result<(f64, Vec<Channel>), TableError> {
    let mut lines = text.lines().enumerate().map(|(i, l)| (i + 1, l.trim())).filter(|(_, l)| !l.is_empty());
    let (_, heading) = lines.next().ok_or(TableError::Empty)?;
    let gauges = gauges(heading, radius_m, fill_m)?;
    let mut rows: Vec<(f64, Vec<Option<f64>>)> = Vec::new();
    for (line, content) in lines {
        let columns =
            || TableError::Columns { line, expected: EXAMPLE, found: content.chars().take(80).collect() };
        let sequence = || TableError::Sequence { line, found: content.chars().take(80).collect() };
        let fields: Vec<&str> = content.split(',').map(str::trim).collect();
        if fields.len() != gauges.len() + 1 || rows.len() >= MOST_ROWS {
            return Err(columns());
        }
        let t: f64 = fields[0].parse().map_err(|_| columns())?;
        let mut heights = Vec::with_capacity(gauges.len());
        for (field, gauge) in fields[1..].iter().zip(&gauges) {
            let number: Option<f64> =
                if field.is_empty() { None } else { Some(field.parse().map_err(|_| columns())?) };
            if number.is_some_and(|number| !number.is_finite()) {
                return Err(sequence());
            }
            heights.push(number.map(|number| number * gauge.unit_m + gauge.zero_m));
        }
        if !t.is_finite() || rows.last().is_some_and(|(last, _)| t <= *last) {
            return Err(sequence());
        }
        rows.push((t, heights));
    }
    let interval_s = interval(&rows)?;
    Ok((interval_s, channels(&gauges, &rows)))
}

/// Returns the interval of the rows, s.
fn interval(rows: &[(f64, Vec<Option<f64>>)]) -> Result<f64, TableError> {
    if rows.len() < LEAST_ROWS {
        return Err(TableError::TooShort { rows: rows.len(), unit: "rows", least: LEAST_ROWS });
    }
    let mean_s = (rows[rows.len() - 1].0 - rows[0].0) / (rows.len() - 1) as f64;
    let range_s = (1e-3, 0.1);
    if !(range_s.0..range_s.1).contains(&mean_s) {
        return Err(TableError::Interval { interval_s: mean_s, range_s });
    }
    let step =
        rows.windows(2).map(|pair| pair[1].0 - pair[0].0).find(|dt| (dt / mean_s - 1.0).abs() > UNEVEN);
    match step {
        Some(step_s) => Err(TableError::Uneven { step_s, mean_s }),
        None => Ok(mean_s),
    }
}

/// Returns level, slope and bow of each row where three places or more were seen, or the slope of two.
fn channels(gauges: &[Gauge], rows: &[(f64, Vec<Option<f64>>)]) -> Vec<Channel> {
    let distinct = |seen: &[(f64, f64)]| {
        let mut places: Vec<f64> = seen.iter().map(|(s, _)| *s).collect();
        places.sort_by(f64::total_cmp);
        places.dedup_by(|a, b| (*a - *b).abs() < APART);
        places.len()
    };
    let all: Vec<(f64, f64)> = gauges.iter().map(|gauge| (gauge.s, 0.0)).collect();
    let terms = distinct(&all).min(3);
    let quantities = match terms {
        3 => &[Quantity::Level, Quantity::Slope, Quantity::Bow][..],
        _ => &[Quantity::Slope],
    };
    let mean = mean_bow();
    let fit = |heights: &[Option<f64>]| -> Option<Vec<f64>> {
        let seen: Vec<(f64, f64)> =
            gauges.iter().zip(heights).filter_map(|(gauge, z)| z.map(|z| (gauge.s, z))).collect();
        if distinct(&seen) < terms {
            return None;
        }
        let basis = |s: f64, term: usize| [1.0, s, 2.0 * s * s - 1.0 - mean][term];
        let a = DMatrix::from_fn(seen.len(), terms, |row, term| basis(seen[row].0, term));
        let b = DVector::from_iterator(seen.len(), seen.iter().map(|(_, z)| *z));
        let solved = a.svd(true, true).solve(&b, 1e-9).ok()?;
        Some(if terms == 3 { solved.iter().copied().collect() } else { vec![solved[1]] })
    };
    let fitted: Vec<Option<Vec<f64>>> = rows.iter().map(|(_, heights)| fit(heights)).collect();
    let channel = |(n, quantity): (usize, &Quantity)| Channel {
        quantity: *quantity,
        value: fitted.iter().map(|row| row.as_ref().map(|row| row[n])).collect(),
    };
    quantities.iter().enumerate().map(channel).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const RADIUS_M: f64 = 0.04;
    const FILL_M: f64 = 0.05;

    /// Table whose surface is level + slope s + bow (T2 - <T2>), m, at `places` in mm.
    fn table(places: &[f64], heading: impl Fn(f64) -> String, number: impl Fn(f64) -> f64) -> String {
        let mut text = String::from("time_s");
        places.iter().for_each(|x| text += &format!(",{}", heading(*x)));
        for n in 0..40 {
            text += &format!("\n{}", f64::from(n) / 50.0);
            for x in places {
                let s = 1e-3 * x / RADIUS_M;
                let z = 1e-3 + 4e-3 * f64::from(n) / 40.0 * s + 5e-4 * (2.0 * s * s - 1.0 - mean_bow());
                text += &format!(",{}", number(z));
            }
        }
        text
    }

    #[test]
    fn level_slope_and_bow_come_from_three_places_in_any_unit() {
        let places = [-30.0, 0.0, 20.0, 38.0];
        for (heading, unit, zero) in [("height_mm", 1e3, FILL_M), ("rise_cm", 1e2, 0.0), ("rise_m", 1.0, 0.0)]
        {
            let text = table(&places, |x| format!("{heading}@x={}cm", 0.1 * x), |z| unit * (z + zero));
            let (interval_s, channels) = read(&text, RADIUS_M, FILL_M).expect("a table");
            assert!((interval_s - 0.02).abs() < 1e-12);
            let last = |n: usize| channels[n].value[39].expect("seen");
            let wanted = [1e-3, 4e-3 * 39.0 / 40.0, 5e-4];
            for (n, wanted) in wanted.into_iter().enumerate() {
                assert!((last(n) - wanted).abs() < 1e-9, "{heading} {n}: {} for {wanted}", last(n));
            }
        }
    }

    #[test]
    fn two_opposite_places_give_the_slope_whatever_the_bow() {
        let text = table(&[-32.0, 32.0], |x| format!("rise_mm@x={x}mm"), |z| 1e3 * z);
        let (_, channels) = read(&text, RADIUS_M, FILL_M).expect("a table");
        assert_eq!(channels.len(), 1);
        assert!((channels[0].value[20].expect("seen") - 2e-3).abs() < 1e-9, "{:?}", channels[0].value[20]);
    }

    #[test]
    fn a_place_that_was_not_seen_leaves_a_gap_where_it_is_needed() {
        let text = table(&[-30.0, 0.0, 30.0], |x| format!("rise_mm@x={x}mm"), |z| 1e3 * z);
        let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
        let cut = lines[5].rfind(',').expect("a column") + 1;
        lines[5].truncate(cut);
        let (_, channels) = read(&lines.join("\n"), RADIUS_M, FILL_M).expect("a table");
        assert_eq!(channels[1].value.iter().filter(|value| value.is_none()).count(), 1);
    }

    #[test]
    fn names_without_units_and_other_faults_are_refused_by_name() {
        let text = table(&[-30.0, 0.0, 30.0], |x| format!("rise_mm@x={x}mm"), |z| 1e3 * z);
        let refused = |from: &str, to: &str, words: &str| {
            let why = read(&text.replacen(from, to, 1), RADIUS_M, FILL_M).expect_err(to).to_string();
            assert!(why.contains(words), "'{words}' is not in: {why}");
        };
        refused("rise_mm@x=0mm", "gauge 2", "'gauge 2': it names no place");
        refused("rise_mm@x=0mm", "rise@x=0mm", "its height has no unit");
        refused("rise_mm@x=0mm", "rise_in@x=0mm", "none of the units m, cm and mm");
        refused("rise_mm@x=0mm", "rise_mm@x=0", "its place has none of the units");
        refused("rise_mm@x=0mm", "z_mm@x=0mm", "neither height (from the inner bottom) nor rise");
        refused("rise_mm@x=0mm", "rise_mm@x=45mm", "outside of the glass, whose inner radius is 40.0 mm");
        refused("rise_mm@x=-30mm", "rise_mm@x=1mm", "its 2 places are too few");
        refused("time_s", "t", "the first column is time_s");
        refused("\n0.02,", "\n0.035,", "rows are not even");
        refused("\n0.02,", "\n0.02,1,", "expected");
        refused("\n0.04,", "\n0.04,nan#", "expected");
        assert_eq!(read("", RADIUS_M, FILL_M).expect_err("nothing"), TableError::Empty);
    }

    #[test]
    fn rates_above_10_hz_and_up_to_1000_are_taken() {
        let at = |hz: f64| {
            let row = |n: i32| format!("\n{},1,2,3", f64::from(n) / hz);
            let rows: String = (0..40).map(row).collect();
            let heading = "time_s,rise_mm@x=-30mm,rise_mm@x=0mm,rise_mm@x=30mm";
            read(&format!("{heading}{rows}"), RADIUS_M, FILL_M)
        };
        assert!([12.0, 60.0, 990.0].into_iter().all(|hz| at(hz).is_ok()));
        for hz in [8.0, 1100.0] {
            assert!(matches!(at(hz), Err(TableError::Interval { .. })), "{hz} Hz");
        }
    }
}
