use super::super::covariance::ErrorCovariance;
use super::super::kalman::{Filter, PORT_LIMIT};
use super::super::measurements::{Adaptation, Reading, Update, UpdateContext};
use super::super::state::{StateIndex, StateMatrix, StateVector};
use super::{behind_the_latents, close, correlated, filter, model, steady};
use crate::blob::{FilterConfig, Model, ScaleBounds};
use crate::latent::generic::{LATENTS, Latent};
use crate::latent::linearisation::Linearisation;
use crate::surface::{POINTS, SurfaceProfile};
use crate::units::Micros;
use nalgebra::SMatrix;

const HOLD: UpdateContext = UpdateContext { latent_energy: 0.5, adaptation: Adaptation::Hold };
const FOLLOW: UpdateContext = UpdateContext { adaptation: Adaptation::Follow, ..HOLD };

fn profile(height_m: [f32; POINTS]) -> SurfaceProfile {
    SurfaceProfile {
        height_m,
        variance_m2: [4e-8; POINTS],
        valid: [true; POINTS],
        glass_x_m: None,
        sequence: 0,
        captured: Micros(0),
    }
}

fn about(model: &Model<'_>) -> Linearisation {
    model.decoder.linearise(&[0.1; LATENTS], 0.2)
}

/// Bayes' rule in its information form: P+ = (P^-1 + sum c c^T / r)^-1 and y+ - y- = P+ sum c z / r.
#[derive(Clone)]
struct Information {
    matrix: StateMatrix,
    vector: StateVector,
}

impl Information {
    fn of(prior: StateMatrix) -> Self {
        Self { matrix: prior.try_inverse().expect("positive"), vector: StateVector::zeros() }
    }

    fn add(&mut self, c: &StateVector, innovation: f64, noise: f64) {
        self.matrix += c * c.transpose() / noise;
        self.vector += c * (innovation / noise);
    }

    /// Compares a filter that was at rest, and its latents that were zero, with the result.
    fn compare(self, filter: &Filter, latent: &Latent) {
        let due = self.matrix.try_inverse().expect("positive");
        let p = StateMatrix::from_fn(|i, j| filter.covariance.at(i, j));
        assert!((p - due).norm() < 1e-7 * due.norm(), "{p} for {due}");
        let mut state = behind_the_latents(filter);
        state.fixed_rows_mut::<LATENTS>(0).copy_from(latent);
        let moved = due * self.vector;
        assert!((state - moved).norm() < 1e-7 * moved.norm(), "{state} for {moved}");
    }
}

/// Positions of a glass under a constant acceleration, and nothing else, tell the acceleration.
#[test]
fn positions_tell_the_acceleration() {
    let model = model(steady());
    let mut filter = Filter::new(&model.header.filter);
    let mut latent = Latent::zeros();
    let acceleration = -1.2 * f64::from(model.header.acceleration_scale);
    for n in 1..=40 {
        let x_m = acceleration / 3600.0 * f64::from(n * (n + 1) / 2);
        filter.update_position::<f64>(&model, &mut latent, x_m);
        filter.predict::<f64>(&model, 0.0);
    }
    assert!((filter.input() + 1.2).abs() < 0.02, "{}", filter.input());
    let variance = filter.covariance.between(StateIndex::Input, StateIndex::Input);
    assert!(variance < 0.1, "{variance}");
}

#[test]
fn a_position_is_taken_by_the_rule_of_bayes() {
    let config = FilterConfig { position_noise_mm: 3.0, ..steady() };
    let model = model(config);
    let mut filter = Filter { glass_mm: [4.0, 50.0], ..filter(&config, correlated(2.0)) };
    filter.input = [0.5, 0.0, 0.0];
    let (before, mut latent) = (behind_the_latents(&filter), Latent::zeros());
    // In one turn a unit of the input moves the glass by its acceleration times the square of the turn.
    let gain = 1e3 * f64::from(model.header.acceleration_scale) / 3600.0;
    let mut c = StateVector::zeros();
    c[StateIndex::Input.index()] = gain;
    (c[StateIndex::GlassTravel.index()], c[StateIndex::GlassPosition.index()]) = (1.0, 1.0);
    let mut due = Information::of(correlated(2.0));
    due.add(&c, 62.0 - (54.0 + 0.5 * gain), 9.0);
    filter.update_position::<f64>(&model, &mut latent, 0.062);
    let after = behind_the_latents(&filter);
    let mut rest = Filter { covariance: filter.covariance.clone(), ..Filter::new(&config) };
    rest.shift(&mut Latent::zeros(), &(after - before));
    due.compare(&rest, &latent);
}

