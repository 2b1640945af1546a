//! Upper end of a scale in a terminal.

use std::collections::VecDeque;

/// Pictures after which a large value no longer counts: ten seconds.
const REMEMBERED: usize = 150;

/// End of a scale that follows the largest value of the last ten seconds in steps, so that it can be read.
#[derive(Clone, Debug)]
pub(super) struct ScaleEnd {
    steps: &'static [f64],
    values: VecDeque<f64>,
}

impl ScaleEnd {
    /// A scale that ends at one of `steps`, which rise.
    pub(super) fn new(steps: &'static [f64]) -> Self {
        Self { steps, values: VecDeque::with_capacity(REMEMBERED) }
    }

    /// Takes a value into account.
    pub(super) fn remember(&mut self, value: f64) {
        if self.values.len() == REMEMBERED {
            self.values.pop_front();
        }
        self.values.push_back(value);
    }

    /// Returns the smallest step that no remembered value exceeds; the last one if all do.
    pub(super) fn shown(&self) -> f64 {
        let largest = self.values.iter().copied().fold(0.0, f64::max);
        let end = self.steps.iter().copied().find(|step| *step >= largest);
        end.or(self.steps.last().copied()).unwrap_or(1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_scale_follows_in_steps_and_forgets() {
        let mut span = ScaleEnd::new(&[2.0, 4.0, 8.0]);
        assert_eq!(span.shown(), 2.0);
        span.remember(3.0);
        assert_eq!(span.shown(), 4.0);
        span.remember(100.0);
        assert_eq!(span.shown(), 8.0);
        (0..REMEMBERED).for_each(|_| span.remember(1.0));
        assert_eq!(span.shown(), 2.0);
    }
}
