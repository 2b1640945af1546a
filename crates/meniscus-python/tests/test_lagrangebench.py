"""Particles in LagrangeBench's layout, read by h5py and by LagrangeBench's own reader."""

from __future__ import annotations

import importlib.util
import json
import sys
import types
from pathlib import Path

import numpy as np
import pytest
from conftest import same_bits

import meniscus_liquid as ml

h5py = pytest.importorskip("h5py")

from meniscus_liquid.hdf5 import Trajectory, write_lagrangebench  # noqa: E402
from safetensors.numpy import load_file, save_file  # noqa: E402

FRAMES = 90


def moved(folder: Path, motion: str, seconds: float, **more) -> Trajectory:
    """A simulation with its particles."""
    file = folder / f"{motion.replace(':', '-')}-{seconds}.particles.safetensors"
    return Trajectory(ml.simulate(motion, seconds=seconds, **{"spacing_mm": 8.7, **more}, particles=file), file)


@pytest.fixture(scope="module")
def jolts(tmp_path_factory: pytest.TempPathFactory) -> Trajectory:
    return moved(tmp_path_factory.mktemp("jolts"), "jolts:1x0.3", FRAMES / 60)


@pytest.fixture(scope="module")
def still(tmp_path_factory: pytest.TempPathFactory) -> Trajectory:
    return moved(tmp_path_factory.mktemp("still"), "still", 0.2)


def in_the_box(trajectory: Trajectory, folder: Path) -> np.ndarray:
    """Positions as the data set in `folder` has them."""
    offset = json.loads((folder / "metadata.json").read_text())["offset_m"]
    return (load_file(trajectory.particles)["position_m"].astype(np.float64) + offset).astype(np.float32)


def test_the_particles_are_the_command_s(program, jolts: Trajectory, tmp_path: Path) -> None:
    recording = tmp_path / "jolts.safetensors"
    program.run(
        "simulate", "--motion", "jolts:1x0.3", "--seconds", FRAMES / 60, "--spacing-mm", "8.7", "--particles", "--out", recording
    )
    mine, command_s = load_file(jolts.particles), load_file(tmp_path / "jolts.particles.safetensors")
    assert sorted(mine) == sorted(command_s) == ["heat_j_kg", "mass_kg", "position_m", "pressure_pa", "velocity_m_s"]
    for name, values in mine.items():
        assert same_bits(values, command_s[name]), name
    with pytest.raises(ml.MeniscusError, match="exists already"):
        ml.simulate("still", seconds=0.1, spacing_mm=8.7, particles=jolts.particles)


def lagrangebench_reader(monkeypatch: pytest.MonkeyPatch) -> type:
    """The reader of LagrangeBench's own package, its file alone.

    The package needs torch and jax, gigabytes that the reader uses for a base class, an array and a cumulative sum: here they are an empty
    class and numpy's.
    """
    from importlib.metadata import distribution

    torch, data, jax, utils = (types.ModuleType(name) for name in ("torch", "torch.utils.data", "jax", "lagrangebench.utils"))
    data.Dataset = object
    utils.NodeType = type("NodeType", (), {"PAD_VALUE": -1})
    jax.numpy = np
    stand_ins = {"torch": torch, "torch.utils": types.ModuleType("torch.utils"), "torch.utils.data": data, "jax": jax, "jax.numpy": np,
                 "lagrangebench": types.ModuleType("lagrangebench"), "lagrangebench.utils": utils}
    for name, module in stand_ins.items():
        monkeypatch.setitem(sys.modules, name, module)
    file = distribution("lagrangebench").locate_file("lagrangebench/data/data.py")
    spec = importlib.util.spec_from_file_location("lagrangebench_data", file)
    reader = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(reader)
    return reader.H5Dataset


