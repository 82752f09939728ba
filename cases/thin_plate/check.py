#!/usr/bin/python3
"""Compares a run of this case with its references, as summary.json holds them.

    check.py [DIR]          DIR: folder of the run, default runs/thin_plate-hybrid

Exit code 1 where a tolerance is exceeded, a key is missing, or the run did not reach its end.
"""
import json
import os
import sys

# key: largest relative error of a number; None: a truth value has to agree
TOLERANCE = {"bumper.hole_diameter": 0.10, "cloud.spray_half_angle": 0.15, "peak_pressure": 0.15}
# shown, not judged
SHOWN = ["cloud.fast_half_angle", "cloud.half_angle_outer_projectile", "cloud.envelope_half_angle"]


def text(value, unit):
    if isinstance(value, bool):
        return "yes" if value else "no"
    scale, name = {"m": (1e3, "mm"), "rad": (57.29577951308232, "deg"), "Pa": (1e-9, "GPa")}.get(unit, (1, unit))
    return f"{scale * value:.4g} {name}"


def main():
    run = sys.argv[1] if len(sys.argv) > 1 else "runs/thin_plate-hybrid"
    with open(os.path.join(run, "summary.json")) as f:
        summary = json.load(f)
    bad = not summary["completed"]
    print(f"{run}: {summary['stop_reason']}")
    print(f"{'quantity':36} {'computed':>12} {'reference':>12} {'error':>8} {'allowed':>8}")
    for key in [*TOLERANCE, *SHOWN]:
        entry = summary["measurements"].get(key)
        if entry is None:
            print(f"{key:36} {'missing':>12}")
            bad = bad or key in TOLERANCE
            continue
        value, unit, judged = entry["value"], entry["unit"], key in TOLERANCE
        line = f"{key:36} {text(value, unit):>12}"
        if "reference" in entry:
            truth = isinstance(value, bool)
            reference = bool(entry["reference"]) if truth else entry["reference"]
            line += f" {text(reference, unit):>12}"
            if truth:
                wrong = judged and value != reference
            else:
                error = value / reference - 1
                line += f" {100 * error:+7.1f}%"
                wrong = judged and not abs(error) <= TOLERANCE[key]
                line += f" {100 * TOLERANCE[key]:7.0f}%" if judged else ""
            bad = bad or wrong
            line += "  BEYOND" if wrong else ""
        print(line)
    sys.exit(1 if bad else 0)


main()
