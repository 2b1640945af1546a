#!/usr/bin/env python3
"""A robot's side of Meniscus: reads the controller's records, sends the motion of the glass, hands in a plan.

    meniscus run --source usb --publish unix:/tmp/m.sock --controller --plan udp:127.0.0.1:9001 --motion udp:127.0.0.1:9000
    python3 examples/robot.py read /tmp/m.sock --count 100
    python3 examples/robot.py move 127.0.0.1:9000 --seconds 5
    python3 examples/robot.py plan 127.0.0.1:9001 --distance 0.05 --seconds 0.5

Only the standard library. The formats are in docs/robots.md.
"""

import argparse
import math
import socket
import struct
import time

from client import LATENTS, MODES, Reader, records

CONTROL_KIND, CONTROL_VERSION = ord("C"), 1
FAULTS = ["none", "version", "layout", "too few samples", "too many samples", "spacing of the stamps", "range",
          "begins in the past", "ends too far ahead", "ends while moving"]
HOST_CLOCK, ACCELERATION = 1, 4


class ControlReader(Reader):
    """postcard's numbers, with the forms that a controller's record has beside those of a packet."""

    def byte(self):
        self.at += 1
        return self.data[self.at - 1]

    def option(self, read):
        return read() if self.byte() else None

    def rows(self, count, columns):
        return [self.floats("f", columns) for _ in range(count)]


def control(record):
    """A controller's record as a dictionary; None for a record of another kind or version."""
    if record[:2] != bytes([CONTROL_KIND, CONTROL_VERSION]):
        return None
    r = ControlReader(record)
    r.at = 2
    said = {"number": r.varint(), "camera_us": r.varint()}
    said["host"] = r.option(lambda: {"unix_ns": r.varint(), "std_ns": r.varint(), "latency_us": r.varint()})
    said["mode"] = MODES[r.varint()]
    mode = lambda: dict(zip(("amplitude_m", "rate_m_s"), r.floats("f", 2)))
    said["along"] = [mode(), mode()]
    said["along_covariance"] = r.rows(4, 4)
    said["across"] = r.option(mode)
    said["across_covariance"] = r.rows(2, 2)
    number = lambda: r.floats("f", 1)[0]
    said["spill"] = {"horizon": r.varint(), "planned": r.varint(), "probability": number(),
                     "crest_turn": r.varint(), "crest_m": number(), "crest_half_m": number()}
    said["plan"] = {"sequence": r.option(r.varint), "across_m": number(), "taken": r.varint(),
                    "refused": r.varint(), "last_fault": FAULTS[r.byte()]}
    said["forecast"] = [{"ahead": r.varint(), "surface_m": r.floats("f", 21), "half_width_m": r.floats("f", 21)}
                        for _ in range(r.varint())]
    said["linear"] = r.option(lambda: {
        "dt_s": r.floats("d", 1)[0], "latent": r.floats("d", LATENTS), "next": r.floats("d", LATENTS),
        "a": r.rows(LATENTS, LATENTS), "b": r.floats("f", LATENTS), "q": r.rows(LATENTS, LATENTS),
        "acceleration_m_s2": number(), "heights_m": r.floats("f", 21), "c": r.rows(21, LATENTS),
        "d": r.floats("f", 21)})
    said["chain"] = [{"acceleration_m_s2": number(), "latent": r.floats("f", LATENTS), "a": r.rows(LATENTS, LATENTS),
                      "b": r.floats("f", LATENTS), "heights_m": r.floats("f", 21), "c": r.rows(21, LATENTS)}
                     for _ in range(r.varint())]
    said["skipped"] = r.varint()
    if r.at != len(record):
        raise ValueError(f"{len(record) - r.at} bytes are left behind the record")
    return said


def motion_frame(sequence, stamp_ns, position_m, acceleration_m_s2):
    """One stamped sample on this computer's clock."""
    head = struct.pack("<4sBBHIQ", b"MNSM", 1, HOST_CLOCK | ACCELERATION, 0, sequence, stamp_ns)
    return head + struct.pack("<6d", *position_m, *acceleration_m_s2)


