#!/usr/bin/env python3
"""The first mode of the liquid as a pendulum: a simulator for `meniscus discover` and meniscus_liquid.discover.

    meniscus discover --recordings mine --simulator "python3 examples/one_mode.py" --library viscosity,yield_stress --out found

With x the height of the surface at the wall (Faltinsen and Timokha, "Sloshing", 2009, chapter 5, for the frequency):

    x'' + 2 d x' + r sign(x') + w^2 x = -c a(t)
    w^2 = k g tanh(k h),  k = 1.841/R,  d = 0.65 sqrt(nu w)/R + 2 k^2 nu,  r = 10 yield_stress/(rho R),  c = 1.53 tanh(k h)
"""

import json
import math
import sys


def simulate(scene):
    """Returns the heights by motion, frame and point, m."""
    glass, liquid, effects = scene["glass"], scene["liquid"], scene["effects"]
    radius, fill, rho, g = glass["radius_m"], glass["fill_m"], liquid["density_kg_m3"], scene["gravity_m_s2"]
    nu = effects.get("viscosity", liquid["viscosity_pa_s"]) / rho
    k = 1.841 / radius
    w2 = k * g * math.tanh(k * fill)
    d = 0.65 * math.sqrt(nu * math.sqrt(w2)) / radius + 2.0 * k * k * nu
    r = 10.0 * effects.get("yield_stress", 0.0) / (rho * radius)
    return [[[fill + x * point[0] / radius for point in scene["points_m"]] for x in crest(motion, scene, w2, d, r, k * fill)]
            for motion in scene["motions"]]


def crest(motion, scene, w2, d, r, depth):
    """Returns the crest of each frame, m, by small steps between the samples of the motion."""
    time, push = motion["time_s"], motion["acceleration_m_s2"]
    x, v, out, steps = 0.0, 0.0, [], 4
    per_frame = round(scene["frame_interval_s"] / (time[1] - time[0]))
    for n in range(motion["frames"] * per_frame):
        if n % per_frame == 0:
            out.append(x)
        dt = (time[n + 1] - time[n]) / steps
        for i in range(steps):
            a = push[n] + (push[n + 1] - push[n]) * i / steps
            v += dt * (-w2 * x - 2.0 * d * v - 1.53 * math.tanh(depth) * a)
            v = math.copysign(max(abs(v) - dt * r, 0.0), v)
            x += dt * v
    return out


if __name__ == "__main__":
    with open(sys.argv[1]) as request:
        scene = json.load(request)
    unknown = set(scene["effects"]) - {"viscosity", "yield_stress"}
    answer = {"failed": f"this model has no {', '.join(sorted(unknown))}"} if unknown else {"heights_m": simulate(scene)}
    with open(sys.argv[2], "w") as file:
        json.dump({"meniscus_simulator": 1, **answer}, file)
