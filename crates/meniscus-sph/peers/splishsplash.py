#!/usr/bin/env python3
"""The simulator beside SPlisHSPlasH: same glass, spacing, liquid and motion, in one run.

    python3 -m venv peer && peer/bin/pip install -r crates/meniscus-sph/peers/requirements.txt
    peer/bin/python crates/meniscus-sph/peers/splishsplash.py --meniscus target/release/meniscus

The glass (35 mm, filled to 70 mm with water) stands, is pushed by 8 mm (--push-mm) within 0.2 s, and rings down. Both programs have one
thread. The settings of the peer are those below: DFSPH (Bender and Koschier 2015), boundaries of sampled particles (Akinci et
al. 2012), steps by CFL. It has no viscosity: its own numerical one is far above that of water. Both start from a settled
liquid. The cost of the peer is that of its steps in the motion; that of this project is of the whole command, the recording included.

Theory is linear: the first mode of an inviscid liquid has w^2 = g k tanh(k h), k = 1.8412 / R, so 3.613 Hz. That of water
between walls without slip has 3.612 Hz and decays by 0.083 /s (a Ritz solution, docs/validation).
"""

import argparse
import ctypes
import importlib.util
import json
import math
import os
import resource
import struct
import subprocess
import sys
import tempfile
import time
from pathlib import Path

os.environ["OMP_NUM_THREADS"] = "1"

import numpy as np  # noqa: E402

RADIUS_M, FILL_M, RIM_M = 0.035, 0.070, 0.110
SPACING_M = 0.005
GRAVITY = 9.81
PUSH_S, SETTLE_S = 0.2, 0.6
DENSITY, END_S = 998.0, 3.0
# Theory.
FREQUENCY_HZ, DECAY_S = 3.612, 0.083
# Free of the push's own motion.
RING_FROM_S = PUSH_S + 0.05


def push(t, push_m):
    """Position of the glass, m: 10 s^3 - 15 s^4 + 6 s^5."""
    s = min(max(t / PUSH_S, 0.0), 1.0)
    return push_m * s**3 * (10.0 - 15.0 * s + 6.0 * s * s)


def acceleration(t, push_m):
    """Acceleration of the glass, m/s2."""
    s = t / PUSH_S
    return push_m / PUSH_S**2 * (60.0 * s - 180.0 * s**2 + 120.0 * s**3) if 0.0 < s < 1.0 else 0.0


def cylinder(path, steps=128):
    """The wall and the bottom of the glass as a closed surface, half a spacing outside: the peer's boundary particles lie on
    it, and the liquid's keep a spacing from them."""
    radius, bottom, top = RADIUS_M + 0.5 * SPACING_M, -0.5 * SPACING_M, 2.0 * RIM_M
    vertices, faces = [(0.0, 0.0, bottom), (0.0, 0.0, top)], []
    for z in (bottom, top):
        vertices += [
            (radius * math.cos(2 * math.pi * k / steps), radius * math.sin(2 * math.pi * k / steps), z)
            for k in range(steps)
        ]
    for k in range(steps):
        a, b = 3 + k, 3 + (k + 1) % steps
        faces += [(1, b, a), (2, a + steps, b + steps), (a, b, b + steps), (a, b + steps, a + steps)]
    lines = [f"v {x:.8f} {y:.8f} {z:.8f}" for x, y, z in vertices] + [f"f {a} {b} {c}" for a, b, c in faces]
    path.write_text("\n".join(lines) + "\n")


def packed():
    """Particles on rings, as many as the volume has at this spacing."""
    places, layers = [], round(FILL_M / SPACING_M)
    rings = round(RADIUS_M / SPACING_M)
    for layer in range(layers):
        z = (layer + 0.5) * FILL_M / layers
        for ring in range(rings):
            r = (ring + 0.5) * RADIUS_M / rings
            count = max(1, round(2 * math.pi * r / SPACING_M))
            turn = 0.7 * layer + 0.3 * ring
            places += [
                (r * math.cos(turn + 2 * math.pi * k / count), r * math.sin(turn + 2 * math.pi * k / count), z)
                for k in range(count)
            ]
    return places


def bgeo(places):
    """Points in Houdini's binary geometry, version 5, big-endian: a head, then x, y, z, 1 of each."""
    head = b"BgeoV" + struct.pack(">9i", 5, len(places), 0, 0, 0, 0, 0, 0, 0)
    return head + b"".join(struct.pack(">4f", *place, 1.0) for place in places)


