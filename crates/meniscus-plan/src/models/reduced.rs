//! The reduced slosh model as a liquid that forecasts its surface: any liquid of known density and viscosity, without learning.
//!
//! ```text
//! half = sqrt(e P e^T + (s |h|)^2 + g^2) z            e: slope of an end of the wall in heights and rates of the modes
//! ```
//! P is the covariance of [`super::ReducedWatcher`], s the relative error of the model's crest, g that of a surface at rest, z the
//! normal quantile of nine in ten. [`ReducedLiquid::CREST_ERROR`] says what s was measured on.

use super::{FrameForecast, FrameInput, Pendulum, SurfaceModel};
use crate::wall::WALL;
use meniscus::reduced::{
    Baseline, Cylinder, Forcing, RADIAL, ReducedModel, ReducedState, Rheology, step, wall_harmonics,
};
use meniscus::surface::profile_abscissa;
use meniscus::units::{FRAME_INTERVAL_S, GRAVITY_M_S2};
use meniscus_data::glass::Glass;
use meniscus_data::liquids::Liquid;
use nalgebra::{SMatrix, SVector};

/// Steps of the reduced model in a frame.
const SUBSTEPS: usize = 4;

/// Numbers of the linear state: heights of the modes, then their rates.
pub(super) const LINEAR: usize = 2 * RADIAL;

/// Matrix on the linear state.
pub(super) type Linear = SMatrix<f64, LINEAR, LINEAR>;

/// Calibration on the particle simulator, with water in the glass of the recordings: frequency of the first mode, damping of all, and
/// softening. All else is theory. They were fitted beside factors of the forcing and of the second order that stood for the blur of
/// the simulator's surface then, and not again since. All are dimensionless; for other liquids and glasses they are not measured.
const SIMULATED: Baseline = Baseline {
    frequency: [0.0058, 0.0, 0.0],
    damping: [0.9; RADIAL],
    lever: [1.0; RADIAL],
    detuning: 0.144,
    drive: None,
    held_line: 1.0,
};

/// Normal quantile of an interval that holds nine times out of ten.
const NINE_IN_TEN: f64 = 1.645;

/// A liquid of the reduced model that plans.
#[derive(Clone, Debug)]
pub struct ReducedLiquid {
    pub(super) model: ReducedModel,
    room_m: f64,
    /// Relative standard deviation s of a crest.
    crest_error: f64,
    /// Transition of the linear state over a frame.
    pub(super) transition: Linear,
}

/// Modes with their error.
#[derive(Clone, Debug, PartialEq)]
pub struct ReducedLiquidState {
    /// State of the reduced model.
    pub modes: ReducedState,
    /// P of the linear state along x.
    pub covariance: Linear,
}

impl ReducedLiquid {
    /// s of [`Self::new`]. On four tuning moves of water (seeds 1002, 1004, 1008 and 1014 of the study) the crest in the simulator was
    /// above the predicted one by 8 to 18 %; s makes the half-width 21 %.
    pub const CREST_ERROR: f64 = 0.13;

    /// Standard deviation g of a surface at rest, m.
    const REST_M: f64 = 1e-4;

    /// The reduced model of `liquid` in an upright glass; `None` where the glass is no cylinder.
    #[must_use]
    pub fn new(glass: &Glass, liquid: &Liquid) -> Option<Self> {
        if !glass.is_cylinder() {
            return None;
        }
        let cylinder =
            Cylinder { radius_m: glass.radius_m, depth_m: glass.fill_m, density_kg_m3: liquid.density_kg_m3 };
        let law = liquid.rheology;
        let rheology =
            Rheology { index: law.index, yield_pa: law.yield_stress, ..Rheology::newtonian(law.consistency) };
        let dt = FRAME_INTERVAL_S / SUBSTEPS as f64;
        let model = ReducedModel::new(cylinder, rheology, &SIMULATED, &[], dt);
        let mut out = Self {
            model,
            room_m: glass.rim_m - glass.fill_m,
            crest_error: Self::CREST_ERROR,
            transition: Linear::zeros(),
        };
        out.transition = out.linearised();
        Some(out)
    }

