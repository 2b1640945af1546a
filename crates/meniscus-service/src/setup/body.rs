//! The body of liquid in a portrait, without knowing yet where the camera stands or how wide the glass is.
//!
//! In each row of the search range the pixels fall into two classes (Otsu). A row shows the body if a run of one
//! class has background of the other on both sides; rows on rows whose runs have the same ends are the body.

use super::portrait::Portrait;
use meniscus::surface::Liquid;
use meniscus_numerics::statistics::median;
use std::ops::Range;

/// Least difference of a row's two classes that is looked at, grey levels: well above noise and dots.
const LEAST_CONTRAST: f32 = 14.0;
/// Fewest and most columns of a body, and fewest rows.
const WIDTH: std::ops::RangeInclusive<usize> = 20..=230;
const LEAST_ROWS: usize = 16;
/// Ends of neighbouring rows differ by this many columns at most.
const STEP: usize = 3;
/// Rows without a fitting run that a body may have inside, and the widest highlight that is bridged, columns.
const GAP_ROWS: usize = 3;
const BRIDGE: usize = 12;
/// Least contrast of a part of the body, as a share of that of the rest.
const LEAST_PALE: f32 = 0.5;

/// A body of liquid in an image, pixels.
#[derive(Clone, Debug, PartialEq)]
pub struct Body {
    /// Grey levels of the liquid against its background.
    pub liquid: Liquid,
    /// Its rows with the sub-pixel columns of its left and its right side, rows rising.
    pub sides: Vec<(usize, [f32; 2])>,
    /// Columns between the sides, each with the row of its upper edge.
    pub top: Vec<(usize, f32)>,
    /// Row of its lower edge in the middle.
    pub foot: Option<f32>,
    /// Difference between liquid and background, grey levels.
    pub contrast: f32,
}

impl Body {
    /// Returns the tallest body, dark or bright, in these columns.
    pub(super) fn find(portrait: &Portrait, columns: &Range<usize>) -> Option<Self> {
        let of = |liquid| Self::of_tone(portrait, columns, liquid);
        let tall = |body: &Self| body.sides.len();
        [of(Liquid::Dark), of(Liquid::Bright)].into_iter().flatten().max_by_key(tall)
    }

    /// Returns the tallest body of this tone in these columns; a clear liquid is dark.
    pub(super) fn of_tone(portrait: &Portrait, columns: &Range<usize>, liquid: Liquid) -> Option<Self> {
        let rows = of_one_tone(tallest(portrait, columns, liquid));
        if rows.len() < LEAST_ROWS {
            return None;
        }
        let median = |value: &dyn Fn(&Row) -> f32| median(rows.iter().map(value));
        let (inside, outside) = (median(&|row| row.means[0])?, median(&|row| row.means[1])?);
        let sides: Vec<_> = rows.iter().filter_map(|row| Some((row.row, row.sides(portrait)?))).collect();
        let (first, last) = (rows.first()?, rows.last()?);
        let middle = rows.get(rows.len() / 2)?;
        let half = 0.5 * (middle.last - middle.first) as f32;
        let axis = 0.5 * (middle.first + middle.last) as f32;
        let level = 0.5 * (inside + outside);
        let is_liquid = |grey: f32| (grey < level) == (liquid == Liquid::Dark);
        let height = last.row - first.row;
        // From the middle outwards to the first two pixels of background; the crossing lies between.
        let edge = |column: usize, up: bool| -> Option<f32> {
            let mut row = middle.row;
            let step = |row: usize| if up { row.checked_sub(1) } else { Some(row + 1) };
            for _ in 0..height {
                let next = step(row)?;
                let beyond = step(next)?;
                if !is_liquid(portrait.grey(column, next)) && !is_liquid(portrait.grey(column, beyond)) {
                    let (here, there) = (portrait.grey(column, row), portrait.grey(column, next));
                    let share = ((level - here) / (there - here)).clamp(0.0, 1.0);
                    return Some(if up { row as f32 - share } else { row as f32 + share });
                }
                row = next;
            }
            None
        };
        let columns = ((axis - 0.8 * half) as usize)..=((axis + 0.8 * half) as usize);
        let top: Vec<_> = columns.filter_map(|column| Some((column, edge(column, true)?))).collect();
        let near = (axis as usize).saturating_sub(3)..=axis as usize + 3;
        let foot = meniscus_numerics::statistics::median(near.filter_map(|column| edge(column, false)));
        Some(Self { liquid, sides, top, foot, contrast: (outside - inside).abs() })
    }

    /// First and last row.
    #[must_use]
    pub fn rows(&self) -> (usize, usize) {
        let row = |side: Option<&(usize, [f32; 2])>| side.map_or(0, |(row, _)| *row);
        (row(self.sides.first()), row(self.sides.last()))
    }

    /// Width between the sides, median over the rows, pixels.
    #[must_use]
    pub fn width_px(&self) -> f32 {
        median(self.sides.iter().map(|(_, [left, right])| right - left)).unwrap_or(0.0)
    }
}

