"""Fixtures: the program `meniscus` as the other side of every comparison, and small inputs."""

from __future__ import annotations

import json
import os
import subprocess
from pathlib import Path

import numpy as np
import pytest

import meniscus_liquid as ml

ROOT = Path(__file__).resolve().parents[3]


def pytest_sessionfinish(session: pytest.Session) -> None:
    """A test that was skipped, as for want of a library, is a failure where CI is set."""
    reporter = session.config.pluginmanager.get_plugin("terminalreporter")
    if os.environ.get("CI") and reporter is not None and reporter.stats.get("skipped"):
        session.exitstatus = pytest.ExitCode.TESTS_FAILED


class Program:
    """The built program. `MENISCUS` names it, or it is that of the release build or of the Rust tests."""

    def __init__(self, path: Path) -> None:
        self.path = path

    def run(self, *arguments: object, cwd: Path | None = None) -> str:
        command = [str(self.path), *map(str, arguments)]
        done = subprocess.run(command, capture_output=True, text=True, cwd=cwd, timeout=300, check=False)
        assert done.returncode == 0, f"{' '.join(command)}: {done.stderr}"
        return done.stdout

    def json(self, *arguments: object) -> dict:
        return json.loads(self.run(*arguments, "--json"))


@pytest.fixture(scope="session")
def program() -> Program:
    target = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target")) / "release"
    named = os.environ.get("MENISCUS")
    candidates = [Path(named)] if named else [target / "meniscus-under-test", target / "meniscus"]
    for candidate in candidates:
        if candidate.exists():
            return Program(candidate)
    # A comparison that did not happen is a failure where CI is set, as in the Rust tests.
    message = f"no program: build it, or name it with MENISCUS ({', '.join(map(str, candidates))})"
    if os.environ.get("CI"):
        pytest.fail(message)
    pytest.skip(message)


@pytest.fixture(scope="session")
def shipped() -> ml.Recording:
    return ml.Recording.shipped()


@pytest.fixture(scope="session")
def water(program: Program, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Water of the command, coarse particles, full states."""
    path = tmp_path_factory.mktemp("water") / "water.safetensors"
    program.run(
        "simulate", "--liquid", "water", "--motion", "jolts:1x0.2", "--seconds", "2.0", "--spacing-mm", "8.7", "--out", path
    )
    return path


def same_bits(one: np.ndarray, other: np.ndarray) -> bool:
    """Whether two arrays have the same type, shape and bytes."""
    one, other = np.asarray(one), np.asarray(other)
    return one.dtype == other.dtype and one.shape == other.shape and one.tobytes() == other.tobytes()
