"""The job file for Kubernetes against the published schema of its resources. No cluster runs here."""

from __future__ import annotations

import copy
from pathlib import Path
from typing import Any

import pytest

kubernetes_validate = pytest.importorskip("kubernetes_validate")
yaml = pytest.importorskip("yaml")

JOB = Path(__file__).parents[3] / "examples/sweep/kubernetes.yaml"

# Indexed jobs with a limit of retries for each index are stable from this version of Kubernetes on.
VERSION = "1.33"


def job() -> dict[str, Any]:
    return dict(yaml.safe_load(JOB.read_text()))


def test_the_schema_accepts_the_job() -> None:
    kubernetes_validate.validate(job(), VERSION, strict=True)


def test_the_schema_refuses_a_word_that_it_does_not_know() -> None:
    wrong = copy.deepcopy(job())
    wrong["spec"]["completionmode"] = wrong["spec"].pop("completionMode")
    with pytest.raises(kubernetes_validate.ValidationError):
        kubernetes_validate.validate(wrong, VERSION, strict=True)


def test_there_is_a_part_for_each_index() -> None:
    spec = job()["spec"]
    (container,) = spec["template"]["spec"]["containers"]
    command = container["command"]
    assert int(command[command.index("--parts") + 1]) == spec["completions"]
    assert spec["completionMode"] == "Indexed"