/// One row's run.
#[derive(Clone, Copy, Debug)]
struct Row {
    row: usize,
    first: usize,
    last: usize,
    /// Mean grey of the run and of the background.
    means: [f32; 2],
}

impl Row {
    /// Columns at which the grey crosses half-way between run and background.
    fn sides(&self, portrait: &Portrait) -> Option<[f32; 2]> {
        let level = 0.5 * (self.means[0] + self.means[1]);
        let cross = |inner: usize, outer: usize| {
            let (inside, outside) = (portrait.grey(inner, self.row), portrait.grey(outer, self.row));
            let share = (level - inside) / (outside - inside);
            (0.0..=1.0).contains(&share).then_some(inner as f32 + share * (outer as f32 - inner as f32))
        };
        Some([cross(self.first, self.first.checked_sub(1)?)?, cross(self.last, self.last + 1)?])
    }
}

/// The most rows on rows whose runs have the same ends.
fn tallest(portrait: &Portrait, columns: &Range<usize>, liquid: Liquid) -> Vec<Row> {
    let (mut best, mut now): (Vec<Row>, Vec<Row>) = (Vec::new(), Vec::new());
    for row in 0..portrait.height {
        let found = run(portrait, row, columns, liquid);
        let fits = |next: &Row| {
            now.last().is_some_and(|last| {
                next.row - last.row <= 1 + GAP_ROWS
                    && next.first.abs_diff(last.first) <= STEP
                    && next.last.abs_diff(last.last) <= STEP
            })
        };
        match found {
            Some(next) if fits(&next) => now.push(next),
            Some(next) => {
                best = taller(best, std::mem::replace(&mut now, vec![next]));
            }
            None => {}
        }
    }
    taller(best, now)
}

/// The rows without the glass above a bright liquid, which is lit by it and has the same sides: of two classes of rows, of which
/// one is less than half as far from the background, the other.
fn of_one_tone(mut rows: Vec<Row>) -> Vec<Row> {
    let inside: Vec<f32> = rows.iter().map(|row| row.means[0]).collect();
    let background = median(rows.iter().map(|row| row.means[1]));
    let Some((background, (dark, bright))) = background.zip(classes(&inside)) else { return rows };
    let (pale, full) =
        if (dark - background).abs() < (bright - background).abs() { (dark, bright) } else { (bright, dark) };
    if (pale - background).abs() < LEAST_PALE * (full - background).abs() {
        rows.retain(|row| (row.means[0] - full).abs() < (row.means[0] - pale).abs());
    }
    rows
}

fn taller(a: Vec<Row>, b: Vec<Row>) -> Vec<Row> {
    if b.len() > a.len() { b } else { a }
}

/// The widest run of the liquid's class in a row that has background on both sides.
fn run(portrait: &Portrait, row: usize, columns: &Range<usize>, liquid: Liquid) -> Option<Row> {
    let greys: Vec<f32> = columns.clone().map(|column| portrait.grey(column, row)).collect();
    let (dark, bright) = classes(&greys).filter(|(dark, bright)| bright - dark >= LEAST_CONTRAST)?;
    let level = 0.5 * (dark + bright);
    let is_liquid = |grey: f32| (grey < level) == (liquid == Liquid::Dark);
    let mut best: Option<(usize, usize)> = None;
    let mut now: Option<(usize, usize)> = None;
    for (column, grey) in greys.iter().enumerate() {
        if is_liquid(*grey) {
            let begun = now.filter(|(_, last)| column - last <= BRIDGE).map_or(column, |(first, _)| first);
            now = Some((begun, column));
            if best.is_none_or(|(first, last)| column - begun > last - first) {
                best = now;
            }
        }
    }
    let (first, last) = best?;
    let means = if liquid == Liquid::Dark { [dark, bright] } else { [bright, dark] };
    let framed = first >= 2 && last + 3 <= greys.len();
    (framed && WIDTH.contains(&(last - first + 1))).then_some(Row {
        row,
        first: columns.start + first,
        last: columns.start + last,
        means,
    })
}

/// Means of the two classes of `greys` after Otsu: the split with the largest `w0 w1 (m0 - m1)^2`.
fn classes(greys: &[f32]) -> Option<(f32, f32)> {
    let mut sorted = greys.to_vec();
    sorted.sort_by(f32::total_cmp);
    let (all, sum) = (sorted.len() as f32, sorted.iter().sum::<f32>());
    let (mut below, mut best): (f32, Option<(f32, f32, f32)>) = (0.0, None);
    for (count, grey) in (1..sorted.len()).zip(&sorted) {
        below += grey;
        let (lower, upper) = (count as f32, all - count as f32);
        let (dark, bright) = (below / lower, (sum - below) / upper);
        let between = lower * upper * (bright - dark) * (bright - dark);
        if best.is_none_or(|(most, ..)| between > most) {
            best = Some((between, dark, bright));
        }
    }
    best.map(|(_, dark, bright)| (dark, bright))
}
