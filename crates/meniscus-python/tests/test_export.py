"""Data out: VTK files read by VTK itself, and HDF5 by h5py and by LagrangeBench's own reader."""

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

pyvista = pytest.importorskip("pyvista")


def test_vtk_reads_tracers_and_surface_as_they_are(program, shipped: ml.Recording, tmp_path: Path) -> None:
    folder = tmp_path / "vtp"
    assert ml.export_vtp(shipped, folder, every=100) == 6
    reader = pyvista.get_reader(folder / "tracers.pvd")
    np.testing.assert_allclose(reader.time_values, shipped.time_s[::100])
    reader.set_active_time_value(reader.time_values[3])
    cloud = reader.read()[0]
    moved = shipped.field("q")[300] + np.array([shipped.glass_x_m[300], shipped.glass_y_m[300], 0.0])
    assert cloud.n_points == cloud.n_verts == 2134
    np.testing.assert_allclose(cloud.points, moved, atol=1e-7)
    assert float(cloud.field_data["TimeValue"][0]) == pytest.approx(5.0)
    names = {"v": "velocity_m_s", "e": "internal_energy_j_kg", "sigma": "normal_stress_pa", "tau": "shear_stress_pa"}
    assert set(cloud.point_data) == set(names.values())
    for group, name in names.items():
        assert same_bits(np.asarray(cloud.point_data[name]).reshape(2134, -1), shipped.field(group)[300]), name
    surface = pyvista.read(folder / "surface-0300.vtp")
    assert surface.n_points == 194 + 72 and surface.is_all_triangles
    edges = surface.extract_feature_edges(boundary_edges=True, non_manifold_edges=False, feature_edges=False, manifold_edges=False)
    assert edges.n_cells == 72
    assert same_bits(np.asarray(surface["height_m"]), np.concatenate([shipped.column_m[300], shipped.wall_m[300]]))
    # At rest the mesh is the disc of the glass, and VTK agrees on its area.
    flat = pyvista.read(folder / "surface-0000.vtp")
    assert flat.area == pytest.approx(np.pi * 0.035**2, rel=3e-3)
    # The command writes the same files.
    other = tmp_path / "command"
    recording = tmp_path / "shipped.safetensors"
    shipped.save(recording)
    program.run("export", recording, "--vtp", other, "--every", "100")
    mine = sorted(path.name for path in folder.iterdir())
    assert mine == sorted(path.name for path in other.iterdir()) and len(mine) == 14
    for name in mine:
        assert (folder / name).read_bytes() == (other / name).read_bytes(), name


def test_vtk_reads_particles(program, tmp_path: Path) -> None:
    recording, folder = tmp_path / "still.safetensors", tmp_path / "vtp"
    program.run(
        "simulate", "--motion", "still", "--seconds", "0.2", "--spacing-mm", "8.7", "--particles", "--out", recording
    )
    program.run("export", recording, "--vtp", folder)
    from safetensors.numpy import load_file

    file = load_file(tmp_path / "still.particles.safetensors")
    cloud = pyvista.get_reader(folder / "particles.pvd")
    assert len(cloud.time_values) == 12
    last = pyvista.read(folder / "particles-0011.vtp")
    np.testing.assert_allclose(last.points, file["position_m"][11], atol=1e-7)
    assert same_bits(np.asarray(last["pressure_pa"]), file["pressure_pa"][11])
    # Hydrostatic: the pressure falls with height by rho g.
    slope = np.polyfit(last.points[:, 2], last["pressure_pa"], 1)[0]
    assert slope == pytest.approx(-1261.0 * 9.80665, rel=0.05)


def test_a_folder_that_is_not_empty_is_refused(shipped: ml.Recording, tmp_path: Path) -> None:
    (tmp_path / "x").write_text("")
    with pytest.raises(ml.MeniscusError, match="is not empty: choose another folder"):
        ml.export_vtp(shipped, tmp_path)
    with pytest.raises(ml.MeniscusError, match="every = 0 is out of range"):
        ml.export_vtp(shipped, tmp_path / "new", every=0)


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