def plan_frame(sequence, samples):
    """A plan of (stamp in ns since 1970, (x, y, z) in m)."""
    head = struct.pack("<4sBBHI", b"MNSP", 1, HOST_CLOCK, len(samples), sequence)
    return head + b"".join(struct.pack("<Q3d", stamp_ns, *position_m) for stamp_ns, position_m in samples)


def read(arguments):
    """Prints the first mode, the risk of spilling and the plan."""
    printed = 0
    for record in records(arguments.path):
        said = control(record)
        if said is None:
            continue
        first, std = said["along"][0], math.sqrt(said["along_covariance"][0][0])
        line = (f"{said['number']:6} {said['mode']:8} {1e3 * first['amplitude_m']:+7.2f} mm +- {1e3 * std:.2f} mm, "
                f"{1e3 * first['rate_m_s']:+8.1f} mm/s, spill {100 * said['spill']['probability']:.1f} %")
        if said["plan"]["sequence"] is not None:
            line += f", plan {said['plan']['sequence']} with {len(said['forecast'])} forecasts"
        if said["plan"]["refused"]:
            line += f", {said['plan']['refused']} plans refused ({said['plan']['last_fault']})"
        if said["linear"]:
            line += f", A[0][0] {said['linear']['a'][0][0]:.3f}"
        print(line, flush=True)
        printed += 1
        if printed == arguments.count:
            return


def address(text):
    host, _, port = text.rpartition(":")
    return host, int(port)


def token(arguments):
    """The word before each datagram, with a space."""
    if not arguments.token_file:
        return b""
    with open(arguments.token_file, encoding="ascii") as file:
        return file.read().strip().encode() + b" "


def move(arguments):
    """Sends 500 samples a second of a swing of 5 mm at 1 Hz."""
    word, begun_ns, omega = token(arguments), time.time_ns(), 2 * math.pi
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
        for sequence in range(round(500 * arguments.seconds)):
            t = (time.time_ns() - begun_ns) * 1e-9
            x = 0.005 * math.sin(omega * t)
            frame = motion_frame(sequence, begun_ns + round(1e9 * t), (x, 0, 0), (-omega * omega * x, 0, 0))
            sender.sendto(word + frame, arguments.address)
            time.sleep(0.002)


def plan(arguments):
    """Hands in a move that begins now and ends at rest: x = d (10 s^3 - 15 s^4 + 6 s^5)."""
    begun_ns, count = time.time_ns() + 50_000_000, round(100 * arguments.seconds) + 2
    samples = []
    for k in range(count):
        s = min(1.0, 0.01 * k / arguments.seconds)
        x = arguments.distance * s**3 * (10 - 15 * s + 6 * s * s)
        samples.append((begun_ns + k * 10_000_000, (x, 0, 0)))
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
        sender.sendto(token(arguments) + plan_frame(arguments.sequence, samples), arguments.address)
    print(f"plan {arguments.sequence}: {count} samples sent")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    verbs = parser.add_subparsers(required=True)
    verb = verbs.add_parser("read", help="print the controller's records")
    verb.add_argument("path", help="the Unix socket")
    verb.add_argument("--count", type=int, default=0, help="records to print; 0: all")
    verb.set_defaults(run=read)
    for name, run, what in (("move", move, "send the motion"), ("plan", plan, "hand in a plan")):
        verb = verbs.add_parser(name, help=what)
        verb.add_argument("address", type=address, help="HOST:PORT")
        verb.add_argument("--seconds", type=float, default=0.5, help="length of it")
        verb.add_argument("--token-file", help="the word of --motion-token-file")
        verb.set_defaults(run=run)
    verb.add_argument("--distance", type=float, default=0.05, help="way along x, m")
    verb.add_argument("--sequence", type=int, default=1, help="number of the plan")
    arguments = parser.parse_args()
    arguments.run(arguments)


if __name__ == "__main__":
    main()
