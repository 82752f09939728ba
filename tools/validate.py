#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Runs the validation set, tests/validation/shots.toml, and writes docs/validation.md from what the runs leave. No figure is typed.

    tools/validate.py [--only WORD ...] [--across 10,20] [--modes hybrid,erosion] [--minutes M] [--threads N] [--report] [--list] [--check]

Runs that have ended in the output folder are kept, interrupted ones go on from their checkpoint, the rest is started; a run whose case has changed
since is run again. The report always shows everything that the output folder holds. A run that a guard stopped is shown as stopped.
Exit code 1 where a run could not be started or was stopped by a guard.
"""
import argparse
import json
import math
import pathlib
import re
import signal
import statistics
import subprocess
import sys
import tempfile
import tomllib

import runs

ROOT = pathlib.Path(__file__).resolve().parent.parent
SET = ROOT / "tests/validation/shots.toml"
UNITS = {"mm": 1e-3, "m": 1, "us": 1e-6, "km/s": 1e3, "m/s": 1, "deg": math.pi / 180, "rad": 1, "GPa": 1e9, "mg": 1e-6}
CLEARANCE = 0.0125    # of the projectile's diameter, above what it strikes
AROUND = 0.2          # of the time: measured points that are averaged
NEVER = "has not been run"


def si(value):
    if isinstance(value, (int, float)):
        return float(value)
    number, unit = value.split()
    return float(number) * UNITS[unit]


# ---------------------------------------------------------------------------------------------------- cases

def toml_value(v):
    if isinstance(v, bool):
        return "true" if v else "false"
    if isinstance(v, dict):
        return "{ " + ", ".join(f"{k} = {toml_value(x)}" for k, x in v.items()) + " }"
    if isinstance(v, (list, tuple)):
        return "[" + ", ".join(toml_value(x) for x in v) + "]"
    return json.dumps(v)


def toml_table(name, pairs):
    return f"{name}\n" + "".join(f"{k} = {toml_value(v)}\n" for k, v in pairs.items()) + "\n"


def plate_size(plate, k, distance, diameter, slant):
    """Edges of a plate at `distance` behind the first one's back; `slant`: tangent of the line of flight's angle."""
    if "size" in plate:
        return [si(x) for x in plate["size"]]
    across = 16 * diameter if k == 0 else 1.5 * distance + 8 * diameter
    return [across + distance * slant, across]


def bodies(shot, exchange, names):
    """Projectile and plates as tables of a case, SI. The line of flight meets the first front face at the origin."""
    p = shot["projectile"]
    diameter, speed, angle = si(p["diameter"]), si(p["velocity"]), si(p.get("angle", "0 deg"))
    extent = si(p["length"]) if p["shape"] == "cylinder" else diameter
    height = 0.5 * extent + (0 if shot.get("wall") else CLEARANCE * diameter)
    material = lambda name: names.get(name, exchange.get(name, name))
    projectile = {"name": "projectile", "shape": p["shape"], "diameter": diameter, "center": [-height * math.tan(angle), 0.0, height],
                  "velocity": [speed * math.sin(angle), 0.0, -speed * math.cos(angle)], "material": material(p["material"])}
    if p["shape"] == "cylinder":
        projectile["length"] = extent
    result, front, first_back = [projectile], 0.0, 0.0
    for k, plate in enumerate(shot.get("plates", [])):
        thickness = si(plate["thickness"])
        front -= si(plate.get("gap", 0))
        if k == 0:
            first_back = front - thickness
        distance = max(0.0, first_back - front)
        middle = -front * math.tan(angle)
        # an oblique cloud spreads from the normal through the hole to the line of flight
        result.append({"name": plate["name"], "shape": "plate", "size": plate_size(plate, k, distance, diameter, math.tan(angle)),
                       "thickness": thickness, "center": [0.5 * middle, 0.0, front - 0.5 * thickness], "material": material(plate["material"])})
        front -= thickness
    return result


def case_text(shot, setting, across):
    materials = {p["material"] for p in [shot["projectile"], *shot.get("plates", [])]}
    exchange = setting.get("exchange", {})
    names = {m: "whole-" + m for m in materials} if shot.get("no_failure") or shot.get("no_damage") else {}
    text = f"title = {json.dumps(shot['title'] + ', ' + setting['label'])}\n\n"
    text += toml_table("[run]", {"end": shot["end"], "elements_across": across})
    for body in bodies(shot, exchange, names):
        text += toml_table("[[body]]", body)
    if shot.get("wall"):
        text += toml_table("[[wall]]", {"point": [0, 0, 0], "normal": [0, 0, 1]})
    convert = {k.removeprefix("convert."): v for k, v in setting.get("set", {}).items()}
    text += toml_table("[convert]", convert) if convert else ""
    text += toml_table("[output]", {"every": shot.get("every", shot["end"])})
    for material, name in names.items():
        text += toml_table(f"[materials.{name}]", {"base": exchange.get(material, material), "damage": {"model": "none"}}
                           | ({"spall": {"limit": "100 GPa"}} if shot.get("no_failure") else {}))
    return text


# ---------------------------------------------------------------------------------------------------- runs

class Run:
    """One run of the set: a folder out/SHOT/SETTING-MODE-ACROSS[-REPEAT]."""

    def __init__(self, the_set, out, shot, setting, mode, across, repeat=0):
        self.shot_name, self.setting_name, self.across, self.repeat = shot, setting, across, repeat
        self.shot, self.setting = the_set["shot"][shot], the_set["setting"][setting]
        self.mode = self.setting.get("mode", mode)
        self.dir = out / shot / (f"{setting}-{self.mode}-{across}" + (f"-{repeat}" if repeat else ""))
        self.case = self.dir.with_suffix(".toml")

    @property
    def key(self):
        return self.dir

    def summary(self):
        try:
            return runs.summary(self.dir)
        except (OSError, ValueError):
            return None

    def state(self):
        """ "ended", "stopped", "interrupted" or "new". """
        s = self.summary()
        if not self.case.exists() or self.case.read_text() != self.text():
            return "new"
        if s is None:
            return "interrupted" if (self.dir / "checkpoint.h5").exists() else "new"
        if s["completed"]:
            return "ended"
        return "interrupted" if s["stop_reason"].startswith("interrupted") else "stopped"

    def text(self):
        return case_text(self.shot, self.setting, self.across)

    def go(self, ejecta, threads, minutes):
        """True where the run has ended."""
        command = [str(ejecta), "resume", str(self.dir)]
        if self.state() == "new":
            self.dir.parent.mkdir(parents=True, exist_ok=True)
            self.case.write_text(self.text())
            command = [str(ejecta), "run", str(self.case), "--out", str(self.dir), "--mode", self.mode, "--force"]
        with open(self.dir.with_suffix(".log"), "w") as log:
            process = subprocess.Popen(command + ["--threads", str(threads)], stdout=log, stderr=subprocess.STDOUT)
            try:
                code = process.wait(60 * minutes if minutes else None)
            except (subprocess.TimeoutExpired, KeyboardInterrupt) as reason:
                process.send_signal(signal.SIGINT)
                process.wait()
                if isinstance(reason, KeyboardInterrupt):
                    raise
                return False
        if code == 0 and "growth" in self.shot:
            subprocess.run([str(ejecta), "measure", str(self.dir), "--series"], stdout=subprocess.DEVNULL, check=True)
        if code == 2:
            raise SystemExit(f"{self.case}: {self.dir.with_suffix('.log').read_text().strip()}")
        return code == 0


def planned(the_set, out, table, across, modes):
    """The runs of a table at the fidelities asked for, or at each shot's own."""
    for shot in table["shots"]:
        for n in across or the_set["shot"][shot]["across"]:
            for repeat in range(table.get("repeats", 1)):  # repeats one after the other over all settings: noise hits them alike
                for setting in table["settings"]:
                    for mode in [m for m in table["modes"] if not modes or m in modes]:
                        yield Run(the_set, out, shot, setting, mode, n, repeat)


