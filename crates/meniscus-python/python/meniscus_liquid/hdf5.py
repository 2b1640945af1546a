"""Recordings in the HDF5 layout of LagrangeBench (needs ``h5py``).

LagrangeBench (Toshev et al., NeurIPS 2023) reads a folder with ``train.h5``, ``valid.h5``, ``test.h5`` and ``metadata.json``. A file has one
group a trajectory, ``00000``, ``00001``, ..., with ``position`` [frames, particles, 3], float32, and ``particle_type`` [particles], int64.
Our particles are the 2134 tracers of a recording in the frame of the glass; the motion of the glass is an extra dataset of each group,
``acceleration`` [frames, 3], which the loader ignores.
"""

from __future__ import annotations

import json
import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Union

import h5py
import numpy as np

from ._native import MeniscusError, Recording

__all__ = ["write_lagrangebench"]

_SPLITS = ("train", "valid", "test")
_FLUID = 0
_DT_S = 1.0 / 60.0


def write_lagrangebench(
    folder: Union[str, "os.PathLike[str]"], splits: Mapping[str, Sequence[Recording]], *, case: str = "glass"
) -> None:
    """Writes recordings as a data set of LagrangeBench; the folder is made, and has to be empty.

    All recordings are of one glass and of one liquid, and know the positions. Splits are by recording. Velocity and acceleration statistics of
    the metadata are those of the training split, per frame interval, as the benchmark defines them:
    ``v = x(t+1) - x(t)``, ``a = x(t+1) - 2 x(t) + x(t-1)``.

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
    metadata = _metadata(splits, case)
    folder.mkdir(parents=True, exist_ok=True)
    for name in _SPLITS:
        # Under another name until it is whole.
        part = folder / f"{name}.h5.part"
        _write_split(part, splits[name])
        os.replace(part, folder / f"{name}.h5")
    part = folder / "metadata.json.part"
    part.write_text(json.dumps(metadata, indent=2) + "\n")
    os.replace(part, folder / "metadata.json")


def _write_split(path: Path, recordings: Sequence[Recording]) -> None:
    with h5py.File(path, "w") as file:
        for number, recording in enumerate(recordings):
            position = np.asarray(recording.field("q"), np.float32)
            group = file.create_group(f"{number:05d}")
            group.create_dataset("position", data=position, chunks=(1, *position.shape[1:]))
            group.create_dataset("particle_type", data=np.full(position.shape[1], _FLUID, np.int64))
            acceleration = np.zeros((recording.frames, 3))
            acceleration[:, 0] = recording.acceleration_m_s2
            group.create_dataset("acceleration", data=acceleration)
            group.attrs["command"] = recording.provenance["command"]


def _metadata(splits: Mapping[str, Sequence[Recording]], case: str) -> dict[str, Any]:
    first = splits["train"][0]
    sums = {"velocity": np.zeros((2, 3)), "acceleration": np.zeros((2, 3))}
    counts = {"velocity": 0, "acceleration": 0}
    for recording in splits["train"]:
        position = np.asarray(recording.field("q"), np.float64)
        for name, order in (("velocity", 1), ("acceleration", 2)):
            steps = np.diff(position, order, axis=0).reshape(-1, 3)
            sums[name] += [steps.sum(0), (steps**2).sum(0)]
            counts[name] += len(steps)
    statistics = {}
    for name, (total, squares) in sums.items():
        mean = total / counts[name]
        statistics[f"{name[:3]}_mean"] = mean.tolist()
        statistics[f"{name[:3]}_std"] = np.sqrt(np.maximum(squares / counts[name] - mean**2, 0.0)).tolist()
    glass = first.glass
    reach = max(glass.radius_at(z) for z in np.linspace(0.0, glass.rim_m, 200))
    spacing_m = (np.pi * reach**2 * glass.fill_m / position.shape[1]) ** (1.0 / 3.0)
    frames = max(recording.frames for name in _SPLITS for recording in splits[name])
    return {
        "case": case,
        "solver": "meniscus",
        "dim": 3,
        "dx": spacing_m,
        "dt": _DT_S,
        "write_every": 1,
        "t_end": frames * _DT_S,
        "bounds": [[-reach, reach], [-reach, reach], [0.0, glass.rim_m]],
        "default_connectivity_radius": 1.45 * spacing_m,
        "num_particles_max": int(position.shape[1]),
        "sequence_length_train": min(recording.frames for recording in splits["train"]),
        "sequence_length_test": min(recording.frames for recording in splits["test"]),
        "num_trajs_train": len(splits["train"]),
        "num_trajs_test": len(splits["test"]),
        "periodic_boundary_conditions": [False, False, False],
        **statistics,
    }