/// A glass that seems to jump by ten metres neither leaves the port's range nor, behind a gate, moves the filter by more than the
/// gate's number of standard deviations.
#[test]
fn a_jump_of_the_glass_is_bounded() {
    for (x_m, limit) in [(10.0, PORT_LIMIT), (-10.0, -PORT_LIMIT)] {
        let model = model(FilterConfig { position_gate: 1e9, ..steady() });
        let mut filter = filter(&model.header.filter, StateMatrix::identity() * 1e6);
        filter.update_position::<f64>(&model, &mut Latent::zeros(), x_m);
        assert_eq!(filter.input(), limit);
    }
    let model = model(FilterConfig { position_gate: 2.0, position_noise_mm: 1.0, ..steady() });
    let mut p = StateMatrix::zeros();
    p[(StateIndex::GlassPosition.index(), StateIndex::GlassPosition.index())] = 3.0;
    let mut filter = filter(&model.header.filter, p);
    filter.update_position::<f64>(&model, &mut Latent::zeros(), 10.0);
    // An innovation of b = 2 of its own deviations, sqrt(3 + 1), would move by 4 * 3 / 4; a farther one moves by less.
    let [_, position] = filter.glass_mm;
    assert!(position > 0.0 && position <= 3.0, "{position}");
}

#[test]
fn heights_are_taken_by_the_rule_of_bayes() {
    let model = model(steady());
    let about = about(&model);
    let mut seen = profile(core::array::from_fn(|i| about.heights_m[i] + 1e-4 * (i as f32 - 7.0)));
    for (i, variance) in seen.variance_m2.iter_mut().enumerate() {
        *variance *= 1.0 + i as f32;
    }
    // What was not seen is not taken, whatever stands there.
    for point in [3, 20] {
        (seen.valid[point], seen.height_m[point]) = (false, f32::NAN);
    }
    let prior = correlated(0.3);
    let mut filter = Filter { lateral_mm: [0.4, 0.0], ..filter(&model.header.filter, prior) };
    let mut latent = Latent::zeros();
    let w = f64::from(model.error_model.factors.weight_floor) + 0.5;
    let mut due = Information::of(prior);
    for point in (0..POINTS).filter(|point| ![3, 20].contains(point)) {
        let mut c = StateVector::zeros();
        (0..LATENTS).for_each(|k| c[k] = f64::from(about.latent_slopes_m[k][point]));
        c[StateIndex::Input.index()] = f64::from(about.input_slopes_m[point]);
        // A millimetre across the line stands as the mode's shape, in metres.
        c[StateIndex::Lateral.index()] = 1e-3 * model.cross_axis.shape[point];
        let innovation = f64::from(seen.height_m[point])
            - f64::from(about.heights_m[point])
            - 0.4e-3 * model.cross_axis.shape[point];
        let noise =
            f64::from(seen.variance_m2[point]) + w * f64::from(model.error_model.surface_misfit[point]);
        due.add(&c, innovation, noise);
    }
    let taken = filter.update_heights::<f64>(&model, &mut latent, &seen, &about, HOLD);
    assert_eq!(taken, Update::Accepted);
    filter.lateral_mm[0] -= 0.4;
    due.compare(&filter, &latent);
}

/// The reading's error covariance is 2 b w R, R = (W^T W)^-1 with the blob's W; that of its input is READ^2.
#[test]
fn a_reading_is_taken_by_the_rule_of_bayes() {
    let config = FilterConfig { encoder_noise_factor: 2.0, encoder_input_std: 0.3, ..steady() };
    let mut model = model(config);
    model.error_model.reading =
        SMatrix::from_fn(|i, j| if i == j { 2.0 } else { 0.1 * (i as f64 - j as f64) });
    model.error_model.factors.weight_floor = 0.25;
    let prior = correlated(0.3);
    let mut filter = Filter { measurement_noise_scale: 1.5, ..filter(&config, prior) };
    // The reading counts from where the state is.
    let (start, input) = (Latent::repeat(0.4), 0.3);
    filter.input = [input, 0.0, 0.0];
    let off = Latent::from_fn(|i, _| 0.1 * (i as f64 - 5.0));
    let reading = Reading { latent: start + off, input: input + 0.7 };
    let mut due = Information::of(prior);
    for k in 0..LATENTS {
        let row = model.error_model.reading.row(k);
        let c = StateVector::from_fn(|i, _| row.get(i).copied().unwrap_or(0.0));
        due.add(&c, (row * off)[0], 2.0 * 1.5 * 0.75);
    }
    let of_input = StateVector::from_fn(|i, _| if i == StateIndex::Input.index() { 1.0 } else { 0.0 });
    due.add(&of_input, 0.7, 0.09);
    let mut latent = start;
    let taken = filter.update_reading::<f64>(&model, &mut latent, &reading, HOLD);
    assert_eq!((taken, filter.measurement_noise_scale), (Update::Accepted, 1.5));
    filter.input[0] -= input;
    due.compare(&filter, &(latent - start));
}