def present(the_set, out, table):
    """What the report shows: every run of the table in the output folder, whatever its fidelity."""
    for shot in table["shots"]:
        found = {int(m.group(1)) for p in (out / shot).glob("*") if (m := re.search(r"-(\d+)(?:-\d+)?$", p.name)) and p.is_dir()}
        for setting in table["settings"]:
            for mode in table["modes"]:
                for n in sorted(found | set(the_set["shot"][shot]["across"])):
                    for repeat in range(table.get("repeats", 1)):
                        r = Run(the_set, out, shot, setting, mode, n, repeat)
                        if r.summary() is not None and r.state() != "new":
                            yield r


def refusal(run, ejecta):
    """What the program says against the run's case; empty where it accepts it."""
    with tempfile.NamedTemporaryFile("w", suffix=".toml") as f:
        f.write(run.text())
        f.flush()
        r = subprocess.run([str(ejecta), "check", f.name, "--no-cost", "--mode", run.mode], capture_output=True, text=True)
    return "" if r.returncode == 0 else f"{run.dir.name}: {r.stderr.strip()}"


def wanted(table, the_set, words):
    text = " ".join([table["name"], table["title"], *table["shots"], *table["columns"], *table["columns"].values()]).lower()
    return not words or any(w.lower() in text for w in words)


