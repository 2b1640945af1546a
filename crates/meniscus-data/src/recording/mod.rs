//! A recording: one liquid in one moved glass, sampled at the camera's 60 Hz on tracers.
//!
//! The state lives on 2134 tracers, a lattice stretched column by column to the free surface, and
//! not on the simulator's particles, which mix during a slosh (1.9 mm rms drift in 3 s).

mod compress;
mod estimates;
mod groups;
mod lattice;
mod store;
mod tensors;

pub use crate::glass::Glass;
pub use compress::Factored;
pub use estimates::EstimateRecording;
pub use groups::names as group_names;
pub use lattice::{COLUMNS, LAYERS, Lattice, TRACERS, WALL_POINTS, wall_azimuth};
pub use store::StoreError;

pub(crate) use lattice::RING;
pub(crate) use tensors::{f32s, read_file, rows};

/// Numbers of one tracer in each field group: position, velocity, specific internal energy, normal
/// stresses (xx, yy, zz), shear stresses (xy, yz, zx); the camera side decodes the same.
pub use meniscus::latent::decoder::GROUP_COMPONENTS;

use meniscus::blob::KnownGroups;
use meniscus::surface::POINTS;
use meniscus::units::{FRAME_INTERVAL_S, Micros};
use serde::{Deserialize, Serialize};

/// Names of the field groups, in file order.
pub const GROUP_NAMES: [&str; 5] = ["q", "v", "e", "sigma", "tau"];

/// Numbers in one full state: 2134 x 13 = 27742, group after group, tracer after tracer.
pub const STATE: usize = TRACERS * 13;

/// The slice of a full state that holds group `group`.
#[must_use]
pub fn group_range(group: usize) -> std::ops::Range<usize> {
    let start: usize = GROUP_COMPONENTS[..group].iter().sum();
    start * TRACERS..(start + GROUP_COMPONENTS[group]) * TRACERS
}

/// Origin of a recording, enough to make it again.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Provenance {
    /// Liquid name as in its file.
    pub liquid: String,
    /// Density, kg/m3.
    pub density_kg_m3: f64,
    /// Motion, as the command line spells it.
    pub motion: String,
    /// Seed of motion and packing.
    pub seed: u64,
    /// The command that made it.
    pub command: String,
    /// Particle spacing of the simulator, m.
    pub spacing_m: f64,
    /// Point of the glass (x, z from the middle of its bottom, m) that is moved and
    /// about which it is inclined.
    #[serde(default)]
    pub pivot_m: [f64; 2],
    /// Effects that were on, by name with their values.
    #[serde(default)]
    pub effects: Vec<(String, f64)>,
}

/// Books of energy at one instant, joules, in the frame of the glass, relative to rest.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct EnergyBook {
    /// Kinetic energy of the liquid relative to the glass.
    pub kinetic: f64,
    /// Potential energy above that of rest: gravity, weak compression, and what effects store (area of
    /// the surface, spring of the contact line, elastic stress).
    pub potential: f64,
    /// Heat since the start: viscous dissipation, friction of effects, and what the density diffusion
    /// and the wall model of the simulator lose.
    pub internal: f64,
    /// Work done since the start by the inertial forces of the moving glass and by gravity as far as it
    /// turns with it.
    pub work: f64,
    /// Energy above that of rest that left with liquid over the rim.
    #[serde(default)]
    pub spilled: f64,
}

/// The full states of a recording: as they are, or as a low-rank product for a small file.
#[derive(Clone, Debug)]
pub enum States {
    /// Frames x [`STATE`], row-major.
    Full(Vec<f32>),
    /// Truncated singular value decomposition of each group, with its stated error.
    Factored(Box<Factored>),
}

