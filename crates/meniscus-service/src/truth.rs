//! The true surface, where the camera is simulated.

use meniscus::surface::POINTS;
use meniscus::units::{FRAME_INTERVAL_S, Micros};

/// Free surface as the simulator knows it.
#[derive(Clone, Debug)]
pub struct Truth {
    /// Heights above the inner bottom, m; frames x 21.
    pub profiles_m: Vec<f32>,
    /// Camera time of the first frame.
    pub start: Micros,
    /// Frames after which the recording begins again. In those beyond `profiles_m` nothing is known: the glass is carried back.
    pub round: usize,
    /// Height of the liquid at rest, m.
    pub fill_m: f64,
}

impl Truth {
    /// Returns the surface at `time`; `None` where nothing is known.
    #[must_use]
    pub fn at(&self, time: Micros) -> Option<&[f32; POINTS]> {
        let after_s = time.0.checked_sub(self.start.0)? as f64 * 1e-6;
        let frame = (after_s / FRAME_INTERVAL_S).round() as usize % self.round.max(1);
        self.profiles_m.as_chunks::<POINTS>().0.get(frame)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn truth() -> Truth {
        let profiles_m = (0..3_u8).flat_map(|frame| [f32::from(frame); POINTS]).collect();
        Truth { profiles_m, start: Micros(1_000_000), round: 5, fill_m: 0.07 }
    }

    #[test]
    fn a_round_has_its_frames_and_a_way_back_of_which_nothing_is_known() {
        let truth = truth();
        let at = |frame: u64| truth.at(Micros(1_000_000 + (frame * 1_000_000 + 30) / 60)).map(|z| z[7]);
        assert_eq!([at(0), at(2), at(3), at(4)], [Some(0.0), Some(2.0), None, None]);
        assert_eq!([at(5), at(601), at(603)], [Some(0.0), Some(1.0), None]);
        assert_eq!(truth.at(Micros(999_999)), None, "before the first frame");
    }
}
