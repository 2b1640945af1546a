//! Group of references: recordings of one known liquid in one glass.

use crate::recordings::record::Record;
use crate::recordings::split::Split;
use crate::recordings::stated::Known;

/// Recordings of one known liquid in one glass, with the baseline that was fitted to them.
#[derive(Clone, Debug)]
pub struct Group {
    /// Glass and liquid as stated.
    pub known: Known,
    /// Recordings.
    pub records: Vec<Record>,
    /// The same recordings, split for the judgement of this group by the others.
    pub split: Split,
    /// Numbers of the baseline that fit the recordings best, then their lags.
    pub(crate) theta: Vec<f64>,
    /// Residual of the baseline by recording, channel and frame, m.
    pub(crate) residual_m: Vec<Vec<Vec<f64>>>,
}
