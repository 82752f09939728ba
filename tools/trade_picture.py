#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Cost against accuracy of a trade study: every run a point, those on the Pareto front joined.

    trade_picture.py TRADE.csv [--out FILE]        writes TRADE.png
"""
import argparse
import csv
import os

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import matplotlib.ticker

# Okabe & Ito: told apart by the colour-blind too
STYLE = {"hybrid": ("#D55E00", "o"), "erosion": ("#0072B2", "s"), "fem": ("#009E73", "^"), "sph": ("#CC79A7", "D")}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("table", metavar="TRADE.csv")
    parser.add_argument("--out", help="picture to write (default: beside the table)")
    a = parser.parse_args()
    with open(a.table, newline="") as f:
        runs = [r for r in csv.DictReader(f) if r["completed"] == "1"]
    figure, ax = plt.subplots(figsize=(8, 5.5), dpi=130)
    cost, error = (lambda r: float(r["cpu_seconds"])), (lambda r: 100 * float(r["error"]))
    front = sorted((r for r in runs if r["on_front"] == "1"), key=cost)
    ax.plot([cost(r) for r in front], [error(r) for r in front], color="#999999", linewidth=1.2, drawstyle="steps-post", zorder=1, label="Pareto front")
    for mode in dict.fromkeys(r["mode"] for r in runs):
        its = [r for r in runs if r["mode"] == mode]
        colour, marker = STYLE[mode]
        ax.scatter([cost(r) for r in its], [error(r) for r in its], color=colour, marker=marker, s=45, zorder=2, label=mode)
    for r in runs:
        ax.annotate(r["elements_across"], (cost(r), error(r)), textcoords="offset points", xytext=(6, 5), fontsize=8)
    ax.set_xscale("log")
    plain = matplotlib.ticker.FuncFormatter(lambda x, _: f"{x:g}")
    ax.xaxis.set_major_formatter(plain)
    if runs and max(map(cost, runs)) < 30 * min(map(cost, runs)):  # else they would cover each other
        ax.xaxis.set_minor_formatter(plain)
        ax.tick_params(axis="x", which="minor", labelsize=8)
    ax.set_ylim(bottom=0)
    ax.set_xlabel("processor time (s)")
    ax.set_ylabel("root mean square error of the measurements (%)")
    ax.set_title("Cost against accuracy; numbers: elements across the projectile", fontsize=11, loc="left")
    ax.grid(color="#E0E0E0", linewidth=0.5, which="both")
    ax.legend(fontsize=9)
    figure.tight_layout()
    figure.savefig(a.out or os.path.splitext(a.table)[0] + ".png")


main()
