#!/usr/bin/python3
"""Compares the final shape of the bar of cases/taylor_copper with Johnson & Cook (1983).

    check.py [DIR]          DIR: folder of the run, default runs/taylor_copper-fem

From the last snapshot: length of the bar on the axis, diameter of the foot, diameter at 0.2 of the original length from the
foot (interpolated on the outline). The model is a quarter: the outline is read on y = 0. Exit code 1 beyond a tolerance of
reference.csv.
"""
import csv
import os
import sys

import h5py
import numpy as np

LENGTH = 25.4e-3     # original [m]


def final_shape(path):
    """(time, {quantity: mm}) of the last snapshot."""
    with h5py.File(path, "r") as f:
        first, last = (pick((f[g] for g in f if "time" in f[g].attrs), key=lambda g: g.attrs["time"]) for pick in (min, max))
        x_0, x, time = first["node_x"][:], last["node_x"][:], float(last.attrs["time"])
    foot = x[:, 2].min()
    on_axis = np.hypot(x_0[:, 0], x_0[:, 1]) < 1e-9
    # a node line up the skin: as built on the curved surface and on y = 0
    radius_0 = np.hypot(x_0[:, 0], x_0[:, 1])
    skin = np.flatnonzero((radius_0 > radius_0.max() * (1 - 1e-6)) & (abs(x_0[:, 1]) < 1e-9) & (x_0[:, 0] > 0))
    skin = skin[np.argsort(x_0[skin, 2])]
    height, radius = x[skin, 2] - foot, np.hypot(x[skin, 0], x[skin, 1])
    order = np.argsort(height, kind="stable")
    return time, {
        "final length": 1e3 * (x[on_axis, 2].max() - foot),
        "foot diameter": 2e3 * radius[height < 0.05 * LENGTH].max(),
        "diameter at 0.2 L0": 2e3 * float(np.interp(0.2 * LENGTH, height[order], radius[order])),
    }


def main():
    run = sys.argv[1] if len(sys.argv) > 1 else "runs/taylor_copper-fem"
    time, found = final_shape(os.path.join(run, "run.h5"))
    here = os.path.dirname(os.path.abspath(__file__))
    print(f"{run}, t = {time * 1e6:.1f} us")
    print(f"{'quantity':24} {'computed':>10} {'measured':>10} {'error':>8} {'allowed':>8}")
    bad = 0
    with open(os.path.join(here, "reference.csv"), newline="") as f:
        for row in csv.DictReader(f):
            value, expected, allowed = found[row["quantity"]], float(row["value"]), float(row["tolerance"])
            error = value / expected - 1
            wrong = not abs(error) <= allowed
            bad += wrong
            print(f"{row['quantity']:24} {value:7.2f} mm {expected:7.2f} mm {100 * error:+7.1f}% {100 * allowed:7.1f}%"
                  + ("  BEYOND" if wrong else ""))
    sys.exit(1 if bad else 0)


main()
