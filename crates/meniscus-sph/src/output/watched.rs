//! A glass that is watched while it moves, for a motion that is decided on the way.
//!
//! Each frame gives the profile of that instant, as a camera has it: unfiltered, sound of the weakly compressible liquid
//! included. The heights along the wall are known afterwards, behind the filter of [`super::record`], which looks ahead.

use super::record::{HALF, OVERSAMPLING, taps};
use super::surface::{COEFFICIENTS, Coefficients, SurfaceFinder};
use crate::settled::check_running;
use crate::{Error, Setup, Simulator};
use meniscus::surface::POINTS;
use meniscus::units::FRAME_INTERVAL_S;
use meniscus_data::motion::Kinematics;
use std::sync::atomic::AtomicBool;

/// A glass of liquid with all that was seen of its surface. A clone goes on from the same instant.
#[derive(Clone, Debug)]
pub struct WatchedGlass {
    simulator: Simulator,
    finder: SurfaceFinder,
    /// Steps between two samples.
    steps: usize,
    /// Samples since the start, the first at time zero.
    samples: Vec<Coefficients>,
}

impl WatchedGlass {
    /// Settles the glass of `setup`; ends early once `stop` is raised.
    ///
    /// # Errors
    /// When the setup is out of range or settling fails, and [`Error::Stopped`].
    pub fn new(setup: &Setup, stop: &AtomicBool) -> Result<Self, Error> {
        let mut simulator = Simulator::new_until(setup, stop)?;
        let finder = SurfaceFinder::new(&simulator)?;
        let steps = simulator.divide(FRAME_INTERVAL_S / OVERSAMPLING as f64);
        let mut glass = Self { simulator, finder, steps, samples: Vec::new() };
        glass.look();
        Ok(glass)
    }

    /// Returns the profile of this instant, m above the inner bottom.
    #[must_use]
    pub fn profile(&self) -> [f32; POINTS] {
        self.samples.last().map_or([0.0; POINTS], |surface| self.finder.profile(surface))
    }

    /// Advances by one frame under `motion`, which gives the motion of the glass at a time since the start.
    ///
    /// # Errors
    /// When particles escape or a number is not finite, and [`Error::Stopped`].
    pub fn advance(&mut self, stop: &AtomicBool, motion: impl Fn(f64) -> Kinematics) -> Result<(), Error> {
        for _ in 0..OVERSAMPLING {
            for _ in 0..self.steps {
                check_running(stop)?;
                self.simulator.step_moving(&motion)?;
            }
            self.look();
        }
        self.simulator.check_inside()
    }

    /// Returns the heights along the wall, one row of 72 for each frame, m above the inner bottom. The last four frames are
    /// missing: the filter looks ahead. Before the start the glass was at rest.
    #[must_use]
    pub fn wall_m(&self) -> Vec<Vec<f32>> {
        let taps = taps();
        let frames = (self.samples.len().saturating_sub(1 + HALF)) / OVERSAMPLING;
        let filtered = |frame: usize| {
            let mut surface = [0.0; COEFFICIENTS];
            for (k, tap) in taps.iter().enumerate() {
                let sample = (frame * OVERSAMPLING + k).saturating_sub(HALF);
                surface.iter_mut().zip(&self.samples[sample]).for_each(|(s, x)| *s += tap * x);
            }
            self.finder.heights(&surface).1
        };
        (0..=frames).map(filtered).collect()
    }

    /// Takes a sample of the surface.
    fn look(&mut self) {
        let nearby = self.finder.nearby(&self.simulator);
        self.samples.push(self.finder.coefficients(&self.simulator, &nearby));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::record_surfaces;
    use crate::setup::small_glass;
    use meniscus_data::liquids::Rheology;
    use meniscus_data::motion::Motion;

    /// The wall of a watched glass is that of a recording of the same motion, and a clone goes on as its original.
    #[test]
    fn a_watched_glass_is_a_recorded_one() {
        let setup = small_glass(1261.0, Rheology::newtonian(0.95));
        let motion = Motion::sampled(&[(0.0, 0.0), (0.1, 0.01), (0.2, 0.03)]).expect("a motion");
        let recorded = record_surfaces(&setup, &[(motion.clone(), 12, String::new())]).expect("a recording");
        let never = AtomicBool::new(false);
        let mut glass = WatchedGlass::new(&setup, &never).expect("it settles");
        let advance = |glass: &mut WatchedGlass, frames: usize| {
            for _ in 0..frames {
                glass.advance(&never, |t| motion.kinematics(t)).expect("it stays inside");
            }
        };
        advance(&mut glass, 6);
        let mut other = glass.clone();
        advance(&mut glass, 11);
        advance(&mut other, 11);
        assert_eq!(glass.profile(), other.profile());
        let wall = glass.wall_m();
        assert!(wall.len() >= 12, "{} frames", wall.len());
        let mut moved = 0.0_f32;
        for (frame, row) in wall.iter().take(12).enumerate() {
            for (k, height) in row.iter().enumerate() {
                let due = recorded[0].wall_m[frame * row.len() + k];
                assert!((height - due).abs() < 1e-6, "frame {frame}, point {k}: {height} for {due}");
                moved = moved.max((height - 0.035).abs());
            }
        }
        assert!(moved > 1e-3, "the glass was moved: {moved}");
    }
}