class Peer:
    """SPlisHSPlasH before one glass."""

    def __init__(self, folder):
        import pysplishsplash as splash

        self.splash = splash
        mesh, cloud, scene = folder / "glass.obj", folder / "liquid.bgeo", folder / "scene.json"
        cylinder(mesh)
        self.places = packed()
        cloud.write_bytes(bgeo(self.places))
        scene.write_text(json.dumps(self.scene(mesh, cloud)))
        self.base = splash.Exec.SimulatorBase()
        self.base.init(sceneFile=str(scene), useGui=False, initialPause=False, outputDir=str(folder / "out"))
        self.base.initSimulation()
        self.simulation = splash.Simulation.getCurrent()
        self.liquid = self.simulation.getFluidModel(0)

    @staticmethod
    def scene(mesh, cloud):
        return {
            "Configuration": {
                "particleRadius": 0.5 * SPACING_M,
                "simulationMethod": 4,
                "gravitation": [0.0, 0.0, -GRAVITY],
                "timeStepSize": 0.001,
                "cflMethod": 1,
                "cflFactor": 0.4,
                "cflMinTimeStepSize": 1e-5,
                "cflMaxTimeStepSize": 0.002,
                "boundaryHandlingMethod": 0,
                "enableZSort": True,
                "maxError": 0.01,
                "maxErrorV": 0.05,
            },
            "Materials": [{"id": "Fluid", "density0": DENSITY, "viscosityMethod": 0}],
            "RigidBodies": [
                {
                    "geometryFile": str(mesh),
                    "translation": [0, 0, 0],
                    "rotationAxis": [1, 0, 0],
                    "rotationAngle": 0,
                    "scale": [1, 1, 1],
                    "isDynamic": False,
                    "isWall": True,
                    "samplingMode": 0,
                }
            ],
            "FluidModels": [{"particleFile": str(cloud), "id": "Fluid"}],
        }

    def measure(self):
        """Centre of mass along x, m, and root mean square speed, m/s."""
        count = self.liquid.numActiveParticles()
        x = sum(self.liquid.getPosition(k)[0] for k in range(count)) / count
        square = sum(float(np.dot(v, v)) for v in (self.liquid.getVelocity(k) for k in range(count))) / count
        return x, math.sqrt(square)

    def run(self, push_m, result):
        """Settles, plays the motion, writes times, centres and the cost of the motion to `result`, and ends the process."""
        clock = self.splash.TimeManager.getCurrent()
        gravitation = self.splash.Simulation.GRAVITATION
        ran = {"t": [], "a": [], "cost": 0.0, "rest_mm_s": None, "due": 0.0, "cpu": None}

        def after_step():
            now_cpu = time.process_time()
            t = clock.getTime() - SETTLE_S
            if t < 0.0:
                return
            if ran["rest_mm_s"] is None:
                ran["rest_mm_s"] = 1e3 * self.measure()[1]
            else:
                # The step alone: what this function does between two steps is no cost of the peer.
                ran["cost"] += now_cpu - ran["cpu"]
            if t >= ran["due"]:
                ran["t"].append(t)
                ran["a"].append(self.measure()[0])
                ran["due"] += 1.0 / 60.0
            if t >= END_S:
                heights = [self.liquid.getPosition(k)[2] for k in range(self.liquid.numActiveParticles())]
                found = {key: ran[key] for key in ("t", "a", "rest_mm_s")}
                found |= {"cost": ran["cost"] / t, "particles": len(self.places), "lost": sum(z < -SPACING_M for z in heights)}
                result.write_text(json.dumps(found, default=lambda number: number.item()))
                # The loop of the peer does not come back to here.
                os._exit(0)
            self.simulation.setVec3ValueReal(gravitation, [-acceleration(t, push_m), 0.0, -GRAVITY])
            ran["cpu"] = time.process_time()

        self.base.setTimeStepCB(after_step)
        # It does not start without an end; the end above comes first.
        self.base.setValueFloat(self.base.STOP_AT, SETTLE_S + END_S + 1.0)
        self.base.runSimulation()


def ours(program, push_m, folder):
    """The same by the simulator of this project: the slope of the profile in place of the centre of mass."""
    table = folder / "push.csv"
    rows = [f"{k / 240:.6f},{push(k / 240, push_m):.9f}" for k in range(int(240 * END_S) + 24)]
    table.write_text("t,x_m\n" + "\n".join(rows) + "\n")
    cost = None
    # The first run settles the liquid and keeps it; the second starts from there.
    for turn in range(2):
        out = folder / f"water-{turn}.safetensors"
        words = [program, "simulate", "--liquid", "water", "--motion", str(table), "--seconds", str(END_S), "--out", str(out)]
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        subprocess.run(words, check=True, env={**os.environ, "RAYON_NUM_THREADS": "1"}, stdout=subprocess.DEVNULL)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        cost = (after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime) / END_S
    content = out.read_bytes()
    length = struct.unpack("<Q", content[:8])[0]
    head = json.loads(content[8 : 8 + length])
    begin, end = head["profile_m"]["data_offsets"]
    profile = np.frombuffer(content[8 + length + begin : 8 + length + end], dtype="<f4").reshape(-1, 21)
    across = np.linspace(-1.0, 1.0, 21)
    slope = (profile - profile.mean(axis=1, keepdims=True)) @ across
    return {"t": list(np.arange(len(slope)) / 60.0), "a": list(slope), "cost": cost}


