"""Heights of a recording of the simulator as plain numbers: heights.py RECORDING FRAMES OUT."""

import json
import struct
import sys

recording, frames, out = sys.argv[1], int(sys.argv[2]), sys.argv[3]
with open(recording, "rb") as file:
    (length,) = struct.unpack("<Q", file.read(8))
    header = json.loads(file.read(length))
    entry = header["profile_m"]
    start, end = entry["data_offsets"]
    file.seek(8 + length + start)
    data = file.read(end - start)
points = entry["shape"][1]
assert entry["dtype"] == "F32" and len(data) == 4 * entry["shape"][0] * points, entry
with open(out, "wb") as file:
    file.write(data[: 4 * frames * points])
