#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Sets two files of the target `performance` side by side: tools/compare_performance.py OLD.json NEW.json

Rates (per second) and costs (everything else) are told apart, so that the last column always says how many times
quicker, or smaller, the new one is; '*' marks what changed by more than both quartile ranges together."""
import json
import sys


def half_range(row):
    if "upper_quartile" not in row:
        return 0.1 * abs(row["value"])
    return 0.5 * (row["upper_quartile"] - row["lower_quartile"])


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    files = [json.load(open(name)) for name in sys.argv[1:]]
    if files[0]["machine"] != files[1]["machine"]:
        print(f"different machines: {files[0]['machine']} and {files[1]['machine']}")
    old, new = (f["results"] for f in files)
    print(f"{'':<56} {'old':>11} {'new':>11} {'gain':>7}")
    for key in list(old) + [k for k in new if k not in old]:
        a, b = old.get(key), new.get(key)
        if a is None or b is None:
            print(f"{key:<56} {a['value'] if a else float('nan'):>11.4g} {b['value'] if b else float('nan'):>11.4g}")
            continue
        rate = a["unit"].endswith("/s")
        top, bottom = (b, a) if rate else (a, b)
        gain = top["value"] / bottom["value"] if bottom["value"] else float("nan")
        mark = "*" if abs(a["value"] - b["value"]) > half_range(a) + half_range(b) else " "
        print(f"{key:<56} {a['value']:>11.4g} {b['value']:>11.4g} {gain:>6.2f}{mark} {a['unit']}")


if __name__ == "__main__":
    main()
