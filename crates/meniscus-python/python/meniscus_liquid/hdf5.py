"""Particles of simulations in the HDF5 layout of LagrangeBench (needs ``h5py`` and ``safetensors``).

LagrangeBench (Toshev et al., NeurIPS 2023) reads a folder with ``train.h5``, ``valid.h5``, ``test.h5`` and ``metadata.json``. A file has one
group a trajectory, ``00000``, ``00001``, ..., with ``position`` [frames, particles, 3], float32, and ``particle_type`` [particles], int64.
The particles are those of the simulator in the frame of the glass, which move with the liquid. The tracers of a recording do not: they are
points of a lattice that is stretched up and down. The wall is not among the particles. The neighbour search takes them to be in a box that
begins at zero, and misses pairs of others. So ``offset_m`` of the metadata is added to every position. The motion of the glass is an extra dataset of
each group, ``acceleration`` [frames, 3], which the loader ignores.

Example:
    >>> import pathlib, tempfile
    >>> import meniscus_liquid as ml
    >>> from meniscus_liquid.hdf5 import Trajectory, write_lagrangebench
    >>> scratch = tempfile.TemporaryDirectory()
    >>> folder = pathlib.Path(scratch.name)
    >>> def moved(seed):
    ...     file = folder / f"{seed}.particles.safetensors"
    ...     return Trajectory(ml.simulate(f"jolts:{seed}x0.3", seconds=1.5, spacing_mm=8.7, particles=file), file)
    >>> write_lagrangebench(folder / "glass", {"train": [moved(1)], "valid": [moved(2)], "test": [moved(3)]})
    >>> sorted(path.name for path in (folder / "glass").iterdir())
    ['metadata.json', 'test.h5', 'train.h5', 'valid.h5']
"""

from __future__ import annotations

import json
import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple, Union

import h5py
import numpy as np
from safetensors import safe_open

from ._native import Glass, MeniscusError, Recording

__all__ = ["Trajectory", "write_lagrangebench"]

_SPLITS = ("train", "valid", "test")
_FLUID = 0
_DT_S = 1.0 / 60.0


class Trajectory(NamedTuple):
    """A simulation with its particles: of ``simulate(..., particles=FILE)`` or of ``meniscus simulate --particles``."""

    #: Recording of the simulation.
    recording: Recording
    #: File of its particles, ``NAME.particles.safetensors``.
    particles: Union[str, "os.PathLike[str]"]


def write_lagrangebench(
    folder: Union[str, "os.PathLike[str]"], splits: Mapping[str, Sequence[Trajectory]], *, case: str = "glass"
) -> None:
    """Writes simulations as a data set of LagrangeBench; the folder is made, and has to be empty.

    All are of one glass, one liquid and one number of particles, and no particle leaves over the rim. Splits are by recording. A split has the
    length of its shortest recording, because the loader takes that of the first for all. Velocity and acceleration statistics of the metadata
    are those of the training split, per frame interval, as the benchmark defines them: ``v = x(t+1) - x(t)``,
    ``a = x(t+1) - 2 x(t) + x(t-1)``.

    Args:
        folder: Folder for train.h5, valid.h5, test.h5 and metadata.json.
        splits: Simulations of ``train``, ``valid`` and ``test``, each one or more.
        case: Name of the data set in the metadata.

    Raises:
        MeniscusError: The splits are incomplete, or simulations do not belong together.
        OSError: A file cannot be read or written.
    """
    folder = Path(folder)
    if set(splits) != set(_SPLITS):
        raise MeniscusError(f"the splits are {', '.join(sorted(splits)) or 'none'}: give train, valid and test")
    for name in _SPLITS:
        if not splits[name]:
            raise MeniscusError(f"the split '{name}' has no recording: data are split by recording, one at least in each")
    if folder.exists() and any(folder.iterdir()):
        raise MeniscusError(f"{folder} is not empty: choose another folder")
    taken = {name: [_taken(Trajectory(*one)) for one in splits[name]] for name in _SPLITS}
    everything = [one for name in _SPLITS for one in taken[name]]
    first = everything[0]
    for one in everything:
        _check(one, first)
    box = _box(first.recording.glass, everything)
    metadata = _metadata(taken, case, box)
    folder.mkdir(parents=True, exist_ok=True)
    for name in _SPLITS:
        # Under another name until it is whole.
        part = folder / f"{name}.h5.part"
        _write_split(part, taken[name], box)
        os.replace(part, folder / f"{name}.h5")
    part = folder / "metadata.json.part"
    part.write_text(json.dumps(metadata, indent=2) + "\n")
    os.replace(part, folder / "metadata.json")


class _Taken(NamedTuple):
    """A simulation with its particles in memory."""

    recording: Recording
    #: [frames, particles, 3], m.
    position_m: np.ndarray
    file: Path


def _taken(trajectory: Trajectory) -> _Taken:
    file = Path(trajectory.particles)
    try:
        with safe_open(file, "np") as tensors:
            position_m = tensors.get_tensor("position_m")
    except OSError:
        raise
    except Exception as error:
        raise MeniscusError(f"{file} holds no particles of simulate(..., particles=FILE): {error}") from error
    return _Taken(trajectory.recording, position_m, file)


