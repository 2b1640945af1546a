"""Correction and evaluation from Python: the command's blobs and figures, bit for bit."""

from __future__ import annotations

from pathlib import Path

import pytest

import meniscus_liquid as ml


def short(program, path: Path, liquid: str, motion: str, seconds: float) -> Path:
    """A coarse recording of the command."""
    path.parent.mkdir(parents=True, exist_ok=True)
    program.run(
        "simulate", "--liquid", liquid, "--motion", motion, "--seconds", str(seconds), "--spacing-mm", "8.7", "--out", path
    )
    return path


@pytest.fixture(scope="module")
def two(program, tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    base = tmp_path_factory.mktemp("two")
    return [short(program, base / f"{n}.safetensors", "water", f"strokes:{n}x0.25", 1.5) for n in (1, 2)]


@pytest.fixture(scope="module")
def own(program, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The model's own liquid; shorter than the recording in the package, which takes longer to look at than to learn from."""
    return short(program, tmp_path_factory.mktemp("own") / "own.safetensors", "glycerine", "strokes:3", 1.5)


def test_a_correction_is_that_of_the_command_to_the_bit(program, two: list[Path], own: Path, tmp_path: Path) -> None:
    said = program.json(
        "correct", "--recordings", *two, "--source", own, "--steps", 20, "--seed", 3, "--out", tmp_path / "command.blob"
    )
    mine = ml.correct([ml.Recording.load(path) for path in two], source=[ml.Recording.load(own)], steps=20, seed=3)
    assert mine.improved and mine.checks == said["checks"]
    assert [list(look) for look in mine.looks] == said["looks"]
    model = mine.model
    assert bytes(model) == (tmp_path / "command.blob").read_bytes()
    assert sorted(model.known) == sorted(said["known"])
    assert model.liquid == "water from glycerine" and "sigma" not in model.known


def test_profiles_are_learnt_from_as_recordings_are(two: list[Path], own: Path) -> None:
    recordings, source = [ml.Recording.load(path) for path in two], [ml.Recording.load(own)]
    with pytest.raises(ml.MeniscusError, match="profiles do not name their liquid"):
        ml.correct([recording.observe(seed=1) for recording in recordings], steps=10)
    seen = ml.correct([recording.observe(seed=1) for recording in recordings], source=source, steps=5, liquid="mine")
    assert len(seen.checks) == 5 and seen.checks[0]["name"] == "held_before_forecast"


def test_arguments_are_refused_before_the_work(two: list[Path], tmp_path: Path) -> None:
    recording = ml.Recording.load(two[0])
    for change, words in [
        ({"steps": 0}, "steps = 0 is out of range"),
        ({"noise_px": 9.0}, "noise_px = 9 is out of range"),
        ({"forgetting": -1.0}, "forgetting = -1 is out of range"),
        ({"liquid": "water"}, "are for profiles"),
    ]:
        with pytest.raises(ml.MeniscusError, match=words):
            ml.correct([recording], **change)
    with pytest.raises(ml.MeniscusError, match="recordings is empty"):
        ml.correct([])
    with pytest.raises(ml.MeniscusError, match="no liquid of the study is called 'tar'"):
        ml.evaluate(recordings=tmp_path, liquids=["tar"])
