//! Correction of boundary-layer theory for a layer that is not thin, and for a wall that holds the contact line.
//!
//! Layer theory is of first order in `x = delta/R`, `delta = sqrt(2 nu/w)`, for a line that slides freely. The linearised
//! Navier-Stokes equations of the first mode, solved by Ritz's method in a glass of h = 2 R whose sticking wall holds the
//! line too, give a damping gamma and a frequency `w = |s|`, s the complex root. The tables hold what they add:
//! ```text
//! damping   gamma - gamma_layer = w x D(x, u),     u = s/(1 + s),   s = b/delta the slip
//! lowering  (w0 - w) - lowering_layer = w x L(x, u)
//! film      gamma and lowering of an inextensible film, over w x
//! ```
//! Where the share h of the line is held, `u D(x, 1) + h (D(x, u) - u D(x, 1))` takes the place of D, and the same of L: the line's
//! part falls with the slip as the tables do, and none is left where the liquid slips freely. A line that keeps still bends the
//! surface within a layer's depth, so that D grows with x from 0; the tables begin at x = 0.03 and go straight to 0 below it. They are
//! made by `tests/fixtures/viscous/make.py`, and discovery's tests hold them against the simulator's own solver.

use super::wall_impedance::{Root, WallLayer};
use crate::math::ln;

/// Ratios x of the layer's depth to the radius.
const DEPTHS: [f64; 10] = [0.03, 0.045, 0.06, 0.08, 0.1, 0.13, 0.16, 0.2, 0.25, 0.3];

/// Slips u.
const SLIPS: [f64; 9] = [0.0, 0.05, 0.1, 0.2, 0.3, 0.4, 0.55, 0.75, 1.0];

/// D by depth and slip.
#[rustfmt::skip]
const DAMPING: [[f64; SLIPS.len()]; DEPTHS.len()] = [
    [0.1303, 0.1254, 0.1012, 0.0632, 0.0372, 0.0195, 0.0035, -0.0059, -0.0093],
    [0.1705, 0.1524, 0.1242, 0.0778, 0.0448, 0.0220, 0.0011, -0.0114, -0.0162],
    [0.1868, 0.1666, 0.1371, 0.0856, 0.0478, 0.0212, -0.0034, -0.0184, -0.0247],
    [0.1914, 0.1711, 0.1417, 0.0873, 0.0455, 0.0155, -0.0126, -0.0303, -0.0382],
    [0.1846, 0.1646, 0.1360, 0.0811, 0.0374, 0.0054, -0.0251, -0.0449, -0.0545],
    [0.1613, 0.1414, 0.1144, 0.0605, 0.0161, -0.0172, -0.0498, -0.0720, -0.0840],
    [0.1275, 0.1073, 0.0816, 0.0298, -0.0139, -0.0474, -0.0810, -0.1051, -0.1196],
    [0.0712, 0.0502, 0.0258, -0.0230, -0.0649, -0.0978, -0.1320, -0.1586, -0.1771],
    [-0.0093, -0.0322, -0.0561, -0.1024, -0.1423, -0.1746, -0.2102, -0.2409, -0.2654],
    [-0.0902, -0.1169, -0.1424, -0.1898, -0.2305, -0.2642, -0.3036, -0.3409, -0.3729],
];

/// L by depth and slip.
#[rustfmt::skip]
const LOWERING: [[f64; SLIPS.len()]; DEPTHS.len()] = [
    [-0.1280, -0.0834, -0.0638, -0.0468, -0.0359, -0.0263, -0.0139, -0.0028, 0.0028],
    [-0.1659, -0.1188, -0.0952, -0.0691, -0.0512, -0.0362, -0.0180, -0.0020, 0.0061],
    [-0.2067, -0.1564, -0.1272, -0.0909, -0.0655, -0.0450, -0.0209, -0.0002, 0.0106],
    [-0.2538, -0.2011, -0.1659, -0.1174, -0.0825, -0.0547, -0.0230, 0.0038, 0.0181],
    [-0.2925, -0.2385, -0.1988, -0.1401, -0.0966, -0.0622, -0.0232, 0.0094, 0.0272],
    [-0.3371, -0.2817, -0.2373, -0.1667, -0.1123, -0.0690, -0.0203, 0.0203, 0.0435],
    [-0.3681, -0.3116, -0.2640, -0.1845, -0.1213, -0.0707, -0.0138, 0.0341, 0.0624],
    [-0.3918, -0.3345, -0.2839, -0.1961, -0.1242, -0.0659, -0.0000, 0.0560, 0.0908],
    [-0.3997, -0.3418, -0.2891, -0.1948, -0.1155, -0.0505, 0.0236, 0.0879, 0.1303],
    [-0.3920, -0.3338, -0.2799, -0.1816, -0.0976, -0.0281, 0.0520, 0.1232, 0.1727],
];

/// Damping and lowering of an inextensible film over those of layer theory, by depth.
const FILM: [[f64; 2]; DEPTHS.len()] = [
    [0.9204, 0.8629],
    [0.8447, 0.7824],
    [0.7735, 0.7225],
    [0.6843, 0.6485],
    [0.5989, 0.5821],
    [0.4819, 0.4938],
    [0.3808, 0.4149],
    [0.2710, 0.3218],
    [0.1731, 0.2272],
    [0.1180, 0.1586],
];

/// Damping and lowering of the frequency.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Excess {
    /// Excess of the damping over layer theory.
    pub(super) damping: f64,
    /// Excess of the lowering over it.
    pub(super) lowering: f64,
}

/// Step by which the slope of the tables is found, as a factor on x.
const APART: f64 = 1.15;

