use super::super::kalman::{Filter, PORT_LIMIT};
use super::super::state::{STATES, StateIndex, StateMatrix, StateVector};
use super::{behind_the_latents, close, correlated, filter, model, steady};
use crate::blob::{FilterConfig, Model};
use crate::latent::generic::{LATENTS, Latent, LatentState};
use nalgebra::SMatrix;

/// Settings and model without process noise.
fn noiseless() -> Model<'static> {
    let config = FilterConfig {
        input_recursion: [0.9, -0.3, 0.2],
        input_noise_std: 0.0,
        lateral_noise_std: 0.0,
        lateral_noise_share: 0.0,
        ..steady()
    };
    let mut model = model(config);
    model.error_model.process = SMatrix::zeros();
    model
}

/// Under a constant input the glass moves as under a constant acceleration: X = a dt^2 n (n + 1) / 2 after n turns.
#[test]
fn a_constant_input_moves_the_glass_as_newton_says() {
    let model = model(steady());
    let mut filter = Filter::new(&model.header.filter);
    filter.set_known_input(&model.header.filter, 1.5);
    (0..10).for_each(|_| filter.predict::<f64>(&model, 0.0));
    let acceleration = 1.5 * f64::from(model.header.acceleration_scale);
    let [travel, position] = filter.glass_mm;
    close(travel, 1e3 * acceleration * 10.0 / 3600.0);
    close(position, 1e3 * acceleration * 55.0 / 3600.0);
}

/// The recursion 3, -3, 1 continues a parabola: 16 after 1, 4, 9.
#[test]
fn the_input_is_extrapolated_from_the_last_three() {
    let model = model(FilterConfig { input_recursion: [3.0, -3.0, 1.0], ..steady() });
    let mut filter = Filter { input: [9.0, 4.0, 1.0], ..Filter::new(&model.header.filter) };
    filter.predict::<f64>(&model, 0.0);
    assert_eq!(filter.input, [16.0, 9.0, 4.0]);
    assert_eq!(filter.input(), 16.0);
}

/// Derivatives of the model's own step about rest, by its latents and by the input.
fn derivatives(model: &Model<'_>) -> (SMatrix<f64, LATENTS, LATENTS>, Latent) {
    let small = 1e-4;
    let by = |latent: Latent, u: f64| {
        let mut state = LatentState { latent, ..LatentState::default() };
        model.generic.step(&mut state, u);
        state.latent / small
    };
    let unit = |k: usize| Latent::from_fn(|i, _| if i == k { small } else { 0.0 });
    let columns: [Latent; LATENTS] = core::array::from_fn(|k| by(unit(k), 0.0));
    (SMatrix::from_columns(&columns), by(Latent::zeros(), small))
}

/// An error of the state moves as a difference of two states does: P = v v^T becomes (G v) (G v)^T, where G v is taken from the
/// motion of the states themselves. Of the input's kick k, half comes before the closed step A and half behind it; the
/// filter has all of it behind, and A k / 2 + k / 2 is solved for k.
#[test]
fn errors_move_as_the_states_do() {
    let model = noiseless();
    let (closed, kicked) = derivatives(&model);
    let kick = 2.0 * (closed + SMatrix::identity()).try_inverse().expect("regular") * kicked;
    for k in 0..STATES {
        let v = StateVector::from_fn(|i, _| f64::from(u8::from(i == k)));
        let mut still = filter(&model.header.filter, v * v.transpose());
        still.shift(&mut Latent::zeros(), &v);
        still.predict::<f64>(&model, 0.0);
        let mut due = behind_the_latents(&still);
        if k <= LATENTS {
            due.fixed_rows_mut::<LATENTS>(0).copy_from(&if k < LATENTS {
                closed.column(k).into()
            } else {
                kick
            });
        }
        for i in 0..STATES {
            for j in 0..STATES {
                let (p, product) = (still.covariance.at(i, j), due[i] * due[j]);
                // The latents' step is linear for small states only.
                let slack = if i.min(j) < LATENTS { 0.01 * due.norm_squared() } else { 1e-9 * product.abs() };
                assert!((p - product).abs() <= slack, "{k}: {i} {j}: {p} for {product}");
            }
        }
    }
}

/// From a state that is known exactly the errors are those of the step alone: here 3 w Q = 3 * 2 * 0.5 for the latents, 0.3^2 for
/// the input, and (0.5 * 2 mm)^2 + 0.5^2 (3^2 + 4^2) mm2 for the cross-axis slosh.
#[test]
fn a_known_state_is_left_with_the_noise_of_one_step() {
    let config = FilterConfig {
        input_noise_std: 0.3,
        lateral_noise_std: 0.5,
        lateral_noise_share: 0.5,
        ..FilterConfig::REFERENCE
    };
    let mut model = model(config);
    model.error_model.process = SMatrix::identity() * 0.5;
    model.error_model.factors.weight_floor = 0.25;
    model.cross_axis.kick_m = 2e-3;
    let mut filter = filter(&config, StateMatrix::zeros());
    (filter.lateral_mm, filter.process_noise_scale) = ([3.0, -4.0], 3.0);
    close(filter.lateral(&model).noise, 7.25e-6);
    filter.predict::<f64>(&model, 1.75);
    for i in 0..STATES {
        for j in 0..STATES {
            let due = match (i == j, StateIndex::at(i)) {
                (true, None) => 3.0,
                (true, Some(StateIndex::Input)) => 0.09,
                (true, Some(StateIndex::Lateral)) => 7.25,
                _ => 0.0,
            };
            close(filter.covariance.at(i, j), due);
        }
    }
}

