//! Conformal factors of a blob, and the one place that knows their order in the tensor `Reach`.

/// Turns ahead for which a forecast's interval has been measured: now, 0.25 s, 0.5 s.
pub const LEADS: [usize; 3] = [0, 15, 30];

/// Turns without heights and without a known motion after which an estimate is worth as much as a forecast of a free glass: an
/// acceleration is carried on for two turns.
const FREE_TURNS: u32 = 3;

/// Groups of the field with a factor: q, v, e, sigma, tau.
pub const FIELD_GROUPS: usize = 5;

/// Factors of the intervals, and the two constants of the variances that they multiply.
///
/// ```
/// use meniscus::uncertainty::error_factors::ErrorFactors;
///
/// // A blob from before surfaces at rest were measured states nine numbers: its `rest_noise_std_m` is zero.
/// let old = ErrorFactors::from_tensor(&[0.1, 2.0, 2.5, 3.0, 1.1, 1.2, 1.3, 1.4, 1.5]).unwrap();
/// assert_eq!((old.weight_floor, old.surface, old.rest_noise_std_m), (0.1, [2.0, 2.5, 3.0], 0.0));
/// assert_eq!((old.planned, old.crest, old.disagreement), ([2.0, 2.0], 2.0, ErrorFactors::LEAST_DISAGREEMENT));
/// assert_eq!(ErrorFactors::from_tensor(&old.to_tensor()), Some(old));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ErrorFactors {
    /// Floor of the weight w = floor + H(x), in units of H: the slosh at which the encoder's error has doubled.
    pub weight_floor: f32,
    /// k of the surface at each of [`LEADS`].
    pub surface: [f32; LEADS.len()],
    /// k of q, v, e, sigma and tau.
    pub field: [f32; FIELD_GROUPS],
    /// g: standard deviation of what is missed of a surface at rest, m.
    pub rest_noise_std_m: f32,
    /// k of the surface at each of [`LEADS`] but the present, where the motion of the glass is planned.
    pub planned: [f32; LEADS.len() - 1],
    /// k of the height of the next crest, where the motion is planned up to it.
    pub crest: f32,
    /// theta: disagreement with the camera up to which the intervals stay as wide as k says (`crate::uncertainty::disagreement`).
    pub disagreement: f32,
}

impl ErrorFactors {
    /// Sizes that the tensor may have. Blobs before the later numbers have fewer: the first end before
    /// `rest_noise_std_m`, the next before `planned`, the next before `disagreement`.
    pub const SIZES: [usize; 4] =
        [1 + LEADS.len() + FIELD_GROUPS, 2 + LEADS.len() + FIELD_GROUPS, Self::NUMBERS - 1, Self::NUMBERS];

    /// Numbers of [`Self::to_tensor`].
    pub const NUMBERS: usize = 2 * LEADS.len() + FIELD_GROUPS + 3;

    /// Least theta of a model, and that of a blob from before it was measured. A model that errs as it states has a rho of one; the rest
    /// is room for the scatter of rho.
    pub const LEAST_DISAGREEMENT: f32 = 1.4;

    /// Numbers of [`Self::quantiles`].
    pub const QUANTILES: usize = 2 * LEADS.len() + FIELD_GROUPS;

    /// Factors of one, as a blob has them before it is calibrated, and intervals that never widen: how much they would depends on k.
    #[must_use]
    pub const fn uncalibrated(weight_floor: f32) -> Self {
        Self {
            weight_floor,
            surface: [1.0; LEADS.len()],
            field: [1.0; FIELD_GROUPS],
            rest_noise_std_m: 0.0,
            planned: [1.0; LEADS.len() - 1],
            crest: 1.0,
            disagreement: f32::MAX,
        }
    }

    /// Reads the tensor; `None` where it has another size than [`Self::SIZES`].
    ///
    /// A blob without factors of a planned motion had none measured: they are that of the present surface.
    #[must_use]
    pub fn from_tensor(numbers: &[f32]) -> Option<Self> {
        let (&weight_floor, rest) = numbers.split_first()?;
        let (&surface, rest) = rest.split_first_chunk()?;
        let (&field, rest) = rest.split_first_chunk()?;
        let [now, ..]: [f32; LEADS.len()] = surface;
        let (as_now, least) = ([now; LEADS.len() - 1], Self::LEAST_DISAGREEMENT);
        let (rest_noise_std_m, planned, crest, disagreement) = match *rest {
            [] => (0.0, as_now, now, least),
            [at_rest] => (at_rest, as_now, now, least),
            [at_rest, near, far, crest] => (at_rest, [near, far], crest, least),
            [at_rest, near, far, crest, disagreement] => (at_rest, [near, far], crest, disagreement),
            _ => return None,
        };
        Some(Self { weight_floor, surface, field, rest_noise_std_m, planned, crest, disagreement })
    }