/// Returns what a wall adds to layer theory, in units of w: `x` is the layer's depth without relaxation over the radius, and `held`
/// the share of the contact line that is held.
///
/// With relaxation the depth is complex, `x r`. The sum `f(x) = x (D + i L)` that the tables give is continued from `x |r|`, to first
/// order in the angle of r: `f(x r) = f(x |r|) + (r/|r| - 1) df/d ln x`.
pub(super) fn wall_excess(x: f64, layer: &WallLayer, held: f64) -> Excess {
    let Root { a, b, size } = layer.root();
    let at = |x: f64| {
        let slip = layer.slip / size;
        let Excess { damping, lowering } = tabled(x, slip / (1.0 + slip), held);
        Excess { damping: x * damping, lowering: x * lowering }
    };
    let deep = x * size;
    let here = at(deep);
    if b == 0.0 {
        return here;
    }
    let (more, less) = (at(deep * APART), at(deep / APART));
    let over = 0.5 / ln(APART);
    let slope = Excess {
        damping: over * (more.damping - less.damping),
        lowering: over * (more.lowering - less.lowering),
    };
    // r/|r| - 1 = turned - i across, on damping + i lowering.
    let (turned, across) = (a / size - 1.0, b / size);
    Excess {
        damping: here.damping + turned * slope.damping + across * slope.lowering,
        lowering: here.lowering + turned * slope.lowering - across * slope.damping,
    }
}

/// Returns D and L, or what takes their place, of a layer `x` deep (radii) and the slip `u`.
fn tabled(x: f64, u: f64, held: f64) -> Excess {
    let at = |table: &[[f64; SLIPS.len()]; DEPTHS.len()]| {
        let of =
            |slip: f64| along_depth(x, |row| table.get(row).map_or(0.0, |row| between(&SLIPS, row, slip)));
        let free = u * of(1.0);
        free + held * (of(u) - free)
    };
    Excess { damping: at(&DAMPING), lowering: at(&LOWERING) }
}

/// Returns the damping and the lowering of an inextensible film over those of layer theory, as factors.
pub(super) fn film_factors(x: f64) -> Excess {
    let of = |column: usize| {
        let first = FILM.first().and_then(|row| row.get(column)).copied().unwrap_or(1.0);
        let thick = between(&DEPTHS, &FILM.map(|row| row.get(column).copied().unwrap_or(1.0)), x);
        let thin = (x / DEPTHS[0]).clamp(0.0, 1.0);
        if thin < 1.0 { 1.0 + (first - 1.0) * thin } else { thick }
    };
    Excess { damping: of(0), lowering: of(1) }
}

/// Returns the value at the depth `x` of a table by rows of [`DEPTHS`], 0 at x = 0.
fn along_depth(x: f64, row: impl Fn(usize) -> f64) -> f64 {
    let values: [f64; DEPTHS.len()] = core::array::from_fn(row);
    let thin = (x / DEPTHS[0]).clamp(0.0, 1.0);
    if thin < 1.0 { values[0] * thin } else { between(&DEPTHS, &values, x) }
}

/// Returns the value at `x` on straight lines between `places` and `values`; beyond the ends it is that of the end.
pub(super) fn between<const N: usize>(places: &[f64; N], values: &[f64; N], x: f64) -> f64 {
    let mut last = (places.first().copied().unwrap_or(0.0), values.first().copied().unwrap_or(0.0));
    for (place, value) in places.iter().zip(values) {
        if x <= *place {
            let width = place - last.0;
            let part = if width > 0.0 { ((x - last.0) / width).max(0.0) } else { 1.0 };
            return last.1 + (value - last.1) * part;
        }
        last = (*place, *value);
    }
    last.1
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_thin_layer_has_no_correction_and_a_free_line_none_that_a_sticking_wall_makes() {
        let thin = tabled(1e-6, 0.0, 1.0);
        assert!(thin.damping.abs() < 1e-5 && thin.lowering.abs() < 1e-5, "{thin:?}");
        assert_eq!(tabled(0.13, 0.0, 0.0), Excess { damping: 0.0, lowering: 0.0 });
        // Where the liquid slips freely nothing is held that could be let go.
        assert_eq!(tabled(0.13, 1.0, 0.0), tabled(0.13, 1.0, 1.0));
        assert_eq!(film_factors(0.0), Excess { damping: 1.0, lowering: 1.0 });
        // Beyond the table nothing jumps.
        assert_eq!(tabled(0.9, 0.3, 1.0), tabled(0.3, 0.3, 1.0));
    }

    #[test]
    fn a_stress_that_relaxes_at_once_makes_the_layer_deeper_and_an_elastic_one_gives_back() {
        let plain = wall_excess(0.1, &WallLayer { slip: 0.0, relaxing: [0.0; 2] }, 1.0);
        assert!((plain.damping - 0.01846).abs() < 1e-9, "{plain:?}");
        let deeper = wall_excess(0.1, &WallLayer { slip: 0.0, relaxing: [0.69, 0.0] }, 1.0);
        let wanted = wall_excess(0.13, &WallLayer { slip: 0.0, relaxing: [0.0; 2] }, 1.0);
        assert!((deeper.damping - wanted.damping).abs() < 1e-9, "{deeper:?}");
        // An elastic layer damps less than a viscous one, and raises the frequency more than a thin one.
        let elastic = wall_excess(0.1, &WallLayer { slip: 0.0, relaxing: [0.54, -0.62] }, 1.0);
        assert!(elastic.damping < deeper.damping && elastic.lowering < plain.lowering, "{elastic:?}");
    }
}
