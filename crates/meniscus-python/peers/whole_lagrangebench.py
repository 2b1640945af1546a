#!/usr/bin/env python3
"""LagrangeBench as a whole on a data set that `write_lagrangebench` made: neighbour search, features, training and rollouts.

    crates/meniscus-python/peers/run

makes the environment, builds the wheel and starts this program. It prints a report of checks as JSON and ends with status 1 where one fails.

The data are the particles of four strokes of the simulator. The model is LagrangeBench's GNS (Sanchez-Gonzalez et al. 2020) in a
small size. It is trained by `lagrangebench.runner.train_or_infer`, which also rolls it out and computes the benchmark's metrics.
"""

from __future__ import annotations

import argparse
import contextlib
import io
import json
import pickle
import re
import sys
import tempfile
import time
import warnings
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

import meniscus_liquid as ml
from meniscus_liquid.hdf5 import Trajectory, write_lagrangebench

# Their own older interfaces, which they tell everybody of.
warnings.simplefilter("ignore")

import jax  # noqa: E402
from lagrangebench.case_setup import case_builder  # noqa: E402
from lagrangebench.data import H5Dataset  # noqa: E402
from lagrangebench.defaults import defaults  # noqa: E402
from lagrangebench.runner import train_or_infer  # noqa: E402
from omegaconf import OmegaConf  # noqa: E402
from safetensors.numpy import load_file  # noqa: E402
from scipy.spatial import cKDTree  # noqa: E402

HISTORY, ROLLOUT = 6, 10
BACKENDS = ("jaxmd_vmap", "jaxmd_scan", "matscipy")


def neighbours_wrong(folder: Path, backend: str) -> tuple[int, int]:
    """Returns the pairs that LagrangeBench misses or invents in four windows, and the pairs that a k-d tree finds there."""
    data = H5Dataset("train", str(folder), name="glass", input_seq_length=HISTORY, nl_backend=backend)
    wrong = all_pairs = 0
    for index in np.linspace(0, len(data) - 1, 4).astype(int):
        window, kinds = data[index]
        _, features, _, _ = case_of(data.metadata, backend).allocate(jax.random.PRNGKey(0), (window, kinds))
        particles = len(kinds)
        ends = np.stack([np.asarray(features["senders"]), np.asarray(features["receivers"])], 1)
        # Lists are padded by a particle that does not exist, and every particle is a neighbour of its own.
        ends = ends[(ends < particles).all(1) & (ends[:, 0] != ends[:, 1])]
        found = {(int(a), int(b)) for a, b in ends}
        radius = data.metadata["default_connectivity_radius"]
        tree = cKDTree(np.asarray(window[:, HISTORY - 1], np.float64))
        # Pairs on the very radius fall to either side by rounding.
        due, most = (both_ways(tree.query_pairs(radius * (1.0 + slack))) for slack in (-1e-5, 1e-5))
        wrong += len(due - found) + len(found - most)
        all_pairs += len(due)
    return wrong, all_pairs


def both_ways(pairs: set[tuple[int, int]]) -> set[tuple[int, int]]:
    return pairs | {(b, a) for a, b in pairs}


def case_of(metadata: dict[str, Any], backend: str) -> Any:
    """Returns the case as `lagrangebench.runner` builds it, without noise."""
    bounds = np.array(metadata["bounds"])
    return case_builder(
        box=bounds[:, 1] - bounds[:, 0],
        metadata=metadata,
        input_seq_length=HISTORY,
        cfg_neighbors={"backend": backend, "multiplier": 1.25},
        noise_std=0.0,
    )


def positions_m(trajectory: Trajectory) -> np.ndarray:
    return load_file(trajectory.particles)["position_m"].astype(np.float64)


def target_error(folder: Path, first: Trajectory) -> float:
    """Returns the largest error of normalised accelerations of the first simulation, in their deviations."""
    data = H5Dataset("train", str(folder), name="glass", input_seq_length=HISTORY)
    metadata, errors = data.metadata, []
    case = case_of(metadata, BACKENDS[0])
    for frame in (0, 40, 80):
        _, _, target, _ = case.allocate(jax.random.PRNGKey(0), data[frame])
        last = frame + HISTORY
        before, now, after = positions_m(first)[last - 2 : last + 1]
        due = (after - 2.0 * now + before - metadata["acc_mean"]) / metadata["acc_std"]
        errors.append(np.abs(np.asarray(target["acc"]) - due).max())
    return float(np.max(errors))