def test_lagrangebench_s_own_reader_reads_it(jolts: Trajectory, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder = tmp_path / "h5"
    write_lagrangebench(folder, {"train": [jolts, jolts], "valid": [jolts], "test": [jolts]})
    reader = lagrangebench_reader(monkeypatch)
    position = in_the_box(jolts, folder)
    count = position.shape[1]
    windows = reader("train", str(folder), input_seq_length=6)
    # Six positions, one to predict, and one of two trajectories.
    assert len(windows) == 2 * (FRAMES - 6 - 1)
    for index, frame in ((0, 0), (17, 17), (FRAMES - 7, 0), (2 * (FRAMES - 7) - 1, FRAMES - 8)):
        window, kinds = windows[index]
        assert same_bits(np.ascontiguousarray(window), np.ascontiguousarray(position[frame : frame + 7].transpose(1, 0, 2)))
        assert kinds.shape == (count,) and (kinds == 0).all()
    whole = reader("valid", str(folder), is_rollout=True, split_valid_traj_into_n=3, nl_backend="matscipy")
    assert len(whole) == 3
    part, kinds = whole[2]
    # Padded to the largest number of particles, which is that of every recording.
    assert same_bits(np.ascontiguousarray(part), np.ascontiguousarray(position[60:90].transpose(1, 0, 2)))
    assert len(kinds) == windows.metadata["num_particles_max"]


def test_a_split_has_the_length_of_its_shortest_recording(jolts: Trajectory, still: Trajectory, tmp_path: Path) -> None:
    folder = tmp_path / "h5"
    write_lagrangebench(folder, {"train": [jolts, still], "valid": [jolts], "test": [still]})
    with h5py.File(folder / "train.h5") as file:
        assert [len(file[f"0000{number}/position"]) for number in (0, 1)] == [12, 12]
        assert same_bits(file["00000/position"][...], in_the_box(jolts, folder)[:12])
        assert same_bits(file["00000/acceleration"][:, 0], jolts.recording.acceleration_m_s2[:12])
    metadata = json.loads((folder / "metadata.json").read_text())
    assert metadata["sequence_length_train"] == 12 and metadata["sequence_length_test"] == 12


def test_h5py_reads_the_layout_and_its_statistics(jolts: Trajectory, tmp_path: Path) -> None:
    folder = tmp_path / "h5"
    write_lagrangebench(folder, {"train": [jolts, jolts], "valid": [jolts], "test": [jolts]})
    position = load_file(jolts.particles)["position_m"].astype(float)
    with h5py.File(folder / "train.h5") as file:
        assert sorted(file) == ["00000", "00001"]
        written = file["00001/position"]
        assert written.shape == position.shape and written.dtype == np.float32
        assert same_bits(written[...], in_the_box(jolts, folder))
        kinds = file["00000/particle_type"]
        assert kinds.shape == (position.shape[1],) and kinds.dtype == np.int64 and (kinds[...] == 0).all()
    metadata = json.loads((folder / "metadata.json").read_text())
    steps = np.diff(position, axis=0)
    # Shifted positions have rounding of their own, up to 4e-9 m.
    np.testing.assert_allclose(metadata["vel_mean"], steps.mean((0, 1)), atol=1e-8)
    np.testing.assert_allclose(metadata["vel_std"], steps.std((0, 1)), rtol=1e-4)
    np.testing.assert_allclose(metadata["acc_std"], np.diff(steps, axis=0).std((0, 1)), rtol=1e-2)
    # A learner divides by these. The tracers of a recording, which move up and down alone, have zeros.
    assert min(metadata["vel_std"] + metadata["acc_std"]) > 1e-8
    low, high = np.array(metadata["bounds"]).T
    # The neighbour search cuts a box from zero on into cells, the upper faces not included.
    assert (low == 0.0).all() and (in_the_box(jolts, folder) >= 0.0).all()
    assert (in_the_box(jolts, folder) < high.astype(np.float32)).all()
    assert metadata["dim"] == 3 and metadata["num_particles_max"] == position.shape[1] and metadata["sequence_length_train"] == FRAMES


def test_what_does_not_belong_together_is_refused_by_name(jolts: Trajectory, still: Trajectory, tmp_path: Path) -> None:
    def refused(match: str, error: type[Exception] = ml.MeniscusError, **splits: list[Trajectory]) -> None:
        with pytest.raises(error, match=match):
            write_lagrangebench(tmp_path / "new", {"train": [jolts], "valid": [jolts], "test": [jolts], **splits})
        assert not (tmp_path / "new").exists()

    (tmp_path / "full").mkdir()
    (tmp_path / "full/x").write_text("")
    with pytest.raises(ml.MeniscusError, match="is not empty"):
        write_lagrangebench(tmp_path / "full", {"train": [jolts], "valid": [jolts], "test": [jolts]})
    with pytest.raises(ml.MeniscusError, match="give train, valid and test"):
        write_lagrangebench(tmp_path / "new", {"train": [jolts]})
    refused("has no recording", valid=[])
    refused("of another glass or liquid", valid=[moved(tmp_path, "still", 0.1, liquid="water")])
    refused("simulate with one spacing", valid=[moved(tmp_path, "still", 0.15, spacing_mm=7.0)])
    refused("give what belongs together", valid=[Trajectory(jolts.recording, still.particles)])
    refused("No such file", FileNotFoundError, valid=[Trajectory(jolts.recording, tmp_path / "absent")])
    text = tmp_path / "text.safetensors"
    text.write_text("no particles")
    refused("holds no particles", valid=[Trajectory(jolts.recording, text)])
    tensors = dict(load_file(jolts.particles))
    tensors["position_m"] = tensors["position_m"].copy()
    tensors["position_m"][40:, 7] = np.nan
    save_file(tensors, tmp_path / "gone.safetensors")
    refused("particle 7 of .* is over the rim in frame 40", valid=[Trajectory(jolts.recording, tmp_path / "gone.safetensors")])
