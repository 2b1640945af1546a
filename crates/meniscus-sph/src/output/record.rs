//! From a running simulation to a recording at the camera's 60 Hz.
//!
//! Surface and fields are sampled at 180 Hz and decimated to 60 Hz by a zero-phase low-pass filter
//! (27 taps, half amplitude at 20 Hz): it keeps slosh (below about 10 Hz) and removes the sound of the weakly
//! compressible liquid, whose slowest tone in a 70 mm glass is c0/(4 h) = 25 Hz. Energies are
//! taken at the frames as they are. Positions of tracers follow from the filtered surface.

use super::surface::{COEFFICIENTS, Coefficients, SurfaceFinder};
use super::tracers::sample;
use crate::settled::check_running;
use crate::{Error, Setup, Simulator};
use meniscus::blob::KnownGroups;
use meniscus::reduced::effects::EffectKind;
use meniscus::units::FRAME_INTERVAL_S;
use meniscus_data::motion::Motion;
use meniscus_data::recording::{COLUMNS, LAYERS, Lattice, Provenance, Recording, STATE, States, TRACERS};
use std::collections::VecDeque;
use std::sync::atomic::AtomicBool;

/// Samples in a frame.
pub(super) const OVERSAMPLING: usize = 3;

/// Taps of the filter on either side of the middle one.
pub(super) const HALF: usize = 13;

/// Frequency at which the filter halves an amplitude, Hz.
const CUTOFF_HZ: f64 = 20.0;

/// One sample: fitted surface and fields.
struct Sample {
    surface: Coefficients,
    fields: Vec<f32>,
}

/// Simulates `setup` under `motion` for `frames` frames and tells `watch` how many are done.
/// `command` is kept as provenance.
///
/// # Errors
/// When the setup is out of range, particles escape, or a number is not finite.
pub fn record(
    setup: &Setup,
    motion: &Motion,
    frames: usize,
    command: &str,
    watch: impl FnMut(usize),
) -> Result<Recording, Error> {
    record_particles(setup, motion, frames, command, watch, |_| ())
}

/// As [`record`]; `each` also sees the simulator at every frame.
///
/// # Errors
/// As for [`record`].
pub fn record_particles(
    setup: &Setup,
    motion: &Motion,
    frames: usize,
    command: &str,
    mut watch: impl FnMut(usize),
    mut each: impl FnMut(&Simulator),
) -> Result<Recording, Error> {
    let stop = &AtomicBool::new(false);
    record_until(setup, motion, frames, command, Observer { watch: &mut watch, each: &mut each, stop })
}

/// Observer of a simulation that is recorded.
pub struct Observer<'a> {
    /// Is called with the number of frames that are recorded.
    pub watch: &'a mut dyn FnMut(usize),
    /// Sees the simulator at every frame.
    pub each: &'a mut dyn FnMut(&Simulator),
    /// Ends the simulation within a step once it is raised, the settling included.
    pub stop: &'a AtomicBool,
}

/// As [`record_particles`], until `observer.stop` is raised.
///
/// # Errors
/// As for [`record`], and [`Error::Stopped`].
pub fn record_until(
    setup: &Setup,
    motion: &Motion,
    frames: usize,
    command: &str,
    mut observer: Observer<'_>,
) -> Result<Recording, Error> {
    let setup = &setup.resolved();
    let simulator = Simulator::new_until(setup, observer.stop)?;
    run(simulator, setup, motion, frames, command, true, &mut observer)
}

/// The free surface of one settled glass under several motions, one recording for each of `courses`
/// (motion, frames, command); without states, which take most of the memory. Each motion starts from the
/// same settled liquid, as if one glass were moved again and again.
///
/// # Errors
/// As for [`record`].
pub fn record_surfaces(setup: &Setup, courses: &[(Motion, usize, String)]) -> Result<Vec<Recording>, Error> {
    let setup = &setup.resolved();
    let settled = Simulator::new(setup)?;
    let one = |(motion, frames, command): &(Motion, usize, String)| {
        let stop = &AtomicBool::new(false);
        let mut observer = Observer { watch: &mut |_| (), each: &mut |_| (), stop };
        run(settled.clone(), setup, motion, *frames, command, false, &mut observer)
    };
    courses.iter().map(one).collect()
}

/// Records a settled `simulator`, with the fields at the tracers or without.
fn run(
    mut simulator: Simulator,
    setup: &Setup,
    motion: &Motion,
    frames: usize,
    command: &str,
    fields: bool,
    observer: &mut Observer<'_>,
) -> Result<Recording, Error> {
    let finder = SurfaceFinder::new(&simulator)?;
    let lattice = fields.then(|| Lattice::new(&setup.glass));
    let steps = simulator.divide(FRAME_INTERVAL_S / OVERSAMPLING as f64);
    let taps = taps();
    let mut recording = begin(setup, motion, frames, command);
    let mut states = Vec::with_capacity(if fields { frames * STATE } else { 0 });
    // Before the start the glass was at rest: the first sample stands for its past.
    let mut past: VecDeque<Sample> =
        (0..=HALF).map(|_| take(&simulator, &finder, lattice.as_ref())).collect();
    recording.energy.push(simulator.energy());
    recording.spilled_m3.push(0.0);
    (observer.each)(&simulator);
    let mut taken = 0;
    for frame in 0..frames {
        while taken < frame * OVERSAMPLING + HALF {
            for _ in 0..steps {
                check_running(observer.stop)?;
                simulator.step_moving(|t| motion.kinematics(t))?;
            }
            taken += 1;
            past.push_back(take(&simulator, &finder, lattice.as_ref()));
            if past.len() > taps.len() {
                past.pop_front();
            }
            if taken % OVERSAMPLING == 0 {
                simulator.check_inside()?;
                if recording.energy.len() < frames {
                    recording.energy.push(simulator.energy());
                    recording.spilled_m3.push(simulator.spilled().volume_m3);
                    (observer.each)(&simulator);
                }
            }
        }
        let (surface, fields) = decimate(&taps, &past);
        let columns = append(&mut recording, &finder, &surface);
        if let Some(lattice) = &lattice {
            append_state(&mut states, lattice, &columns, &fields);
        }
        (observer.watch)(frame + 1);
    }
    recording.states = States::Full(states);
    Ok(recording)
}