/// Where the state is known exactly, three standard deviations of the measurements are a normalised square of 9: with a rate of
/// 1/2 the noise scale of the step grows threefold, within its bounds, and only where there is something to follow.
#[test]
fn the_noise_of_the_step_follows_the_heights() {
    let bounds = ScaleBounds { min: 0.5, max: 7.0 };
    let config = FilterConfig { adaptation_rate: 0.5, process_noise_scale: bounds, ..steady() };
    let mut model = model(config);
    model.error_model.factors.weight_floor = 0.0;
    let misfit = [8e-8; POINTS];
    model.error_model.surface_misfit = &misfit;
    let about = about(&model);
    // Noise 4e-8 + 0.5 * 8e-8 m2, of which 3 deviations are 0.84853 mm.
    let off = profile(about.heights_m.map(|z| z + 8.485_281e-4));
    let after = |scale: f64, seen: &SurfaceProfile, context| {
        let mut filter = filter(&config, StateMatrix::zeros());
        filter.process_noise_scale = scale;
        let taken = filter.update_heights::<f64>(&model, &mut Latent::zeros(), seen, &about, context);
        assert_eq!((taken, filter.measurement_noise_scale), (Update::Accepted, 1.0));
        filter.process_noise_scale
    };
    assert!((after(1.0, &off, FOLLOW) - 3.0).abs() < 1e-3);
    assert_eq!(after(1.0, &off, HOLD), 1.0);
    assert_eq!(after(4.0, &off, FOLLOW), 7.0);
    assert_eq!(after(1.0, &profile(about.heights_m), FOLLOW), 0.5, "nothing is off: down to the least");
    let blind = SurfaceProfile { valid: [false; POINTS], ..off };
    assert_eq!(after(1.0, &blind, FOLLOW), 1.0, "nothing was seen");
}

#[test]
fn the_noise_of_the_encoder_follows_its_readings() {
    let bounds = ScaleBounds { min: 0.5, max: 7.0 };
    let config = FilterConfig { adaptation_rate: 0.5, measurement_noise_scale: bounds, ..steady() };
    let mut model = model(config);
    model.error_model.factors.weight_floor = 0.5;
    model.error_model.reading = SMatrix::identity() * 4.0;
    // A variance of 2 w / 4^2 with w = 1; the reading of the input, far off, has no part in it.
    let reading = |deviations: f64| Reading {
        latent: Latent::repeat(deviations * crate::math::sqrt(2.0) / 4.0),
        input: 50.0,
    };
    let after = |scale: f64, deviations: f64, context| {
        let mut filter = filter(&config, StateMatrix::zeros());
        filter.measurement_noise_scale = scale;
        let taken = filter.update_reading::<f64>(&model, &mut Latent::zeros(), &reading(deviations), context);
        assert_eq!((taken, filter.process_noise_scale), (Update::Accepted, 1.0));
        filter.measurement_noise_scale
    };
    close(after(1.0, 3.0, FOLLOW), 3.0);
    assert_eq!(after(1.0, 3.0, HOLD), 1.0);
    // Twice the scale, twice the variance: the normalised square is 4.5.
    close(after(2.0, 3.0, FOLLOW), 2.0 * crate::math::sqrt(4.5));
    assert_eq!(after(1.0, 1e3, FOLLOW), 7.0);
}

/// A height that is no number, and a covariance that is none, lead back to the prior.
#[test]
fn what_is_no_number_leads_back_to_the_prior() {
    let config = steady();
    let model = model(config);
    let about = about(&model);
    let mut latent = Latent::repeat(0.1);
    let mut broken = profile(about.heights_m);
    broken.height_m[4] = f32::NAN;
    let mut lost = filter(&config, correlated(0.3));
    let taken = lost.update_heights::<f64>(&model, &mut latent, &broken, &about, FOLLOW);
    assert_eq!((taken, latent), (Update::Refused, Latent::repeat(0.1)));
    assert_eq!(lost, Filter::new(&config));

    let mut p = StateMatrix::identity();
    p[(StateIndex::InputLag2.index(), StateIndex::InputLag2.index())] = f64::NAN;
    let mut lost = Filter { covariance: ErrorCovariance::new(p), ..Filter::new(&config) };
    let blind = SurfaceProfile { valid: [false; POINTS], ..broken };
    let taken = lost.update_heights::<f64>(&model, &mut latent, &blind, &about, FOLLOW);
    assert_eq!((taken, lost), (Update::Refused, Filter::new(&config)));
}