    /// The first mode as a pendulum.
    #[must_use]
    pub fn first_mode(&self) -> Pendulum {
        let (frequency, gamma) = self.model.frequency_and_damping(0).unwrap_or((self.model.frequency(), 0.0));
        let (radius_m, room_m) = (self.model.glass.radius_m, self.room_m);
        Pendulum { frequency, damping: gamma / frequency, radius_m, room_m }
    }

    /// Transition of small heights and rates about rest, by one column a number.
    fn linearised(&self) -> Linear {
        const SMALL: f64 = 1e-7;
        let mut out = Linear::zeros();
        for column in 0..LINEAR {
            let mut unit = SVector::<f64, LINEAR>::zeros();
            unit[column] = SMALL;
            let mut state = ReducedState::default();
            set_linear(&mut state, &unit);
            self.frame(&mut state, 0.0);
            out.set_column(column, &(linear(&state) / SMALL));
        }
        out
    }

    /// Advances `state` by a frame under a mean acceleration of the glass.
    pub(super) fn frame(&self, state: &mut ReducedState, acceleration_m_s2: f64) {
        let push = Forcing { along_m_s2: [-acceleration_m_s2, 0.0], lift_m_s2: 0.0 };
        for _ in 0..SUBSTEPS {
            step(&self.model, state, &push);
        }
    }

    /// Height of the surface at the wall over rest, at s = cos theta, m.
    pub(super) fn height_m(&self, state: &ReducedState, acceleration_m_s2: f64, s: f64) -> f64 {
        let push = [-acceleration_m_s2, 0.0];
        let [mean, cos, _, cos2, _] = wall_harmonics(&self.model, state, &push);
        mean + cos * s + cos2 * (2.0 * s * s - 1.0)
    }
}

/// Heights and rates of the modes along x.
pub(super) fn linear(state: &ReducedState) -> SVector<f64, LINEAR> {
    SVector::from_fn(|i, _| if i < RADIAL { state.height[0][i] } else { state.rate[0][i - RADIAL] })
}

/// Replaces heights and rates of the modes along x.
pub(super) fn set_linear(state: &mut ReducedState, to: &SVector<f64, LINEAR>) {
    for i in 0..RADIAL {
        (state.height[0][i], state.rate[0][i]) = (to[i], to[RADIAL + i]);
    }
}

impl SurfaceModel for ReducedLiquid {
    type State = ReducedLiquidState;

    const INPUT: FrameInput = FrameInput::Mean;

    fn rest(&self) -> ReducedLiquidState {
        ReducedLiquidState { modes: ReducedState::default(), covariance: Linear::zeros() }
    }

    fn advance(&self, state: &mut ReducedLiquidState, input: f64) {
        self.frame(&mut state.modes, input);
        state.covariance = self.transition * state.covariance * self.transition.transpose();
    }

    fn look(&self, state: &ReducedLiquidState, input: f64) -> FrameForecast {
        let wall_m = std::array::from_fn(|i| {
            let s = match i {
                0 => -1.0,
                _ if i == WALL - 1 => 1.0,
                _ => profile_abscissa(i - 1),
            };
            self.height_m(&state.modes, input, s)
        });
        // Along the wall all radial modes have the shape cos theta: e has one for each height.
        let heights = state.covariance.fixed_view::<RADIAL, RADIAL>(0, 0);
        let crest = self.crest_error * f64::max(f64::abs(wall_m[0]), f64::abs(wall_m[WALL - 1]));
        let variance = heights.sum().max(0.0) + crest * crest + Self::REST_M * Self::REST_M;
        FrameForecast { wall_m, half_width_m: NINE_IN_TEN * variance.sqrt() }
    }

    fn room_m(&self) -> f64 {
        self.room_m
    }

    fn static_m(&self) -> f64 {
        self.model.glass.radius_m / GRAVITY_M_S2
    }
}