def settings(folder: Path, scratch: Path, steps: int) -> Any:
    """Returns LagrangeBench's defaults with a small model, few steps and no pushforward."""
    changed = {
        "mode": "all",
        "dtype": "float32",
        "dataset": {"src": str(folder), "name": "glass"},
        "model": {"name": "gns", "num_mp_steps": 2, "num_mlp_layers": 1, "latent_dim": 32},
        "train": {
            "num_workers": 0,
            "noise_std": 0.0,
            "step_max": steps,
            "optimizer": {"lr_start": 1e-3},
            "pushforward": {"steps": [-1], "unrolls": [0], "probs": [1]},
        },
        "eval": {
            "n_rollout_steps": ROLLOUT,
            "test": True,
            "rollout_dir": str(scratch / "rollout"),
            "train": {"n_trajs": 1},
            "infer": {"n_trajs": 2, "batch_size": 1},
        },
        "logging": {"log_steps": 1, "eval_steps": steps, "ckp_dir": str(scratch / "ckp")},
    }
    return OmegaConf.merge(defaults, changed)


def train(folder: Path, scratch: Path, steps: int) -> list[float]:
    """Trains, rolls out, and returns the losses that the trainer printed."""
    printed = io.StringIO()
    with contextlib.redirect_stdout(printed):
        train_or_infer(settings(folder, scratch, steps))
    text = printed.getvalue()
    sys.stderr.write(text)
    return [float(loss) for loss in re.findall(r"train/loss: (\S+)\.$", text, re.MULTILINE)]


def rollouts(scratch: Path) -> list[dict[str, np.ndarray]]:
    """Returns the rollouts of the trained model on the test split."""
    return [pickle.loads(file.read_bytes()) for file in sorted(scratch.glob("rollout/**/rollout_[0-9]*.pkl"))]


def truth_error_m(parts: list[dict[str, np.ndarray]], tested: Trajectory, offset_m: list[float]) -> float:
    """Returns the largest distance of the rollouts' truth from the simulation."""
    positions = positions_m(tested) + offset_m
    frames = HISTORY + ROLLOUT
    due = [positions[part * frames :][:frames] for part in range(len(parts))]
    return max(float(np.abs(part["ground_truth_rollout"] - due).max()) for part, due in zip(parts, due))


def check(name: str, value: float, most: float, *, least: float = 0.0) -> dict[str, Any]:
    """Returns a line of the report. A value that is no number fails."""
    return {"name": name, "value": value, "least": least, "most": most, "ok": bool(least <= value <= most)}


def checks(folder: Path, scratch: Path, steps: int) -> list[dict[str, Any]]:
    """Writes the data set and lets LagrangeBench read, train and roll out."""
    def moved(seed: int) -> Trajectory:
        file = scratch / f"{seed}.particles.safetensors"
        return Trajectory(ml.simulate(f"strokes:{seed}x0.25", seconds=3, particles=file), file)

    first, second, valid, tested = (moved(seed) for seed in (1, 2, 3, 4))
    write_lagrangebench(folder, {"train": [first, second], "valid": [valid], "test": [tested]})
    all_checks = []
    for backend in BACKENDS:
        wrong, pairs = neighbours_wrong(folder, backend)
        all_checks.append(check(f"neighbours_wrong_{backend}", wrong, 0))
        all_checks.append(check(f"neighbours_{backend}", pairs, 1e7, least=50_000))
    all_checks.append(check("target_error_std", target_error(folder, first), 0.01))
    losses = train(folder, scratch, steps)
    # A model that predicts no acceleration has three on the average, one for each axis.
    all_checks.append(check("training_steps", len(losses), steps + 1, least=steps + 1))
    all_checks.append(check("loss_of_last_steps", float(np.mean(losses[-20:])), 1.0))
    parts = rollouts(scratch)
    all_checks.append(check("rollouts", len(parts), 2, least=2))
    offset_m = json.loads((folder / "metadata.json").read_text())["offset_m"]
    all_checks.append(check("rollout_truth_error_m", truth_error_m(parts, tested, offset_m), 1e-8))
    apart = max(float(np.abs(part["predicted_rollout"] - part["ground_truth_rollout"]).max()) for part in parts)
    all_checks.append(check("rollout_error_m", apart, 0.07))
    return all_checks


def main() -> int:
    parser = argparse.ArgumentParser(description="LagrangeBench as a whole on a data set of ours")
    parser.add_argument("--steps", type=int, default=200, help="steps of training")
    parser.add_argument("--folder", type=Path, help="empty folder that keeps the data set")
    options = parser.parse_args()
    began = time.monotonic()
    with tempfile.TemporaryDirectory() as name:
        found = checks(options.folder or Path(name) / "glass", Path(name), options.steps)
    seconds = time.monotonic() - began
    print(json.dumps({"checks": found, "lagrangebench": version("lagrangebench"), "seconds": round(seconds, 1)}, indent=2))
    return 0 if all(line["ok"] for line in found) else 1


if __name__ == "__main__":
    sys.exit(main())
