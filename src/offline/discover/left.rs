//! What references leave in one motion: mean and scatter.

use super::record::Record;
use crate::offline::prelude::*;

/// What the references leave in one motion.
#[derive(Clone, Debug)]
pub struct Left {
    pub(super) like: Record,
    /// Mean, by channel and frame, m.
    pub mean: Vec<Vec<f64>>,
    /// Scatter about it, one for each reference, m.
    pub scatter: Vec<Vec<Vec<f64>>>,
}

impl Left {
    /// Smooths the scatter over five frames: its noise is in the noise already.
    pub(super) fn smooth(&mut self) {
        for series in self.scatter.iter_mut().flatten() {
            let rough = series.clone();
            for (f, x) in series.iter_mut().enumerate() {
                let near = &rough[f.saturating_sub(2)..(f + 3).min(rough.len())];
                *x = near.iter().sum::<f64>() / near.len() as f64;
            }
        }
    }

    /// Splits what the references leave into mean and scatter.
    pub(super) fn centred(mut self) -> Self {
        let frames = self.scatter.iter().map(|s| s[0].len()).min().unwrap_or(0);
        let groups = self.scatter.len() as f64;
        let channels = self.scatter[0].len();
        self.mean = (0..channels)
            .map(|c| {
                (0..frames).map(|f| self.scatter.iter().map(|s| s[c][f]).sum::<f64>() / groups).collect()
            })
            .collect();
        for scatter in &mut self.scatter {
            for (series, mean) in scatter.iter_mut().zip(&self.mean) {
                series.truncate(frames);
                series.iter_mut().zip(mean).for_each(|(x, m)| *x -= m);
            }
        }
        self
    }
}