/// A recording with everything that is known before the simulation.
fn begin(setup: &Setup, motion: &Motion, frames: usize, command: &str) -> Recording {
    let time = |n: usize| n as f64 * FRAME_INTERVAL_S;
    // Mean over the two intervals around the frame: (X(t+dt) - 2 X(t) + X(t-dt)) / dt^2.
    let mean_acceleration = |n: usize| {
        let [before, at, after] = [-1.0, 0.0, 1.0].map(|k| motion.position(time(n) + k * FRAME_INTERVAL_S));
        (after - 2.0 * at + before) / (FRAME_INTERVAL_S * FRAME_INTERVAL_S)
    };
    Recording {
        glass: setup.glass,
        provenance: Provenance {
            liquid: setup.liquid.name.clone(),
            density_kg_m3: setup.liquid.density_kg_m3,
            motion: motion.spelling.clone(),
            seed: setup.seed,
            command: command.into(),
            spacing_m: setup.spacing_m,
            pivot_m: motion.pivot_m(),
            effects: setup
                .effects
                .on()
                .into_iter()
                .map(|(parameter, value)| (parameter.spelling.into(), value))
                .collect(),
        },
        glass_x_m: (0..frames).map(|n| motion.position(time(n))).collect(),
        acceleration_m_s2: (0..frames).map(mean_acceleration).collect(),
        glass_y_m: (0..frames).map(|n| motion.away(time(n))).collect(),
        glass_z_m: (0..frames).map(|n| motion.height(time(n))).collect(),
        tilt_rad: (0..frames)
            .map(|n| motion.tilt(time(n)) + setup.effects.value(EffectKind::ContainerTilt).unwrap_or(0.0))
            .collect(),
        column_m: Vec::new(),
        wall_m: Vec::new(),
        profile_m: Vec::new(),
        energy: Vec::new(),
        spilled_m3: Vec::new(),
        states: States::Full(Vec::new()),
        known: KnownGroups::ALL,
    }
}

/// Samples the present state; without fields where there is no `lattice`.
fn take(simulator: &Simulator, finder: &SurfaceFinder, lattice: Option<&Lattice>) -> Sample {
    let nearby = finder.nearby(simulator);
    let surface = finder.coefficients(simulator, &nearby);
    let fields = lattice.map_or_else(Vec::new, |lattice| {
        let (columns, _) = finder.heights(&surface);
        sample(simulator, lattice, &nearby[..COLUMNS], &columns)
    });
    Sample { surface, fields }
}

/// Low-pass filter: `sin(2 pi fc t)/(pi t)` under a Hamming window, scaled to the sum 1.
pub(super) fn taps() -> [f64; 2 * HALF + 1] {
    let rate = OVERSAMPLING as f64 / FRAME_INTERVAL_S;
    let mut taps = std::array::from_fn(|k| {
        let n = k as f64 - HALF as f64;
        let angle = std::f64::consts::TAU * CUTOFF_HZ / rate * n;
        let sinc = if n == 0.0 { 1.0 } else { angle.sin() / angle };
        sinc * (0.54 + 0.46 * (std::f64::consts::PI * n / (HALF as f64 + 1.0)).cos())
    });
    let sum: f64 = taps.iter().sum();
    for tap in &mut taps {
        *tap /= sum;
    }
    taps
}

/// The filtered sample in the middle of `past`, which holds one sample for each tap.
fn decimate(taps: &[f64], past: &VecDeque<Sample>) -> (Coefficients, Vec<f32>) {
    let mut surface = [0.0; COEFFICIENTS];
    let mut fields = vec![0.0_f64; past.front().map_or(0, |sample| sample.fields.len())];
    for (tap, sample) in taps.iter().zip(past) {
        for (s, x) in surface.iter_mut().zip(&sample.surface) {
            *s += tap * x;
        }
        for (s, x) in fields.iter_mut().zip(&sample.fields) {
            *s += tap * f64::from(*x);
        }
    }
    (surface, fields.into_iter().map(|x| x as f32).collect())
}

/// Appends the surface of one frame; returns its heights over the columns.
fn append(recording: &mut Recording, finder: &SurfaceFinder, surface: &Coefficients) -> Vec<f32> {
    let (columns, wall) = finder.heights(surface);
    recording.profile_m.extend(finder.profile(surface));
    recording.column_m.extend(&columns);
    recording.wall_m.extend(wall);
    columns
}

/// Appends the full state of one frame.
fn append_state(states: &mut Vec<f32>, lattice: &Lattice, columns: &[f32], fields: &[f32]) {
    for tracer in 0..TRACERS {
        let column = tracer / LAYERS;
        let q = lattice.tracer(column, tracer % LAYERS, f64::from(columns[column]));
        states.extend(q.map(|x| x as f32));
    }
    states.extend_from_slice(fields);
}
