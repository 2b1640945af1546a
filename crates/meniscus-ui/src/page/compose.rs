//! The page's own thread: turns of the worker into frames and images, once for all viewers.

use super::board::Board;
use super::frame::{AHEAD, Facts, frame};
use super::image::{GlassExtent, Window};
use super::recent_error::RecentError;
use meniscus::blob::Model;
use meniscus::runtime::{Crest, Forecast, Mode};
use meniscus::surface::Config;
use meniscus::units::Micros;
use meniscus_service::snapshot::{ImageSchedule, SnapshotOutlet};
use meniscus_service::truth::Truth;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

/// Pause between two looks for viewers while there are none.
const IDLE: Duration = Duration::from_millis(30);

/// Time between two forecasts: they cost more than all else here, and the eye does not follow them faster.
const FORECAST_EVERY: Duration = Duration::from_millis(95);

/// Turns within which the next crest is looked for.
const CREST_WITHIN: usize = 30;

/// Source that the page shows.
pub(super) struct Shown<'s> {
    /// Reader of the images.
    pub(super) config: &'s Config,
    /// The true surface, where the camera is simulated.
    pub(super) truth: Option<&'s Truth>,
}

/// Composes until the page closes; with nobody there it does nothing at all.
pub(super) fn compose(model: &Model<'_>, shown: &Shown<'_>, outlet: &SnapshotOutlet, board: &Board) {
    let header = &model.header;
    let glass = GlassExtent { radius_m: header.radius_m as f32, rim_m: header.rim_m as f32 };
    let (mut window, mut number) = (Window::default(), 0_u32);
    // Through a lens of its own it would not lie under what is drawn on it.
    let depth_fits = shown.config.settings().depth_lens_m == [0.0; 3];
    let (mut images, mut recent) = (ImageSchedule::default(), RecentError::default());
    let mut last_frame: Option<Micros> = None;
    let mut foreseen: Option<(Instant, Option<Crest>, [Forecast; 2])> = None;
    while !board.closing() {
        let viewers = board.viewers.load(Ordering::Relaxed);
        if viewers == 0 {
            std::thread::sleep(IDLE);
            continue;
        }
        images.want_depth(depth_fits && board.depth_viewers.load(Ordering::Relaxed) > 0);
        let Some((snapshot, logged)) = outlet.take(&mut images) else { continue };
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
        let estimated = matches!(logged.turn.estimate.mode, Mode::Tracking | Mode::Coasting);
        let truth = shown.truth.and_then(|truth| Some((truth.at(now)?, truth.fill_m)));
        if let Some((surface_m, fill_m)) = truth.filter(|_| estimated) {
            recent.add(surface_m, &logged.turn.estimate.surface_m, fill_m);
        }
        let facts = Facts {
            snapshot: &snapshot,
            logged: &logged,
            unseen_s: last_frame.map_or(f64::NAN, |last| now.since(last) as f64 * 1e-6),
            viewers: (viewers, board.counters.left_out.load(Ordering::Relaxed)),
            crest,
            ahead,
            truth: truth.map(|(surface_m, _)| surface_m),
            recent_error: recent.get(),
        };
        let bytes = frame(model, &facts, number);
        let images = window.images(shown.config, glass, &snapshot, number);
        let images = images.map(|image| image.map(|bytes| (number, bytes.into())));
        board.put((number, bytes.into()), images);
    }
}