# ---------------------------------------------------------------------------------------------------- the report

def number(x):
    return "-" if x is None else f"{x:.0f}" if abs(x) >= 1000 else f"{x:.3g}"


def markdown(head, rows):
    return "\n".join(["| " + " | ".join(r) + " |" for r in [head, ["---"] * len(head), *rows]]) + "\n"


def percent(value, expected):
    return "-" if value is None or not expected else f"{100 * (value / expected - 1):+.1f} %"


def shown(found, key):
    if key not in found:
        return None
    value, unit = found[key]
    return 100 * value if key.endswith("_fraction") else runs.shown(value, unit)[0]


def cost(run):
    return number(run.summary()["cpu_seconds"])


def remark(run):
    if run.state() == "ended":
        return ""
    s = run.summary()
    return f"{'stopped' if run.state() == 'stopped' else 'not finished'} at {1e6 * s['time']:.3g} us of {run.shot['end']}"


def found(run, columns):
    """Measurements of a run that has ended: a stopped run has none that could be compared."""
    return runs.measured(run.dir, list(columns)) if run.state() == "ended" else {}


def measured(shot, key):
    """Measured value as shown."""
    if key not in shot.get("measured", {}):
        return None
    value, unit = shot["measured"][key].split()
    scale = {"us": 1}.get(unit, 1)
    return float(value) * scale


def heading(the_set, table):
    lines = [f"## {table['title']}", "", table["text"], ""]
    for name in table["shots"]:
        shot = the_set["shot"][name]
        figures = ", ".join(f"{table['columns'][k].split(',')[0]} {v}" for k, v in shot.get("measured", {}).items() if k in table["columns"])
        if table["kind"] in ("values", "spread", "growth") and len(table["shots"]) > 1 or figures:
            lines.append(f"- {shot['title']}{': ' + figures if figures else ''}. {shot['source']}.")
    return "\n".join(lines).rstrip() + "\n\n"


def values(the_set, out, table):
    several = len(table["shots"]) > 1
    paper = table.get("paper", {})
    head = ["shot"] * several + ["criterion"] * (len(table["settings"]) > 1) + ["mode", "across"]
    published = {k for p in paper.values() for k in p}
    for key, label in table["columns"].items():
        head += [label, "error"] if any(measured(the_set["shot"][s], key) for s in table["shots"]) else [label]
        head += ["1997"] if key in published else []
    rows = []
    for run in present(the_set, out, table):
        row = [run.shot["title"]] * several + [run.setting["label"]] * (len(table["settings"]) > 1) + [run.mode, str(run.across)]
        values_of = found(run, table["columns"])
        for key in table["columns"]:
            value = shown(values_of, key)
            row.append(number(value))
            if any(measured(the_set["shot"][s], key) for s in table["shots"]):
                row.append(percent(value, measured(run.shot, key)))
            if key in published:
                row.append(number(paper.get(run.setting_name, {}).get(key)))
        rows.append(row + [cost(run), remark(run)])
    note = "1997: their value, with erosion. " if published else ""
    return note + "Error: against the figure above.\n\n" + markdown(head + ["cpu s", "remark"], rows)


def spread(the_set, out, table):
    groups = {}
    for run in present(the_set, out, table):
        groups.setdefault((run.mode, run.across), []).append(run)
    head = ["mode", "across", "runs"]
    for label in table["columns"].values():
        head += [label + ": lowest", "highest", "spread"]
    rows = []
    for (mode, across), members in sorted(groups.items()):
        row = [mode, str(across), f"{sum(r.state() == 'ended' for r in members)} of {len(table['settings'])}"]
        for key in table["columns"]:
            got = [v for r in members if (v := shown(found(r, table["columns"]), key)) is not None]
            low, high = (min(got), max(got)) if got else (None, None)
            expected = measured(members[0].shot, key)
            row += [number(low), number(high), f"{100 * (high - low) / expected:.1f} %" if got and expected else "-"]
        rows.append(row + [number(sum(r.summary()["cpu_seconds"] for r in members))])
    single = [[r.setting["label"], r.mode, str(r.across)] + [number(shown(found(r, table["columns"]), k)) for k in table["columns"]]
              + [cost(r), remark(r)] for members in groups.values() for r in members]
    return ("Spread: highest less lowest, over the measured value.\n\n" + markdown(head + ["cpu s, all"], rows) + "\n"
            + markdown(["criterion", "mode", "across", *table["columns"].values(), "cpu s", "remark"], single))


