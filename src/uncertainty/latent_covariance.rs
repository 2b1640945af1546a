//! Error covariance of the latents in a form that can be sent: the lower triangle in single precision.

use crate::latent::generic::LATENTS;
use core::fmt;
use nalgebra::SMatrix;
use serde::de::{Error, SeqAccess, Visitor};
use serde::ser::SerializeTuple;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// Entries of the lower triangle.
pub const COVARIANCE_ENTRIES: usize = LATENTS * (LATENTS + 1) / 2;

/// Error covariance P of the reduced state, 13 x 13, lower triangle row by row, in units of the latents squared.
///
/// ```
/// use meniscus::uncertainty::latent_covariance::LatentCovariance;
///
/// let covariance = LatentCovariance::from_fn(|row, column| if row == column { 4.0 } else { 0.5 });
/// assert_eq!(covariance.at(3, 7), covariance.at(7, 3));
/// assert_eq!((covariance.at(5, 5), covariance.std(5)), (4.0, 2.0));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LatentCovariance([f32; COVARIANCE_ENTRIES]);

impl LatentCovariance {
    /// Returns the covariance whose entry in `row` and `column` is `entry(row, column)`, called with `column <= row`.
    #[must_use]
    pub fn from_fn(mut entry: impl FnMut(usize, usize) -> f32) -> Self {
        let mut packed = [0.0; COVARIANCE_ENTRIES];
        let places = (0..LATENTS).flat_map(|row| (0..=row).map(move |column| (row, column)));
        for (value, (row, column)) in packed.iter_mut().zip(places) {
            *value = entry(row, column);
        }
        Self(packed)
    }

    /// Returns the lower triangle of `matrix`, rounded to single precision.
    pub(crate) fn of(matrix: &SMatrix<f64, LATENTS, LATENTS>) -> Self {
        Self::from_fn(|row, column| matrix.get((row, column)).map_or(0.0, |value| *value as f32))
    }

    /// Returns the entry in `row` and `column`; NaN outside the matrix.
    #[must_use]
    pub fn at(&self, row: usize, column: usize) -> f32 {
        let (row, column) = if row < column { (column, row) } else { (row, column) };
        // Packed rows have 1, 2, 3, ... entries: row r starts behind r (r + 1) / 2 of them.
        let place = row.saturating_mul(row.saturating_add(1)) / 2 + column;
        if row < LATENTS { self.0.get(place).copied().unwrap_or(f32::NAN) } else { f32::NAN }
    }

    /// Returns the standard deviation of latent `index`; NaN outside the matrix.
    #[must_use]
    pub fn std(&self, index: usize) -> f32 {
        crate::math::sqrtf(self.at(index, index))
    }

    /// Returns the lower triangle, row by row.
    #[must_use]
    pub fn packed(&self) -> &[f32; COVARIANCE_ENTRIES] {
        &self.0
    }
}

impl Default for LatentCovariance {
    /// All zeros.
    fn default() -> Self {
        Self([0.0; COVARIANCE_ENTRIES])
    }
}

// serde derives arrays up to 32 entries only.
impl Serialize for LatentCovariance {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut tuple = serializer.serialize_tuple(COVARIANCE_ENTRIES)?;
        self.0.iter().try_for_each(|value| tuple.serialize_element(value))?;
        tuple.end()
    }
}

impl<'de> Deserialize<'de> for LatentCovariance {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Entries;

        impl<'de> Visitor<'de> for Entries {
            type Value = LatentCovariance;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                write!(f, "{COVARIANCE_ENTRIES} numbers")
            }

            fn visit_seq<A: SeqAccess<'de>>(self, mut entries: A) -> Result<Self::Value, A::Error> {
                let mut packed = [0.0; COVARIANCE_ENTRIES];
                for (index, value) in packed.iter_mut().enumerate() {
                    *value = entries.next_element()?.ok_or_else(|| A::Error::invalid_length(index, &self))?;
                }
                Ok(LatentCovariance(packed))
            }
        }

        deserializer.deserialize_tuple(COVARIANCE_ENTRIES, Entries)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn entries_are_those_of_the_matrix_on_both_sides() {
        let matrix = SMatrix::<f64, LATENTS, LATENTS>::from_fn(|row, column| {
            (10 * row.max(column) + row.min(column)) as f64
        });
        let covariance = LatentCovariance::of(&matrix);
        for row in 0..LATENTS {
            for column in 0..LATENTS {
                assert_eq!(f64::from(covariance.at(row, column)), matrix[(row, column)]);
            }
        }
        assert!(covariance.at(0, LATENTS).is_nan() && covariance.at(LATENTS, 0).is_nan());
        assert_eq!(covariance.packed()[COVARIANCE_ENTRIES - 1], covariance.at(12, 12));
    }

    #[test]
    fn bytes_give_the_same_covariance_and_a_cut_is_refused() {
        let covariance = LatentCovariance::from_fn(|row, column| (row + column) as f32);
        let mut buffer = [0; 4 * COVARIANCE_ENTRIES];
        let bytes = postcard::to_slice(&covariance, &mut buffer).expect("four bytes an entry");
        assert_eq!(bytes.len(), 4 * COVARIANCE_ENTRIES);
        assert_eq!(postcard::from_bytes::<LatentCovariance>(bytes), Ok(covariance));
        assert!(postcard::from_bytes::<LatentCovariance>(&bytes[..bytes.len() - 1]).is_err());
    }
}
