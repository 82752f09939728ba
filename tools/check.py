#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Compares a run of a case with the case's reference.csv.

    tools/check.py CASE [DIR]        DIR: folder of the run, default runs/CASE-MODE

Columns of reference.csv: quantity, key (of docs/measurements.md, or of tools/runs.py), value, unit, tolerance (relative; of a truth
value any number, it has to agree), source. Rows without a tolerance are shown, not judged; rows without a key are figures of others, for the reader.
Exit code 1 where a tolerance is exceeded, a judged key is missing, or the run did not reach its end; 2 where there is no run.
"""
import csv
import os
import sys
import tomllib

import runs

SI = {"mm": 1e-3, "deg": 1 / 57.29577951308232, "GPa": 1e9, "km/s": 1e3, "mg": 1e-6, "MJ/kg": 1e6, "m/s": 1, "": 1, "-": 1}


def reference(row):
    if row["value"] in ("yes", "no"):
        return row["value"] == "yes"
    return float(row["value"]) * SI[row["unit"]]


def judge(row, entry):
    """(line, beyond) of one row."""
    judged, line = row["tolerance"] != "", f"{row['quantity']:46}"
    if entry is None:
        return line + f" {'missing':>12}", judged
    value, unit = entry
    line += f" {runs.text(value, unit):>12}"
    if row["value"] == "":
        return line, False
    expected = reference(row)
    line += f" {runs.text(expected, unit):>12}"
    if isinstance(expected, bool):
        beyond = judged and bool(value) != expected
    else:
        error = value / expected - 1
        beyond = judged and not abs(error) <= float(row["tolerance"])
        line += f" {100 * error:+7.1f}%" + (f" {100 * float(row['tolerance']):7.1f}%" if judged else "")
    return line + ("  BEYOND" if beyond else ""), beyond


def main():
    if len(sys.argv) not in (2, 3):
        sys.exit(__doc__)
    case = sys.argv[1].rstrip("/")
    with open(os.path.join(case, "case.toml"), "rb") as f:
        mode = tomllib.load(f)["run"].get("mode", "hybrid")
    run = sys.argv[2] if len(sys.argv) == 3 else f"runs/{os.path.basename(os.path.abspath(case))}-{mode}"
    if not os.path.exists(os.path.join(run, "summary.json")):
        print(f"{run}: holds no summary.json; run the case first: build/ejecta run {case}", file=sys.stderr)
        sys.exit(2)
    with open(os.path.join(case, "reference.csv"), newline="") as f:
        rows = [r for r in csv.DictReader(f) if r["key"]]
    end = runs.summary(run)
    found = runs.measured(run, [r["key"] for r in rows])
    print(f"{run}: {end['stop_reason']}")
    print(f"{'quantity':46} {'computed':>12} {'reference':>12} {'error':>8} {'allowed':>8}")
    bad = not end["completed"]
    for row in rows:
        line, beyond = judge(row, found.get(row["key"]))
        bad = bad or beyond
        print(line)
    sys.exit(1 if bad else 0)


main()
