#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""One picture of a run: six instants seen from the side, the energy ledger over time, the main measurements.

    picture.py DIR [--out FILE] [--color body|speed]        writes DIR/cloud.png

Reads run.h5, history.csv, summary.json and case.toml of DIR (layout of run.h5: io/snapshot.cpp). A half, quarter or eighth
is mirrored to its full width. The view is cut open along the plane that holds the line of flight: elements there and particles
close to it in full colour, and behind them, paler, the particles and the moving elements farther away, as dots of their size.
"""
import argparse
import csv
import json
import os
import sys
import tomllib

import h5py
import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.collections import EllipseCollection, PolyCollection

# Okabe & Ito: told apart by the colour-blind too
PALETTE = ["#D55E00", "#0072B2", "#009E73", "#CC79A7", "#E69F00", "#56B4E9"]
FACES = np.array([[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]])
AXES = "xyz"
LEDGER = ["kinetic", "internal", "hourglass", "contact", "conversion", "eroded_kinetic", "eroded_internal"]
MM, US = 1e3, 1e6


# ---------------------------------------------------------------------------------------------- reading

class Run:
    """A folder that `ejecta run` made."""

    def __init__(self, folder):
        self.folder = folder
        with open(self.path("case.toml"), "rb") as f:
            self.case = tomllib.load(f)
        with open(self.path("summary.json")) as f:
            self.summary = json.load(f)
        with open(self.path("history.csv"), newline="") as f:
            self.history = list(csv.DictReader(f))
        with h5py.File(self.path("run.h5"), "r") as f:
            names = sorted((g for g in f if "time" in f[g].attrs), key=lambda g: f[g].attrs["time"])
            self.groups = names
            self.times = np.array([float(f[g].attrs["time"]) for g in names])
        self.bodies = self.case["body"]
        symmetry = self.case["run"].get("symmetry", "none")
        self.mirrored = [a in symmetry if isinstance(symmetry, list) else False for a in AXES]
        speeds = [np.linalg.norm(b.get("velocity", [0, 0, 0])) for b in self.bodies]
        self.shot = int(np.argmax(speeds))
        self.speed = max(speeds)
        flight = np.array(self.bodies[self.shot].get("velocity", [0, 0, 0]), float)
        self.flight = flight / self.speed if self.speed > 0 else np.array([0, 0, -1.0])
        # horizontal: the axis nearest to the first plate's normal, or to flight; vertical: the next nearest to flight, x before y
        normals = [b.get("normal", [0, 0, 1]) for k, b in enumerate(self.bodies) if k != self.shot and b["shape"] in ("plate", "box")]
        self.across = int(np.argmax(np.abs(normals[0] if normals else self.flight)))
        others = [d for d in range(3) if d != self.across]
        self.up = max(others, key=lambda d: (abs(self.flight[d]), -d))
        self.depth = 3 - self.across - self.up
        self.towards = np.sign(self.flight[self.across]) or -1.0

    def path(self, name):
        return os.path.join(self.folder, name)

    def size_of_shot(self):
        """Smallest measure of the projectile [m]; one from a file is measured as it was built."""
        b = self.bodies[self.shot]
        given = [v for v in (b.get("diameter"), b.get("length"), *b.get("size", []), b.get("thickness")) if v]
        if given:
            return min(given)
        built = Instant(self, 0)
        its = built.body == self.shot
        return float(((np.ptp(built.x[its], axis=0) + built.size[its].max()) * [2 if m else 1 for m in self.mirrored]).min())

    def plates(self):
        """Bodies at rest with a thickness along the horizontal axis, in the order in which they are met."""
        found = []
        for k, b in enumerate(self.bodies):
            thickness = b.get("thickness") or (b["size"][2] if b["shape"] == "box" else None)
            if k == self.shot or thickness is None or np.linalg.norm(b.get("velocity", [0, 0, 0])) > 0:
                continue
            at = self.towards * b.get("center", [0, 0, 0])[self.across]
            found.append((at - thickness / 2, at + thickness / 2, k))
        return sorted(found)


class Instant:
    """Matter at one time: elements first, particles after, in the order of run.h5."""

    def __init__(self, run, index):
        with h5py.File(run.path("run.h5"), "r") as f:
            g = f[run.groups[index]]
            self.time = float(g.attrs["time"])
            self.node_x, self.node = g["node_x"][:], g["element_node"][:]
            particle_x, particle_v = g["particle_x"][:], g["particle_v"][:]
            self.n_elements = len(self.node)
            centre, velocity = (g[k][:][self.node].mean(1) if self.n_elements else np.empty((0, 3)) for k in ("node_x", "node_v"))
            self.x = np.vstack([centre, particle_x])
            self.v = np.vstack([velocity, particle_v])
            join = lambda name: np.concatenate([g[f"{part}/{name}"][:] if f"{part}/{name}" in g else np.empty(0)
                                                for part in ("element", "particle")])
            self.mass, self.size, self.body = join("mass"), join("size"), join("body").astype(int)
        self.speed = np.linalg.norm(self.v, axis=1)

    def front(self, run):
        """How far the fastest hundredth of the projectile has come, along the horizontal axis towards the target [m]."""
        s = run.towards * self.x[self.body == run.shot, run.across]
        return float(np.quantile(s, 0.99)) if len(s) else -np.inf


# ---------------------------------------------------------------------------------------------- which instants

def choose(run):
    """[(snapshot, name)]: contact, perforation, cloud free, before the rear wall, just after arrival, end."""
    n, plates, size = len(run.times), run.plates(), run.size_of_shot()
    chosen = {0: "at contact" if plates else "start", n - 1: "end"}
    if plates and n > 2:
        fronts = np.array([Instant(run, k).front(run) for k in range(n)])
        first_after = lambda s: next((k for k in range(1, n - 1) if fronts[k] > s), None)
        behind = first_after(plates[0][1] + size)
        if behind is not None:
            chosen.setdefault(behind, "first plate perforated")
            if len(plates) > 1:
                rear = plates[-1][0]
                free = first_after(0.5 * (plates[0][1] + plates[1][0]))
                before = max((k for k in range(behind, n - 1) if fronts[k] < rear and (fronts[k + 1] > fronts[k])), default=None)
                if free is not None:
                    chosen.setdefault(free, "cloud in free flight")
                if before is not None:
                    arrived = fronts[min(before + 1, n - 1)] > rear - size
                    chosen.setdefault(before, "before the rear wall" if arrived else "cloud on its way")
                    if arrived:
                        after = int(np.searchsorted(run.times, run.times[before] + 0.15 * (run.times[-1] - run.times[before])))
                        chosen.setdefault(min(max(after, before + 1), n - 2), "just after arrival")
    # what is left: where the gap in time is widest
    while len(chosen) < min(6, n):
        ks = sorted(chosen)
        gaps = [(run.times[b] - run.times[a], a, b) for a, b in zip(ks, ks[1:]) if b - a > 1]
        _, a, b = max(gaps)
        middle = a + int(np.argmin(abs(run.times[a:b + 1] - 0.5 * (run.times[a] + run.times[b]))))
        chosen[min(max(middle, a + 1), b - 1)] = ""
    return sorted(chosen.items())


# ---------------------------------------------------------------------------------------------- drawing

def window(run, now, name, aspect):
    """Horizontal and vertical limits [m] that show what happens, with the aspect ratio of the panel."""
    h, u, plates = run.across, run.up, run.plates()
    size = run.size_of_shot()
    moving = now.speed > 0.02 * run.speed
    x = now.x[moving] if moving.any() and plates else now.x
    low, high = (np.quantile(x[:, [h, u]], q, axis=0) for q in (0.005, 0.995))
    if len(plates) > 1 and now.front(run) > plates[0][1] + 2 * size:
        # the whole scene, from a little before the first plate to a little behind the last
        ends = sorted(run.towards * s for s in (plates[0][0] - 0.12 * (plates[-1][1] - plates[0][0]),
                                               plates[-1][1] + 0.22 * (plates[-1][1] - plates[0][0])))
        low[0], high[0] = ends
        # up and down about the line of flight between the first plate and the last
        reach = 0.5 * (ends[1] - ends[0]) / aspect
        start = np.array(run.bodies[run.shot].get("center", [0, 0, 0]), float)
        way = [(s - run.towards * start[h]) / max(abs(run.flight[h]), 0.1) for s in (plates[0][0], plates[-1][0])]
        middle = 0.0 if run.mirrored[u] else float(np.mean([start[u] + run.flight[u] * w for w in way]))
        low[1], high[1] = middle - reach, middle + reach
    if run.mirrored[u]:
        reach = max(abs(low[1]), abs(high[1]))
        low[1], high[1] = -reach, reach
    centre, half = 0.5 * (low + high), 0.5 * (high - low) * 1.08 + 0.6 * size
    half[0] = max(half[0], half[1] * aspect)
    half[1] = half[0] / aspect
    return centre[0] - half[0], centre[0] + half[0], centre[1] - half[1], centre[1] + half[1]


def mirror(points, run, axis):
    """Points and their image behind a plane of symmetry, stacked; points as they are where there is none."""
    if not run.mirrored[axis]:
        return points, 1
    image = points.copy()
    image[..., 1] *= -1
    return np.concatenate([points, image]), 2


def paler(colours):
    """Colours of what lies behind: a third of the way to the background."""
    return np.concatenate([0.67 * colours[:, :3] + 0.33 * 0.95, colours[:, 3:]], axis=1)


def draw_dots(ax, run, now, rows, color, order):
    """Points as discs of their size, the farthest first."""
    if not len(rows):
        return
    rows = rows[np.argsort(-abs(now.x[rows, run.depth]), kind="stable")]
    xy, copies = mirror(now.x[rows][:, [run.across, run.up]], run, run.up)
    diameter = np.tile(1.1 * now.size[rows] * MM, copies)
    ax.add_collection(EllipseCollection(diameter, diameter, 0, units="xy", offsets=xy * MM, offset_transform=ax.transData,
                                        facecolors=np.tile(color(now, rows), (copies, 1)),
                                        edgecolors="#00000040", linewidths=0.12, zorder=order))


def draw_instant(ax, run, now, color, name):
    h, u, d = run.across, run.up, run.depth
    box = ax.get_window_extent()
    left, right, low, high = window(run, now, name, box.width / box.height)
    ax.set_xlim(left * MM, right * MM)
    ax.set_ylim(low * MM, high * MM)
    if run.towards < 0:
        ax.invert_xaxis()
    ax.set_facecolor("#F4F4F1")
    n = now.n_elements
    # elements that the cut goes through: their face nearest to it
    corner = now.node_x[now.node]
    depth = corner[:, :, d]
    cut = (depth.min(1) <= 1e-9) & (depth.max(1) >= -1e-9) if n else np.zeros(0, bool)
    if run.mirrored[d]:
        # the row of elements that touches the plane of symmetry
        cut = depth.min(1) < 1e-3 * now.size[:n]
    # dots: particles, and elements behind the cut that move; the cut itself; particles near it
    dots = np.ones(len(now.x), bool)
    dots[:n] = ~cut & (now.speed[:n] > 0.01 * run.speed)
    near = dots & (abs(now.x[:, d]) < 1.5 * now.size)
    near[:n] = False
    draw_dots(ax, run, now, np.flatnonzero(dots & ~near), lambda *a: paler(color(*a)), 1)
    if cut.any():
        c = corner[cut]
        faces = FACES[np.argmin(abs(c[:, FACES, d]).mean(2), axis=1)]
        polygons = np.take_along_axis(c, faces[:, :, None], axis=1)[:, :, [h, u]]
        polygons, copies = mirror(polygons, run, u)
        colours = np.tile(color(now, np.flatnonzero(cut)), (copies, 1))
        ax.add_collection(PolyCollection(polygons * MM, facecolors=colours, edgecolors=colours, linewidths=0.15, zorder=2))
    draw_dots(ax, run, now, np.flatnonzero(near), color, 3)
    ax.set_title(f"{now.time * US:.2f} µs" + (f"   {name}" if name else ""), fontsize=10, loc="left")
    ax.tick_params(labelsize=8)


def draw_energy(ax, run):
    time = np.array([float(r["time_s"]) for r in run.history]) * US
    scale = 100 / run.summary["conservation"]["initial_kinetic"]
    styles = ["-", "-", "-", "--", "-.", ":", (0, (1, 3))]
    colours = ["#0072B2", "#D55E00", "#CC79A7", "#009E73", "#E69F00", "#000000", "#666666"]
    for term, style, colour in zip(LEDGER, styles, colours):
        value = np.array([float(r[term + "_J"]) for r in run.history]) * scale
        ax.plot(time, value, color=colour, linestyle=style, linewidth=1.6, label=f"{term.replace('_', ' ')}  {value[-1]:.1f}")
    ax.axhline(0, color="#999999", linewidth=0.6, zorder=0)
    ax.set_xlim(time[0], time[-1])
    ax.set_xlabel("time (µs)", fontsize=9)
    ax.set_ylabel("% of the initial kinetic energy", fontsize=9)
    error = run.summary["conservation"].get("largest_energy_error", run.summary["conservation"]["energy_error"])
    ax.set_title(f"Energy ledger, with values at the end; closes to {abs(error):.0e}", fontsize=10, loc="left")
    ax.legend(fontsize=7.5, loc="best", framealpha=0.9)
    ax.tick_params(labelsize=8)
    ax.grid(color="#E0E0E0", linewidth=0.5)


def people(value, unit):
    """A value as people write it."""
    if isinstance(value, bool):
        return "yes" if value else "no"
    scale, name = {"m": (1e3, "mm"), "rad": (180 / np.pi, "deg"), "m/s": (1e-3, "km/s"), "Pa": (1e-9, "GPa"),
                   "kg": (1e6, "mg"), "": (1, "")}.get(unit, (1, unit))
    return f"{value:.0f}" if unit == "" and value == int(value) else f"{scale * value:.3g} {name}".strip()


def wanted(run):
    """Keys of the main measurements, those with a reference first."""
    all_keys = run.summary["measurements"]
    endings = ["perforated", "hole_diameter", "bulge", "impulse", "crater_depth", "crater_diameter"]
    names = [run.bodies[k]["name"] for _, _, k in run.plates()]
    cloud = ["cloud.spray_half_angle", "cloud.fast_half_angle", "cloud.axial_velocity_front", "cloud.melt_fraction",
             "fragments.count", "peak_pressure", "peak_pressure_hugoniot"]
    keys = [k for k, m in all_keys.items() if "reference" in m]
    keys += [f"{n}.{e}" for n in names for e in endings] + cloud
    if not all_keys.get("cloud.mass", {}).get("value"):
        keys = [k for k in keys if not k.startswith(("cloud.", "fragments."))]
    closed = [n for n in names if all_keys.get(n + ".perforated", {}).get("value") is False]
    keys = [k for k in keys if k not in [f"{n}.hole_diameter" for n in closed]]
    return [k for k in dict.fromkeys(keys) if k in all_keys][:17]


def draw_text(ax, run):
    ax.axis("off")
    m = run.summary["measurements"]
    rows = [f"{'':27}{'computed':>11}{'reference':>11}{'':>8}"]
    for key in wanted(run):
        e = m[key]
        row = f"{key:27}{people(e['value'], e['unit']):>11}"
        if "reference" in e:
            truth = isinstance(e["value"], bool)
            row += f"{people(bool(e['reference']) if truth else e['reference'], e['unit']):>11}"
            if "relative_error" in e and not truth:
                row += f"{100 * e['relative_error']:+7.1f}%"
        rows.append(row)
    s = run.summary
    rows += ["", f"mode {s['mode']}, {s.get('elements_across', '?')} elements across, 1/{2 ** sum(run.mirrored)} of the scene",
             f"{s['elements']['initial']} elements, {s['particles']['created']} particles, {s['steps']} steps",
             f"{s['wall_seconds']:.0f} s on {s['threads']} thread{'' if s['threads'] == 1 else 's'}; {s['stop_reason'][:52]}"]
    ax.text(0, 1, "\n".join(rows), family="monospace", fontsize=7.6, va="top", transform=ax.transAxes, linespacing=1.35)


def colouring(run, by, figure, axis):
    """Colour of rows of an instant, and its legend."""
    if by == "speed":
        norm, table = matplotlib.colors.Normalize(0, run.speed * 1e-3), plt.get_cmap("viridis")
        bar = figure.colorbar(matplotlib.cm.ScalarMappable(norm, table), cax=axis, orientation="horizontal")
        bar.set_label("speed (km/s)", fontsize=9)
        bar.ax.tick_params(labelsize=8)
        return lambda now, rows: table(norm(now.speed[rows] * 1e-3))
    colours = np.array([matplotlib.colors.to_rgba(PALETTE[k % len(PALETTE)]) for k in range(len(run.bodies))])
    axis.axis("off")
    handles = [matplotlib.patches.Patch(color=colours[k], label=f"{b['name']} ({b['material']})") for k, b in enumerate(run.bodies)]
    axis.legend(handles=handles, ncol=len(handles), fontsize=9, loc="center", frameon=False)
    return lambda now, rows: colours[now.body[rows]]


def draw(run, out, by):
    figure = plt.figure(figsize=(17, 9), dpi=130)
    grid = figure.add_gridspec(2, 3, left=0.045, right=0.69, top=0.9, bottom=0.12, wspace=0.2, hspace=0.22)
    side = figure.add_gridspec(2, 1, left=0.745, right=0.99, top=0.9, bottom=0.07, hspace=0.2, height_ratios=[1, 1.05])
    title = run.case.get("title") or os.path.basename(os.path.abspath(run.folder))
    figure.suptitle(title, fontsize=14, x=0.045, ha="left", weight="bold")
    color = colouring(run, by, figure, figure.add_axes([0.2, 0.045, 0.35, 0.018 if by == "speed" else 0.03]))
    picked = choose(run)
    for k, (index, name) in enumerate(picked):
        ax = figure.add_subplot(grid[k // 3, k % 3])
        draw_instant(ax, run, Instant(run, index), color, name)
        if k >= len(picked) - 3:
            ax.set_xlabel(f"{AXES[run.across]} (mm)", fontsize=9)
        if k % 3 == 0:
            ax.set_ylabel(f"{AXES[run.up]} (mm)", fontsize=9)
    draw_energy(figure.add_subplot(side[0]), run)
    draw_text(figure.add_subplot(side[1]), run)
    figure.savefig(out)
    plt.close(figure)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", metavar="DIR", help="folder of a run")
    parser.add_argument("--out", help="picture to write (default: DIR/cloud.png)")
    parser.add_argument("--color", choices=["body", "speed"], default="body", help="what colours stand for (default: body)")
    a = parser.parse_args()
    for name in ("run.h5", "history.csv", "summary.json", "case.toml"):
        if not os.path.isfile(os.path.join(a.folder, name)):
            sys.exit(f"{a.folder}: holds no {name}; this needs the folder of a run that has ended")
    out = a.out or os.path.join(a.folder, "cloud.png")
    draw(Run(a.folder), out, a.color)
    print(out)


main()