/// The cross-axis slosh and its errors in SI units: mm, mm2 and mm by latent.
#[test]
fn the_cross_axis_slosh_is_given_in_metres() {
    let config = steady();
    let model = model(config);
    let (y, before) = (StateIndex::Lateral.index(), StateIndex::LateralLag.index());
    let mut p = StateMatrix::zeros();
    (p[(y, y)], p[(before, before)]) = (4.0, 9.0);
    (p[(y, before)], p[(before, y)], p[(2, y)], p[(y, 2)]) = (-1.0, -1.0, 5.0, 5.0);
    let filter = Filter { lateral_mm: [2.0, -3.0], ..filter(&config, p) };
    close(filter.lateral_m(), 2e-3);
    let state = filter.lateral(&model);
    state.amplitude_m.into_iter().zip([2e-3, -3e-3]).for_each(|(m, due)| close(m, due));
    let [[yy, yz], [zy, zz]] = state.covariance.data.0;
    [(yy, 4e-6), (yz, -1e-6), (zy, -1e-6), (zz, 9e-6)].into_iter().for_each(|(m2, due)| close(m2, due));
    (0..LATENTS).for_each(|i| close(state.latent_covariance[i], if i == 2 { 5e-3 } else { 0.0 }));
}

#[test]
fn the_errors_of_latents_and_input_are_those_of_the_state() {
    let config = steady();
    let p = correlated(2.0);
    let filter = Filter { process_noise_scale: 1.25, ..filter(&config, p) };
    assert_eq!(filter.latents_and_input(), p.fixed_view::<{ LATENTS + 1 }, { LATENTS + 1 }>(0, 0));
    let part = filter.covariance();
    assert_eq!(part.latents, p.fixed_view::<LATENTS, LATENTS>(0, 0));
    assert_eq!((part.input, part.process_noise_scale), (4.0, 1.25));
}

/// Standard deviations of the settings, squared by hand.
#[test]
fn a_filter_begins_with_the_prior_of_its_model_and_no_other() {
    let config = FilterConfig {
        input_prior_std: 3.0,
        lateral_prior_mm: 5.0,
        travel_prior_mm: 7.0,
        position_prior_mm: 11.0,
        measured_input_std: 0.2,
        ..FilterConfig::REFERENCE
    };
    let variances = |filter: &Filter| StateIndex::ALL.map(|index| filter.covariance.between(index, index));
    let mut primed = Filter::default();
    primed.prime(&config);
    assert_eq!(variances(&primed), [9.0, 9.0, 9.0, 49.0, 121.0, 25.0, 25.0]);
    primed.prime(&FilterConfig::REFERENCE);
    assert_eq!(variances(&primed), [9.0, 9.0, 9.0, 49.0, 121.0, 25.0, 25.0], "a prior is given once");

    // A known input: its error is that of the sensor, and of no other number's making.
    let mut known = filter(&config, correlated(2.0));
    known.set_known_input(&config, -0.5);
    assert_eq!(known.input(), -0.5);
    let index = StateIndex::Input.index();
    (0..STATES).for_each(|j| close(known.covariance.at(index, j), if j == index { 0.04 } else { 0.0 }));

    // A position that is forgotten, and no other number.
    let mut lost = Filter { glass_mm: [1.0, 2.0], ..filter(&config, correlated(2.0)) };
    lost.reset_position(&config);
    assert_eq!((lost.glass_mm, variances(&lost)), ([0.0; 2], [4.0, 4.0, 4.0, 49.0, 121.0, 4.0, 4.0]));
    let of = |i: StateIndex, j: StateIndex| lost.covariance.between(i, j);
    assert_eq!(of(StateIndex::GlassTravel, StateIndex::GlassPosition), 0.0);
    assert_eq!(of(StateIndex::Input, StateIndex::InputLag1), correlated(2.0)[(0, 1)]);
}

#[test]
fn an_input_stays_within_the_limit_of_the_port() {
    let mut filter = Filter::new(&steady());
    let mut latent = Latent::repeat(1.0);
    let step = StateVector::from_fn(|i, _| if i == StateIndex::InputLag1.index() { -1e3 } else { 1e3 });
    filter.shift(&mut latent, &step);
    assert_eq!(filter.input, [PORT_LIMIT, -PORT_LIMIT, PORT_LIMIT]);
    assert_eq!((latent, filter.glass_mm, filter.lateral_mm), (Latent::repeat(1001.0), [1e3; 2], [1e3; 2]));
}
