"""The simulator from Python: the command's file to the bit, its messages, progress, and Ctrl-C."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import numpy as np
import pytest

import meniscus_liquid as ml


def test_a_simulation_is_the_command_s_to_the_bit(water: Path, tmp_path: Path) -> None:
    steps: list[tuple[str, float]] = []
    recording = ml.simulate(
        "jolts:1x0.2",
        seconds=2.0,
        liquid="water",
        spacing_mm=8.7,
        threads=1,
        progress=lambda step, done: steps.append((step, done)),
    )
    path = tmp_path / "python.safetensors"
    recording.save(path)
    assert path.read_bytes() == water.read_bytes()
    assert steps[0] == ("settling", 0.0) and steps[-1] == ("simulating", 1.0)
    assert len(steps) == 121


def test_scenes_effects_and_made_up_motions_are_the_command_s(program, tmp_path: Path) -> None:
    scene = tmp_path / "scene.toml"
    scene.write_text("liquid = 'honey'\nspacing_mm = 8.7\n[glass]\nfill_m = 0.05\n[effects]\nsurface_tension = 0.055\n")
    csv = tmp_path / "motion.csv"
    time_s = np.linspace(0.0, 0.6, 31)
    x_m = 0.01 * (1.0 - np.cos(np.pi * time_s / 0.6))
    csv.write_text("t, x_m\n" + "".join(f"{t!r}, {x!r}\n" for t, x in zip(time_s.tolist(), x_m.tolist())))
    out = tmp_path / "command.safetensors"
    program.run(
        "simulate", "--scene", scene, "--motion", csv, "--seconds", "0.5", "--effect", "foam=0.1", "--out", out
    )
    recording = ml.simulate(str(csv), seconds=0.5, scene=ml.Scene(scene), effects={"foam": 0.1})
    mine = tmp_path / "python.safetensors"
    recording.save(mine)
    assert mine.read_bytes() == out.read_bytes()
    sampled = ml.simulate(
        ml.Motion.sampled(time_s, x_m), seconds=0.5, scene=ml.Scene(scene), effects={"foam": 0.1}
    )
    assert np.array_equal(sampled.states, recording.states)
    assert "sampled" in sampled.provenance["command"] or "samples" in sampled.provenance["command"]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"motion": "strike:1"}, "no motion is called|strike:1"),
        ({"motion": "strokes:1", "seconds": 0.0}, "seconds = 0 is out of range: 0.1 to 600"),
        ({"motion": "strokes:1", "liquid": "treacle"}, "no liquid is called 'treacle': take one of glycerine, water"),
        ({"motion": "strokes:1", "effects": {"ghosts": 1.0}}, "no effect is called 'ghosts'"),
        ({"motion": "strokes:1", "effects": {"surface_tension": "much"}}, "must be a number"),
        ({"motion": "strokes:1", "effects": {"camera_pitch": 0.03}}, "camera_pitch is not simulated"),
        ({"motion": "strokes:1", "spacing_mm": 40.0}, "spacing"),
        ({}, "give a motion"),
    ],
)
def test_bad_input_is_refused_before_the_work(arguments: dict, message: str) -> None:
    begun = time.monotonic()
    with pytest.raises(ml.MeniscusError, match=message):
        ml.simulate(**arguments)
    assert time.monotonic() - begun < 1.0


def test_an_exception_of_the_callback_ends_the_simulation() -> None:
    def progress(step: str, done: float) -> None:
        raise RuntimeError(f"enough at {step}")

    begun = time.monotonic()
    with pytest.raises(RuntimeError, match="enough at settling"):
        ml.simulate("strokes:1", seconds=60.0, progress=progress)
    assert time.monotonic() - begun < 5.0


INTERRUPTED = """
import meniscus_liquid as ml
try:
    ml.simulate("strokes:1", seconds=600.0, progress=lambda *_: print("begun", flush=True))
except KeyboardInterrupt:
    print("interrupted", flush=True)
"""


def test_ctrl_c_ends_a_simulation_also_while_it_settles() -> None:
    child = subprocess.Popen([sys.executable, "-c", INTERRUPTED], stdout=subprocess.PIPE, text=True)
    assert child.stdout is not None and child.stdout.readline() == "begun\n"
    os.kill(child.pid, signal.SIGINT)
    begun = time.monotonic()
    said, _ = child.communicate(timeout=60)
    assert said.splitlines()[-1] == "interrupted" and child.returncode == 0
    assert time.monotonic() - begun < 5.0


def test_other_threads_run_meanwhile() -> None:
    counted = 0
    stop = threading.Event()

    def count() -> None:
        nonlocal counted
        while not stop.is_set():
            counted += 1
            time.sleep(0.001)

    thread = threading.Thread(target=count)
    thread.start()
    begun = time.monotonic()
    try:
        ml.simulate("still", seconds=0.3, liquid="water", spacing_mm=8.7)
    finally:
        waited = time.monotonic() - begun
        stop.set()
        thread.join()
    # With the lock held it would be one count or two; a busy machine gives a thread a fifth of its turns at least.
    assert counted > 0.02 * waited / 0.001, f"{counted} in {waited:.2f} s"


def test_motions_and_liquids() -> None:
    motion = ml.Motion("strokes:7", seconds=4.0)
    t = np.linspace(0.5, 3.0, 2000)
    h = 1e-4
    second = (motion.position_m(t + h) - 2 * motion.position_m(t) + motion.position_m(t - h)) / h**2
    np.testing.assert_allclose(motion.acceleration_m_s2(t), second, atol=0.1)
    assert "honey" in ml.liquids() and ml.Liquid("honey") == ml.Liquid("honey") != ml.Liquid("water")
    ketchup = ml.Liquid("ketchup")
    assert ketchup.yield_stress_pa > 0 and ketchup.viscosity_pa_s(1.0) > ketchup.viscosity_pa_s(100.0)
    names = {effect["name"] for effect in ml.effects()}
    assert {"surface_tension", "contact_line_reach", "camera_pitch"} <= names
    with pytest.raises(ml.MeniscusError, match="times that rise"):
        ml.Motion.sampled(np.array([0.0, 0.0]), np.array([0.0, 1.0]))
    with pytest.raises(ml.MeniscusError, match="x is not a liquid file"):
        ml.Liquid.parse("colour = 3", "x")
    assert ml.Glass(profile_m=[[0, 0], [0.02, 0.03], [0.06, 0.04]], fill_m=0.03).rim_m == 0.06
    with pytest.raises(ml.MeniscusError, match="it needs 3 to 32"):
        ml.Glass(profile_m=[[0, 0.1]])
