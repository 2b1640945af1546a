"""Figures of recordings, estimates and verdicts (needs ``matplotlib``). Each function returns a ``matplotlib.figure.Figure``."""

from __future__ import annotations

from typing import Any, Optional

import numpy as np
from matplotlib.figure import Figure

from ._native import Estimates, MeniscusError, Recording, Verdict

__all__ = ["estimates_figure", "recording_figure", "verdict_figure"]


def recording_figure(recording: Recording) -> Figure:
    """Motion of the glass, surface at its two sides, and energies over time."""
    figure = Figure(figsize=(8, 7), layout="constrained")
    motion, surface, energy = figure.subplots(3, 1, sharex=True)
    time = recording.time_s
    motion.plot(time, 1e3 * recording.glass_x_m)
    motion.set_ylabel("glass, mm")
    motion.set_title(f"{recording.provenance['liquid']}, {recording.provenance['motion']}")
    rest = recording.glass.fill_m
    for point, label in ((0, "left edge"), (10, "middle"), (20, "right edge")):
        surface.plot(time, 1e3 * (recording.profile_m[:, point] - rest), label=label)
    surface.set_ylabel("surface over rest, mm")
    surface.legend(loc="upper right")
    for name, book in recording.energy_j.items():
        if name != "spilled" or book.any():
            energy.plot(time, 1e3 * book, label=name)
    energy.set_ylabel("energy, mJ")
    energy.set_xlabel("time, s")
    energy.legend(loc="upper left")
    return figure


def estimates_figure(estimates: Estimates, truth: Optional[Recording] = None) -> Figure:
    """Estimated surface at both edges with its interval of 90 %, over turns; with a recording, its truth."""
    figure = Figure(figsize=(8, 5), layout="constrained")
    axes = figure.subplots(2, 1, sharex=True)
    turns = np.arange(len(estimates)) / 60.0
    for panel, point, label in zip(axes, (0, 20), ("left edge", "right edge")):
        height, half = 1e3 * estimates.surface_m[:, point], 1e3 * estimates.surface_half_m[:, point]
        panel.fill_between(turns, height - half, height + half, alpha=0.3, label="interval, 90 %")
        panel.plot(turns, height, label="estimate")
        if truth is not None:
            count = min(len(turns), truth.frames)
            panel.plot(turns[:count], 1e3 * truth.profile_m[:count, point], "k--", lw=0.8, label="truth")
        panel.set_ylabel(f"{label}, mm")
    axes[0].legend(loc="upper right")
    axes[1].set_xlabel("time, s")
    return figure


def verdict_figure(verdict: Verdict) -> Figure:
    """Ranking of the effects, and the error of the held-out recording without and with the verdict."""
    report: dict[str, Any] = verdict.report
    ranking = [entry for entry in report["ranking"] if entry["effects"]][:12]
    if not ranking:
        raise MeniscusError("the verdict has no ranking: no effect was fitted")
    figure = Figure(figsize=(9, 5), layout="constrained")
    gain, gap = figure.subplots(1, 2, width_ratios=[2, 1])
    names = [" + ".join(entry["effects"]) for entry in ranking]
    chosen = set(report["names"])
    colours = ["C1" if set(entry["effects"]) & chosen else "C0" for entry in ranking]
    places = np.arange(len(names))[::-1]
    gain.barh(places, [entry["gain"] for entry in ranking], color=colours)
    gain.set_yticks(places, names)
    gain.axvline(report["thresholds"]["gain"], color="k", ls="--", lw=0.8, label="threshold")
    gain.set_xlabel("gain over the plain model")
    gain.legend(loc="lower right")
    figure.suptitle(f"verdict: {verdict.word} {', '.join(verdict.names)}")
    measured = report["gap_mm"]
    if measured is None:
        gap.text(0.5, 0.5, "no recording\nwas held out", ha="center", va="center")
        gap.set_axis_off()
    else:
        bars = [("plain", "untouched"), ("refitted", "refitted"), ("black\nbox", "black_box"), ("effect", "effect")]
        gap.bar([label for label, _ in bars], [measured[key] for _, key in bars])
        gap.set_ylabel("error on the held-out recording, mm")
    return figure
