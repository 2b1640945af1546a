//! Conformal factors of a blob, and the one place that knows their order in the tensor `Reach`.

/// Turns ahead for which a forecast's interval has been measured: now, 0.25 s, 0.5 s.
pub const LEADS: [usize; 3] = [0, 15, 30];

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
}

impl ErrorFactors {
    /// Numbers that a tensor holds at least: all but `rest_noise_std_m`, which blobs before it have not.
    pub const LEAST_NUMBERS: usize = 1 + LEADS.len() + FIELD_GROUPS;

    /// Numbers of [`Self::to_tensor`].
    pub const NUMBERS: usize = Self::LEAST_NUMBERS + 1;

    /// Factors of one, as a blob has them before it is calibrated.
    #[must_use]
    pub const fn uncalibrated(weight_floor: f32) -> Self {
        Self { weight_floor, surface: [1.0; LEADS.len()], field: [1.0; FIELD_GROUPS], rest_noise_std_m: 0.0 }
    }

    /// Reads the tensor; `None` where it has fewer or more numbers than a blob may state.
    #[must_use]
    pub fn from_tensor(numbers: &[f32]) -> Option<Self> {
        let (&weight_floor, rest) = numbers.split_first()?;
        let (&surface, rest) = rest.split_first_chunk()?;
        let (&field, rest) = rest.split_first_chunk()?;
        let rest_noise_std_m = match rest {
            [] => 0.0,
            [only] => *only,
            _ => return None,
        };
        Some(Self { weight_floor, surface, field, rest_noise_std_m })
    }

    /// Returns the numbers in the order of the tensor.
    #[must_use]
    pub fn to_tensor(&self) -> [f32; Self::NUMBERS] {
        let mut numbers = [0.0; Self::NUMBERS];
        let values = core::iter::once(&self.weight_floor)
            .chain(&self.surface)
            .chain(&self.field)
            .chain(core::iter::once(&self.rest_noise_std_m));
        numbers.iter_mut().zip(values).for_each(|(slot, value)| *slot = *value);
        numbers
    }

    /// Returns the factors of surface and field in one row: those of the surface first.
    #[must_use]
    pub fn quantiles(&self) -> [f32; LEADS.len() + FIELD_GROUPS] {
        let mut row = [0.0; LEADS.len() + FIELD_GROUPS];
        let all = self.surface.iter().chain(&self.field);
        row.iter_mut().zip(all).for_each(|(slot, k)| *slot = *k);
        row
    }

    /// Iterates over the factors in the order of [`Self::quantiles`], to change them.
    pub fn quantiles_mut(&mut self) -> impl Iterator<Item = &mut f32> {
        self.surface.iter_mut().chain(&mut self.field)
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
        assert_eq!(ErrorFactors::from_tensor(&numbers), None);
        assert_eq!(ErrorFactors::from_tensor(&numbers[..ErrorFactors::LEAST_NUMBERS - 1]), None);
        assert!(ErrorFactors::from_tensor(&numbers[..ErrorFactors::NUMBERS]).is_some());
    }

    #[test]
    fn the_order_is_that_of_the_specification() {
        let mut factors = ErrorFactors::uncalibrated(0.5);
        factors.quantiles_mut().zip(2_u8..).for_each(|(k, number)| *k = f32::from(number));
        factors.rest_noise_std_m = 10.0;
        assert_eq!(factors.to_tensor(), [0.5, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0, 10.0]);
        assert_eq!(factors.quantiles(), [2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0]);
        assert!(factors.none_negative());
        factors.field[4] = -1e-9;
        assert!(!factors.none_negative());
    }
}
