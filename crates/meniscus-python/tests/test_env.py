"""The environment against Gymnasium's own checker, and its physics."""

from __future__ import annotations

import numpy as np
import pytest

gymnasium = pytest.importorskip("gymnasium")

from gymnasium.utils.env_checker import check_env

import meniscus_liquid as ml
from meniscus_liquid.env import CarryGlass


@pytest.mark.filterwarnings("ignore::UserWarning")
def test_gymnasium_accepts_it() -> None:
    check_env(CarryGlass("water", random_distance=True), skip_render_check=True)
    made = gymnasium.make("meniscus_liquid/CarryGlass-v0", liquid="honey")
    made.reset(seed=1)
    made.close()


def carry(acceleration: float) -> tuple[dict, int]:
    """Half the way forward and half back at one acceleration; then nothing."""
    env = CarryGlass("water", distance_m=0.5)
    observation, _ = env.reset(seed=0)
    half = round(60 * np.sqrt(0.5 / acceleration))
    acceleration = 0.5 / (half / 60.0) ** 2
    for step in range(600):
        share = acceleration / 5.0 * (1.0 if step < half else -1.0 if step < 2 * half else 0.0)
        observation, _, terminated, truncated, info = env.step(np.array([share], np.float32))
        if terminated or truncated:
            return info, step + 1
    raise AssertionError("the episode does not end")


def test_a_gentle_hand_arrives_and_a_rough_one_spills() -> None:
    info, steps = carry(0.5)
    assert info["arrived"] and not info["spilled"] and steps == pytest.approx(2 * 60 * np.sqrt(0.5 / 0.5), abs=2)
    info, steps = carry(5.0)
    assert info["spilled"] and not info["arrived"]


def test_seeds_draw_the_goal_and_nothing_else_is_random() -> None:
    env = CarryGlass("water", random_distance=True)
    one, _ = env.reset(seed=4)
    other, _ = env.reset(seed=5)
    again, _ = env.reset(seed=4)
    assert one[0] == again[0] != other[0] and 0.1 <= one[0] <= 0.5


def test_bad_input_is_refused() -> None:
    with pytest.raises(ml.MeniscusError, match="rim_m = 0.05 is not above"):
        CarryGlass(rim_m=0.05)
    with pytest.raises(ml.MeniscusError, match="distance_m = 0"):
        CarryGlass(distance_m=0)
