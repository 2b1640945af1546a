//! Motion planning for a robot that carries a glass of liquid: the fastest motion whose crest stays below a limit.
//!
//! The motion has constant jerk between M + 1 knots that divide its duration T evenly. Its positions are linear in the jerks, so
//! the surface is, too, about a forecast:
//!
//! ```text
//! x(t)  = x0 + v0 t + a0 t^2/2 + sum_i j_i b_i(t)         b_i: one jerk of unity between two knots, integrated three times
//! h_k   = d_k + sum_l g_(k-l) u_l(j)                      ends of the wall in frame k; g the impulse response about rest
//! min c + e |j|^2   under   h_k + m_k <= c L,   |v|, |a|, |j| <= limits,   x, v, a at rest at T
//! ```
//! `u` is the input of each frame that the liquid model takes from the positions, `m` the half-width of the forecast at the
//! stated confidence, `L` the limit and `d` what the linear response lacks of the model's own forecast: the present slosh and the
//! second order. The program is convex. The whole nonlinear model forecasts each solution, which gives the next `d` and `m`; a step
//! that does not lower the forecast is shortened (sequential convex programming with a fixed linear part and a line search). The
//! fastest motion has the shortest T whose forecast keeps the limit.
//!
//! Planning slosh-free motions as a quadratic program with a linear pendulum is known (Muchacho et al. 2022, and with a tilted
//! glass GSFT, arXiv 2402.05197); here the liquid is a model of the surface that a camera corrects 60 times a second.
//!
//! | module | purpose |
//! |---|---|
//! | `request`, `error` | what is planned, checked; why it is refused |
//! | `course` | motions of piecewise constant jerk |
//! | `wall` | from a profile to both ends of the wall |
//! | `models` | liquids that forecast a surface: the learned model, the reduced model, a pendulum |
//! | `response`, `program`, `preferred` | linear response of the surface, the quadratic program, and the jerks that it prefers |
//! | `search`, `shortest`, `settle`, `verify` | shortest duration, lowest crest of a duration, and the forecast that verifies it |
//! | `receding`, `renew` | planning again from a measured state |
//! | `rivals` | minimum jerk, trapezoid, input shaping, pendulum |
//! | `compare` | the motion of minimum jerk beside a plan, by the same model |
//! | [`study`] | random moves in the simulator, with the estimator in the loop |

mod compare;
mod course;
mod error;
mod models;
mod preferred;
mod program;
mod receding;
mod renew;
mod request;
mod response;
mod rivals;
mod search;
mod settle;
mod shortest;
pub mod study;
mod verify;
mod wall;

pub use compare::{MinimumJerk, compare, crest_m, forecast_motion};
pub use course::{Course, GlassState};
pub use error::PlanError;
pub use models::{
    FrameForecast, FrameInput, LearnedModel, LearnedState, LearnedWatcher, Pendulum, ReducedLiquid,
    ReducedLiquidState, ReducedWatcher, SurfaceModel, Watcher,
};
pub use receding::{LEAD_FRAMES, PERIOD_FRAMES, Receding};
pub use request::{Limits, Request};
pub use rivals::{Motion, minimum_jerk, pendulum, shaped, trapezoid};
pub use search::{Plan, plan, smoothest};
pub use wall::{WALL, WallMap};
