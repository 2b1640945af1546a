#!/usr/bin/env python3
"""Reads estimates from `meniscus run --publish unix:PATH` and prints the highest point of the surface.

    python3 examples/client.py /run/meniscus.sock [--count 100]

Only the standard library. The format is in firmware-config/SPEC.md: records stuffed by COBS, a zero byte behind
each, numbers as postcard writes them.
"""

import argparse
import socket
import struct

MODES = ["filling", "tracking", "coasting", "halted"]
GROUPS = ["q", "v", "e", "sigma", "tau", "surface"]
LATENTS = 13
OUTPUT_VERSION = 3


def unstuff(data):
    """Takes the COBS stuffing out of one record, without its zero byte."""
    out, at = bytearray(), 0
    while at < len(data):
        code = data[at]
        out += data[at + 1 : at + code]
        at += code
        if code < 255 and at < len(data):
            out.append(0)
    return bytes(out)


class Reader:
    """postcard's numbers, one after another."""

    def __init__(self, data):
        self.data, self.at = data, 0

    def varint(self):
        value = shift = 0
        while True:
            byte = self.data[self.at]
            self.at += 1
            value |= (byte & 0x7F) << shift
            if byte < 0x80:
                return value
            shift += 7

    def floats(self, kind, count):
        values = struct.unpack_from(f"<{count}{kind}", self.data, self.at)
        self.at += struct.calcsize(f"<{count}{kind}")
        return values


def estimate(record):
    """The front of a packet: times, model, mode, latents with their covariance, heights with their half-widths."""
    reader = Reader(record)
    reader.at = 1
    said = {"number": reader.varint(), "camera_us": reader.varint()}
    said["sequence"] = reader.varint() if reader.varint() else None
    said["host"] = None
    if reader.varint():
        said["host"] = {"unix_ns": reader.varint(), "std_ns": reader.varint(), "latency_us": reader.varint()}
    said["model_version"] = reader.varint()
    known = reader.varint()
    said["known"] = [name for bit, name in enumerate(GROUPS) if known >> bit & 1]
    said["mode"] = MODES[reader.varint()]
    said["latent"] = reader.floats("d", LATENTS)
    # The lower triangle of a symmetric matrix, row by row.
    packed = reader.floats("f", LATENTS * (LATENTS + 1) // 2)
    said["covariance"] = [[packed[max(i, j) * (max(i, j) + 1) // 2 + min(i, j)] for j in range(LATENTS)]
                          for i in range(LATENTS)]
    said["surface_m"] = reader.floats("f", 21)
    said["half_m"] = reader.floats("f", 21)
    return said


def records(path):
    """Whole records, as they come."""
    with socket.socket(socket.AF_UNIX, socket.SOCK_STREAM) as stream:
        stream.connect(path)
        waiting = b""
        while chunk := stream.recv(65536):
            *whole, waiting = (waiting + chunk).split(b"\0")
            yield from (unstuff(record) for record in whole if record)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("path", help="the socket")
    parser.add_argument("--count", type=int, default=0, help="estimates to print; 0: all")
    arguments = parser.parse_args()
    printed = 0
    for record in records(arguments.path):
        if record[0] != OUTPUT_VERSION:
            continue  # a field frame
        said = estimate(record)
        highest = max(range(21), key=lambda point: said["surface_m"][point])
        line = (f"{said['number']:6} {said['camera_us'] / 1e6:9.3f} s {said['mode']:8} "
                f"highest {1e3 * said['surface_m'][highest]:.1f} mm +- {1e3 * said['half_m'][highest]:.1f} mm")
        if said["host"]:
            line += f", {said['host']['latency_us'] / 1e3:.1f} ms after mid-exposure"
        if "surface" not in said["known"]:
            line += ", of another liquid"
        print(line, flush=True)
        printed += 1
        if printed == arguments.count:
            return


if __name__ == "__main__":
    main()
