//! The page's own thread: turns of the worker into frames and images, once for all viewers.

use super::board::{Board, Numbered};
use super::frame::{AHEAD, Facts, frame};
use super::image::{GlassExtent, Window};
use meniscus::blob::Model;
use meniscus::runtime::{Crest, Forecast};
use meniscus::surface::Config;
use meniscus::units::Micros;
use meniscus_service::snapshot::SnapshotOutlet;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

/// Pause between two looks for viewers while there are none.
const IDLE: Duration = Duration::from_millis(30);

/// Time between two forecasts: they cost more than all else here, and the eye does not follow them faster.
const FORECAST_EVERY: Duration = Duration::from_millis(95);

/// Turns within which the next crest is looked for.
const CREST_WITHIN: usize = 30;

/// Composes until the page closes; with nobody there it does nothing at all.
pub(super) fn compose(model: &Model<'_>, config: &Config, outlet: &SnapshotOutlet, board: &Board) {
    let header = &model.header;
    let glass = GlassExtent { radius_m: header.radius_m as f32, rim_m: header.rim_m as f32 };
    let (mut window, mut number) = (Window::default(), 0_u32);
    let mut image_due = Instant::now();
    let mut last_frame: Option<Micros> = None;
    let mut foreseen: Option<(Instant, Option<Crest>, [Forecast; 2])> = None;
    while !board.closing() {
        let viewers = board.viewers.load(Ordering::Relaxed);
        if viewers == 0 {
            std::thread::sleep(IDLE);
            continue;
        }
        let Some((snapshot, logged)) = outlet.take(&mut image_due) else { continue };
        number = number.wrapping_add(1);
        let now = logged.turn.time;
        if logged.turn.stamp.is_some() {
            last_frame = Some(now);
        }
        let (_, crest, ahead) = match foreseen {
            Some(old) if old.0.elapsed() < FORECAST_EVERY => old,
            _ => {
                let crest = Crest::next(model, &snapshot.memory, CREST_WITHIN, &[]);
                let ahead = AHEAD.map(|turns| Forecast::new(model, &snapshot.memory, turns, &[]));
                *foreseen.insert((Instant::now(), crest, ahead))
            }
        };
        let facts = Facts {
            snapshot: &snapshot,
            logged: &logged,
            unseen_s: last_frame.map_or(f64::NAN, |last| now.since(last) as f64 * 1e-6),
            viewers: (viewers, board.counters.left_out.load(Ordering::Relaxed)),
            crest,
            ahead,
        };
        let bytes = frame(model, &facts, number);
        let image = window.image(config, glass, &snapshot, number);
        let image: Option<Numbered> = image.map(|bytes| (number, bytes.into()));
        board.put((number, bytes.into()), image);
    }
}