def _check(one: _Taken, first: _Taken) -> None:
    """Raises what is wrong with a simulation, by itself or beside the first."""
    recording, position_m, file = one
    if position_m.ndim != 3 or position_m.shape[2] != 3 or len(position_m) != recording.frames:
        raise MeniscusError(f"{file} has positions {list(position_m.shape)}, its recording {recording.frames} frames: give what belongs together")
    if recording.glass != first.recording.glass or recording.provenance["liquid"] != first.recording.provenance["liquid"]:
        raise MeniscusError(f"{recording!r} is of another glass or liquid than {first.recording!r}: a data set is of one")
    if position_m.shape[1] != first.position_m.shape[1]:
        raise MeniscusError(f"{file} has {position_m.shape[1]} particles, {first.file} {first.position_m.shape[1]}: simulate with one spacing")
    if recording.frames < 3:
        raise MeniscusError(f"{recording!r} has {recording.frames} frames: an acceleration needs three")
    gone = np.argwhere(~np.isfinite(position_m).all(2))
    if len(gone):
        frame, particle = gone[0]
        raise MeniscusError(f"particle {particle} of {file} is over the rim in frame {frame}: LagrangeBench needs all, take a gentler motion")


class _Box(NamedTuple):
    """Box of the neighbour search: the glass, and all that is outside of it."""

    #: Added to positions in the frame of the glass, m.
    offset_m: np.ndarray
    #: Lengths of its edges, m.
    size_m: np.ndarray


def _box(glass: Glass, everything: Sequence[_Taken]) -> _Box:
    reach = _reach_m(glass)
    low, high = np.array([-reach, -reach, 0.0]), np.array([reach, reach, glass.rim_m])
    # A position on the upper face counts as outside.
    hair = 1e-6 * reach
    for one in everything:
        position = one.position_m.astype(np.float64).reshape(-1, 3)
        low, high = np.minimum(low, position.min(0)), np.maximum(high, position.max(0) + hair)
    return _Box(-low, high - low)


def _reach_m(glass: Glass) -> float:
    """Returns the largest radius of the glass, m."""
    return max(glass.radius_at(z) for z in np.linspace(0.0, glass.rim_m, 200))


def _shortest(split: Sequence[_Taken]) -> int:
    return min(one.recording.frames for one in split)


def _positions(one: _Taken, frames: int, box: _Box) -> np.ndarray:
    """Returns the positions in the box, m."""
    shifted: np.ndarray = (one.position_m[:frames].astype(np.float64) + box.offset_m).astype(np.float32)
    return shifted


def _write_split(path: Path, split: Sequence[_Taken], box: _Box) -> None:
    frames = _shortest(split)
    with h5py.File(path, "w") as file:
        for number, one in enumerate(split):
            recording, position = one.recording, _positions(one, frames, box)
            group = file.create_group(f"{number:05d}")
            group.create_dataset("position", data=position, chunks=(1, *position.shape[1:]))
            group.create_dataset("particle_type", data=np.full(position.shape[1], _FLUID, np.int64))
            acceleration = np.zeros((frames, 3))
            acceleration[:, 0] = recording.acceleration_m_s2[:frames]
            group.create_dataset("acceleration", data=acceleration)
            group.attrs["command"] = recording.provenance["command"]


def _statistics(split: Sequence[_Taken], box: _Box) -> dict[str, list[float]]:
    """Returns mean and deviation of velocity and acceleration, m per frame interval and its square."""
    sums = {"vel": np.zeros((2, 3)), "acc": np.zeros((2, 3))}
    counts, frames = {"vel": 0, "acc": 0}, _shortest(split)
    for one in split:
        position = _positions(one, frames, box).astype(np.float64)
        for name, order in (("vel", 1), ("acc", 2)):
            steps = np.diff(position, order, axis=0).reshape(-1, 3)
            sums[name] += [steps.sum(0), (steps**2).sum(0)]
            counts[name] += len(steps)
    statistics = {}
    for name, (total, squares) in sums.items():
        mean = total / counts[name]
        statistics[f"{name}_mean"] = mean.tolist()
        statistics[f"{name}_std"] = np.sqrt(np.maximum(squares / counts[name] - mean**2, 0.0)).tolist()
    return statistics


def _metadata(splits: Mapping[str, Sequence[_Taken]], case: str, box: _Box) -> dict[str, Any]:
    first = splits["train"][0]
    glass, particles = first.recording.glass, int(first.position_m.shape[1])
    spacing_m = (np.pi * _reach_m(glass) ** 2 * glass.fill_m / particles) ** (1.0 / 3.0)
    frames = max(_shortest(splits[name]) for name in _SPLITS)
    return {
        "case": case,
        "solver": "meniscus",
        "dim": 3,
        "dx": spacing_m,
        "dt": _DT_S,
        "write_every": 1,
        "t_end": frames * _DT_S,
        "bounds": [[0.0, length] for length in box.size_m.tolist()],
        "offset_m": box.offset_m.tolist(),
        "default_connectivity_radius": 1.45 * spacing_m,
        "num_particles_max": particles,
        "sequence_length_train": _shortest(splits["train"]),
        "sequence_length_test": _shortest(splits["test"]),
        "num_trajs_train": len(splits["train"]),
        "num_trajs_test": len(splits["test"]),
        "periodic_boundary_conditions": [False, False, False],
        **_statistics(splits["train"], box),
    }