/// One recording; every array has one row a frame, 1/60 s apart.
#[derive(Clone, Debug)]
pub struct Recording {
    /// The glass.
    pub glass: Glass,
    /// Its origin.
    pub provenance: Provenance,
    /// Position of the glass along `x`, metres, in the room.
    pub glass_x_m: Vec<f64>,
    /// Acceleration of the glass along `x`, m/s2, averaged over the frame interval centred on the frame.
    pub acceleration_m_s2: Vec<f64>,
    /// Position of the glass away from the camera, metres, in the room.
    pub glass_y_m: Vec<f64>,
    /// Position of the glass upwards, metres, in the room.
    pub glass_z_m: Vec<f64>,
    /// Inclination of the glass towards +x about its pivot, radians.
    pub tilt_rad: Vec<f64>,
    /// Height of the free surface in each lattice column, metres; frames x [`COLUMNS`].
    pub column_m: Vec<f32>,
    /// Height of the contact line at each wall azimuth, metres; frames x [`WALL_POINTS`].
    pub wall_m: Vec<f32>,
    /// The surface profile as a perfect camera would see it, metres; frames x [`POINTS`].
    pub profile_m: Vec<f32>,
    /// Books of energy.
    pub energy: Vec<EnergyBook>,
    /// Volume that left the glass over the rim since the start, m3.
    pub spilled_m3: Vec<f64>,
    /// Full states.
    pub states: States,
    /// Groups of the states that are of this liquid; the numbers of the others mean nothing.
    pub known: KnownGroups,
}

impl Recording {
    /// Number of frames.
    #[must_use]
    pub fn frames(&self) -> usize {
        self.glass_x_m.len()
    }

    /// Writes the full state of `frame` into `out` ([`STATE`] numbers, SI units).
    ///
    /// # Panics
    /// When `frame` or the length of `out` is out of range.
    pub fn state(&self, frame: usize, out: &mut [f32]) {
        match &self.states {
            States::Full(all) => out.copy_from_slice(&all[frame * STATE..(frame + 1) * STATE]),
            States::Factored(factored) => factored.state(frame, out),
        }
    }

    /// Whether the glass is an upright cylinder that stays on the table: what the rendered camera shows.
    #[must_use]
    pub fn is_level(&self) -> bool {
        self.glass.is_cylinder() && self.glass_z_m.iter().chain(&self.tilt_rad).all(|c| *c == 0.0)
    }

    /// Whether it only moves along x, too: what the models know.
    #[must_use]
    pub fn is_plain(&self) -> bool {
        self.is_level() && self.glass_y_m.iter().all(|y| *y == 0.0)
    }

    /// The true profile of `frame`.
    #[must_use]
    pub fn profile(&self, frame: usize) -> &[f32] {
        &self.profile_m[frame * POINTS..(frame + 1) * POINTS]
    }

    /// Returns the acceleration of the glass as the step of each frame takes it, m/s2: a frame interval before each frame, from
    /// the last three positions.
    ///
    /// ```text
    /// a_n = (X_n - 2 X_(n-1) + X_(n-2)) / dt^2
    /// ```
    #[must_use]
    pub fn delayed_acceleration_m_s2(&self) -> Vec<f64> {
        let at = |n: usize, back: usize| self.glass_x_m[n.saturating_sub(back)];
        let second = |n| (at(n, 0) - 2.0 * at(n, 1) + at(n, 2)) / (FRAME_INTERVAL_S * FRAME_INTERVAL_S);
        (0..self.glass_x_m.len()).map(second).collect()
    }

    /// Returns the highest point of each frame's surface, metres above the inner bottom.
    #[must_use]
    pub fn highest_m(&self) -> Vec<f32> {
        let highest = |frame| self.profile(frame).iter().copied().fold(f32::NEG_INFINITY, f32::max);
        (0..self.frames()).map(highest).collect()
    }
}

/// Position of a turn in its recording; `start` is the capture time of frame 0.
#[must_use]
pub fn frame_of(time: Micros, start: Micros) -> usize {
    (time.since(start) as f64 * 1e-6 / FRAME_INTERVAL_S).round() as usize
}