def ring(times, amplitudes):
    """Frequency, Hz, and decay, 1/s, of c + A exp(-d t) cos(2 pi f t + p) by Gauss and Newton's least squares."""
    t, a = np.asarray(times), np.asarray(amplitudes)
    kept = t >= RING_FROM_S
    t, a = t[kept] - RING_FROM_S, a[kept]

    def linear(f, d):
        wave = np.exp(-d * t)
        basis = np.stack([np.ones_like(t), wave * np.cos(2 * math.pi * f * t), wave * np.sin(2 * math.pi * f * t)], axis=1)
        weights = np.linalg.lstsq(basis, a, rcond=None)[0]
        return a - basis @ weights

    # A grid first: the sum of squares has other minima.
    best = min(
        ((f, d) for f in np.linspace(2.8, 4.4, 65) for d in np.geomspace(0.02, 20.0, 40)),
        key=lambda fd: float(np.sum(linear(*fd) ** 2)),
    )
    f, d = best
    for _ in range(30):
        residual = linear(f, d)
        steps = (1e-5, 1e-4)
        jacobian = np.stack(
            [(linear(f + steps[0], d) - residual) / steps[0], (linear(f, d + steps[1]) - residual) / steps[1]], axis=1
        )
        change = np.linalg.lstsq(jacobian, -residual, rcond=None)[0]
        f, d = f + float(np.clip(change[0], -0.1, 0.1)), d + float(np.clip(change[1], -1.0, 1.0))
    return f, d


def row(name, value, unit, target=None, ok=None):
    return {"name": name, "value": value, "unit": unit, "target": target, "ok": ok}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--meniscus", default="meniscus", help="the program, built for release")
    parser.add_argument("--push-mm", type=float, default=8.0, help="distance of the push; default: 8")
    parser.add_argument("--json", action="store_true", help="print one object with a checks array")
    arguments = parser.parse_args()
    push_m = 1e-3 * arguments.push_mm
    checks = []
    with tempfile.TemporaryDirectory(prefix="splishsplash-") as name:
        folder = Path(name)
        print(f"SPlisHSPlasH, {SETTLE_S + END_S:.1f} s", file=sys.stderr)
        # The peer keeps its state in globals and writes on standard output: a process of its own.
        subprocess.run([sys.executable, __file__, "--peer", str(push_m), str(folder)], check=True, stdout=subprocess.DEVNULL)
        peer = json.loads((folder / "peer.json").read_text())
        print(f"meniscus, {END_S:.1f} s twice", file=sys.stderr)
        own = ours(arguments.meniscus, push_m, folder)
        for who, ran in (("meniscus", own), ("splishsplash", peer)):
            frequency, decay = ring(ran["t"], ran["a"])
            checks.append(row(f"{who}_frequency_error", 100 * (frequency / FREQUENCY_HZ - 1), "%"))
            checks.append(row(f"{who}_decay", decay, "1/s"))
            checks.append(row(f"{who}_cpu_s_per_s", ran["cost"], "s/s"))
        checks.append(row("decay_by_theory", DECAY_S, "1/s"))
        checks.append(row("splishsplash_rest_noise", peer["rest_mm_s"], "mm/s"))
        checks.append(row("splishsplash_particles", peer["particles"], "1"))
        checks.append(row("splishsplash_lost", peer["lost"], "1"))
        ratio = own["cost"] / peer["cost"]
        checks.append(row("cost_over_splishsplash", ratio, "1", "<= 0.12", ratio <= 0.12))
    if arguments.json:
        print(json.dumps({"checks": checks}, indent=1))
    else:
        for check in checks:
            verdict = "" if check["ok"] is None else "ok" if check["ok"] else "MISSED"
            print(f"{check['name']:<40}{check['value']:>12.4g} {check['unit']:<6}{check['target'] or 'informational':<16}{verdict}")
    return 0 if all(check["ok"] is not False for check in checks) else 1


def peer_alone(push_m, folder):
    """The part that runs in a process of its own."""
    # The wheel brings this library and does not load it.
    site = Path(importlib.util.find_spec("pysplishsplash").origin).parent
    for library in sorted((site / "pysplishsplash.libs").glob("libGLdispatch*")):
        ctypes.CDLL(str(library), mode=ctypes.RTLD_GLOBAL)
    Peer(folder).run(push_m, folder / "peer.json")


if __name__ == "__main__":
    if len(sys.argv) == 4 and sys.argv[1] == "--peer":
        peer_alone(float(sys.argv[2]), Path(sys.argv[3]))
    else:
        sys.exit(main())
