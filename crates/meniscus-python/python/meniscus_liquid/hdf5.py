"""Recordings in the HDF5 layout of LagrangeBench (needs ``h5py``).

LagrangeBench (Toshev et al., NeurIPS 2023) reads a folder with ``train.h5``, ``valid.h5``, ``test.h5`` and ``metadata.json``. A file has one
group a trajectory, ``00000``, ``00001``, ..., with ``position`` [frames, particles, 3], float32, and ``particle_type`` [particles], int64.
Our particles are the 2134 tracers of a recording in the frame of the glass. Its neighbour search takes them to be in a box that
begins at zero, and misses pairs of others. So ``offset_m`` of the metadata is added to every position. The motion of the glass is an extra dataset of
each group, ``acceleration`` [frames, 3], which the loader ignores.
"""

from __future__ import annotations

import json
import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple, Union

import h5py
import numpy as np

from ._native import Glass, MeniscusError, Recording

__all__ = ["write_lagrangebench"]

_SPLITS = ("train", "valid", "test")
_FLUID = 0
_DT_S = 1.0 / 60.0


def write_lagrangebench(
    folder: Union[str, "os.PathLike[str]"], splits: Mapping[str, Sequence[Recording]], *, case: str = "glass"
) -> None:
    """Writes recordings as a data set of LagrangeBench; the folder is made, and has to be empty.

    All recordings are of one glass and of one liquid, and know the positions. Splits are by recording. A split has the length of its shortest
    recording, because the loader takes that of the first for all. Velocity and acceleration statistics of the metadata are those of the
    training split, per frame interval, as the benchmark defines them: ``v = x(t+1) - x(t)``, ``a = x(t+1) - 2 x(t) + x(t-1)``.

    Args:
        folder: Folder for train.h5, valid.h5, test.h5 and metadata.json.
        splits: Recordings of ``train``, ``valid`` and ``test``, each one or more.
        case: Name of the data set in the metadata.

    Raises:
        MeniscusError: The splits are incomplete, or recordings do not belong together.
    """
    folder = Path(folder)
    if set(splits) != set(_SPLITS):
        raise MeniscusError(f"the splits are {', '.join(sorted(splits)) or 'none'}: give train, valid and test")
    for name in _SPLITS:
        if not splits[name]:
            raise MeniscusError(f"the split '{name}' has no recording: data are split by recording, one at least in each")
    if folder.exists() and any(folder.iterdir()):
        raise MeniscusError(f"{folder} is not empty: choose another folder")
    everything = [recording for name in _SPLITS for recording in splits[name]]
    first = everything[0]
    for recording in everything:
        if recording.glass != first.glass or recording.provenance["liquid"] != first.provenance["liquid"]:
            raise MeniscusError(f"{recording!r} is of another glass or liquid than {first!r}: a data set is of one")
        if recording.frames < 3:
            raise MeniscusError(f"{recording!r} has {recording.frames} frames: an acceleration needs three")
    box = _box(first.glass, everything)
    metadata = _metadata(splits, case, box)
    folder.mkdir(parents=True, exist_ok=True)
    for name in _SPLITS:
        # Under another name until it is whole.
        part = folder / f"{name}.h5.part"
        _write_split(part, splits[name], box)
        os.replace(part, folder / f"{name}.h5")
    part = folder / "metadata.json.part"
    part.write_text(json.dumps(metadata, indent=2) + "\n")
    os.replace(part, folder / "metadata.json")


class _Box(NamedTuple):
    """Box of the neighbour search: the glass, and all that is outside of it."""

    #: Added to positions in the frame of the glass, m.
    offset_m: np.ndarray
    #: Lengths of its edges, m.
    size_m: np.ndarray


def _box(glass: Glass, recordings: Sequence[Recording]) -> _Box:
    reach = _reach_m(glass)
    low, high = np.array([-reach, -reach, 0.0]), np.array([reach, reach, glass.rim_m])
    # A position on the upper face counts as outside.
    hair = 1e-6 * reach
    for recording in recordings:
        position = np.asarray(recording.field("q"), np.float64).reshape(-1, 3)
        low, high = np.minimum(low, position.min(0)), np.maximum(high, position.max(0) + hair)
    return _Box(-low, high - low)


def _reach_m(glass: Glass) -> float:
    """Returns the largest radius of the glass, m."""
    return max(glass.radius_at(z) for z in np.linspace(0.0, glass.rim_m, 200))


def _shortest(recordings: Sequence[Recording]) -> int:
    return min(recording.frames for recording in recordings)


def _positions(recording: Recording, frames: int, box: _Box) -> np.ndarray:
    """Returns the positions in the box, m."""
    shifted: np.ndarray = (np.asarray(recording.field("q"), np.float64)[:frames] + box.offset_m).astype(np.float32)
    return shifted


def _write_split(path: Path, recordings: Sequence[Recording], box: _Box) -> None:
    frames = _shortest(recordings)
    with h5py.File(path, "w") as file:
        for number, recording in enumerate(recordings):
            position = _positions(recording, frames, box)
            group = file.create_group(f"{number:05d}")
            group.create_dataset("position", data=position, chunks=(1, *position.shape[1:]))
            group.create_dataset("particle_type", data=np.full(position.shape[1], _FLUID, np.int64))
            acceleration = np.zeros((frames, 3))
            acceleration[:, 0] = recording.acceleration_m_s2[:frames]
            group.create_dataset("acceleration", data=acceleration)
            group.attrs["command"] = recording.provenance["command"]


def _statistics(recordings: Sequence[Recording], box: _Box) -> dict[str, list[float]]:
    """Returns mean and deviation of velocity and acceleration, m per frame interval and its square."""
    sums = {"vel": np.zeros((2, 3)), "acc": np.zeros((2, 3))}
    counts, frames = {"vel": 0, "acc": 0}, _shortest(recordings)
    for recording in recordings:
        position = _positions(recording, frames, box).astype(np.float64)
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


def _metadata(splits: Mapping[str, Sequence[Recording]], case: str, box: _Box) -> dict[str, Any]:
    first = splits["train"][0]
    glass, particles = first.glass, int(first.field("q").shape[1])
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
