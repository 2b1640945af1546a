"""ROS bags that another program wrote (the package rosbags, which shares no code with ROS or with this project), read by us."""

from __future__ import annotations

import json
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

rosbag1 = pytest.importorskip("rosbags.rosbag1")
rosbag2 = pytest.importorskip("rosbags.rosbag2")
from rosbags.typesys import Stores, get_typestore  # noqa: E402

WIDTH, HEIGHT = 64, 48
FRAMES = 12
NOISE = np.random.default_rng(8)
# Rising depth with noise, so that no byte is like the next; 20 ms a frame.
DEPTH = (1000 + NOISE.integers(0, 400, (FRAMES, HEIGHT, WIDTH))).astype("<u2")
GREY = NOISE.integers(0, 256, (FRAMES, HEIGHT, WIDTH)).astype("u1")
COLOUR = NOISE.integers(0, 256, (FRAMES, HEIGHT, WIDTH, 3)).astype("u1")
START_NS = 1_700_000_000_123_456_000
K = [50.25, 0.0, 31.5, 0.0, 50.5, 23.25, 0.0, 0.0, 1.0]
NAMES = {"depth": "/cam/depth/image_rect_raw", "info": "/cam/depth/camera_info", "grey": "/cam/infra1/image_rect_raw"}


def messages(store: Any, ros1: bool, what: dict[str, Any]) -> list[tuple[str, str, int, Any]]:
    """Messages (topic, type, time, message) of one camera; `what` changes their form."""
    types = store.types
    stamp_of = types["builtin_interfaces/msg/Time"]
    header_of = types["std_msgs/msg/Header"]

    def header(frame: int) -> Any:
        ns = START_NS + frame * 20_000_000
        stamp = stamp_of(sec=ns // 10**9, nanosec=ns % 10**9)
        return header_of(seq=frame, stamp=stamp, frame_id="cam") if ros1 else header_of(stamp=stamp, frame_id="cam")

    def image(frame: int, array: np.ndarray, encoding: str, big: int = 0, padding: int = 0) -> Any:
        rows = array.reshape(HEIGHT, -1).view("u1").reshape(HEIGHT, -1)
        rows = np.pad(rows, ((0, 0), (0, padding)), constant_values=7)
        return types["sensor_msgs/msg/Image"](
            header=header(frame), height=HEIGHT, width=WIDTH, encoding=encoding, is_bigendian=big, step=rows.shape[1],
            data=np.ascontiguousarray(rows).reshape(-1),
        )

    def info(frame: int) -> Any:
        d, r, p = np.array(what.get("d", [0.0] * 5)), np.eye(3).reshape(-1), np.array([K[0], 0, K[2], 0, 0, K[4], K[5], 0, 0, 0, 1, 0])
        roi = types["sensor_msgs/msg/RegionOfInterest"](x_offset=0, y_offset=0, height=0, width=0, do_rectify=False)
        names = {"D": d, "K": np.array(K), "R": r, "P": p}
        matrices = names if ros1 else {key.lower(): value for key, value in names.items()}
        return types["sensor_msgs/msg/CameraInfo"](
            header=header(frame), height=HEIGHT, width=WIDTH, distortion_model="plumb_bob", binning_x=0, binning_y=0, roi=roi,
            **matrices,
        )

    def depth(frame: int) -> Any:
        form = what.get("depth", "16UC1")
        if form == "32FC1":
            metres = (DEPTH[frame] * 1e-3).astype("<f4")
            metres[0, :3] = [np.nan, np.inf, -1.0]
            return image(frame, metres, "32FC1")
        if form == "big":
            return image(frame, DEPTH[frame].astype(">u2"), "16UC1", big=1)
        return image(frame, DEPTH[frame], form, padding=what.get("padding", 0))

    names = NAMES | what.get("names", {})
    out = []
    for frame in range(FRAMES):
        time = START_NS + frame * 20_000_000
        if not what.get("no_info"):
            out.append((names["info"], "sensor_msgs/msg/CameraInfo", time, info(frame)))
        out.append((names["depth"], "sensor_msgs/msg/Image", time, depth(frame)))
        if what.get("second_depth"):
            out.append(("/other/depth/image", "sensor_msgs/msg/Image", time, depth(frame)))
        if what.get("colour"):
            out.append(("/cam/color/image_raw", "sensor_msgs/msg/Image", time, image(frame, COLOUR[frame], what["colour"])))
        if not what.get("no_grey"):
            out.append((names["grey"], "sensor_msgs/msg/Image", time + 1_000_000, image(frame, GREY[frame], "mono8")))
    return out


def write(path: Path, kind: str, **what: Any) -> Path:
    """Writes a bag of one `kind`; returns what the command is given."""
    if kind.startswith("ros1"):
        store = get_typestore(Stores.ROS1_NOETIC)
        writer = rosbag1.Writer(path / "a.bag")
        if kind != "ros1":
            writer.set_compression(rosbag1.Writer.CompressionFormat[kind.removeprefix("ros1-").upper()])
        given, ros1 = path / "a.bag", True
    else:
        store = get_typestore(Stores.ROS2_HUMBLE)
        plugin = rosbag2.StoragePlugin.MCAP if "mcap" in kind else rosbag2.StoragePlugin.SQLITE3
        writer = rosbag2.Writer(path / "bag", version=8, storage_plugin=plugin)
        for word, mode in (("message", "MESSAGE"), ("file", "FILE"), ("zstd", "STORAGE")):
            if word in kind:
                writer.set_compression(rosbag2.CompressionMode[mode], rosbag2.CompressionFormat.ZSTD)
        given, ros1 = path / "bag", False
    with writer:
        connections: dict[str, Any] = {}
        for topic, kind_of, time, message in messages(store, ros1, what):
            if topic not in connections:
                connections[topic] = writer.add_connection(topic, kind_of, typestore=store)
            serialize = store.serialize_ros1 if ros1 else store.serialize_cdr
            writer.write(connections[topic], time, serialize(message, kind_of))
    return given


def convert(program, given: Path, out: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    command = [str(program.path), "record", "--source", str(given), "--out", str(out), *arguments]
    return subprocess.run(command, capture_output=True, text=True, timeout=120, check=False)


def read(folder: Path, kind: str) -> np.ndarray:
    return np.stack([np.array(Image.open(path)) for path in sorted(folder.glob(f"{kind}-*.png"))])


def check(program, given: Path, tmp_path: Path, *arguments: str, grey: np.ndarray = GREY, unit_m: float = 1e-3) -> None:
    done = convert(program, given, tmp_path / "out", *arguments)
    assert done.returncode == 0, done.stderr
    out = tmp_path / "out"
    depth = read(out, "depth")
    wanted = np.rint(DEPTH * (1e-3 / unit_m)).astype(int)
    if unit_m != 1e-3:
        # NaN, infinite and negative depths are nothing seen.
        assert (depth[:, 0, :3] == 0).all()
        depth, wanted = depth[:, 1:], wanted[:, 1:]
    assert (depth == wanted).all()
    assert (read(out, "infrared") == grey).all()
    camera = json.loads((out / "camera.json").read_text())
    assert camera["size"] == [WIDTH, HEIGHT] and camera["depth_unit_m"] == pytest.approx(unit_m)
    assert camera["focal_px"] == [K[0], K[4]] and camera["centre_px"] == [K[2], K[5]]
    times = [float(line.split(",")[1]) for line in (out / "frames.csv").read_text().splitlines()[1:]]
    assert times == pytest.approx([0.02 * n for n in range(FRAMES)], abs=2e-6)


@pytest.mark.parametrize("kind", ["ros1", "ros1-bz2", "ros1-lz4", "ros2-sqlite", "ros2-mcap", "ros2-mcap-zstd"])
def test_bags_of_another_writer_are_read_bit_for_bit(program, tmp_path: Path, kind: str) -> None:
    check(program, write(tmp_path, kind), tmp_path)


@pytest.mark.parametrize(
    ("what", "unit_m"),
    [({"depth": "32FC1"}, 1e-4), ({"depth": "big"}, 1e-3), ({"depth": "mono16", "padding": 6}, 1e-3)],
)
def test_encodings_of_depth(program, tmp_path: Path, what: dict[str, Any], unit_m: float) -> None:
    check(program, write(tmp_path, "ros2-mcap", **what), tmp_path, unit_m=unit_m)


def test_topics_are_chosen_by_name_where_they_are_not_clear(program, tmp_path: Path) -> None:
    given = write(tmp_path, "ros2-sqlite", second_depth=True)
    # The other one is no less a depth image.
    done = convert(program, given, tmp_path / "no")
    assert done.returncode != 0 and "choose one with --depth-topic" in done.stderr, done.stderr
    assert NAMES["depth"] in done.stderr and "/other/depth/image" in done.stderr
    check(program, given, tmp_path, "--depth-topic", NAMES["depth"])
    done = convert(program, given, tmp_path / "no", "--depth-topic", "/nothing")
    assert "--depth-topic /nothing has no images in it; it has" in done.stderr
    done = convert(program, given, tmp_path / "no", "--depth-topic", NAMES["grey"])
    assert "depth is 16UC1 or 32FC1" in done.stderr


@pytest.mark.parametrize("encoding", ["rgb8", "bgr8"])
def test_colour_is_the_outline_where_depth_is_aligned_to_it(program, tmp_path: Path, encoding: str) -> None:
    given = write(tmp_path, "ros2-mcap", colour=encoding, no_grey=True)
    done = convert(program, given, tmp_path / "no")
    assert "give --outline-topic where depth is aligned to colour" in done.stderr, done.stderr
    order = [0.299, 0.587, 0.114] if encoding == "rgb8" else [0.114, 0.587, 0.299]
    done = convert(program, given, tmp_path / "out", "--outline-topic", "/cam/color/image_raw")
    assert done.returncode == 0, done.stderr
    assert np.abs(read(tmp_path / "out", "infrared") - COLOUR @ np.array(order)).max() < 1.5
    assert json.loads((tmp_path / "out" / "camera.json").read_text())["outline"].lower() == "colour"


def test_a_bag_without_its_camera_says_what_to_give(program, tmp_path: Path) -> None:
    given = write(tmp_path, "ros1", no_info=True)
    done = convert(program, given, tmp_path / "no")
    assert done.returncode != 0 and "it has no camera info for /cam/depth/image_rect_raw: give --info-topic" in done.stderr
    camera = {"size": [WIDTH, HEIGHT], "focal_px": [K[0], K[4]], "centre_px": [K[2], K[5]], "depth_unit_m": 0.001,
              "baseline_m": 0.05, "camera": "mine"}
    (tmp_path / "camera.json").write_text(json.dumps(camera))
    check(program, given, tmp_path, "--camera-file", str(tmp_path / "camera.json"))
    camera["size"] = [640, 480]
    (tmp_path / "camera.json").write_text(json.dumps(camera))
    done = convert(program, given, tmp_path / "no", "--camera-file", str(tmp_path / "camera.json"))
    assert "its camera has 640 x 480 pixels, and its depth images have 64 x 48" in done.stderr


def test_what_cannot_be_read_is_said(program, tmp_path: Path) -> None:
    def refused(words: str, kind: str, **what: Any) -> None:
        folder = tmp_path / f"{kind}-{len(list(tmp_path.iterdir()))}"
        folder.mkdir()
        done = convert(program, write(folder, kind, **what), folder / "no")
        assert done.returncode == 1 and words in done.stderr, done.stderr
        assert not (folder / "no").exists()

    raw = {"names": {"depth": "/cam/depth/image_raw"}}
    refused("are distorted (a coefficient of 0.1): rectify them with image_proc", "ros2-mcap", d=[0.1, 0.0, 0.0, 0.0, 0.0], **raw)
    refused("it has no depth images (16UC1 or 32FC1)", "ros1", depth="yuv422")
    refused("each of its messages is compressed", "ros2-sqlite-message")
    refused("unpacked by zstd -d", "ros2-sqlite-file")
    # Cut off in the middle.
    torn = write(tmp_path, "ros1-bz2")
    torn.write_bytes(torn.read_bytes()[: torn.stat().st_size // 2])
    done = convert(program, torn, tmp_path / "torn")
    assert done.returncode == 1 and "is cut off" in done.stderr, done.stderr
