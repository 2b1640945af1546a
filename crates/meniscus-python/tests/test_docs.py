"""Every example of the documentation runs, and the stubs are those of the module."""

from __future__ import annotations

import doctest
import importlib
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest
from conftest import ROOT

import meniscus_liquid as ml

PAGES = [ROOT / "docs" / "python.md", ROOT / "crates" / "meniscus-python" / "README.md"]
MODULES = ["meniscus_liquid", "meniscus_liquid.env", "meniscus_liquid.hdf5"]


def test_examples_in_docstrings_give_what_they_say() -> None:
    finder, runner = doctest.DocTestFinder(), doctest.DocTestRunner(optionflags=doctest.NORMALIZE_WHITESPACE)
    tried = 0
    for name in ml.__all__:
        thing = getattr(ml, name)
        text = getattr(thing, "__doc__", None) or ""
        if ">>>" not in text or name == "__version__":
            continue
        test = doctest.DocTestParser().get_doctest(text, {}, name, None, None)
        runner.run(test)
        tried += len(test.examples)
    for module in MODULES:
        for test in finder.find(importlib.import_module(module)):
            runner.run(test)
            tried += len(test.examples)
    assert runner.summarize(verbose=False).failed == 0 and tried > 15


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_pages_run(page: Path, tmp_path: Path) -> None:
    blocks = re.findall(r"```python\n(.*?)```", page.read_text(), re.S)
    assert blocks
    # One program a page, in an empty folder: what a page makes, its later blocks use.
    done = subprocess.run(
        [sys.executable, "-W", "error", "-c", "\n".join(blocks)],
        cwd=tmp_path, env={**os.environ, "MPLBACKEND": "agg"}, capture_output=True, text=True, timeout=300, check=False,
    )
    assert done.returncode == 0, done.stderr


def test_the_stubs_are_the_module_s() -> None:
    pytest.importorskip("mypy")
    done = subprocess.run(
        [sys.executable, "-m", "mypy.stubtest", "meniscus_liquid._native"], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stdout + done.stderr


def test_the_python_half_is_typed() -> None:
    pytest.importorskip("mypy")
    done = subprocess.run(
        [sys.executable, "-m", "mypy", "--strict", "--ignore-missing-imports", "-p", "meniscus_liquid"],
        capture_output=True, text=True, check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr


def test_everything_public_has_a_docstring() -> None:
    bare = []
    for name in ml.__all__:
        thing = getattr(ml, name)
        if name != "__version__" and not (thing.__doc__ or "").strip():
            bare.append(name)
        if isinstance(thing, type) and thing.__module__.startswith("meniscus_liquid") and not issubclass(thing, Exception):
            bare += [f"{name}.{m}" for m in vars(thing) if not m.startswith("_") and m != "GROUPS"
                     and not (getattr(thing, m).__doc__ or "").strip()]
    assert not bare, bare
