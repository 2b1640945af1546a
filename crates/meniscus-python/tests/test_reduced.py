"""The reduced model against textbook formulas and exact balances."""

from __future__ import annotations

import numpy as np
import pytest

import meniscus_liquid as ml


def test_frequencies_are_those_of_linear_theory() -> None:
    """Lamb 1932, article 257: w^2 = g k tanh kh, with k R the zeros of J1'."""
    radius, depth = 0.049, 0.078
    model = ml.ReducedModel("water", radius_m=radius, depth_m=depth)
    for n, zero in enumerate((1.8411837813, 5.3314427735, 8.5363163663)):
        k = zero / radius
        free = np.sqrt(9.80665 * k * np.tanh(k * depth)) / (2 * np.pi)
        # The boundary layers of water slow a wave by less than a per cent.
        assert model.frequency_hz(n) == pytest.approx(free, rel=0.012)
    with pytest.raises(ml.MeniscusError, match=r"there is no mode \(1,3\)"):
        model.frequency_hz(3)


def test_a_free_slosh_rings_at_the_stated_frequency_and_decay() -> None:
    model, state = ml.ReducedModel("water"), ml.ReducedState()
    state.set_height(0, 0, 1e-5)
    heights = model.run(state, np.zeros((2400, 2)))[:, 1]
    time = model.dt_s * np.arange(1, 2401)
    crossing = np.flatnonzero(np.diff(np.sign(heights)))
    exact = time[crossing] - heights[crossing] * model.dt_s / (heights[crossing + 1] - heights[crossing])
    period = 2 * np.mean(np.diff(exact))
    assert 1 / period == pytest.approx(model.frequency_hz(0), rel=2e-3)
    peaks = [i for i in range(1, 2399) if heights[i] > heights[i - 1] and heights[i] >= heights[i + 1]]
    slope = np.polyfit(time[peaks], np.log(heights[peaks]), 1)[0]
    assert -slope == pytest.approx(model.damping_1_s(0), rel=0.03)


def test_the_books_close_under_any_motion_and_heat_never_falls() -> None:
    generator = np.random.default_rng(3)
    model = ml.ReducedModel("gazpacho", effects={"surface_tension": 0.05, "contact_line": (0.02, 0.0005)})
    state, work = ml.ReducedState(), 0.0
    for push in generator.normal(0.0, 2.0, (500, 2)):
        before = state.heat_j
        balance = model.step(state, (push[0], push[1]))
        work += balance["work_j"]
        assert balance["heat_j"] >= 0.0 and state.heat_j >= before
    assert model.energy_j(state) + state.heat_j == pytest.approx(work, rel=1e-9)


def test_a_constant_acceleration_tilts_the_surface_by_its_angle() -> None:
    model = ml.ReducedModel("water")
    push = (0.5, 0.0)
    state = model.rest(push)
    # The liquid stays behind: dz/dx = -a/g. At the wall the kept modes and the rest make up the whole
    # plane, but for the boundary layers' shift of the frequency, which is in the stiffness.
    wall = model.wall_m(state, np.array([0.0, np.pi]), push)
    assert wall[0] / 0.035 == pytest.approx(-0.5 / 9.80665, rel=0.01)
    assert wall[0] == pytest.approx(-wall[1])
    edge = model.surface_m(state, np.array([[0.035, 0.0], [0.0, 0.02]]), push)
    assert edge == pytest.approx([wall[0], 0.0], abs=1e-12)
    velocity = model.velocity_m_s(state, np.array([[0.01, 0.0, 0.05]]))
    assert (velocity == 0).all()


def test_effects_change_what_they_name() -> None:
    plain, thick = ml.ReducedModel("water"), ml.ReducedModel("water", effects={"viscosity": 0.004})
    tense = ml.ReducedModel("water", effects={"surface_tension": 0.07})
    assert thick.damping_1_s() > 1.5 * plain.damping_1_s()
    assert tense.frequency_hz() > plain.frequency_hz()
    assert ml.ReducedModel("water", effects={"fill": 0.05}).depth_m == pytest.approx(0.05)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: ml.ReducedModel("water", radius_m=0.0), "radius_m = 0 is out of range"),
        (lambda: ml.ReducedModel("treacle"), "no liquid is called 'treacle'"),
        (lambda: ml.ReducedModel("water", effects={"surface_tension": -1.0}), "surface_tension = -1"),
        (lambda: ml.ReducedState().set_height(2, 0, 0.0), "no mode 0 along direction 2"),
        (lambda: ml.ReducedState().set_height(0, 0, np.nan), "height_m = NaN"),
        (lambda: ml.ReducedModel("water").step(ml.ReducedState(), (np.inf, 0.0)), "must be finite"),
        (lambda: ml.ReducedModel("water").run(ml.ReducedState(), np.zeros((3, 1))), "is 3 x 1"),
    ],
)
def test_bad_input_is_refused(call, message: str) -> None:
    with pytest.raises(ml.MeniscusError, match=message):
        call()
