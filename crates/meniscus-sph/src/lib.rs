//! The glass simulator: weakly compressible smoothed particle hydrodynamics with density diffusion
//! (delta-SPH), in double precision, equal bit for bit on any number of threads.
//!
//! The liquid is computed in the frame of the glass; the moving glass enters as a body force.
//!
//! Each layer imports those above it alone:
//!
//! | layer | content |
//! |---|---|
//! | `particles` | particles, kernel, neighbour lists, sums over pairs in a fixed order |
//! | `frame` | body force in the frame of the moving glass |
//! | `walls` | images of the liquid behind the walls, slip |
//! | `corrections` | moments of a neighbourhood, and the gradients, velocities and densities corrected by them |
//! | `forces` | continuity and momentum: rates of density and velocity |
//! | `effects` | surface tension, contact line, foam, viscoelastic stress and the other effects |
//! | `setup` | glass, liquid, spacing and step, and the packing that a simulation starts from |
//! | [`Simulator`] and `integration` | the step, the books of energy |
//! | `settled` | the glass at rest from which a simulation starts |
//! | `output` | surface, fields at tracers, recordings |
//! | [`validate`] | comparison with theory |
//!
//! Measured by `meniscus simulate validate`: first mode from 0.05 m/s, fitted from 0.05 s to 1 s (without
//! viscosity) or 0.8 s, against linear theory (inviscid dispersion; [`viscous_mode`] for a viscous liquid):
//!
//! | liquid, spacing | frequency, Hz | decay, 1/s |
//! |---|---|---|
//! | no viscosity, 7 mm | 3.616 for 3.613 (+0.1 %) | 0.018 for 0 |
//! | no viscosity, 5 mm | 3.614 for 3.613 (0.0 %) | 0.014 for 0 |
//! | no viscosity, 3.5 mm | 3.610 for 3.613 (-0.1 %) | 0.012 for 0 |
//! | 1 mPa s, 5 mm | 3.614 for 3.612 (+0.1 %) | 0.084 for 0.083 (+0.6 %) |
//! | glycerine, 5 mm | 3.352 for 3.401 (-1.4 %) | 6.70 for 6.69 (+0.1 %) |
//! | glycerine, 5 mm, free slip | 3.511 for 3.484 (+0.8 %) | 2.940 for 2.939 (0 %) |
//!
//! The second mode, whose wave is 8 spacings long at 5 mm, is too slow by 0.6 % at 7 mm, 0.2 % at 5 mm and 0.0 % at 3.5 mm.
//!
//! Four things make this, each in its file. **Gradients are corrected up to the free surface** (`corrections::corrected`): the plain
//! divergence of a flow that grows with height lacks the neighbours above the surface, which alone made the second mode 12 %
//! too slow (a linear theory of the sums, layers of particles smooth along the wave, has -18.4, -11.3 and -6.1 % at 7, 5 and
//! 3.5 mm; measured were -19.5, -11.9 and -6.6 %) and wasted most of what was wasted. **The density is called back to the
//! positions of the particles** (`corrections::positions`), without which a low-viscosity liquid under corrected gradients
//! moves from rest. **The wall rubs as a Stokes layer does** (`walls::images`), also where the layer is thinner than the spacing.
//! **What the sums still lack for short waves is given back as a tension** (`effects::surface_tension`).
//!
//! What was tried at 5 mm, in this order; a row keeps what stands above it unless it says otherwise:
//!
//! | remedy | no viscosity: frequency, m2/s | glycerine: frequency, decay | free slip: frequency, decay |
//! |---|---|---|---|
//! | fixed wall particles | -1.8 %, 6.7e-5 | +2.5 %, +5.0 % | -2.0 %, -2.3 % |
//! | corrected gradients beside them (not kept) | -7.1 %, -2.8e-5 (grows) | +1.2 %, +11.5 % | -4.0 %, -27.0 % |
//! | density diffusion 0.03 for 0.1 (not kept) | -2.0 %, 6.5e-5 | +2.1 %, +8.3 % | -2.2 %, +1.0 % |
//! | images that the fixed particles' velocity stands for (not kept) | -0.04 %, 1.3e-4 | | |
//! | walls as mirrors (`walls`) | -0.24 %, 5.9e-5 | -0.2 %, -15.7 % | +1.3 %, -1.1 % |
//! | a gentler shake (`settle`) | -0.18 %, 4.9e-5 | +0.15 %, -15.9 % | +1.5 %, -1.0 % |
//! | smoothing length 1.6 for 1.4 (not kept) | -2.0 %, 4.3e-5 | -3.8 %, -14.3 % | -2.2 %, +1.6 % |
//! | friction complete at the surface (`momentum`) | -0.18 %, 4.9e-5 | -0.8 %, -9.8 % | +0.5 %, +1.0 % |
//! | friction with twice the image's velocity | | -1.5 %, -2.4 % | |
//! | friction of what is not smooth (`smooth`) | -0.14 %, 4.5e-5 | | |
//! | twice the time to settle | +0.05 %, 4.2e-5 | -1.2 %, -2.4 % | +0.6 %, +1.0 % |
//! | shorter steps, 0.2 for 0.45 (not kept) | +0.05 %, 4.2e-5 | | |
//! | twice the speed of sound (not kept) | -0.07 %, 3.7e-5 | | |
//! | density from two moments of the kernel (not kept) | 7 mm: +1.7 to +9 %, 1.7e-4 to 6e-4 | | |
//! | corrected gradients (not kept alone) | -0.7 %, 2.5e-5; stirs itself to 72 mm/s | -2.1 %, +2.7 % | |
//! | the same, density called back (`positions`) | -0.40 %, 2.8e-6 | -2.4 %, +3.6 % | +0.3 %, -0.8 % |
//! | steps 0.8 for 0.45, corrections formed every 4 ms | -0.46 %, 2.6e-6 | -2.3 %, +3.9 % | |
//! | Stokes layers behind the wall (`walls`) | -0.39 %, 2.6e-6 | -1.9 %, -1.3 % | |
//! | the tension that sums lack (`effects::surface_tension`) | +0.02 %, 2.6e-6 | -1.4 %, +0.1 % | |
//!
//! Corrected only near the surface, with the unit matrix in the bulk, the first mode is 2 % faster: the bulk's own correction
//! of 1 % counts. Shifting was not tried.
//!
//! [`viscous_mode`]: crate::validate::viscous_mode

