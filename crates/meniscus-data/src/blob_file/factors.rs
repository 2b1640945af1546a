//! Interval factors among the tensors of a blob.

use super::write::Part;
use meniscus::blob::Tensor;
use meniscus::uncertainty::error_factors::ErrorFactors;

/// Returns the tensor of `factors`.
#[must_use]
pub fn part(factors: &ErrorFactors) -> Part {
    let values = factors.to_tensor().to_vec();
    Part { tensor: Tensor::Reach, rows: values.len(), columns: 1, values }
}

/// Returns the factors among `parts`; `None` where they are missing or have a wrong count.
#[must_use]
pub fn of(parts: &[Part]) -> Option<ErrorFactors> {
    let part = parts.iter().find(|part| part.tensor == Tensor::Reach)?;
    ErrorFactors::from_tensor(&part.values)
}

/// Changes the factors among `parts`, if there are any.
pub fn change(parts: &mut [Part], change: impl FnOnce(&mut ErrorFactors)) {
    let Some(mut factors) = of(parts) else { return };
    change(&mut factors);
    for stored in parts.iter_mut().filter(|stored| stored.tensor == Tensor::Reach) {
        *stored = part(&factors);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_change_is_found_again() {
        let mut parts = [part(&ErrorFactors::uncalibrated(0.25))];
        change(&mut parts, |factors| factors.rest_noise_std_m = 1e-4);
        let due = ErrorFactors { rest_noise_std_m: 1e-4, ..ErrorFactors::uncalibrated(0.25) };
        assert_eq!(of(&parts), Some(due));
        parts[0].values.truncate(3);
        assert_eq!(of(&parts), None);
    }
}
