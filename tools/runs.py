# SPDX-License-Identifier: Apache-2.0
"""What a run measured: summary.json, and figures that only its snapshots or its list of fragments hold. For check.py and validate.py."""
import csv
import json
import os
import tomllib

DISPLAY = {"m": (1e3, "mm"), "rad": (57.29577951308232, "deg"), "Pa": (1e-9, "GPa"), "kg": (1e6, "mg"), "m/s": (1e-3, "km/s")}
ON_AXIS = 1e-9                 # [m]
SHOCK_BAND = (0.5e-3, 1.5e-3)  # between two shocks: distance from the plane of contact, and the radius [m]


def shown(value, unit):
    """(value, unit) as people write it."""
    scale, name = DISPLAY.get(unit, (1, unit))
    return scale * value, name


def text(value, unit):
    if isinstance(value, bool):
        return "yes" if value else "no"
    value, unit = shown(value, unit)
    return f"{value:.4g} {unit}".rstrip()


def summary(run):
    with open(os.path.join(run, "summary.json")) as f:
        return json.load(f)


def case(run):
    """The resolved case, SI."""
    with open(os.path.join(run, "case.toml"), "rb") as f:
        return tomllib.load(f)


def last_snapshot(run):
    import h5py
    with h5py.File(os.path.join(run, "run.h5"), "r") as f:
        steps = sorted((g for g in f if "time" in f[g].attrs), key=lambda g: f[g].attrs["time"])

        def read(g):
            s = {k: f[g][k][:] for k in ("node_x", "node_v", "element_node", "particle_x", "particle_v") if k in f[g]}
            for kind in ("element", "particle"):
                s.update({f"{kind}/{k}": d[:] for k, d in f[g].get(kind, {}).items()})
            return s | {"time": float(f[g].attrs["time"])}
        return read(steps[0]), read(steps[-1])


def axis(run):
    """Gap between the projectile and the body below it on the axis, and the highest pressure there, in the last snapshot. On the axis:
    elements with a node on it, and particles nearer to it than their own size."""
    import numpy as np
    _, s = last_snapshot(run)
    node, x = s["element_node"].reshape(-1, 8), s["node_x"]
    particle = s["particle_x"].reshape(-1, 3)
    corner_z = x[node, 2]
    size = s.get("particle/size", np.zeros(0))
    near = np.concatenate([np.hypot(x[node, 0], x[node, 1]).min(1) < ON_AXIS, np.hypot(particle[:, 0], particle[:, 1]) < size])
    low = np.concatenate([corner_z.min(1), particle[:, 2] - 0.5 * size])
    high = np.concatenate([corner_z.max(1), particle[:, 2] + 0.5 * size])
    field = lambda name: np.concatenate([s[f"element/{name}"], s.get(f"particle/{name}", np.zeros(0))])
    body, result = field("body").astype(int), {}
    if near.any():
        result["axis.pressure"] = (float(field("pressure")[near].max()), "Pa")
    upper, lower = near & (body == 0), near & (body == 1)
    if upper.any() and lower.any():
        result["axis.gap"] = (float(max(0.0, low[upper].min() - high[lower].max())), "m")
    return result


def shock(run):
    """State between the shocks of two like plates, the upper one moving down onto the lower one's face at z = 0: mass-weighted means
    over elements away from the plane of contact, where the start of a shock leaves heat in any scheme with artificial viscosity
    (Noh, J. Comput. Phys. 72 (1987) 78)."""
    import numpy as np
    upper, lower = case(run)["body"][:2]
    speed = -0.5 * upper["velocity"][2]
    gap = (upper["center"][2] - 0.5 * upper["size"][2]) - (lower["center"][2] + 0.5 * lower["size"][2])
    _, s = last_snapshot(run)
    node = s["element_node"]
    centre, velocity = s["node_x"][node].mean(1), s["node_v"][node].mean(1)
    away = abs(centre[:, 2] + speed * (s["time"] - gap / (2 * speed)))
    near, reach = SHOCK_BAND
    inside = (np.hypot(centre[:, 0], centre[:, 1]) < reach) & (away < reach) & (away > near)
    mean = lambda a: float(np.average(a[inside], weights=s["element/mass"][inside]))
    rho_0 = case(run)["materials"][upper["material"]]["rho_0"]
    return {"shock.pressure": (mean(s["element/pressure"]), "Pa"), "shock.compression": (mean(s["element/density"]) / rho_0, ""),
            "shock.velocity": (-mean(velocity[:, 2]), "m/s"), "shock.energy": (mean(s["element/internal_energy"]), "J/kg")}


DERIVED = {"axis": axis, "shock": shock}  # by the first part of a key


def measured(run, keys):
    """{key: (value, unit)} of those keys that the run has."""
    stored = {k: (m["value"], m["unit"]) for k, m in summary(run)["measurements"].items()}
    for owner in sorted({k.split(".")[0] for k in keys} & DERIVED.keys()):
        stored.update(DERIVED[owner](run))
    return {k: stored[k] for k in keys if k in stored}


def series(run, key):
    """[(time, value)] of one key in measurements.csv, which `ejecta measure --series` writes."""
    with open(os.path.join(run, "measurements.csv"), newline="") as f:
        return [(float(r["time_s"]), float(r["value"])) for r in csv.DictReader(f) if r["key"] == key]