mod corrections;
pub(crate) mod effects;
mod forces;
mod frame;
mod integration;
mod output;
mod particles;
mod settled;
mod setup;
pub mod validate;
mod walls;

pub use integration::{Spilled, closure, relative_closure};
pub use output::{
    Observer, Particles, WatchedGlass, record, record_particles, record_surfaces, record_until,
};
pub use settled::keep_settled_in;
pub use setup::{Error, Setup};

use effects::{Acting, Laws, motion_with};
use forces::{Forces, Friction};
use frame::Body;
use integration::Stages;
use meniscus_data::liquids::Liquid;
use meniscus_data::motion::Kinematics;
use meniscus_data::recording::Glass;
use particles::{Box3, Fluid, Neighbours};
use setup::{Packing, SOUND_M_S, check, fitting_spacing, kernel, longest_step, thick};
use std::sync::atomic::AtomicBool;
use walls::{Sticking, Walls};

/// Skin of the neighbour lists in units of the spacing.
const SKIN: f64 = 0.15;

/// A glass of liquid at one instant.
#[derive(Clone, Debug)]
pub struct Simulator {
    glass: Glass,
    liquid: Liquid,
    laws: Laws,
    acting: Acting,
    spacing_m: f64,
    sticking: Sticking,
    fluid: Fluid,
    walls: Walls,
    /// Positions and volumes of the glass around the liquid, for the finder of the surface.
    shell: Packing,
    lists: Neighbours,
    forces: Forces,
    /// Friction in stages, where the liquid is too thick for an explicit step.
    stages: Stages,
    dt: f64,
    longest_step: f64,
    time: f64,
    body: Body,
    /// Body force of the glass at rest, whose potential is in the books.
    gravity: [f64; 3],
    /// Acceleration of each particle by the turning of the glass; empty while it does not turn.
    turning: Vec<[f64; 2]>,
    work: f64,
    rest_energy: f64,
    /// Whether each particle is over the rim, outside of the glass.
    over: Vec<bool>,
    /// End of the last splash, s.
    calm_from_s: f64,
    /// Number of each particle at the start, before any left.
    number: Vec<u32>,
    spilled: Spilled,
}

impl Simulator {
    /// A settled glass of liquid at rest at time zero.
    ///
    /// # Errors
    /// When the glass or the spacing is out of range, or settling fails.
    pub fn new(setup: &Setup) -> Result<Self, Error> {
        Self::new_until(setup, &AtomicBool::new(false))
    }

