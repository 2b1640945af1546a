"""Data out: VTK files read by VTK itself."""

from __future__ import annotations

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
