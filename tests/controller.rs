//! Numbers of the controller's interface on the shipped model and its unseen recording: linearised model, reduced state and
//! its covariance, each against finite differences or against the truth of the recording.

use meniscus::blob::Model;
use meniscus::latent::generic::{LATENTS, Latent, LatentState};
use meniscus::runtime::{Estimate, Forecast, InputSource, LinearModel, LinearStep, Memory, ModalState, Mode};
use meniscus::surface::POINTS;
use meniscus_data::recording::Recording;
use meniscus_platform::files::AlignedBytes;
use meniscus_virtual::observe_recording::{perfect, turns_with};
use std::path::Path;

/// 100 ms, turns.
const AHEAD: usize = 6;

/// Columns of the wall in a recording.
const COLUMNS: usize = 72;

/// 90 % quantile of the size of a standard normal error.
const QUANTILE_90: f64 = 1.645;

fn recording() -> Recording {
    let path = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../recordings/glycerine-unseen.safetensors"));
    Recording::load(path).expect("the shipped recording is good")
}

/// Calls `each` after every turn that tracks, with its frame and the acceleration of every step as three positions of the
/// glass give it.
fn tracked(each: impl FnMut(&Model<'_>, usize, &Memory, &Estimate, &Recording, &[f64])) {
    let (recording, mut each) = (recording(), each);
    let bytes = AlignedBytes::copy(meniscus_shipped::MODEL);
    let model = Model::load(&bytes).expect("the shipped model");
    let x = &recording.glass_x_m;
    let motion: Vec<f64> =
        (0..x.len()).map(|n| if n < 2 { 0.0 } else { (x[n] - 2.0 * x[n - 1] + x[n - 2]) * 3600.0 }).collect();
    turns_with(
        &model,
        &perfect(&recording),
        |_| InputSource::Tracked,
        |frame, memory, estimate| {
            if estimate.mode == Mode::Tracking && frame + AHEAD + 1 < recording.frames() {
                each(&model, frame, memory, estimate, &recording, &motion);
            }
        },
    );
}

/// Amplitude of azimuth `k` along x in a frame, of the recording's own wall all around, m.
fn wall_amplitude(recording: &Recording, frame: usize, k: f64) -> f64 {
    let wall = &recording.wall_m[frame * COLUMNS..(frame + 1) * COLUMNS];
    let angle = |column: usize| std::f64::consts::TAU * column as f64 / COLUMNS as f64;
    let sum: f64 = wall.iter().enumerate().map(|(column, z)| f64::from(*z) * (k * angle(column)).cos()).sum();
    2.0 * sum / COLUMNS as f64
}

/// A and B by central differences through the public step, C and D by differences of the public decoder.
#[test]
fn the_linearised_model_has_the_slopes_of_step_and_decoder() {
    let (mut looked, mut worst) = (0, [0.0_f64; 4]);
    tracked(|model, frame, memory, _, _, _| {
        if frame % 40 != 0 {
            return;
        }
        looked += 1;
        let linear = LinearModel::at(model, memory);
        let scale = f64::from(model.header.acceleration_scale);
        let end = |latent: [f64; LATENTS], acceleration: f64| {
            let mut state = LatentState { latent: Latent::from(latent), ..LatentState::default() };
            model.generic.step(&mut state, acceleration / scale);
            state.latent
        };
        let surface = |latent: [f64; LATENTS], acceleration: f64| {
            let coefficients =
                model.decoder.coefficients(&latent.map(|x| x as f32), (acceleration / scale) as f32);
            model.decoder.surface(&coefficients).map(f64::from)
        };
        let (step, wide) = (1e-5, 1e-3);
        for column in 0..LATENTS {
            let moved = |by: f64| {
                let mut latent = linear.latent;
                latent[column] += by;
                latent
            };
            let slope = (end(moved(step), 0.0) - end(moved(-step), 0.0)) / (2.0 * step);
            for row in 0..LATENTS {
                worst[0] = worst[0].max((slope[row] - f64::from(linear.a[row][column])).abs());
            }
            let a0 = f64::from(linear.acceleration_m_s2);
            let (up, down) = (surface(moved(wide), a0), surface(moved(-wide), a0));
            for row in 0..POINTS {
                let slope = (up[row] - down[row]) / (2.0 * wide);
                worst[2] = worst[2].max((slope - f64::from(linear.c[row][column])).abs());
            }
        }
        let slope = (end(linear.latent, 0.01) - end(linear.latent, -0.01)) / 0.02;
        let (up, down) = (surface(linear.latent, 5.0), surface(linear.latent, -5.0));
        for row in 0..LATENTS {
            worst[1] = worst[1].max((slope[row] - f64::from(linear.b[row])).abs());
        }
        for row in 0..POINTS {
            worst[3] = worst[3].max(((up[row] - down[row]) / 10.0 - f64::from(linear.d[row])).abs());
        }
        let next = end(linear.latent, 0.0);
        assert!((next - Latent::from(linear.next)).norm() < 1e-9, "frame {frame}");
        // Q is a covariance: symmetric, with positive variances.
        for row in 0..LATENTS {
            assert!(linear.q[row][row] > 0.0);
            (0..LATENTS)
                .for_each(|column| assert!((linear.q[row][column] - linear.q[column][row]).abs() < 1e-9));
        }
    });
    println!(
        "{looked} states; largest errors: A {:.1e}, B {:.1e}, C {:.1e} m, D {:.1e} m s2/m",
        worst[0], worst[1], worst[2], worst[3]
    );
    assert!(looked >= 10);
    // A has entries of about one, B of 0.01; C is in metres, and the decoder in single precision.
    assert!(worst[0] < 1e-5 && worst[1] < 1e-6 && worst[2] < 4e-4 && worst[3] < 1e-6, "{worst:?}");
}

/// Sums of one lead.
#[derive(Clone, Copy, Default)]
struct Lead {
    apart: f64,
    chain_apart: f64,
    linear_error: f64,
    full_error: f64,
    size: f64,
    held: u32,
    full_held: u32,
    chain_held: u32,
    count: u32,
}

/// The linearised model alone, under the true motion, against the full model and against the recording: it is exact for a
/// step and bends away from the full one later, unless it is linearised along a course.
#[test]
fn the_linearised_model_predicts_the_next_turns_as_the_full_one() {
    let mut leads = [Lead::default(); AHEAD];
    tracked(|model, frame, memory, estimate, recording, motion| {
        if frame % 3 != 0 {
            return;
        }
        let linear = LinearModel::at(model, memory);
        let plan = &motion[frame + 1..=frame + AHEAD];
        let mut full = Vec::new();
        Forecast::course(model, memory, AHEAD, plan, |_, forecast| full.push(*forecast));
        let mut carried = Carried::at(&linear, estimate);
        let held = [f64::from(linear.acceleration_m_s2); AHEAD];
        let mut chain = Vec::new();
        LinearModel::along(model, memory, &held, |_, step| chain.push(*step));
        let mut course = Carried { x: [0.0; LATENTS], ..Carried::at(&linear, estimate) };
        let k = f64::from(model.error_model.factors.surface[0]) / QUANTILE_90;
        let energy = model.generic.potential.value(&Latent::from(linear.latent));
        let rest = f64::from(model.error_model.factors.rest_noise_std_m);
        let weight = f64::from(model.error_model.factors.weight_floor) + energy;
        let mut lateral = lateral_now(model, memory);
        for (ahead, lead) in leads.iter_mut().enumerate() {
            carried.step(&linear, plan[ahead]);
            let step = &chain[ahead];
            course.deviate(step, &linear, plan[ahead] - f64::from(step.acceleration_m_s2));
            lateral = model.cross_axis.next(lateral);
            for point in 0..POINTS {
                let row = linear.c[point].map(f64::from);
                // A forecast knows no acceleration behind its last step, so that it has no inertial part of the surface.
                let inertial = f64::from(linear.d[point]) * f64::from(linear.acceleration_m_s2);
                let moved: f64 = (0..LATENTS).map(|j| row[j] * (carried.x[j] - linear.latent[j])).sum();
                // The cross-axis slosh is no part of the latents.
                let across = model.cross_axis.shape[point] * lateral[0];
                let predicted = f64::from(linear.heights_m[point]) - inertial + moved + across;
                let in_full = f64::from(full[ahead].surface_m[point]);
                let truth = f64::from(recording.profile(frame + ahead + 1)[point]);
                let row = step.c[point].map(f64::from);
                let deviates: f64 = row.iter().zip(course.x).map(|(c, x)| c * x).sum();
                let chained = f64::from(step.heights_m[point]) + deviates + across;
                let chained_variance = course.variance(&row);
                lead.chain_apart += (chained - in_full).powi(2);
                lead.apart += (predicted - in_full).powi(2);
                lead.linear_error += (predicted - truth).powi(2);
                lead.full_error += (in_full - truth).powi(2);
                lead.size += (truth - recording.glass.fill_m).powi(2);
                let variance = carried.variance(&linear.c[point].map(f64::from));
                let misfit = weight * f64::from(model.error_model.surface_misfit[point]);
                let half = QUANTILE_90 * k * (variance + misfit + rest * rest).sqrt();
                let chained_half = QUANTILE_90 * k * (chained_variance + misfit + rest * rest).sqrt();
                lead.chain_held += u32::from((chained - truth).abs() <= chained_half);
                lead.full_held +=
                    u32::from((in_full - truth).abs() <= f64::from(full[ahead].half_width_m[point]));
                lead.held += u32::from((predicted - truth).abs() <= half);
                lead.count += 1;
            }
        }
    });
    let of_slosh = |sum: f64, lead: &Lead| 100.0 * (sum / lead.size).sqrt();
    for (ahead, lead) in leads.iter().enumerate() {
        println!(
            "{} turns ahead, relative to the slosh: linear to full {:.2} % (along the course {:.2} %), linear to truth {:.2} %, full to truth {:.2} %; \
             {:.1} % of {} heights within A, C and Q (along the course {:.1} %), {:.1} % within the full model's interval",
            ahead + 1,
            of_slosh(lead.apart, lead),
            of_slosh(lead.chain_apart, lead),
            of_slosh(lead.linear_error, lead),
            of_slosh(lead.full_error, lead),
            100.0 * f64::from(lead.held) / f64::from(lead.count),
            lead.count,
            100.0 * f64::from(lead.chain_held) / f64::from(lead.count),
            100.0 * f64::from(lead.full_held) / f64::from(lead.count)
        );
    }
    let [first, _, third, .., last] = &leads;
    assert!(first.count > 1000 && of_slosh(first.apart, first) < 2.0, "one turn");
    assert!(of_slosh(third.apart, third) < 6.0, "three turns");
    assert!(of_slosh(last.chain_apart, last) < 5.0, "100 ms along the course");
    // Nine of ten are promised of the full model, whose interval holds 81 % here; the linearised one loses some of them.
    assert!(10 * last.chain_held >= 7 * last.count, "coverage after 100 ms along the course");
    assert!(10 * first.held >= 8 * first.count, "coverage after a turn");
}

/// State and covariance that the published matrices carry on.
struct Carried {
    x: [f64; LATENTS],
    p: [[f64; LATENTS]; LATENTS],
}

impl Carried {
    fn at(linear: &LinearModel, estimate: &Estimate) -> Self {
        let entry = |i: usize, j: usize| f64::from(estimate.covariance.at(i, j));
        Self { x: linear.latent, p: std::array::from_fn(|i| std::array::from_fn(|j| entry(i, j))) }
    }

    /// C P C^T of a row of C.
    fn variance(&self, row: &[f64; LATENTS]) -> f64 {
        (0..LATENTS).map(|i| (0..LATENTS).map(|j| row[i] * self.p[i][j] * row[j]).sum::<f64>()).sum()
    }

    /// dx+ = A dx + B da,  P+ = A P A^T + Q: `x` is the deviation from a course.
    fn deviate(&mut self, step: &LinearStep, linear: &LinearModel, more_m_s2: f64) {
        // The same as a step of the model about a state that is zero and stays there.
        let about =
            LinearModel { latent: [0.0; LATENTS], next: [0.0; LATENTS], a: step.a, b: step.b, ..*linear };
        self.step(&about, more_m_s2);
    }

    /// x+ = next + A (x - x0) + B a,  P+ = A P A^T + Q.
    fn step(&mut self, linear: &LinearModel, acceleration: f64) {
        let a = |i: usize, j: usize| f64::from(linear.a[i][j]);
        let Self { x, p } = &*self;
        let moved = |i: usize| (0..LATENTS).map(|j| a(i, j) * (x[j] - linear.latent[j])).sum::<f64>();
        let next = std::array::from_fn(|i| linear.next[i] + moved(i) + f64::from(linear.b[i]) * acceleration);
        let half: [[f64; LATENTS]; LATENTS] =
            std::array::from_fn(|i| std::array::from_fn(|j| (0..LATENTS).map(|k| a(i, k) * p[k][j]).sum()));
        let spread = |i: usize, j: usize| (0..LATENTS).map(|k| half[i][k] * a(j, k)).sum::<f64>();
        let p = std::array::from_fn(|i| std::array::from_fn(|j| spread(i, j) + f64::from(linear.q[i][j])));
        *self = Self { x: next, p };
    }
}

/// Cross-axis amplitude of this turn and the one before, m, from the published state.
fn lateral_now(model: &Model<'_>, memory: &Memory) -> [f64; 2] {
    let Some(across) = ModalState::of(model, memory).across else { return [0.0; 2] };
    let [k1, k2] = model.cross_axis.recursion;
    let (now, rate) = (f64::from(across.amplitude_m), f64::from(across.rate_m_s));
    [now, (k1 * now - 2.0 * model.generic.dt_s * rate) / (1.0 - k2)]
}

/// Amplitudes and rates against the recording's own wall, and how often their covariance holds.
#[test]
fn modes_are_those_of_the_recordings_wall_and_nine_of_ten_are_within_their_covariance() {
    let (mut errors, mut sizes, mut held, mut count) = ([0.0; 4], [0.0; 4], [0_u32; 4], 0_u32);
    tracked(|model, frame, memory, _, recording, _| {
        let state = ModalState::of(model, memory);
        for index in 0..4 {
            let (mode, k) = (state.along[index % 2], (index % 2 + 1) as f64);
            let truth = match index {
                0 | 1 => wall_amplitude(recording, frame, k),
                _ => {
                    30.0 * (wall_amplitude(recording, frame + 1, k) - wall_amplitude(recording, frame - 1, k))
                }
            };
            let is = f64::from(if index < 2 { mode.amplitude_m } else { mode.rate_m_s });
            errors[index] += (is - truth).powi(2);
            sizes[index] += truth.powi(2);
            let std = f64::from(state.along_covariance[index][index]).sqrt();
            held[index] += u32::from((is - truth).abs() <= QUANTILE_90 * std);
        }
        count += 1;
    });
    let names = ["a1", "a2", "a1'", "a2'"];
    let coverage = held.map(|held| 100.0 * f64::from(held) / f64::from(count));
    for index in 0..4 {
        let (error, size) = (errors[index] / f64::from(count), sizes[index] / f64::from(count));
        println!(
            "{}: error {:.3e} of {:.3e} ({:.1} %), coverage {:.1} % of {count}",
            names[index],
            error.sqrt(),
            size.sqrt(),
            100.0 * (error / size).sqrt(),
            coverage[index]
        );
    }
    assert!(count > 300);
    assert!(errors[0] < 0.01 * sizes[0], "the amplitude along the line is known to a tenth");
    assert!(errors[2] < 0.04 * sizes[2], "its rate to a fifth");
    assert!(coverage.iter().all(|coverage| *coverage >= 80.0), "{coverage:?}");
}

/// The course of forecasts is that of single forecasts.
#[test]
fn a_course_of_forecasts_is_each_forecast() {
    let mut looked = 0;
    tracked(|model, frame, memory, _, _, motion| {
        if frame % 60 != 0 || frame + 12 >= motion.len() {
            return;
        }
        for plan in [&motion[frame + 1..=frame + 10], &motion[frame + 1..=frame + 4], &[]] {
            Forecast::course(model, memory, 10, plan, |ahead, forecast| {
                let single = Forecast::new(model, memory, ahead, plan);
                for point in 0..POINTS {
                    assert!((forecast.surface_m[point] - single.surface_m[point]).abs() < 1e-7);
                    assert!((forecast.half_width_m[point] - single.half_width_m[point]).abs() < 1e-7);
                }
                looked += 1;
            });
        }
    });
    assert!(looked >= 60, "{looked}");
}