    /// As [`Self::new`]; the settling ends early once `stop` is raised.
    ///
    /// # Errors
    /// As for [`Self::new`], and [`Error::Stopped`].
    pub fn new_until(setup: &Setup, stop: &AtomicBool) -> Result<Self, Error> {
        let setup = &setup.resolved();
        check(setup)?;
        let settled = settled::of(setup, stop)?;
        let rest = setup.liquid.density_kg_m3;
        let mut simulator = Self::with(setup, settled.fluid(rest, setup.liquid.rheology.viscosity(0.0)));
        simulator.start(settled.law);
        Ok(simulator)
    }

    /// A resolved, checked `setup` with the particles of `fluid`, before time starts.
    fn with(setup: &Setup, fluid: Fluid) -> Self {
        let Setup { glass, liquid, effects, .. } = setup.clone();
        let laws = Laws::of(&effects);
        let body = Body::of(&motion_with(&laws, Kinematics::default()));
        let spacing_m = fitting_spacing(&glass, setup.spacing_m);
        let kernel = kernel(setup);
        let support = 2.0 * kernel.h;
        let edge = glass.widest_m() + support;
        let space = Box3 { low: [-edge, -edge, -support], high: [edge, edge, glass.rim_m + support] };
        let particles = fluid.mass.len();
        let lists = Neighbours::new(&fluid.particle, &[], space, support, SKIN * spacing_m);
        let mut forces = Forces::new(kernel, SOUND_M_S, liquid.density_kg_m3, particles);
        forces.friction = thick(&kernel, setup).then(Friction::default);
        let longest_step = setup.step_s.unwrap_or_else(|| longest_step(&kernel, setup));
        let slip_m = if setup.no_slip { laws.slip_m } else { f64::INFINITY };
        let sticking = Sticking::new(&glass, slip_m, |omega| {
            laws.relaxation.map_or([0.0; 2], |relaxation| relaxation.viscosity(omega))
        });
        let mut simulator = Self {
            dt: longest_step,
            longest_step,
            glass,
            liquid,
            laws,
            acting: Acting::default(),
            spacing_m,
            sticking,
            fluid,
            walls: Walls::default(),
            shell: Packing::wall(&glass, spacing_m),
            lists,
            forces,
            stages: Stages::default(),
            time: 0.0,
            body,
            gravity: body.uniform,
            turning: Vec::new(),
            work: 0.0,
            rest_energy: 0.0,
            over: vec![false; particles],
            calm_from_s: 0.0,
            number: (0..).take(particles).collect(),
            spilled: Spilled::default(),
        };
        simulator.list();
        simulator
    }

    /// Starts time with the liquid as it is, whose packing has the given law: books at zero, and the effects act from here.
    fn start(&mut self, law: [f64; 4]) {
        self.forces.position_density.keep(law);
        self.rest_energy = self.potential();
        let rest_density = self.forces.rest_density;
        self.acting = Acting::on(&self.laws, &self.glass, rest_density, self.forces.kernel.h, &self.fluid);
        self.accelerate(&Kinematics::default());
    }

    /// Time since the start, s.
    #[must_use]
    pub fn time_s(&self) -> f64 {
        self.time
    }

    /// Number of liquid particles.
    #[must_use]
    pub fn particles(&self) -> usize {
        self.fluid.mass.len()
    }

    /// Position, velocity and mass of each particle, SI units, in the frame of the glass.
    pub fn motion(&self) -> impl Iterator<Item = ([f64; 3], [f64; 3], f64)> {
        self.fluid.particle.iter().zip(&self.fluid.mass).map(|(p, &m)| (p.x, p.v, m))
    }

    /// Gives every particle the velocity `field(position)`, m/s; the books then start from here.
    pub fn set_velocity(&mut self, field: impl Fn([f64; 3]) -> [f64; 3]) {
        for p in &mut self.fluid.particle {
            p.v = field(p.x);
        }
        self.work = 0.0;
        self.work = closure(&self.energy());
        // A liquid at rest is at its thickest: the first forces give it the viscosity of this flow.
        self.accelerate(&Kinematics::default());
        self.thin();
        self.accelerate(&Kinematics::default());
    }

    /// Sets the step to the longest that is allowed and divides `interval_s`; returns the steps in it.
    pub fn divide(&mut self, interval_s: f64) -> usize {
        let steps = (interval_s / self.longest_step).ceil().max(1.0);
        self.dt = interval_s / steps;
        steps as usize
    }
}
