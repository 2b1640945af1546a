"""Discovery from Python: the command's verdict, number by number."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import meniscus_liquid as ml

LIQUID = "name = 'oil'\n[density_kg_m3]\nvalue = 1261.0\nsource = 'x'\n[viscosity_pa_s]\nvalue = {}\nsource = 'x'\n"


def folder(path: Path, viscosity: float, effects: dict[str, float], seed: int) -> None:
    """Four jolts of different strength in a glass of the reduced model, as its camera would see them, with 0.1 mm of noise."""
    path.mkdir(parents=True)
    path.joinpath("setup.toml").write_text(
        f"radius_m = 0.035\nfill_m = 0.07\ndensity_kg_m3 = 1261.0\nviscosity_pa_s = {viscosity}\n"
    )
    generator = np.random.default_rng(seed)
    model = ml.ReducedModel(ml.Liquid.parse(LIQUID.format(viscosity)), effects=effects)
    across = np.linspace(-0.9, 0.9, 21) * 0.035
    # The camera sees the contact line on the wall that faces it.
    line = np.stack([across, -np.sqrt(0.035**2 - across**2)], 1)
    for name, strength in zip("abcd", (0.6, 1.25, 2.2, 1.7)):
        t = np.linspace(0.0, 2.2, 265 * 2)
        phase = np.clip((t - 0.3) / 0.28, 0.0, 2.0)
        push = np.where((t > 0.3) & (phase < 2.0), strength * np.sin(np.pi * phase), 0.0)
        speed = np.concatenate([[0.0], np.cumsum(0.5 * (push[1:] + push[:-1]) * np.diff(t))])
        place = np.concatenate([[0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1]) * np.diff(t))])
        motion = ml.Motion.sampled(t, place)
        path.joinpath(f"{name}.motion.csv").write_text(
            "t, x_m\n" + "".join(f"{a!r}, {b!r}\n" for a, b in zip(t.tolist(), place.tolist()))
        )
        state, profiles = ml.ReducedState(), []
        for frame in range(132):
            now = np.array([frame / 60.0])
            heights = 0.07 + model.surface_m(state, line, (float(motion.acceleration_m_s2(now)[0]), 0.0))
            noisy = heights + generator.normal(0.0, 1e-4, 21)
            x = float(motion.position_m(now)[0]) + generator.normal(0.0, 1e-4)
            profiles.append(
                ml.Profile(noisy, 1e-4, glass_x_m=x, sequence=frame, captured_us=1_000_000 + round(frame / 60 * 1e6))
            )
            for step in range(4):
                middle = np.array([frame / 60.0 + (step + 0.5) / 240.0])
                model.step(state, (float(motion.acceleration_m_s2(middle)[0]), 0.0))
        ml.save_profiles(path / f"{name}.profile.csv", profiles)


@pytest.fixture(scope="module")
def glasses(tmp_path_factory: pytest.TempPathFactory) -> Path:
    base = tmp_path_factory.mktemp("glasses")
    folder(base / "mine", 0.2, {"yield_stress": 2.0}, 9)
    for i, viscosity in enumerate((0.17, 0.2, 0.235)):
        folder(base / "known" / str(i), viscosity, {}, 20 + i)
    return base


LIBRARY = ["viscosity", "yield_stress", "wall_slip", "surface_tension", "camera_latency"]


@pytest.fixture(scope="module")
def verdict(glasses: Path) -> ml.Verdict:
    return ml.discover(glasses / "mine", glasses / "known", library=LIBRARY)


def test_the_hidden_effect_is_identified_as_by_the_command(
    program, glasses: Path, verdict: ml.Verdict, tmp_path: Path
) -> None:
    assert (verdict.word, verdict.names) == ("named", ["yield_stress"]), verdict.sentence
    size = verdict.parameters[0]
    assert size["value"] == pytest.approx(2.0, abs=0.4) and size["unit"] == "Pa"
    said = program.json(
        "discover", "--recordings", glasses / "mine", "--reference", glasses / "known", "--quick",
        "--library", ",".join(LIBRARY), "--out", tmp_path / "command",
    )
    mine = verdict.report
    for report in (said, mine):
        # The command keeps its fits in a folder, which Python was not given.
        report.pop("fits")
    assert mine == said
    verdict.write(tmp_path / "python")
    for name in ("verdict.json", "scene.toml"):
        command, python = (tmp_path / side / name for side in ("command", "python"))
        if name.endswith("json"):
            a, b = json.loads(command.read_text()), json.loads(python.read_text())
            assert {k: v for k, v in a.items() if k != "fits"} == {k: v for k, v in b.items() if k != "fits"}
        else:
            assert command.read_text() == python.read_text()
    scene = ml.Scene.parse(verdict.scene_toml)
    assert scene.effects["yield_stress"] == pytest.approx(size["value"])
    assert "<svg" in verdict.html and "yield_stress" in verdict.html


def test_its_figure_marks_the_effect(verdict: ml.Verdict, tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    from meniscus_liquid.figures import verdict_figure

    figure = verdict_figure(verdict)
    ranking, gap = figure.axes
    assert any("yield_stress" in label.get_text() for label in ranking.get_yticklabels())
    heights = [bar.get_height() for bar in gap.patches]
    assert len(heights) == 4 and heights[3] < heights[0]
    figure.savefig(tmp_path / "verdict.png")


def test_bad_input_is_refused(glasses: Path, tmp_path: Path) -> None:
    with pytest.raises(ml.MeniscusError, match="setup.toml"):
        ml.discover(tmp_path)
    with pytest.raises(ml.MeniscusError, match="no effect is called 'stickiness'"):
        ml.discover(glasses / "mine", library=["stickiness"])
    with pytest.raises(ml.MeniscusError, match="need a folder for the simulations: give out"):
        ml.discover(glasses / "mine", quick=False)
    with pytest.raises(ml.MeniscusError, match="rivals = 9 is out of range: 0 to 4"):
        ml.discover(glasses / "mine", rivals=9)
