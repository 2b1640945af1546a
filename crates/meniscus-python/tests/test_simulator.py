"""A Python function as the simulator of a discovery: the command's numbers with the same program, and functions that are none."""

from __future__ import annotations

import importlib.util
import sys
import threading
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import meniscus_liquid as ml
from conftest import ROOT

SCRIPT = ROOT / "examples" / "one_mode.py"
LIBRARY = ["viscosity", "yield_stress"]


def load() -> Any:
    spec = importlib.util.spec_from_file_location("one_mode", SCRIPT)
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


one_mode = load()


@pytest.fixture(scope="module")
def mine(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Four jolts of a glass of the other simulator, with 0.1 mm of noise and a yield stress that a seed hides."""
    path = tmp_path_factory.mktemp("mine")
    generator = np.random.default_rng(31)
    hidden = generator.uniform(1.0, 2.5)
    path.joinpath("setup.toml").write_text("radius_m = 0.035\nfill_m = 0.07\ndensity_kg_m3 = 1261.0\nviscosity_pa_s = 0.2\n")
    path.joinpath("hidden").write_text(repr(hidden))
    across = np.linspace(-0.9, 0.9, 21) * 0.035
    scene = {
        "gravity_m_s2": 9.80665,
        "glass": {"radius_m": 0.035, "fill_m": 0.07},
        "liquid": {"density_kg_m3": 1261.0, "viscosity_pa_s": 0.2},
        "effects": {"yield_stress": hidden},
        "frame_interval_s": 1 / 60,
        "points_m": np.stack([across, -np.sqrt(0.035**2 - across**2)], 1),
        "motions": [],
    }
    t = np.arange(4 * 140) / 240.0
    s = np.clip((t - 0.4) / 0.28, 0.0, 1.0)
    for strength in (0.6, 1.25, 2.2, 1.7):
        push = strength * np.sin(2 * np.pi * s)
        place = strength * 0.28**2 / (2 * np.pi) * (s - np.sin(2 * np.pi * s) / (2 * np.pi))
        scene["motions"].append({"frames": 132, "time_s": t, "x_m": place, "acceleration_m_s2": push})
    for name, motion, heights in zip("abcd", scene["motions"], one_mode.simulate(scene)):
        profiles = [
            ml.Profile(row + generator.normal(0.0, 1e-4, 21), 1e-4, sequence=n, captured_us=1_000_000 + round(n / 60 * 1e6))
            for n, row in enumerate(np.array(heights))
        ]
        ml.save_profiles(path / f"{name}.profile.csv", profiles)
        rows = zip(motion["time_s"].tolist(), motion["x_m"].tolist())
        path.joinpath(f"{name}.motion.csv").write_text("t, x_m\n" + "".join(f"{a!r}, {b!r}\n" for a, b in rows))
    return path


def arrays(scene: dict[str, Any]) -> list[np.ndarray]:
    return [np.array(heights) for heights in one_mode.simulate(scene)]


def test_a_function_gives_the_numbers_of_the_same_program_as_a_command(program, mine: Path, tmp_path: Path) -> None:
    scenes: list[dict[str, Any]] = []

    def simulate(scene: dict[str, Any]) -> list[np.ndarray]:
        scenes.append(scene)
        return arrays(scene)

    verdict = ml.discover(mine, library=LIBRARY, out=tmp_path / "python", simulator=simulate, simulator_version="1")
    hidden = float(mine.joinpath("hidden").read_text())
    size = verdict.parameters[0]
    print(hidden, size)
    assert (verdict.word, verdict.names) == ("named", ["yield_stress"]), verdict.sentence
    assert size["by"] == "simulator" and size["value"] == pytest.approx(hidden, rel=0.03)
    scene = scenes[0]
    assert scene["meniscus_simulator"] == 1 and scene["glass"]["fill_m"] == 0.07
    motion = scene["motions"][0]
    assert isinstance(motion["x_m"], np.ndarray) and len(motion["time_s"]) == len(motion["acceleration_m_s2"])
    assert scene["points_m"].shape == (21, 2)
    said = program.json(
        "discover", "--recordings", mine, "--simulator", f"{sys.executable} {SCRIPT}", "--library", ",".join(LIBRARY),
        "--out", tmp_path / "command",
    )
    python = verdict.report
    assert "simulate" in python["simulator"].pop("program") and "one_mode.py" in said["simulator"].pop("program")
    assert python == said
    # What is kept under the version is not asked for again.
    asked = len(scenes)
    again = ml.discover(mine, library=LIBRARY, out=tmp_path / "python", simulator=simulate, simulator_version="1")
    assert len(scenes) == asked and again.parameters == verdict.parameters


class Mine(Exception):
    pass


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        (lambda heights: heights[:-1], "heights of . motions instead of"),
        (lambda heights: [h[:-1] for h in heights], "motion 1: it returned .* frames instead of"),
        (lambda heights: [h[:, :20] for h in heights], "20 heights instead of 21"),
        (lambda heights: [np.where(np.arange(21) == 4, np.nan, h) for h in heights], "frame 1, height 5 is NaN"),
        (lambda heights: [1e3 * h for h in heights], "far outside of the glass"),
        (lambda heights: [h - 0.07 for h in heights], "heights are metres above the inner bottom"),
    ],
)
def test_wrong_answers_are_refused(mine: Path, tmp_path: Path, wrong, words: str) -> None:
    with pytest.raises(ml.MeniscusError, match=words):
        ml.discover(mine, library=LIBRARY, out=tmp_path / "out", simulator=lambda scene: wrong(arrays(scene)))
    assert not (tmp_path / "out" / "verdict.json").exists()


def test_an_exception_comes_back_as_it_was_raised(mine: Path, tmp_path: Path) -> None:
    error = Mine("no licence")

    def raises(scene: dict[str, Any]) -> list[np.ndarray]:
        raise error

    with pytest.raises(Mine) as caught:
        ml.discover(mine, library=LIBRARY, out=tmp_path / "out", simulator=raises)
    assert caught.value is error and any(entry.name == "raises" for entry in caught.traceback)
    with pytest.raises(TypeError):
        ml.discover(mine, library=LIBRARY, out=tmp_path / "out", simulator=lambda scene: 3)
    with pytest.raises(TypeError, match="must be a function"):
        ml.discover(mine, library=LIBRARY, out=tmp_path / "out", simulator="one_mode")
    with pytest.raises(ml.MeniscusError, match="quick leaves all simulations out"):
        ml.discover(mine, quick=True, simulator=arrays)
    with pytest.raises(ml.MeniscusError, match="need a folder for the simulations: give out"):
        ml.discover(mine, simulator=arrays)


def test_a_glass_that_cannot_be_simulated_bounds_the_search(mine: Path, tmp_path: Path) -> None:
    def limited(scene: dict[str, Any]) -> list[np.ndarray]:
        if scene["effects"].get("yield_stress", 0.0) > 4.0:
            raise ml.SimulationError("it stands still")
        return arrays(scene)

    verdict = ml.discover(mine, library=["yield_stress"], out=tmp_path / "out", simulator=limited, rivals=0)
    hidden = float(mine.joinpath("hidden").read_text())
    assert verdict.parameters[0]["value"] == pytest.approx(hidden, rel=0.03)


def test_other_threads_go_on_while_a_function_waits(mine: Path, tmp_path: Path) -> None:
    ticks, done = [0], threading.Event()

    def tick() -> None:
        while not done.is_set():
            ticks[0] += 1
            time.sleep(0.005)

    thread = threading.Thread(target=tick)
    thread.start()

    def slow(scene: dict[str, Any]) -> list[np.ndarray]:
        time.sleep(0.5)
        raise Mine

    try:
        with pytest.raises(Mine):
            ml.discover(mine, library=LIBRARY, out=tmp_path / "out", simulator=slow)
    finally:
        done.set()
        thread.join()
    assert ticks[0] > 20