def cost_table(the_set, out, table):
    times = {}
    for run in present(the_set, out, table):
        if run.state() == "ended":
            times.setdefault((run.across, run.setting_name), []).append(run.summary())
    rows = []
    for (across, name), s in times.items():
        seconds = statistics.median(x["cpu_seconds"] for x in s)
        base = times.get((across, table["settings"][0]))
        extra = "-" if not base else f"{100 * (seconds / statistics.median(x['cpu_seconds'] for x in base) - 1):+.1f} %"
        fired = max(x["elements"]["eroded"] + x["elements"]["converted"] for x in s)
        paper = table["paper"].get(name, {}).get("cost")
        rows.append([the_set["setting"][name]["label"], str(across), str(s[0]["elements"]["initial"]), str(s[0]["steps"]), str(len(s)), f"{seconds:.2f}",
                     extra, "-" if paper is None else f"{paper:+.1f} %", str(fired)])
    return markdown(["criterion", "across", "elements", "steps", "runs", "cpu s, median", "extra", "1997", "elements that went"], rows)


def verdict(the_set, out, table):
    head = ["shot", "measured", "mode", "across", "computed", "", *table["columns"].values(), "cpu s", "remark"]
    rows, score = [], {}
    for run in present(the_set, out, table):
        got = found(run, ["wall.perforated", *table["columns"]])
        is_open = got["wall.perforated"][0] if "wall.perforated" in got else None
        right = is_open == run.shot["perforated"]
        if is_open is not None:
            tally = score.setdefault((run.mode, run.across), [0, 0])
            tally[0] += right
            tally[1] += 1
        rows.append([run.shot["title"], "P" if run.shot["perforated"] else "NP", run.mode, str(run.across),
                     "-" if is_open is None else "P" if is_open else "NP", "-" if is_open is None else "right" if right else "WRONG",
                     *(number(shown(got, k)) for k in table["columns"]), cost(run), remark(run)])
    tallies = "".join(f"- {mode}, {across} across: {a} of {b} right\n" for (mode, across), (a, b) in sorted(score.items()))
    return (tallies + "\n" if tallies else "") + markdown(head, rows)


def read_growth(name):
    points = {}
    for line in (SET.parent / name).read_text().splitlines():
        if not line.startswith("#") and not line.startswith("quantity"):
            quantity, t, value = line.split(",")
            points.setdefault(quantity, []).append((1e-6 * float(t), float(value)))
    return points


def growth(the_set, out, table):
    final = values(the_set, out, table)
    head, rows = ["mode", "across", "t, us", "radius, mm", "measured", "error", "depth, mm", "measured", "error"], []
    for run in present(the_set, out, table):
        if run.state() != "ended" or not (run.dir / "measurements.csv").exists():
            continue
        points = read_growth(run.shot["growth"])
        series = {"radius": [(t, 500 * d) for t, d in runs.series(run.dir, "block.crater_diameter")],
                  "depth": [(t, 1e3 * d) for t, d in runs.series(run.dir, "block.crater_depth")]}
        for t in (2.5e-6, 5e-6, 7.5e-6, 10e-6, 15e-6, 25e-6, 40e-6):
            row = [run.mode, str(run.across), f"{1e6 * t:.3g}"]
            for quantity in ("radius", "depth"):
                got = [v for s, v in series[quantity] if abs(s - t) < 0.02 * t + 1e-9]
                near = [v for s, v in points[quantity] if abs(s - t) <= AROUND * t]
                expected = statistics.mean(near) if near else None
                row += [number(got[0] if got else None), number(expected), percent(got[0] if got else None, expected)]
            rows.append(row)
    return final + "\n" + markdown(head, rows)


def fragments(the_set, out, table):
    keys = [*table["columns"], "fragments.mass", "fragments.momentum", "cloud.mass", "cloud.momentum", "cloud.axial_velocity_front",
            "cloud.projectile_melt_fraction"]
    head = ["shot", "mode", "across", *table["columns"].values(), "cloud, mg", "mass off by", "momentum off by", "front / impact speed", "cpu s", "remark"]
    rows = []
    for run in present(the_set, out, table):
        got = found(run, keys)
        off = lambda q: f"{abs(got['fragments.' + q][0] / got['cloud.' + q][0] - 1):.0e}" if "fragments." + q in got else "-"
        front = got["cloud.axial_velocity_front"][0] / si(run.shot["projectile"]["velocity"]) if got else None
        rows.append([run.shot["title"], run.mode, str(run.across), *(number(shown(got, k)) for k in table["columns"]), number(shown(got, "cloud.mass")),
                     off("mass"), off("momentum"), number(front), cost(run), remark(run)])
    return markdown(head, rows)