def test_lagrangebench_s_own_reader_reads_it(shipped: ml.Recording, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("h5py")
    from meniscus_liquid.hdf5 import write_lagrangebench

    folder = tmp_path / "h5"
    write_lagrangebench(folder, {"train": [shipped, shipped], "valid": [shipped], "test": [shipped]})
    reader = lagrangebench_reader(monkeypatch)
    position = in_the_box(shipped, folder)
    windows = reader("train", str(folder), input_seq_length=6)
    # Six positions, one to predict, and one of two trajectories.
    assert len(windows) == 2 * (600 - 6 - 1)
    for index, frame in ((0, 0), (17, 17), (600 - 7, 0), (2 * (600 - 7) - 1, 600 - 8)):
        window, kinds = windows[index]
        assert same_bits(np.ascontiguousarray(window), np.ascontiguousarray(position[frame : frame + 7].transpose(1, 0, 2)))
        assert kinds.shape == (2134,) and (kinds == 0).all()
    whole = reader("valid", str(folder), is_rollout=True, split_valid_traj_into_n=4, nl_backend="matscipy")
    assert len(whole) == 4
    part, kinds = whole[2]
    # Padded to the largest number of particles, which is that of every recording.
    assert same_bits(np.ascontiguousarray(part), np.ascontiguousarray(position[300:450].transpose(1, 0, 2)))
    assert len(kinds) == windows.metadata["num_particles_max"]


def in_the_box(recording: ml.Recording, folder: Path) -> np.ndarray:
    """Positions as the data set in `folder` has them."""
    offset = json.loads((folder / "metadata.json").read_text())["offset_m"]
    return (np.asarray(recording.field("q"), np.float64) + offset).astype(np.float32)


def test_a_split_has_the_length_of_its_shortest_recording(tmp_path: Path) -> None:
    h5py = pytest.importorskip("h5py")
    from meniscus_liquid.hdf5 import write_lagrangebench

    long, short = (ml.simulate("still", seconds=seconds, spacing_mm=8.7) for seconds in (0.3, 0.2))
    folder = tmp_path / "h5"
    write_lagrangebench(folder, {"train": [long, short], "valid": [long], "test": [short]})
    with h5py.File(folder / "train.h5") as file:
        assert [len(file[f"0000{number}/position"]) for number in (0, 1)] == [12, 12]
        assert same_bits(file["00000/position"][...], in_the_box(long, folder)[:12])
        assert len(file["00001/acceleration"]) == 12
    metadata = json.loads((folder / "metadata.json").read_text())
    assert metadata["sequence_length_train"] == 12 and metadata["sequence_length_test"] == 12


def test_h5py_reads_lagrangebench_s_layout(shipped: ml.Recording, water: Path, tmp_path: Path) -> None:
    h5py = pytest.importorskip("h5py")
    from meniscus_liquid.hdf5 import write_lagrangebench

    folder = tmp_path / "h5"
    write_lagrangebench(folder, {"train": [shipped, shipped], "valid": [shipped], "test": [shipped]})
    with h5py.File(folder / "train.h5") as file:
        assert sorted(file) == ["00000", "00001"]
        position = file["00001/position"]
        assert position.shape == (600, 2134, 3) and position.dtype == np.float32
        assert same_bits(position[...], in_the_box(shipped, folder))
        kinds = file["00000/particle_type"]
        assert kinds.shape == (2134,) and kinds.dtype == np.int64 and (kinds[...] == 0).all()
    metadata = json.loads((folder / "metadata.json").read_text())
    steps = np.diff(shipped.field("q").astype(float), axis=0)
    np.testing.assert_allclose(metadata["vel_mean"], steps.mean((0, 1)), atol=1e-12)
    # Shifted positions have rounding of their own, up to 4e-9 m.
    np.testing.assert_allclose(metadata["vel_std"], steps.std((0, 1)), rtol=1e-4)
    np.testing.assert_allclose(metadata["acc_std"], np.diff(steps, axis=0).std((0, 1)), rtol=1e-2)
    low, high = np.array(metadata["bounds"]).T
    # The neighbour search cuts a box from zero on into cells, the upper faces not included.
    assert (low == 0.0).all() and (in_the_box(shipped, folder) >= 0.0).all()
    assert (in_the_box(shipped, folder) < high.astype(np.float32)).all()
    assert metadata["dim"] == 3 and metadata["num_particles_max"] == 2134 and metadata["sequence_length_train"] == 600
    with pytest.raises(ml.MeniscusError, match="is not empty"):
        write_lagrangebench(folder, {"train": [shipped], "valid": [shipped], "test": [shipped]})
    with pytest.raises(ml.MeniscusError, match="give train, valid and test"):
        write_lagrangebench(tmp_path / "new", {"train": [shipped]})
    mixed = ml.Recording.load(water)
    with pytest.raises(ml.MeniscusError, match="of another glass or liquid"):
        write_lagrangebench(tmp_path / "new", {"train": [shipped], "valid": [mixed], "test": [shipped]})
    assert not (tmp_path / "new").exists()
