"""The page of `meniscus tag`, drawn by resvg and read by AprilTag 3: neither shares code with the program."""

from __future__ import annotations

import io
from pathlib import Path

import numpy as np
import pytest

PX_PER_MM = 4.0


@pytest.mark.parametrize("number, size_mm, paper", [(0, 40, "a4"), (7, 28, "letter"), (586, 140, "a4"), (23, 200, "a3")])
def test_apriltag_reads_the_printed_page(program, tmp_path: Path, number: int, size_mm: int, paper: str) -> None:
    resvg_py = pytest.importorskip("resvg_py")
    pupil_apriltags = pytest.importorskip("pupil_apriltags")
    from PIL import Image

    page = tmp_path / "tag.svg"
    program.run("tag", number, "--size-mm", size_mm, "--paper", paper, "--out", page)
    # A millimetre of SVG is 96/25.4 pixels.
    png = resvg_py.svg_to_bytes(svg_path=str(page), zoom=1, dpi=round(25.4 * PX_PER_MM))
    image = np.asarray(Image.open(io.BytesIO(bytes(png))).convert("L"))
    width_mm = {"a4": 210.0, "a3": 297.0, "letter": 215.9}[paper]
    scale = image.shape[1] / width_mm
    detector = pupil_apriltags.Detector(families="tag36h11")
    found = detector.detect(np.ascontiguousarray(image))
    # Its destructor frees the families and then lets the detector read them: a test run was aborted by that
    # (pupil-labs/apriltags, pull request 65). Without families it frees the detector alone.
    detector.tag_families.clear()
    assert [tag.tag_id for tag in found] == [number]
    tag = found[0]
    assert tag.hamming == 0
    sides = np.linalg.norm(tag.corners - np.roll(tag.corners, 1, axis=0), axis=1) / scale
    np.testing.assert_allclose(sides, size_mm, atol=0.3)
    # In the middle, with the white margin a square wide on all sides.
    assert tag.center[0] / scale == pytest.approx(width_mm / 2.0, abs=0.3)
    left, top = (int(round(edge)) for edge in tag.corners.min(0))
    square = size_mm / 8.0 * scale
    margin = image[int(top - 0.8 * square) : top - 2, int(left - 0.8 * square) : int(left + size_mm * scale)]
    assert margin.size and (margin == 255).all()
