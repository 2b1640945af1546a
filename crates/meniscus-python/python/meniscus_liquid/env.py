"""Gymnasium environment: carry a glass along a line without spilling (needs ``gymnasium``).

The liquid is that of the reduced slosh model, four steps of 1/240 s for each action, so an episode of ten seconds takes milliseconds.
The reduced model knows the first waves and their second order, no breaking crest: a spill is the surface at the wall above the rim.
"""

from __future__ import annotations

from typing import Any

import gymnasium
import numpy as np
from gymnasium import spaces

from ._native import MeniscusError, ReducedModel, ReducedState

__all__ = ["CarryGlass"]

_WALL = np.linspace(0.0, 2.0 * np.pi, 72, endpoint=False)
_SUBSTEPS = 4


class CarryGlass(gymnasium.Env[np.ndarray, np.ndarray]):
    """Carry a glass from rest to rest over a distance, as fast as it goes without a spill.

    Action: the acceleration along x as a share of ``max_acceleration_m_s2``, [1], -1 to 1, held for 1/60 s.

    Observation, [7], float32: distance to the goal (m), speed of the glass (m/s), height of the first wave along x at the wall (m) and its
    rate (m/s), highest and lowest point of the surface at the wall over rest (m), free height below the rim (m).

    Reward: progress towards the goal in metres over the distance, less 1/600 for every step; 1 more on arrival, 1 less for a spill.
    An episode ends on arrival (within 1 mm, below 5 mm/s), on a spill, and when the glass leaves the table (10 cm beyond either end).
    It is cut after ``max_steps``.

    Args:
        liquid: Name or path of a liquid, as ``Liquid`` takes it.
        distance_m: Distance between the start and the goal; with ``random_distance`` the largest, and 0.2 of it the least.
        radius_m, fill_m, rim_m: The glass.
        effects: Effects that are on, as in ``effects()``.
        max_acceleration_m_s2, max_steps: Limits.
        random_distance: Whether ``reset`` draws a distance.

    Example:
        >>> from meniscus_liquid.env import CarryGlass
        >>> env = CarryGlass("water", distance_m=0.5)
        >>> observation, _ = env.reset(seed=1)
        >>> observation.shape
        (7,)
    """

    metadata: dict[str, Any] = {"render_modes": [], "render_fps": 60}

    def __init__(
        self,
        liquid: str = "glycerine",
        *,
        distance_m: float = 0.5,
        radius_m: float = 0.035,
        fill_m: float = 0.07,
        rim_m: float = 0.11,
        effects: dict[str, float] | None = None,
        max_acceleration_m_s2: float = 5.0,
        max_steps: int = 600,
        random_distance: bool = False,
    ) -> None:
        if not 0.01 <= distance_m <= 100.0:
            raise MeniscusError(f"distance_m = {distance_m} is out of range: 0.01 to 100")
        if not fill_m < rim_m:
            raise MeniscusError(f"rim_m = {rim_m} is not above fill_m = {fill_m}: there is no room for a slosh")
        if not 0.0 < max_acceleration_m_s2 <= 50.0:
            raise MeniscusError(f"max_acceleration_m_s2 = {max_acceleration_m_s2} is out of range: above 0 to 50")
        self._model = ReducedModel(liquid, radius_m=radius_m, depth_m=fill_m, effects=effects, dt_s=1.0 / 240.0)
        self._room_m = rim_m - self._model.depth_m
        self._farthest_m = distance_m
        self._random_distance = random_distance
        self._max_acceleration = max_acceleration_m_s2
        self._max_steps = max_steps
        self.action_space = spaces.Box(-1.0, 1.0, (1,), np.float32)
        high = np.array([np.inf] * 7, np.float32)
        self.observation_space = spaces.Box(-high, high, (7,), np.float32)
        self._start()

    def _start(self) -> None:
        self._state = ReducedState()
        self._x = self._v = self._a = 0.0
        self._goal = self._farthest_m
        self._steps = 0

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[np.ndarray, dict[str, Any]]:
        """Puts the glass back to the start, at rest; with ``random_distance`` draws a goal."""
        super().reset(seed=seed)
        self._start()
        if self._random_distance:
            self._goal = float(self.np_random.uniform(0.2, 1.0)) * self._farthest_m
        return self._observation(self._wall()), {}

    def _wall(self) -> np.ndarray:
        """Heights of the surface over rest around the wall, m, [72]."""
        return self._model.wall_m(self._state, _WALL, (self._a, 0.0))

    def _observation(self, wall_m: np.ndarray) -> np.ndarray:
        highest = float(wall_m.max())
        return np.array(
            [
                self._goal - self._x,
                self._v,
                self._state.height_m[0, 0],
                self._state.rate_m_s[0, 0],
                highest,
                float(wall_m.min()),
                self._room_m - highest,
            ],
            np.float32,
        )

    def step(self, action: np.ndarray) -> tuple[np.ndarray, float, bool, bool, dict[str, Any]]:
        """Holds an acceleration for 1/60 s."""
        self._a = float(np.clip(np.asarray(action, np.float64).reshape(-1)[0], -1.0, 1.0)) * self._max_acceleration
        before, spilled, highest = self._x, False, -np.inf
        for _ in range(_SUBSTEPS):
            dt = self._model.dt_s
            self._x += self._v * dt + 0.5 * self._a * dt * dt
            self._v += self._a * dt
            self._model.step(self._state, (self._a, 0.0))
            highest = max(highest, float(self._wall().max()))
        spilled = highest > self._room_m
        self._steps += 1
        arrived = not spilled and abs(self._goal - self._x) < 1e-3 and abs(self._v) < 5e-3
        lost = not -0.1 <= self._x <= self._goal + 0.1
        progress = (abs(self._goal - before) - abs(self._goal - self._x)) / self._goal
        reward = progress - 1.0 / 600.0 + float(arrived) - float(spilled)
        terminated = spilled or arrived or lost
        info = {"spilled": spilled, "arrived": arrived, "highest_m": highest}
        return self._observation(self._wall()), reward, terminated, self._steps >= self._max_steps, info


gymnasium.register(id="meniscus_liquid/CarryGlass-v0", entry_point="meniscus_liquid.env:CarryGlass")