KINDS = {"values": values, "spread": spread, "cost": cost_table, "verdict": verdict, "growth": growth, "fragments": fragments}


def report(the_set, out):
    expected = {r.key: r for t in the_set["table"] for r in planned(the_set, out, t, [], [])}
    missing = [r for r in expected.values() if r.state() in ("new", "interrupted")]
    stopped = [r for r in expected.values() if r.state() == "stopped"]
    text = ("# Validation\n\nWritten by `tools/validate.py` from the runs of `tests/validation/shots.toml`; definitions of what is measured: "
            "`docs/measurements.md`.\n\n")
    text += (f"The set has {len(expected)} runs at its two fidelities: {len(expected) - len(missing) - len(stopped)} ended, "
             f"{len(stopped)} stopped by a guard, {len(missing)} not run or not finished. Runs at other fidelities are shown where there are any. "
             "Across: elements across the projectile. Cpu s: of the whole run, all threads; - where there is no value.\n\n")
    for table in the_set["table"]:
        text += heading(the_set, table)
        shown_runs = list(present(the_set, out, table))
        text += KINDS[table["kind"]](the_set, out, table) if shown_runs else f"This table {NEVER}.\n"
        reasons = {f"- {r.shot['title']}, {r.setting['label']}, {r.mode}, {r.across} across: {r.summary()['stop_reason']}\n"
                   for r in shown_runs if r.state() == "stopped"}
        text += ("\nStopped:\n\n" + "".join(sorted(reasons)) if reasons else "") + "\n"
    return text


# ---------------------------------------------------------------------------------------------------- command line

def main():
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("--ejecta", type=pathlib.Path, default=ROOT / "build/ejecta")
    p.add_argument("--out", type=pathlib.Path, default=ROOT / "runs/validation", help="folder of the runs (default: runs/validation)")
    p.add_argument("--document", type=pathlib.Path, default=ROOT / "docs/validation.md")
    p.add_argument("--only", nargs="+", default=[], metavar="WORD", help="tables whose name, title, shots or columns contain a word, e.g. hole")
    p.add_argument("--shots", nargs="+", default=[], metavar="NAME", help="of these shots only")
    p.add_argument("--settings", nargs="+", default=[], metavar="NAME", help="of these settings only")
    p.add_argument("--across", type=lambda s: [int(x) for x in s.split(",")], default=[], help="elements across the projectile, e.g. 10,20 (default: each shot's own)")
    p.add_argument("--modes", type=lambda s: s.split(","), default=[])
    p.add_argument("--threads", type=int, default=1)
    p.add_argument("--minutes", type=float, default=0, help="longest time for one run; it can go on later (default: none)")
    p.add_argument("--report", action="store_true", help="run nothing, write the document")
    p.add_argument("--check", action="store_true", help="run nothing, have the program read every case")
    p.add_argument("--list", action="store_true", help="run nothing, list the runs and their state")
    a = p.parse_args()
    the_set = tomllib.loads(SET.read_text())
    todo = {r.key: r for t in the_set["table"] if wanted(t, the_set, a.only) for r in planned(the_set, a.out, t, a.across, a.modes)
            if (not a.shots or r.shot_name in a.shots) and (not a.settings or r.setting_name in a.settings)}
    if not todo:
        p.error("nothing of the set matches; tables: " + ", ".join(t["name"] for t in the_set["table"]) + "; shots: " + ", ".join(the_set["shot"]))
    if a.check:
        cases = {(r.shot_name, r.setting_name): r for r in todo.values()}  # mode and fidelity make no difference to what is read
        wrong = [m for r in cases.values() if (m := refusal(r, a.ejecta.resolve()))]
        print("\n".join(wrong + [f"{len(cases)} cases, {len(wrong)} refused"]))
        return 1 if wrong else 0
    if a.list:
        for r in todo.values():
            print(f"{r.state():12} {r.dir.relative_to(a.out)}")
        return 0
    if not a.report and not a.ejecta.exists():
        p.error(f"{a.ejecta} does not exist; build it, or name it with --ejecta")
    failed = False
    for k, r in enumerate([] if a.report else todo.values()):
        before = r.state()
        if before not in ("ended", "stopped"):
            r.go(a.ejecta.resolve(), a.threads, a.minutes)
        s, state = r.summary(), r.state()
        failed = failed or state != "ended"
        print(f"[{k + 1}/{len(todo)}] {r.dir.relative_to(a.out)}: {state}" + (", before" if before == state else "")
              + (f", {s['cpu_seconds']:.1f} cpu s" if s else ""), flush=True)
    a.document.write_text(report(the_set, a.out))
    print(f"{a.document} written")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
