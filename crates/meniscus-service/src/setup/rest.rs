//! The surface at rest, as the reader of a run sees it with the measured settings.

use super::portrait::Pair;
use meniscus::surface::{Config, ExtractionError, ExtractionState, POINTS, SurfaceProfile, profile_abscissa};

/// Surface that the extractor finds in image pairs of a resting glass; lengths in millimetres.
#[derive(Clone, Debug, PartialEq)]
pub struct Rest {
    /// Share of the pairs that gave a profile.
    pub seen: f64,
    /// Share of the points of those profiles that were seen.
    pub valid: f64,
    /// Mean height of the surface above the inner bottom.
    pub level_mm: f64,
    /// Height of the surface at the right side of the glass minus that at the left one.
    pub slope_mm: f64,
    /// Standard deviation of a point over the pairs, root mean square over the points.
    pub noise_mm: f64,
    /// Root mean square distance of the mean surface from a straight line.
    pub bend_mm: f64,
    /// Height of each point, mean over the pairs, metres; none where a point was never seen.
    pub height_m: [Option<f32>; POINTS],
    /// Why the last pair without a profile gave none.
    pub why: Option<ExtractionError>,
}

impl Rest {
    /// Takes every pair through the extractor.
    #[must_use]
    pub fn of(pairs: &[Pair], config: &Config) -> Self {
        let (mut state, mut why) = (ExtractionState::new(), None);
        let mut profiles: Vec<SurfaceProfile> = Vec::with_capacity(pairs.len());
        for pair in pairs {
            match pair.extract(config, &mut state) {
                Ok(profile) => profiles.push(profile),
                Err(error) => why = Some(error),
            }
        }
        let mut points = [(0_u32, 0.0_f64, 0.0_f64); POINTS];
        for profile in &profiles {
            let heights = profile.height_m.iter().zip(&profile.valid);
            for ((count, sum, squares), (height, _)) in
                points.iter_mut().zip(heights).filter(|(_, (_, ok))| **ok)
            {
                let mm = 1e3 * f64::from(*height);
                *count += 1;
                *sum += mm;
                *squares += mm * mm;
            }
        }
        let mean = |(count, sum, _): &(u32, f64, f64)| (*count > 0).then(|| sum / f64::from(*count));
        let placed: Vec<(f64, f64)> = (0..)
            .zip(&points)
            .filter_map(|(index, point)| Some((profile_abscissa(index), mean(point)?)))
            .collect();
        let (level_mm, slope_mm, bend_mm) = straight(&placed);
        let spread = |&(count, sum, squares): &(u32, f64, f64)| {
            let n = f64::from(count);
            (count > 1).then(|| ((squares - sum * sum / n) / (n - 1.0)).max(0.0))
        };
        let spreads: Vec<f64> = points.iter().filter_map(spread).collect();
        let all = profiles.len() * POINTS;
        let valid: usize = profiles.iter().map(SurfaceProfile::valid_points).sum();
        Self {
            seen: profiles.len() as f64 / pairs.len().max(1) as f64,
            valid: if all == 0 { f64::NAN } else { valid as f64 / all as f64 },
            level_mm,
            slope_mm,
            noise_mm: (spreads.iter().sum::<f64>() / spreads.len() as f64).sqrt(),
            bend_mm,
            height_m: points.each_ref().map(|point| mean(point).map(|mm| 1e-3 * mm as f32)),
            why,
        }
    }
}

/// Mean, rise over the whole width and root mean square residual of the straight line through `points`, whose places
/// are in radii; not a number of less than three.
fn straight(points: &[(f64, f64)]) -> (f64, f64, f64) {
    let n = points.len() as f64;
    if points.len() < 3 {
        return (f64::NAN, f64::NAN, f64::NAN);
    }
    let (x, z) = points.iter().fold((0.0, 0.0), |(x, z), p| (x + p.0 / n, z + p.1 / n));
    let (xx, xz) =
        points.iter().fold((0.0, 0.0), |(xx, xz), p| (xx + (p.0 - x).powi(2), xz + (p.0 - x) * (p.1 - z)));
    let slope = xz / xx;
    let squares: f64 = points.iter().map(|p| (p.1 - z - slope * (p.0 - x)).powi(2)).sum();
    (z - slope * x, 2.0 * slope, (squares / n).sqrt())
}
