//! Heights that a simulator returned, checked before they are compared with anything.

use crate::insert::simulated::Course;
use crate::insert::simulator::SimulatorFault;
use meniscus::surface::POINTS;
use meniscus_sph::Setup;
use serde::Deserialize;

/// Largest difference of the mean height of a first frame from the fill, relative to the fill: an effect may change the fill,
/// and a height above rest or in millimetres is far from it.
const NEAR_FILL: f64 = 0.5;

/// Largest height in units of the rim's.
const HIGHEST: f64 = 10.0;

/// Heights of one motion: 21 of each frame, m; none where a number is missing.
pub type Frames = Vec<Vec<Option<f64>>>;

/// Answer of a simulator.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SimulatorAnswer {
    /// Version of the protocol.
    pub meniscus_simulator: Option<u32>,
    /// Heights above the inner bottom by motion, frame and point, m.
    pub heights_m: Option<Vec<Frames>>,
    /// Reason for which this glass cannot be simulated.
    pub failed: Option<String>,
}

impl SimulatorAnswer {
    /// Returns the heights of `courses` in `setup`, frame after frame; faults begin with `by`, the name of the simulator.
    ///
    /// # Errors
    /// [`SimulatorFault::Here`] with the reason that the simulator gave; [`SimulatorFault::Broken`], when counts or numbers are wrong.
    pub fn heights(
        &self,
        by: &str,
        setup: &Setup,
        courses: &[&Course],
    ) -> Result<Vec<Vec<f32>>, SimulatorFault> {
        let broken = |reason: String| SimulatorFault::Broken(format!("{by}: {reason}"));
        match (&self.heights_m, &self.failed) {
            (None, Some(reason)) if !reason.trim().is_empty() => {
                Err(SimulatorFault::Here(reason.trim().chars().take(400).collect()))
            }
            (None, _) => Err(broken("its answer has neither heights_m nor a reason in failed".into())),
            (Some(_), Some(_)) => {
                Err(broken("its answer has heights_m and failed: one of them is meant".into()))
            }
            (Some(motions), None) => {
                if motions.len() != courses.len() {
                    let (got, wanted) = (motions.len(), courses.len());
                    return Err(broken(format!("it returned heights of {got} motions instead of {wanted}")));
                }
                let all = motions.iter().zip(courses).enumerate();
                let checked = all.map(|(n, (motion, course))| {
                    one(setup, motion, course.frames).map_err(|why| format!("motion {}: {why}", n + 1))
                });
                checked.collect::<Result<_, _>>().map_err(broken)
            }
        }
    }
}

/// Checks the heights of one motion.
fn one(setup: &Setup, motion: &Frames, wanted: usize) -> Result<Vec<f32>, String> {
    if motion.len() != wanted {
        return Err(format!("it returned {} frames instead of {wanted}", motion.len()));
    }
    let highest = HIGHEST * setup.glass.rim_m;
    let mut out = Vec::with_capacity(wanted * POINTS);
    for (n, frame) in motion.iter().enumerate() {
        if frame.len() != POINTS {
            return Err(format!("frame {} has {} heights instead of {POINTS}", n + 1, frame.len()));
        }
        for (point, height) in frame.iter().enumerate() {
            let height = height.filter(|z| z.is_finite());
            let place = || format!("frame {}, height {}", n + 1, point + 1);
            let height = height.ok_or_else(|| format!("{} is NaN, infinite or missing", place()))?;
            if height.abs() > highest {
                let why = "heights are metres above the inner bottom";
                return Err(format!("{} is {height} m, far outside of the glass: {why}", place()));
            }
            out.push(height as f32);
        }
    }
    let fill_m = setup.glass.fill_m;
    let mean = out.iter().take(POINTS).map(|z| f64::from(*z)).sum::<f64>() / POINTS as f64;
    if wanted > 0 && (mean - fill_m).abs() > NEAR_FILL * fill_m {
        return Err(format!(
            "the first frame has a mean height of {mean:.4} m, and the glass at rest is filled to {fill_m:.4} m: heights are \
             metres above the inner bottom"
        ));
    }
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::*;
    use meniscus_data::effects::Effects;
    use meniscus_data::glass::{Glass, WallShape};
    use meniscus_data::liquids::{Liquid, Rheology};

    fn setup() -> Setup {
        Setup {
            glass: Glass { radius_m: 0.035, fill_m: 0.05, rim_m: 0.1, wall: WallShape::UPRIGHT },
            liquid: Liquid {
                name: "x".into(),
                density_kg_m3: 1000.0,
                rheology: Rheology::newtonian(0.1),
                effects: Effects::default(),
            },
            spacing_m: 0.007,
            seed: 1,
            no_slip: true,
            effects: Effects::default(),
            step_s: None,
        }
    }

    fn level(frames: usize) -> Frames {
        vec![vec![Some(0.05); POINTS]; frames]
    }

    /// Heights of motions of three and two frames.
    fn heights(answer: &SimulatorAnswer) -> Result<Vec<Vec<f32>>, SimulatorFault> {
        let course = |frames| Course { samples: Vec::new(), frames };
        answer.heights("it", &setup(), &[&course(3), &course(2)])
    }

    fn fault(answer: &SimulatorAnswer) -> SimulatorFault {
        heights(answer).expect_err("it is refused")
    }

    #[test]
    fn whole_answers_are_taken_and_wrong_counts_and_numbers_are_named() {
        let answer =
            |motions: Vec<Frames>| SimulatorAnswer { heights_m: Some(motions), ..SimulatorAnswer::default() };
        let heights = heights(&answer(vec![level(3), level(2)])).expect("whole");
        assert_eq!(heights.iter().map(Vec::len).collect::<Vec<_>>(), [3 * POINTS, 2 * POINTS]);
        let refused = |change: &dyn Fn(&mut Vec<Frames>), wanted: &str| {
            let mut motions = vec![level(3), level(2)];
            change(&mut motions);
            let fault = fault(&answer(motions));
            assert!(matches!(&fault, SimulatorFault::Broken(why) if why.contains(wanted)), "{fault}");
        };
        refused(&|m| drop(m.pop()), "heights of 1 motions instead of 2");
        refused(&|m| drop(m[1].pop()), "motion 2: it returned 1 frames instead of 2");
        refused(&|m| m[0][2].truncate(20), "motion 1: frame 3 has 20 heights instead of 21");
        refused(&|m| m[1][1][4] = Some(f64::NAN), "motion 2: frame 2, height 5 is NaN");
        refused(&|m| m[1][1][4] = None, "NaN, infinite or missing");
        refused(&|m| m[0][1][0] = Some(50.0), "frame 2, height 1 is 50 m, far outside");
        refused(&|m| m[0][0].fill(Some(0.001)), "a mean height of 0.0010 m");
    }

    #[test]
    fn a_reason_is_a_failure_here_and_an_empty_answer_is_none() {
        let failed = SimulatorAnswer { failed: Some(" it spills ".into()), ..SimulatorAnswer::default() };
        assert_eq!(fault(&failed), SimulatorFault::Here("it spills".into()));
        assert!(matches!(fault(&SimulatorAnswer::default()), SimulatorFault::Broken(_)));
        let both = SimulatorAnswer { heights_m: Some(vec![level(3), level(2)]), ..failed };
        assert!(matches!(fault(&both), SimulatorFault::Broken(why) if why.contains("one of them")));
    }
}
