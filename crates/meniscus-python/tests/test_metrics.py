"""Figures of a running program, read by Prometheus' own parser."""

from __future__ import annotations

import re
import subprocess
import urllib.request

import pytest
from prometheus_client.parser import text_string_to_metric_families


@pytest.fixture
def scraped(program):
    """Two scrapes of a run, each as a list of families."""
    command = [str(program.path), "run", "--view", "--listen", "127.0.0.1:0", "--seconds", "60"]
    run = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    try:
        address = next(found[0] for line in run.stdout if (found := re.search(r"http://127[^ ]*/", line)))
        texts = [urllib.request.urlopen(address + "metrics", timeout=10) for _ in range(2)]
        assert all(text.headers["Content-Type"].startswith("text/plain; version=0.0.4") for text in texts)
        yield [list(text_string_to_metric_families(text.read().decode())) for text in texts]
    finally:
        run.kill()
        run.wait()


def test_figures_are_read_and_counters_rise(scraped):
    before, after = ({family.name: family for family in families} for families in scraped)
    assert before.keys() == after.keys() and len(before) > 15
    assert all(family.documentation for family in after.values())

    def value(families, name):
        return families[name].samples[0].value

    assert after["meniscus_turns"].type == "counter"
    assert value(after, "meniscus_turns") > value(before, "meniscus_turns") > 0
    modes = {sample.labels["mode"]: sample.value for sample in after["meniscus_mode"].samples}
    assert sum(modes.values()) == 1
    # A turn takes less than the time between two frames, and the surface has at most 21 points.
    assert 0 < value(after, "meniscus_turn_seconds") < 1
    assert 0 <= value(after, "meniscus_surface_points") <= 21
