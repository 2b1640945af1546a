"""Meniscus in Python: a liquid in a moved glass as numpy arrays.

Arrays that an object returns are read-only views on its memory, in SI units; ``array.copy()`` may be changed. Refused input raises
``MeniscusError`` with the program's own sentence, a file that cannot be read ``OSError``.

Example:
    >>> import meniscus_liquid as ml
    >>> recording = ml.Recording.shipped()
    >>> recording.field("q").shape
    (600, 2134, 3)
"""

from ._native import (
    Correction,
    Estimate,
    Estimates,
    Estimator,
    Evaluation,
    Forecast,
    Glass,
    Liquid,
    MeniscusError,
    Model,
    Motion,
    Profile,
    Recording,
    ReducedModel,
    ReducedState,
    Scene,
    SimulationError,
    Verdict,
    __version__,
    camera_profiles,
    correct,
    discover,
    effects,
    evaluate,
    export_vtp,
    liquids,
    load_profiles,
    save_profiles,
    simulate,
)

__all__ = [
    "Correction",
    "Estimate",
    "Estimates",
    "Estimator",
    "Evaluation",
    "Forecast",
    "Glass",
    "Liquid",
    "MeniscusError",
    "Model",
    "Motion",
    "Profile",
    "Recording",
    "ReducedModel",
    "ReducedState",
    "Scene",
    "SimulationError",
    "Verdict",
    "__version__",
    "camera_profiles",
    "correct",
    "discover",
    "effects",
    "evaluate",
    "export_vtp",
    "liquids",
    "load_profiles",
    "save_profiles",
    "simulate",
]