    /// Returns the numbers in the order of the tensor.
    #[must_use]
    pub fn to_tensor(&self) -> [f32; Self::NUMBERS] {
        let mut numbers = [0.0; Self::NUMBERS];
        let values = core::iter::once(&self.weight_floor)
            .chain(&self.surface)
            .chain(&self.field)
            .chain(core::iter::once(&self.rest_noise_std_m))
            .chain(&self.planned)
            .chain([&self.crest, &self.disagreement]);
        numbers.iter_mut().zip(values).for_each(|(slot, value)| *slot = *value);
        numbers
    }

    /// Returns the factors in one row: surface, field, planned, crest.
    #[must_use]
    pub fn quantiles(&self) -> [f32; Self::QUANTILES] {
        let mut row = [0.0; Self::QUANTILES];
        let all =
            self.surface.iter().chain(&self.field).chain(&self.planned).chain(core::iter::once(&self.crest));
        row.iter_mut().zip(all).for_each(|(slot, k)| *slot = *k);
        row
    }

    /// Iterates over the factors in the order of [`Self::quantiles`], to change them.
    pub fn quantiles_mut(&mut self) -> impl Iterator<Item = &mut f32> {
        self.surface
            .iter_mut()
            .chain(&mut self.field)
            .chain(&mut self.planned)
            .chain(core::iter::once(&mut self.crest))
    }

    /// Returns k of the surface of an estimate behind `blind` turns in a row without heights and without a known motion: that
    /// of a seen surface behind none, that of a free forecast from [`FREE_TURNS`] on, and straight between.
    ///
    /// The filter's covariance alone would be too small there: hands and robots jerk more often than its Gaussian input. With one
    /// factor for all turns, ever fewer heights lie within their interval from one unseen turn to the next.
    pub(crate) fn of_estimate(&self, blind: u32) -> f64 {
        let [now, free, ..] = self.surface.map(f64::from);
        let way = f64::from(blind.min(FREE_TURNS)) / f64::from(FREE_TURNS);
        now + way * (free - now).max(0.0)
    }

    /// Returns k of the surface at each of [`LEADS`] where the motion of the glass is planned.
    pub(crate) fn of_a_plan(&self) -> [f32; LEADS.len()] {
        let ([now, ..], [near, far]) = (self.surface, self.planned);
        [now, near, far]
    }

    /// Whether no number is below zero.
    pub(crate) fn none_negative(&self) -> bool {
        self.to_tensor().iter().all(|number| *number >= 0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn another_count_is_no_tensor_of_factors() {
        let numbers = [1.0; ErrorFactors::NUMBERS + 1];
        for size in 0..=numbers.len() {
            let read = ErrorFactors::from_tensor(&numbers[..size]);
            assert_eq!(read.is_some(), ErrorFactors::SIZES.contains(&size), "{size}");
        }
    }

    #[test]
    fn an_unseen_surface_is_worth_less_from_turn_to_turn() {
        let factors = ErrorFactors { surface: [1.5, 4.5, 4.0], ..ErrorFactors::uncalibrated(0.1) };
        for (blind, due) in [(0, 1.5), (1, 2.5), (2, 3.5), (3, 4.5), (60, 4.5)] {
            assert!((factors.of_estimate(blind) - due).abs() < 1e-6, "{blind}");
        }
        // A blob from before forecasts were measured, or a model that forecasts better than it sees.
        let flat = ErrorFactors { surface: [2.0, 1.5, 1.5], ..factors };
        assert_eq!(flat.of_estimate(9), 2.0);
    }

    #[test]
    fn the_order_is_that_of_the_specification() {
        let mut factors = ErrorFactors::uncalibrated(0.5);
        factors.quantiles_mut().zip(2_u8..).for_each(|(k, number)| *k = f32::from(number));
        factors.rest_noise_std_m = 20.0;
        factors.disagreement = 30.0;
        let row = [0.5, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0, 20.0, 10.0, 11.0, 12.0, 30.0];
        assert_eq!(factors.to_tensor(), row);
        assert_eq!(factors.quantiles(), [2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0, 10.0, 11.0, 12.0]);
        assert!(factors.none_negative());
        // A blob from before these were measured takes the factor of the present surface.
        let old = ErrorFactors::from_tensor(&row[..10]).expect("a size of before");
        assert_eq!((old.planned, old.crest), ([2.0; 2], 2.0));
        let old = ErrorFactors::from_tensor(&row[..13]).expect("a size of before");
        assert_eq!((old.crest, old.disagreement), (12.0, ErrorFactors::LEAST_DISAGREEMENT));
        factors.field[4] = -1e-9;
        assert!(!factors.none_negative());
    }
}
