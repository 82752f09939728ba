#!/usr/bin/python3
"""Compares the state between the shocks of cases/flyer_plate with the jump conditions.

    check.py [DIR]          DIR: folder of the run, default runs/flyer_plate-fem

Reads the latest snapshot up to 0.4 us. Everything is a mass-weighted mean over the elements within 1.5 mm of the axis and
0.5 to 1.5 mm from the plane of contact: the first elements on either side carry the heat that the start of a shock leaves in
any scheme with artificial viscosity (Noh, J. Comput. Phys. 72 (1987) 78). Exit code 1 beyond a tolerance of reference.csv.
"""
import csv
import os
import sys

import h5py
import numpy as np

TIME = 0.4e-6        # both shocks are still inside their plates [s]
NEAR, REACH = 0.5e-3, 1.5e-3   # [m]
RHO_0 = 2785.0       # [kg/m3]
MEET, SPEED = 0.002e-3 / 2000.0, 1000.0   # time of contact [s] and speed of the plane of contact [m/s]


def middle_state(path):
    """(time, {quantity: value}) between the shocks."""
    with h5py.File(path, "r") as f:
        steps = sorted((g for g in f if "time" in f[g].attrs), key=lambda g: f[g].attrs["time"])
        group = f[[g for g in steps if f[g].attrs["time"] <= TIME * (1 + 1e-9)][-1]]
        node, x, v = group["element_node"][:], group["node_x"][:], group["node_v"][:]
        field = {k: group["element/" + k][:] for k in ("mass", "density", "pressure", "internal_energy")}
        time = float(group.attrs["time"])
    centre, velocity = x[node].mean(1), v[node].mean(1)
    plane = -SPEED * (time - MEET)
    away = abs(centre[:, 2] - plane)
    inside = (np.hypot(centre[:, 0], centre[:, 1]) < REACH) & (away < REACH) & (away > NEAR)
    mean = lambda a: float(np.average(a[inside], weights=field["mass"][inside]))
    return time, {
        "pressure between the shocks": mean(field["pressure"]) / 1e9,
        "density over reference density": mean(field["density"]) / RHO_0,
        "velocity between the shocks": -mean(velocity[:, 2]),
        "specific internal energy": mean(field["internal_energy"]) / 1e6,
    }


def main():
    run = sys.argv[1] if len(sys.argv) > 1 else "runs/flyer_plate-fem"
    time, found = middle_state(os.path.join(run, "run.h5"))
    here = os.path.dirname(os.path.abspath(__file__))
    print(f"{run}, t = {time * 1e6:.3f} us")
    print(f"{'quantity':32} {'computed':>10} {'expected':>10} {'error':>8} {'allowed':>8}")
    bad = 0
    with open(os.path.join(here, "reference.csv"), newline="") as f:
        for row in csv.DictReader(f):
            value, expected, allowed = found[row["quantity"]], float(row["value"]), float(row["tolerance"])
            error = value / expected - 1
            wrong = not abs(error) <= allowed
            bad += wrong
            print(f"{row['quantity']:32} {value:10.4g} {expected:10.4g} {100 * error:+7.2f}% {100 * allowed:7.1f}%"
                  + ("  BEYOND" if wrong else ""))
    sys.exit(1 if bad else 0)


main()
