"""Recordings against an independent reader: the reference `safetensors` library and numpy."""

from __future__ import annotations

import gc
import json
from pathlib import Path

import numpy as np
import pytest
from conftest import ROOT, same_bits
from safetensors import safe_open
from safetensors.numpy import load_file

import meniscus_liquid as ml

GROUPS = {"q": 3, "v": 3, "e": 1, "sigma": 3, "tau": 3}
SHIPPED = ROOT / "recordings" / "glycerine-unseen.safetensors"


def test_a_compact_recording_is_expanded_as_its_format_says(shipped: ml.Recording) -> None:
    file = load_file(SHIPPED)
    assert shipped.is_compact and shipped.frames == len(file["glass_x_m"]) == 600
    start = 0
    frames = [0, 1, 299, 599]
    for name, components in GROUPS.items():
        width = components * 2134
        modes = np.concatenate(
            [file[f"{name}.strong"].astype(np.float32), file[f"{name}.weak"].astype(np.float32) / np.float32(127)]
        )
        coefficients = file[f"{name}.coefficients"].astype(np.float32) * file[f"{name}.scale"]
        expected = np.tile(file["reference"][start : start + width], (len(frames), 1))
        # One product at a time and in this order, as single precision rounds each.
        for k, mode in enumerate(modes):
            expected += coefficients[frames, k, None] * mode
        field = shipped.field(name)
        assert field.shape == (600, 2134, components)
        assert same_bits(field[frames].reshape(len(frames), width), expected), name
        start += width
    assert same_bits(shipped.states[frames, : 3 * 2134], shipped.field("q")[frames].reshape(len(frames), -1))


def test_the_command_s_file_has_the_same_numbers(water: Path) -> None:
    recording, file = ml.Recording.load(water), load_file(water)
    assert not recording.is_compact and recording.truncation is None
    for name in ("glass_x_m", "acceleration_m_s2", "glass_y_m", "column_m", "wall_m", "profile_m", "spilled_m3"):
        assert same_bits(getattr(recording, name), file[name]), name
    assert same_bits(recording.states, file["state"])
    energy = recording.energy_j
    assert same_bits(np.stack([energy[k] for k in ("kinetic", "potential", "internal", "work")], 1), file["energy_j"])
    with safe_open(water, "numpy") as opened:
        metadata = opened.metadata()
    assert recording.provenance == json.loads(metadata["provenance"])
    assert recording.known == json.loads(metadata["known"])
    glass = json.loads(metadata["glass"])
    assert (recording.glass.radius_m, recording.glass.fill_m) == (glass["radius_m"], glass["fill_m"])


def test_what_is_saved_is_the_same_file_and_the_reference_library_reads_it(water: Path, tmp_path: Path) -> None:
    again = tmp_path / "again.safetensors"
    recording = ml.Recording.load(water)
    recording.save(again)
    assert again.read_bytes() == water.read_bytes()
    compact = tmp_path / "compact.safetensors"
    recording.compact(0.01).save(compact)
    assert load_file(compact)["q.strong"].dtype == np.float16
    assert compact.stat().st_size < again.stat().st_size / 4
    loaded = ml.Recording.load(compact)
    truncation = loaded.truncation
    assert truncation is not None
    for name in GROUPS:
        # The stated error is the one that was measured after all rounding.
        rest = recording.field(name)[0].astype(float)
        error = np.linalg.norm(loaded.field(name) - recording.field(name).astype(float))
        assert error / np.linalg.norm(recording.field(name) - rest) == pytest.approx(truncation[name], rel=1e-3)


def test_the_command_reads_what_python_writes(program, water: Path, tmp_path: Path) -> None:
    recording = ml.Recording.load(water)
    path = tmp_path / "arrays.safetensors"
    ml.Recording.from_arrays(
        recording.glass,
        "glycerine",
        1261.0,
        recording.glass_x_m,
        recording.column_m,
        recording.wall_m,
        recording.profile_m,
        states=recording.states,
        acceleration_m_s2=recording.acceleration_m_s2,
    ).save(path)
    report = program.json("run", "--patient", "--seconds", "1.5", "--source", path, "--out", tmp_path / "out")
    assert any(check["name"] == "surface_slosh_rel" or "surface" in check["name"] for check in report["checks"])
    # The second difference of the position is what the simulator averages the acceleration to.
    made = ml.Recording.from_arrays(
        recording.glass, "water", 998.0, recording.glass_x_m, recording.column_m, recording.wall_m, recording.profile_m
    )
    assert made.known == ["surface"]
    # The recording ends in rest, but for rounding of positions over the square of the interval.
    np.testing.assert_allclose(made.acceleration_m_s2, recording.acceleration_m_s2, atol=1e-9)


def test_arrays_are_views_that_outlive_the_recording_and_cannot_be_written(water: Path) -> None:
    recording = ml.Recording.load(water)
    column, states, velocity = recording.column_m, recording.states, recording.field("v")
    assert column.base is recording and not column.flags.owndata
    assert np.shares_memory(states, velocity)
    for array in (column, states, velocity):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 0.0
        with pytest.raises(ValueError):
            array.flags.writeable = True
    before = velocity[-1].copy()
    del recording, states, column
    gc.collect()
    assert same_bits(velocity[-1], before)


def test_bad_files_are_refused_in_the_program_s_words(tmp_path: Path, water: Path) -> None:
    with pytest.raises(OSError, match="No such file"):
        ml.Recording.load(tmp_path / "nothing.safetensors")
    text = tmp_path / "text.safetensors"
    text.write_text("not tensors")
    with pytest.raises(ml.MeniscusError, match="text.safetensors: not a recording: its header would have"):
        ml.Recording.load(text)
    cut = tmp_path / "cut.safetensors"
    cut.write_bytes(water.read_bytes()[:-100])
    with pytest.raises(ml.MeniscusError, match="cut.safetensors is not a recording"):
        ml.Recording.load(cut)
    recording = ml.Recording.load(water)
    with pytest.raises(ml.MeniscusError, match="exists already.*overwrite=True"):
        recording.save(text)
    recording.save(text, overwrite=True)
    assert text.read_bytes() == water.read_bytes()
    with pytest.raises(ml.MeniscusError, match="no field is called 'speed': take one of q, v, e, sigma, tau"):
        recording.field("speed")  # type: ignore[arg-type]
    with pytest.raises(ml.MeniscusError, match="tolerance = 2 is out of range"):
        recording.compact(2.0)
    args = [recording.glass_x_m, recording.column_m, recording.wall_m, recording.profile_m]
    with pytest.raises(ml.MeniscusError, match="wall_m is 120 x 194: 120 frames need 120 x 72"):
        ml.Recording.from_arrays(recording.glass, "water", 998.0, args[0], args[1], args[1], args[3])
    broken = recording.column_m.copy()
    broken[3, 5] = np.nan
    with pytest.raises(ml.MeniscusError, match=r"column_m\[3, 5\] is NaN"):
        ml.Recording.from_arrays(recording.glass, "water", 998.0, args[0], broken, args[2], args[3])


def test_a_field_of_another_liquid_is_refused(water: Path) -> None:
    recording = ml.Recording.load(water)
    known = ml.Recording.from_arrays(
        recording.glass,
        "water",
        998.0,
        recording.glass_x_m,
        recording.column_m,
        recording.wall_m,
        recording.profile_m,
        states=recording.states,
        known=("q", "surface"),
    )
    assert known.field("q").shape == (120, 2134, 3)
    with pytest.raises(ml.MeniscusError, match="field 'v' is not known.*known are q, surface"):
        known.field("v")
