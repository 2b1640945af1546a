//! The camera's image of the highest crest of a run, for its picture.

use crate::sink::{TurnRecord, TurnSink};
use meniscus::runtime::Turn;

/// Image of the turn in which the estimated surface was farthest from rest.
#[derive(Clone, Debug, Default)]
pub struct CrestImage {
    /// Y8 pixels, row-major.
    pub outline: Vec<u8>,
    /// Its turn; `None` until the liquid has been seen.
    pub turn: Option<Turn>,
    /// Largest distance of the estimated surface from rest, metres.
    pub crest_m: f32,
    fill_m: f32,
}

impl CrestImage {
    /// Returns room for an image of `pixels` pixels, of a liquid that stands `fill_m` high at rest.
    #[must_use]
    pub fn new(fill_m: f32, pixels: usize) -> Self {
        Self { outline: vec![0; pixels], fill_m, ..Self::default() }
    }
}

impl TurnSink for CrestImage {
    fn accept(&mut self, record: &TurnRecord<'_>) {
        let turn = &record.logged.turn;
        let (Some(after), Some(Ok(_))) = (record.after, turn.profile) else { return };
        let away = |z: &f32| (z - self.fill_m).abs();
        let crest_m = turn.estimate.surface_m.iter().map(away).fold(0.0, f32::max);
        if crest_m > self.crest_m && after.outline.len() == self.outline.len() {
            self.outline.copy_from_slice(after.outline);
            self.turn = Some(*turn);
            self.crest_m = crest_m;
        }
    }
}
