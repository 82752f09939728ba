#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The built program from outside: exit codes, what it says, what it leaves on the disk.

    command_line_test.py PROGRAM [TEST ...]      TEST as for unittest: a class or class.method
Only the standard library; h5py compares states and Matplotlib draws where they are installed.
"""
import csv
import glob
import importlib.util
import json
import os
import re
import resource
import shlex
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import unittest

try:
    import h5py
except ImportError:
    h5py = None

PROGRAM = None

CASE = """title = "small shot"
[run]
mode = "hybrid"
end = "0.4 us"
elements_across = 6
[[body]]
name = "projectile"
shape = "sphere"
diameter = "1 mm"
center = ["0 mm", "0 mm", "0.52 mm"]
velocity = ["0 km/s", "0 km/s", "-6 km/s"]
material = "Al2024-T351"
[[body]]
name = "bumper"
shape = "plate"
size = ["6 mm", "6 mm"]
thickness = "0.3 mm"
center = ["0 mm", "0 mm", "-0.15 mm"]
material = "Al2024-T351"
[output]
every = "0.1 us"
"""

SUMMARY_KEYS = """completed stop_reason mode time steps threads wall_seconds cpu_seconds peak_memory_bytes
elements.initial elements.alive elements.converted elements.eroded particles.created particles.final
work.element_updates work.element_updates_asleep work.particle_updates work.particle_updates_asleep work.pair_updates
work.stage_seconds.contact
conservation.initial_kinetic conservation.mass_error conservation.momentum_error conservation.angular_momentum_error
conservation.energy_error conservation.ledger.kinetic conservation.ledger.internal conservation.ledger.hourglass
conservation.ledger.contact conservation.ledger.conversion conservation.ledger.eroded_kinetic
conservation.ledger.eroded_internal measurements""".split()


class Folder(unittest.TestCase):
    """A folder of its own for every test, gone after it."""

    def setUp(self):
        self.dir = tempfile.mkdtemp(prefix="ejecta_cli_")
        self.addCleanup(shutil.rmtree, self.dir, True)
        self.case = self.write("case.toml", CASE)
        self.out = os.path.join(self.dir, "out")

    def write(self, name, text):
        path = os.path.join(self.dir, name)
        with open(path, "w") as f:
            f.write(text)
        return path

    def ejecta(self, *arguments, **more):
        env = dict(os.environ, OMP_NUM_THREADS="1")
        return subprocess.run([PROGRAM, *arguments], cwd=self.dir, env=env, capture_output=True, text=True, timeout=100, **more)

    def files(self):
        return sorted(os.path.relpath(os.path.join(d, f), self.dir) for d, _, fs in os.walk(self.dir) for f in fs)

    def nothing_half_written(self, folder):
        for d, _, fs in os.walk(folder):
            for f in fs:
                self.assertFalse(f.endswith(".tmp"), f"{f} was left in {d}")

    def summary(self, folder):
        with open(os.path.join(folder, "summary.json")) as f:
            return json.load(f)


class Messages(Folder):
    """Errors of usage and of the case: exit 2, where, what, what instead; nothing written."""

    def refused(self, *arguments, says, name="case.toml", text=None):
        if text is not None:
            self.write(name, text)
        before = self.files()
        r = self.ejecta(*arguments)
        said = r.stdout + r.stderr
        self.assertEqual(r.returncode, 2, said)
        for part in says:
            self.assertIn(part, said)
        self.assertNotIn("terminate called", said)
        self.assertEqual(self.files(), before, "something was written")
        self.assertFalse(os.path.exists(self.out) and os.listdir(self.out))
        return said

    def line_of(self, text, part):
        return next(i + 1 for i, line in enumerate(text.splitlines()) if part in line)

    def run_with(self, old, new, says):
        text = CASE.replace(old, new, 1)
        self.assertNotEqual(text, CASE)
        line = self.line_of(text, new.splitlines()[0])
        for command in ("run", "check"):
            arguments = [command, "case.toml"] + (["--out", self.out] if command == "run" else [])
            self.refused(*arguments, text=text, says=[f"case.toml:{line}", *says])

    def test_misspelt_key(self):
        self.run_with('diameter = "1 mm"', 'diametre = "1 mm"', ["diametre", "diameter"])

    def test_misspelt_table(self):
        self.run_with("[output]", "[ouput]", ["ouput", "output"])

    def test_wrong_unit(self):
        self.run_with('end = "0.4 us"', 'end = "0.4 mm"', ["end", "0.4 mm"])

    def test_unknown_unit(self):
        self.run_with('thickness = "0.3 mm"', 'thickness = "0.3 smoot"', ["thickness", "smoot"])

    def test_zero_thickness(self):
        self.run_with('thickness = "0.3 mm"', 'thickness = "0 mm"', ["thickness", "0"])

    def test_unknown_material(self):
        self.run_with('material = "Al2024-T351"', 'material = "Al2024-T53"', ["material", "Al2024-T53", "Al2024-T351"])

    def test_unknown_mode(self):
        self.run_with('mode = "hybrid"', 'mode = "hybird"', ["mode", "hybird", "hybrid"])

    def test_unknown_shape(self):
        self.run_with('shape = "sphere"', 'shape = "spere"', ["shape", "spere", "sphere"])

    def test_missing_velocity_number(self):
        self.run_with('velocity = ["0 km/s", "0 km/s", "-6 km/s"]', 'velocity = ["0 km/s", "-6 km/s"]', ["velocity", "3"])

    def test_syntax(self):
        self.refused("run", "case.toml", "--out", self.out, text=CASE.replace("[run]", "[run"), says=["case.toml:2"])

    def test_overlapping_bodies(self):
        text = CASE.replace('"0.52 mm"]', '"0.42 mm"]')
        self.refused("run", "case.toml", "--out", self.out, text=text, says=["projectile", "bumper", "overlap", "case.toml"])

    def test_a_body_that_a_plane_of_symmetry_does_not_halve(self):
        text = CASE.replace('elements_across = 6', 'elements_across = 6\nsymmetry = ["y"]').replace('"0 mm", "0 mm", "-0.15 mm"', '"0 mm", "1 mm", "-0.15 mm"')
        self.refused("run", "case.toml", "--out", self.out, text=text, says=["case.toml", "run.symmetry", '"y"', 'body "bumper"', "auto"])

    def test_a_body_behind_a_wall(self):
        wall = '[[wall]]\npoint = [0, 0, "{}"]\nnormal = [0, 0, {}]\n'
        for height, normal, depth in [("-1 mm", -1, "2.02"), ("0.5 mm", 1, "0.48")]:
            self.refused("run", "case.toml", "--out", self.out, text=CASE + wall.format(height, normal),
                         says=["wall.0", '"projectile"', depth + " mm behind"])

    def test_walls_that_are_not_square(self):
        walls = "".join(f'[[wall]]\npoint = [0, 0, "-9 mm"]\nnormal = {n}\n' for n in ("[0, 0, 1]", "[1, 0, 1]"))
        self.refused("run", "case.toml", "--out", self.out, text=CASE + walls, says=["wall.1", "wall.0", "45 deg"])

    def test_a_mesh_in_a_plate(self):
        corners = [(x, y, z) for z in (0, 1) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))]
        self.write("cube.k", "*KEYWORD\n*NODE\n" + "".join(f"{k + 1},{x * 1e-3},{y * 1e-3},{z * 1e-3}\n" for k, (x, y, z) in enumerate(corners)) +
                   "*ELEMENT_SOLID\n1,1,1,2,3,4,5,6,7,8\n*END\n")
        text = CASE.replace('shape = "sphere"\ndiameter = "1 mm"', 'shape = "mesh"\nfile = "cube.k"')
        deep = text.replace('"0.52 mm"]\nvelocity', '"-0.2 mm"]\nvelocity')
        self.assertEqual(deep.count('"-0.2 mm"'), 1)
        self.refused("run", "case.toml", "--out", self.out, text=deep, says=["overlap", '"projectile"', '"bumper"'])
        self.write("case.toml", text)
        self.assertEqual(self.ejecta("check", "case.toml", "--no-cost").returncode, 0)

    def test_names_that_results_cannot_hold(self):
        for name in ("a|b", "a,b", "fragments"):
            self.run_with('name = "bumper"', f'name = "{name}"', [name])

    def test_no_utf8(self):
        r = subprocess.run([PROGRAM.encode(), b"check", b"case.toml", b"--set", b"title=\xff\xfe"], cwd=self.dir, capture_output=True)
        self.assertEqual(r.returncode, 2)
        self.assertIn(b"UTF-8", r.stderr)

    def test_references(self):
        for line, says in [('"bumper.perforated" = 7', "true or false"), ('"cloud.mass" = "5 mm"', "a mass is needed"),
                           ('"bumper.hole_diametr" = "2 mm"', "did you mean 'bumper.hole_diameter'?"), ('"peak_pressur" = "50 GPa"', "did you mean 'peak_pressure'"),
                           ('"bumper.cloud.spray" = 1', "valid: bumper.cloud.mass, "), ('"" = 1', "valid: peak_pressure, "), ('"bumper." = 1', "valid: bumper.hole_diameter, "),
                           ('"hole_diameter" = "2 mm"', "nothing is measured by that name")]:
            self.refused("run", "case.toml", "--out", self.out, text=CASE + f"[reference]\n{line}\n", says=["case.toml:23", says])
        self.write("case.toml", CASE + '[reference]\n"fragments.count" = 5\n"projectile.final_length" = "2 mm"\n')
        r = self.ejecta("run", "case.toml", "--out", self.out)
        self.assertEqual(r.returncode, 0, r.stderr)
        warnings = self.summary(self.out)["warnings"]
        self.assertEqual(len(warnings), 1, warnings)
        self.assertIn("projectile.final_length", warnings[0])
        # all that runs measure is known by name
        wall = CASE[CASE.rindex("[[body]]"):CASE.index("[output]")].replace("bumper", "wall").replace("-0.15 mm", "-1.65 mm")
        bar = """title = "bar"
[run]
mode = "fem"
end = "0.2 us"
elements_across = 4
[[body]]
name = "bar"
shape = "cylinder"
diameter = "1 mm"
length = "2 mm"
center = ["0 mm", "0 mm", "1 mm"]
velocity = [0, 0, -100]
material = "Al2024-T351"
[[wall]]
point = [0, 0, 0]
normal = [0, 0, 1]
"""
        shots = {"shot": CASE.replace("elements_across = 6", "elements_across = 4") + wall, "bar": bar}
        for name, text in shots.items():
            self.write(name + ".toml", text)
            r = self.ejecta("run", name + ".toml", "--out", name, "--set", 'run.end="0.6 us"')
            self.assertEqual(r.returncode, 0, r.stderr)
            measured = self.summary(os.path.join(self.dir, name))["measurements"]
            self.assertGreater(len(measured), 3)
            value = lambda v: str(v).lower() if isinstance(v, bool) else repr(v)
            self.write(name + ".toml", text + "[reference]\n" + "".join(f'"{k}" = {value(m["value"])}\n' for k, m in measured.items()))
            r = self.ejecta("check", "--no-cost", name + ".toml")
            self.assertEqual(r.returncode, 0, r.stderr)

    def test_sizes_without_end(self):
        for override in ("body.projectile.element_size=1e-11", 'body.bumper.size=["1e6 m", "1e6 m"]'):
            self.refused("run", "case.toml", "--out", self.out, "--set", override, says=["elements in a line"])

    def test_more_than_can_be_counted(self):
        """8e6 elements along each axis of a sphere are 3e20, more than 64 bits count."""
        text = '[run]\nend = "1 us"\n[[body]]\nname = "p"\nshape = "sphere"\ndiameter = "1 mm"\nmaterial = "Be"\nelement_size = 1.2e-10\n'
        self.refused("check", "case.toml", text=text, says=["GiB free"])

    def test_more_than_the_machine_has(self):
        text = CASE.replace("elements_across = 6", "elements_across = 3000")
        said = self.refused("run", "case.toml", "--out", self.out, text=text, says=["elements_across", "3000"])
        self.assertIn(f"case.toml:{self.line_of(text, '3000')}", said)
        text = CASE.replace("elements_across = 6", "elements_across = 1000")
        self.refused("run", "case.toml", "--out", self.out, text=text, says=["elements_across", "1000", "GiB"])
        self.refused("check", "case.toml", text=text, says=["GiB"])

    def test_no_case(self):
        self.refused("run", "nowhere.toml", says=["nowhere.toml"])
        self.write("noise.toml", "\x00\x01\x7fELF no case at all")
        self.refused("run", "noise.toml", says=["noise.toml"])
        self.write("empty.toml", "")
        self.refused("run", "empty.toml", says=["empty.toml"])
        os.mkdir(os.path.join(self.dir, "folder"))
        self.refused("run", "folder", says=["folder"])

    def test_existing_folder(self):
        os.mkdir(self.out)
        with open(os.path.join(self.out, "mine"), "w") as f:
            f.write("precious")
        before = self.files()
        r = self.ejecta("run", "case.toml", "--out", self.out)
        self.assertEqual(r.returncode, 2)
        self.assertIn("--force", r.stderr)
        self.assertIn(self.out, r.stderr)
        self.assertEqual(self.files(), before)

    def test_folder_that_cannot_be_made(self):
        self.write("file", "")
        self.refused("run", "case.toml", "--out", os.path.join(self.dir, "file", "out"), says=["file"])

    def test_folder_that_takes_no_files(self):
        said = self.refused("run", "case.toml", "--out", "/proc", "--force", says=["/proc", "cannot be written", "--out"])  # whoever runs it
        self.assertNotIn("stopped", said)

    def test_usage(self):
        self.refused("rnu", "case.toml", says=["rnu"])
        self.refused(says=["run"])
        self.refused("run", says=["CASE"])
        self.refused("run", "case.toml", "--threads", "0", says=["threads"])
        self.refused("run", "case.toml", "--speed", "11", says=["speed"])
        self.refused("run", "case.toml", "--mode", "hybird", "--out", self.out, says=["hybird", "hybrid"])

    def test_bad_override(self):
        for key, says in (("run.ned=1", ["run.ned", "end"]), ("end=1", ["end"]), ("run.end", ["run.end"]),
                          ('run.end="3 mm"', ["end", "3 mm"]), ("body.bumber.thickness=1", ["bumber", "bumper"])):
            self.refused("run", "case.toml", "--out", self.out, "--set", key, says=["--set", *says])

    def test_an_override_before_the_case(self):
        """--set takes what assigns something, and leaves the case alone."""
        for order in (["--set", "run.end=0.1 us", "case.toml"], ["--set", "run.end=0.1 us", "run.cfl=0.5", "case.toml"],
                      ["case.toml", "--set", "run.end=0.1 us", "run.cfl=0.5"], ["--set=run.end=0.1 us", "case.toml", "--set", "run.cfl=0.5"]):
            r = self.ejecta("check", "--no-cost", *order)
            self.assertEqual(r.returncode, 0, r.stderr)
            self.assertIn("\nend = 1e-07\n", r.stdout)
            self.assertEqual("\ncfl = 0.5\n" in r.stdout, "run.cfl=0.5" in order)
        self.refused("check", "--set", "case.toml", says=["CASE is required"])

    def test_files_of_a_run_that_cannot_be_read(self):
        self.assertEqual(self.ejecta("run", "case.toml", "--out", "run", "--set", 'run.end="0.05 us"').returncode, 0)
        case, checkpoint, h5 = (os.path.join(self.dir, "run", name) for name in ("case.toml", "checkpoint.h5", "run.h5"))
        with open(checkpoint, "rb") as f:
            whole = f.read()
        for damaged in (b"", whole[:1000], whole[:-1], b"no checkpoint" * 100):
            with open(checkpoint, "wb") as f:
                f.write(damaged)
            self.refused("resume", "run", says=["checkpoint.h5: cannot be read", "start anew with: ejecta run CASE --out run --force"])
        shutil.copy(h5, checkpoint)
        self.refused("resume", "run", says=["is no checkpoint of Ejecta"])
        os.truncate(h5, 3000)
        for more in ([], ["--series"]):
            self.refused("measure", "run", *more, says=["run.h5: cannot be read", "finish the run with: ejecta resume run"])
        # without its history a run begins a new one, head and all
        with open(checkpoint, "wb") as f:
            f.write(whole)
        os.remove(os.path.join(self.dir, "run", "history.csv"))
        with open(case) as f:
            text = f.read()
        with open(case, "w") as f:
            f.write(text.replace("\nend = 5e-08\n", "\nend = 1e-07\n"))
        self.assertEqual(self.ejecta("resume", "run").returncode, 0)
        with open(os.path.join(self.dir, "run", "history.csv")) as f:
            self.assertGreater(float(next(csv.DictReader(f))["time_s"]), 5e-8)

    def test_unknown_names(self):
        self.refused("materials", "Al2024", says=["Al2024-T351"])
        self.refused("hugoniot", "unobtainium", says=["unobtainium"])
        self.refused("resume", "nowhere", says=["nowhere"])
        self.refused("measure", "nowhere", says=["nowhere"])
        self.refused("compare", "nowhere", "elsewhere", says=["nowhere/summary.json"])
        self.refused("compare", "nowhere", says=["two or more"])

    def test_files_that_results_cannot_go_to(self):
        kept = self.write("rates.json", "precious")
        self.refused("bench", "octree", "--points", "nowhere", "--json", "rates.json", says=["nowhere"])
        with open(kept) as f:
            self.assertEqual(f.read(), "precious")
        for command, option in ((("bench", "hex"), "--json"), (("eos", "table", "Al"), "--out")):
            self.refused(*command, option, "no/file", says=[option, "no folder"])
            self.refused(*command, option, self.dir, says=[option, "is a folder"])


class Output(Folder):
    """What a run leaves, and the commands that only print."""

    def test_a_run_and_its_measurements(self):
        r = self.ejecta("run", "case.toml", "--out", self.out)
        self.assertEqual(r.returncode, 0, r.stdout + r.stderr)
        for name in ("case.toml", "summary.json", "history.csv", "run.h5", "run.xdmf", "checkpoint.h5", "log.txt"):
            self.assertTrue(os.path.getsize(os.path.join(self.out, name)) > 0, name)
        self.nothing_half_written(self.out)
        summary = self.summary(self.out)
        for key in SUMMARY_KEYS:
            value = summary
            for part in key.split("."):
                self.assertIn(part, value, key)
                value = value[part]
        self.assertIs(summary["completed"], True)
        self.assertEqual(summary["stop_reason"], "end time")
        self.assertAlmostEqual(summary["time"], 0.4e-6, delta=1e-15)
        self.assertLess(abs(summary["conservation"]["energy_error"]), 1e-9)
        ledger = summary["conservation"]["ledger"]
        self.assertAlmostEqual(sum(ledger.values()) / summary["conservation"]["initial_kinetic"], 1, delta=1e-9)
        elements = summary["elements"]
        self.assertEqual(elements["initial"], elements["alive"] + elements["converted"] + elements["eroded"])
        self.assertGreater(len(summary["measurements"]), 3)
        for entry in summary["measurements"].values():
            self.assertEqual(set(entry) & {"value", "unit"}, {"value", "unit"})

        with open(os.path.join(self.out, "history.csv")) as f:
            rows = list(csv.DictReader(f))
        self.assertGreater(len(rows), 10)
        times = [float(row["time_s"]) for row in rows]
        self.assertEqual(times, sorted(times))
        self.assertEqual(len(times), len(set(times)), "a time is there twice")
        for row in rows:
            self.assertNotIn(None, row)
            for key, value in row.items():
                if key != "limiter":
                    self.assertEqual(float(value), float(value), f"{key} is no number")
        self.assertEqual(int(rows[-1]["step"]), summary["steps"])

        # measured again from the stored state: the same numbers
        again = self.ejecta("measure", self.out)
        self.assertEqual(again.returncode, 0, again.stderr)
        remeasured = self.summary(self.out)
        self.assertEqual(remeasured["measurements"], summary["measurements"])
        self.assertEqual({k: v for k, v in remeasured.items() if k != "measurements"},
                         {k: v for k, v in summary.items() if k != "measurements"})

        # a finished run has nothing left to do; --force overwrites
        r = self.ejecta("resume", self.out)
        self.assertEqual(r.returncode, 0, r.stderr)
        self.assertEqual(self.summary(self.out), remeasured)
        r = self.ejecta("run", "case.toml", "--out", self.out, "--force")
        self.assertEqual(r.returncode, 0, r.stderr)
        self.assertEqual(self.summary(self.out)["measurements"], summary["measurements"], "the same run gave other numbers")

    def test_runs_side_by_side(self):
        """Numbers are those of the summaries; brackets against the reference of one of the cases, or against the first run."""
        reference = '[reference]\n"bumper.hole_diameter" = { value = "2 mm", source = "none" }\n'
        self.write("case.toml", CASE + reference)
        self.assertEqual(self.ejecta("run", "case.toml", "--out", "first", "--mode", "erosion").returncode, 0)
        self.assertEqual(self.ejecta("run", "case.toml", "--out", "second/run", "--set", "convert.jacobian_ratio=2").returncode, 0)
        r = self.ejecta("compare", "first", "second/run/")
        self.assertEqual(r.returncode, 0, r.stderr)
        one, two = self.summary(os.path.join(self.dir, "first")), self.summary(os.path.join(self.dir, "second", "run"))
        lines = r.stdout.splitlines()
        self.assertEqual(lines[0].split(), ["first", "run", "reference"])
        rows = {re.split("  +", line.strip())[0]: re.split("  +", line.strip())[1:] for line in lines[1:]}
        differs = lines[lines.index("what differs in the cases") + 1:lines.index("runs")]
        self.assertEqual([line.split()[0] for line in differs], ["convert.jacobian_ratio", "run.mode"])
        self.assertEqual(rows["run.mode"], ["erosion", "hybrid"])
        self.assertEqual(rows["steps"], [str(one["steps"]), str(two["steps"])])
        self.assertEqual(rows["elements, eroded"], [str(one["elements"]["eroded"]), "0"])
        self.assertEqual(rows["particles, final"], ["0", str(two["particles"]["final"])])
        hole = [s["measurements"]["bumper.hole_diameter"]["value"] for s in (one, two)]
        self.assertEqual(rows["bumper.hole_diameter"], [f"{1e3 * h:.4g} mm ({100 * (h / 2e-3 - 1):+.1f} %)" for h in hole] + ["2 mm"])
        impulse = [s["measurements"]["bumper.impulse"]["value"] for s in (one, two)]
        self.assertEqual(rows["bumper.impulse"],
                         [f"{impulse[0]:.4g} N s", f"{impulse[1]:.4g} N s ({100 * (impulse[1] / impulse[0] - 1):+.1f} %)"])
        for k, s in enumerate((one, two)):
            kinetic = 100 * s["conservation"]["ledger"]["kinetic"] / s["conservation"]["initial_kinetic"]
            self.assertEqual(rows["kinetic"][k], f"{kinetic:.3f}")
        # what one run alone has measured
        only = set(two["measurements"]) - set(one["measurements"])
        for key in only:
            self.assertEqual(rows[key][0], "-", key)

    def test_a_later_end(self):
        self.assertEqual(self.ejecta("run", "case.toml", "--out", self.out, "--set", 'run.end="0.2 us"').returncode, 0)
        first = self.summary(self.out)
        path = os.path.join(self.out, "case.toml")
        with open(path) as f:
            text = f.read()
        self.assertIn("end = 2e-07", text)
        with open(path, "w") as f:
            f.write(text.replace("end = 2e-07", 'end = "0.4 us"'))
        r = self.ejecta("resume", self.out)
        self.assertEqual(r.returncode, 0, r.stderr)
        second = self.summary(self.out)
        self.assertTrue(second["completed"])
        self.assertAlmostEqual(second["time"], 4e-7)
        self.assertGreater(second["steps"], first["steps"])
        self.assertLess(abs(second["conservation"]["energy_error"]), 1e-12)
        with open(os.path.join(self.out, "history.csv")) as f:
            times = [float(row["time_s"]) for row in csv.DictReader(f)]
        self.assertEqual(times, sorted(set(times)), "a step stands twice")

    def test_a_later_end_with_a_plate_that_was_out_of_reach(self):
        """It keeps the mesh that it has, and says that the plate's is coarse."""
        text = CASE + """[[body]]
name = "wall"
shape = "plate"
size = ["6 mm", "6 mm"]
thickness = "0.3 mm"
center = ["0 mm", "0 mm", "-8 mm"]
material = "Al2024-T351"
"""
        self.write("case.toml", text)
        self.assertEqual(self.ejecta("run", "case.toml", "--out", self.out).returncode, 0)
        case = os.path.join(self.out, "case.toml")
        with open(case) as f:
            resolved = f.read()
        self.assertIn("\nend = 4e-07\n", resolved)
        with open(case, "w") as f:
            f.write(resolved.replace("\nend = 4e-07\n", "\nend = 2e-06\n"))
        before = self.summary(self.out)["measurements"]["wall.rim_displacement"]
        self.assertEqual(self.ejecta("measure", self.out).returncode, 0)
        self.assertEqual(self.summary(self.out)["measurements"]["wall.rim_displacement"], before)
        r = self.ejecta("resume", self.out)
        self.assertEqual(r.returncode, 0, r.stderr)
        self.assertAlmostEqual(self.summary(self.out)["time"], 2e-6, delta=1e-15)
        self.assertTrue(any('"wall" has the coarse mesh' in w for w in self.summary(self.out)["warnings"]))

    def test_two_runs_into_one_folder(self):
        slow = ["run", "case.toml", "--out", self.out, "--threads", "1", "--set", "run.elements_across=16", "--set", "run.end=20us"]
        first = subprocess.Popen([PROGRAM, *slow], cwd=self.dir, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        self.addCleanup(first.communicate)
        self.addCleanup(first.kill)
        while not os.path.exists(os.path.join(self.out, "history.csv")):
            self.assertIsNone(first.poll())
            time.sleep(0.02)
        r = self.ejecta(*slow, "--force")
        self.assertEqual(r.returncode, 2)
        self.assertIn("another run", r.stderr)
        first.send_signal(signal.SIGHUP)  # the terminal was closed: like Ctrl-C
        self.assertEqual(first.wait(60), 130)
        self.assertTrue(os.path.exists(os.path.join(self.out, "checkpoint.h5")))

    def test_without_a_screen(self):
        """Neither a closed screen nor one that goes away gets into the results or ends the run."""
        for how in ("{} run case.toml --out closed >&- 2>&-", "{} run case.toml --out gone | head -n 1"):
            subprocess.run(how.format(PROGRAM), shell=True, cwd=self.dir, capture_output=True, timeout=100)
        for name in ("closed", "gone"):
            self.assertTrue(self.summary(os.path.join(self.dir, name))["completed"])
            with open(os.path.join(self.dir, name, "history.csv")) as f:
                self.assertNotIn("gone", f.read())

    def test_the_default_folder(self):
        os.makedirs(os.path.join(self.dir, "plate_0.8mm"))
        self.write("plate_0.8mm/case.toml", CASE.replace("0.4 us", "0.02 us"))
        self.assertEqual(self.ejecta("run", "plate_0.8mm/").returncode, 0)
        self.assertEqual(os.listdir(os.path.join(self.dir, "runs")), ["plate_0.8mm-hybrid"])

    def test_a_case_is_not_overwritten_by_its_run(self):
        self.assertEqual(self.ejecta("run", ".", "--out", ".", "--force").returncode, 2)
        with open(self.case) as f:
            self.assertEqual(f.read(), CASE)

    def test_a_case_that_was_changed_is_resumed_where_it_can_be(self):
        self.assertEqual(self.ejecta("run", "case.toml", "--out", self.out, "--set", "convert.criterion=deformation").returncode, 0)
        case = os.path.join(self.out, "case.toml")
        with open(case) as f:
            resolved = f.read()
        resolved = resolved.replace("\nend = 4e-07\n", "\nend = 6e-07\n")
        for old, new, code in [('hourglass = "viscous"', 'hourglass = "stiffness"', 2), ('["deformation"]', '["jacobian"]', 0)]:
            self.assertIn(old, resolved)
            with open(case, "w") as f:
                f.write(resolved.replace(old, new))
            r = self.ejecta("resume", self.out)
            self.assertEqual(r.returncode, code, r.stderr)
            if code:
                self.assertIn("run.hourglass", r.stderr)

    def test_a_case_that_was_not_changed_is_resumed(self):
        """case.toml holds what TOML reads to the same: a zero with a minus before it, a material that has no strength and says nothing of it."""
        self.write("case.toml", CASE + '[materials.gas]\nrho_0 = 1000\neos = { model = "ideal_gas", gamma = 1.4, cv = 718 }\n')
        for override in ('body.projectile.center=[-0.0, 0, "0.52 mm"]', "body.bumper.material=gas"):
            self.assertEqual(self.ejecta("run", "case.toml", "--out", self.out, "--force", "--set", override, "--set", "run.end=1e-8").returncode, 0)
            with open(os.path.join(self.out, "case.toml")) as f:
                resolved = f.read()
            with open(os.path.join(self.out, "case.toml"), "w") as f:
                f.write(resolved.replace("\nend = 1e-08\n", "\nend = 2e-08\n"))
            r = self.ejecta("resume", self.out)
            self.assertEqual(r.returncode, 0, r.stderr)
            self.assertEqual(self.summary(self.out)["time"], 2e-8)

    def test_a_summary_that_is_none(self):
        self.assertEqual(self.ejecta("run", "case.toml", "--out", self.out).returncode, 0)
        for text in ("[]", "5", ""):
            with open(os.path.join(self.out, "summary.json"), "w") as f:
                f.write(text)
            r = self.ejecta("measure", self.out)
            self.assertEqual(r.returncode, 2, r.stderr)
            self.assertIn("ejecta resume", r.stderr)

    def test_state_of_another_mesh(self):
        self.assertEqual(self.ejecta("run", "case.toml", "--out", self.out).returncode, 0)
        path = os.path.join(self.out, "case.toml")
        with open(path) as f:
            text = f.read()
        with open(path, "w") as f:
            f.write(text.replace("elements_across = 6", "elements_across = 4"))
        with open(os.path.join(self.out, "summary.json")) as f:
            before = f.read()
        r = self.ejecta("measure", self.out)
        self.assertEqual(r.returncode, 2, r.stdout + r.stderr)
        self.assertIn("run it again", r.stdout + r.stderr)
        with open(os.path.join(self.out, "summary.json")) as f:
            self.assertEqual(f.read(), before)

    def test_the_resolved_case_gives_the_same_run(self):
        r = self.ejecta("run", "case.toml", "--out", self.out)
        self.assertEqual(r.returncode, 0, r.stderr)
        other = os.path.join(self.dir, "other")
        r = self.ejecta("run", os.path.join(self.out, "case.toml"), "--out", other)
        self.assertEqual(r.returncode, 0, r.stderr)
        a, b = self.summary(self.out), self.summary(other)
        self.assertEqual(a["steps"], b["steps"])
        self.assertEqual(a["measurements"], b["measurements"])

    def test_a_run_is_the_same_whatever_is_written(self):
        runs = []
        for every, folder in (("0.4 us", self.out), ("0.013 us", os.path.join(self.dir, "often"))):
            r = self.ejecta("run", "case.toml", "--out", folder, "--set", f'output.every="{every}"')
            self.assertEqual(r.returncode, 0, r.stderr)
            runs.append(self.summary(folder))
        self.assertEqual(runs[0]["steps"], runs[1]["steps"])
        self.assertEqual(runs[0]["measurements"], runs[1]["measurements"])
        self.assertEqual(runs[0]["conservation"], runs[1]["conservation"])

    def test_overrides_and_modes(self):
        r = self.ejecta("run", "case.toml", "--out", self.out, "--mode", "erosion", "--set", 'run.end="0.1 us"', "--threads", "2")
        self.assertEqual(r.returncode, 0, r.stderr)
        summary = self.summary(self.out)
        self.assertEqual(summary["mode"], "erosion")
        self.assertEqual(summary["threads"], 2)
        self.assertAlmostEqual(summary["time"], 0.1e-6, delta=1e-15)
        self.assertEqual(summary["particles"]["created"], 0)

    def test_check(self):
        before = self.files()
        r = self.ejecta("check", "case.toml")
        self.assertEqual(r.returncode, 0, r.stderr)
        for part in ("[run]", "projectile", "bumper", "elements", "active", "cost", "steps"):
            self.assertIn(part, r.stdout)
        self.assertEqual(self.files(), before)
        # what it prints is a case
        self.write("resolved.toml", r.stdout)
        r = self.ejecta("check", "resolved.toml")
        self.assertEqual(r.returncode, 0, r.stderr)
        self.assertNotIn("# warning", r.stdout)
        # and what the run would warn of
        r = self.ejecta("check", "case.toml", "--no-cost", "--set", "body.bumper.elements_through=9")
        self.assertIn('# warning: body "bumper" has layers of elements of 0.0333 mm', r.stdout)

    def test_check_of_particles(self):
        for each in (1, 2):  # particles per edge
            r = self.ejecta("check", "case.toml", "--mode", "sph", "--threads", "1", "--set", f"convert.particles_per_edge={each}")
            self.assertEqual(r.returncode, 0, r.stderr)
            elements, particles = map(int, re.search(r"# cost: (\d+) elements.* (\d+) particles at the end", r.stdout).groups())
            self.assertEqual(particles, each**3 * elements)

    def test_a_cloud_is_measured_before_it_strikes(self):
        if h5py is None:
            self.skipTest("needs h5py")
        wall = CASE[CASE.rindex("[[body]]"):CASE.index("[output]")].replace("bumper", "wall").replace("-0.15 mm", "-1.65 mm")  # front face at -1.5 mm
        self.write("case.toml", CASE.replace("elements_across = 6", "elements_across = 4") + wall)
        r = self.ejecta("run", "case.toml", "--out", self.out, "--set", "output.every=1e-15")
        self.assertEqual(r.returncode, 0, r.stderr)
        with h5py.File(os.path.join(self.out, "run.h5")) as f:
            steps = [f[name] for name in sorted(f) if any("frozen:cloud." in a for a in f[name].attrs)]
            step = steps[0]
            front = min(float(x) for x in step["particle_x"][:, 2])
            nodes = step["element_node"][:][step["element/body"][:] < 2].ravel()
            front = min(front, float(step["node_x"][:][nodes, 2].min()))
            longest = max(float(f[name].attrs["time"]) for name in f) / len(f)
        near = 0.25e-3  # a quarter of the sphere
        self.assertLess(front + 1.5e-3, near)
        self.assertGreater(front + 1.5e-3, near - 1.5 * 6000 * 2 * longest)  # within a step's way

    def test_picture_of_a_projectile_from_a_file(self):
        if h5py is None or importlib.util.find_spec("matplotlib") is None:
            self.skipTest("needs h5py and Matplotlib")
        corners = [(x, y, z) for z in (0, 1) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))]  # one hex of 1 mm, 0.02 mm above the plate
        self.write("cube.k", "*NODE\n" + "".join(f"{k + 1}, {1e-3 * x}, {1e-3 * y}, {1e-3 * z + 2e-5}\n" for k, (x, y, z) in enumerate(corners)) +
                   "*ELEMENT_SOLID\n1, 1, 1, 2, 3, 4, 5, 6, 7, 8\n*END\n")
        sphere = CASE[CASE.index('shape = "sphere"'):CASE.index("velocity")]
        self.write("case.toml", CASE.replace(sphere, 'shape = "mesh"\nfile = "cube.k"\n', 1))
        r = self.ejecta("run", "case.toml", "--out", self.out, "--set", 'run.end="0.01 us"', "--set", 'output.every="0.01 us"')
        self.assertEqual(r.returncode, 0, r.stderr)
        r = self.ejecta("report", self.out)
        self.assertEqual(r.returncode, 0, r.stderr)
        self.assertGreater(os.path.getsize(os.path.join(self.out, "cloud.png")), 10000)

    def test_materials_and_hugoniot(self):
        r = self.ejecta("materials")
        self.assertEqual(r.returncode, 0)
        for name in ("Al2024-T351", "Al6061-T6", "OFHC-Cu", "Be", "Ti-6Al-4V"):
            self.assertIn(name, r.stdout)
        for line in r.stdout.splitlines():
            self.assertEqual("without a limit of tension" in line, "spall.limit" not in self.ejecta("materials", line.split()[0]).stdout, line)
        r = self.ejecta("materials", "Al2024-T351")
        self.assertEqual(r.returncode, 0)
        for part in ("Al2024-T351", "MPa", "johnson_cook"):
            self.assertIn(part, r.stdout)
        r = self.ejecta("hugoniot", "Al2024-T351")
        self.assertEqual(r.returncode, 0)
        rows = [list(map(float, line.split())) for line in r.stdout.splitlines() if line.strip() and line.split()[0][0].isdigit()]
        self.assertGreater(len(rows), 10)
        for up, us, p, rho, *_ in rows:  # jump conditions [km/s, GPa, kg/m3], rounded to the digits printed
            rho_0 = 2785
            self.assertAlmostEqual(p, rho_0 * us * up * 1e-3, delta=2e-3 * p)
            self.assertAlmostEqual(rho, rho_0 * us / (us - up), delta=2e-3 * rho)
        # LASL Shock Hugoniot Data (Marsh 1980): Us = 5.328 + 1.338 up for 2024 aluminium
        up, us = next((row[0], row[1]) for row in rows if abs(row[0] - 2) < 1e-6)
        self.assertAlmostEqual(us, 5.328 + 1.338 * up, delta=0.02 * us)
        # McQueen et al. (1970): V/V0 = 0.73401 at 48.2608 GPa, so up = sqrt(p (1 - V/V0)/rho_0) = 2.147 km/s; the model there: rho_0 Us up
        at = next(row for row in rows if row[2] == 48.2608)
        model = 2785 * (5328 + 1.338 * 2146.9) * 2146.9e-9
        self.assertAlmostEqual(at[0], 2.147, delta=6e-4)
        self.assertAlmostEqual(at[4], model, delta=2e-4 * model)
        self.assertAlmostEqual(at[5], 100 * (model / 48.2608 - 1), delta=0.02)
        self.write("case.toml", CASE + '[materials.mine]\nbase = "Al2024-T351"\n[materials.mine.strength]\nA = "300 MPa"\n')
        of_mine = self.ejecta("hugoniot", "mine", "--case", "case.toml")
        self.assertEqual(of_mine.stdout.splitlines()[1:], r.stdout.splitlines()[1:])
        self.assertIn("no measured shock states", self.ejecta("hugoniot", "Be").stdout)

    def test_examples_of_the_documents(self):
        """Every `ejecta run cases/...` of README.md, docs/ and cases/ is a case that can be run."""
        root = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
        texts = []
        for path in [os.path.join(root, "README.md"), *glob.glob(root + "/docs/*.md"), *glob.glob(root + "/cases/*/README.md")]:
            with open(path) as f:
                texts.append(f.read())
        examples = {m for text in texts for m in re.findall(r"^    (?:build/)?ejecta run (cases/[^&#\n]*?)(?:  |&&|$)", text, re.M)}
        self.assertGreater(len(examples), 6)
        for example in sorted(examples):
            r = subprocess.run([PROGRAM, "check", "--no-cost", *shlex.split(example)], cwd=root, capture_output=True, text=True, timeout=100)
            self.assertEqual(r.returncode, 0, example + r.stderr)

    def test_help(self):
        r = self.ejecta("--help")
        self.assertEqual(r.returncode, 0)
        for command in ("run", "resume", "check", "measure", "report", "compare", "trade", "hugoniot", "materials", "bench"):
            self.assertIn(command, r.stdout)


class Studies(Folder):
    """Reports, and trade studies of cost against accuracy."""

    REFERENCE = """[reference]
"bumper.hole_diameter" = { value = "2.0 mm", source = "Smith & <Sons>" }
"cloud.spray_half_angle" = { value = "30 deg", source = "the same" }
"bumper.perforated" = { value = true, source = "the same" }
"""
    draws = h5py is not None and importlib.util.find_spec("matplotlib") is not None

    def test_report(self):
        self.write("case.toml", CASE.replace("small shot", "shot & <cloud>") + self.REFERENCE)
        self.assertEqual(self.ejecta("run", "case.toml", "--out", self.out).returncode, 0)
        r = self.ejecta("report", self.out)
        self.assertEqual(r.returncode, 0 if self.draws else 3, r.stderr)
        with open(os.path.join(self.out, "report.html")) as f:
            page = f.read()
        measured = self.summary(self.out)["measurements"]
        hole = measured["bumper.hole_diameter"]["value"]
        for part in ("<h1>shot &amp; &lt;cloud&gt;</h1>", "Smith &amp; &lt;Sons&gt;", f"<td>{1e3 * hole:.4g} mm</td><td>2 mm</td><td>{100 * (hole / 2e-3 - 1):+.1f} %</td>",
                     "<td>bumper.perforated</td><td>yes</td><td>yes</td><td>right</td>", "elements_across = 6"):
            self.assertIn(part, page)
        for key in measured:
            self.assertIn(f"<td>{key}</td>", page)
        with open(os.path.join(self.out, "fragments.csv")) as f:
            heaviest = max(float(row["mass_kg"]) for row in csv.DictReader(f))
        self.assertIn(f"<td>1</td><td>{1e6 * heaviest:.4g} mg</td>", page)
        for picture in ("cloud.png", "speed.png"):
            self.assertEqual(f'<img src="{picture}"' in page, self.draws)
            self.assertEqual(os.path.exists(os.path.join(self.out, picture)), self.draws)
        if not self.draws:
            self.assertIn("python3-matplotlib", r.stderr)
        # what an earlier run's report says is not left beside another run
        self.assertEqual(self.ejecta("run", "case.toml", "--out", self.out, "--force", "--set", 'run.end="0.01 us"').returncode, 0)
        self.assertFalse({"report.html", "cloud.png", "speed.png"} & set(os.listdir(self.out)))

    def test_report_without_pictures(self):
        """Where nothing can be drawn the report is there all the same, and the command says what is missing."""
        self.assertEqual(self.ejecta("run", "case.toml", "--out", self.out, "--set", 'run.end="0.01 us"').returncode, 0)
        os.rename(os.path.join(self.out, "history.csv"), os.path.join(self.dir, "kept.csv"))
        self.write("out/history.csv", "no history\n")
        r = self.ejecta("report", self.out)
        self.assertEqual(r.returncode, 3)
        self.assertIn("report.html is without pictures", r.stderr)
        with open(os.path.join(self.out, "report.html")) as f:
            self.assertNotIn("<img", f.read())
        os.remove(os.path.join(self.out, "history.csv"))
        r = self.ejecta("report", self.out)
        self.assertEqual(r.returncode, 2)
        self.assertIn("holds no history.csv", r.stderr)
        r = self.ejecta("report", self.dir)
        self.assertEqual(r.returncode, 2)
        self.assertIn("summary.json: is not there", r.stderr)

    def trade(self, *more):
        return self.ejecta("trade", "case.toml", "--fidelities", "4,6", "--out", "study", *more)

    def rows(self):
        with open(os.path.join(self.dir, "study", "trade.csv")) as f:
            return list(csv.DictReader(f))

    def test_trade(self):
        self.write("case.toml", CASE + self.REFERENCE)
        r = self.trade()
        self.assertEqual(r.returncode, 0 if self.draws else 3, r.stderr)
        rows = self.rows()
        self.assertEqual([row["run"] for row in rows], ["hybrid-4", "erosion-4", "hybrid-6", "erosion-6"])
        for row in rows:
            s = self.summary(os.path.join(self.dir, "study", row["run"]))
            errors = [s["measurements"][k]["value"] / ref - 1 if k in s["measurements"] else 1
                      for k, ref in (("bumper.hole_diameter", 2e-3), ("cloud.spray_half_angle", 30 * 3.141592653589793 / 180))]
            errors.append(0 if s["measurements"]["bumper.perforated"]["value"] is True else 1)
            self.assertAlmostEqual(float(row["error"]), (sum(e * e for e in errors) / 3) ** 0.5, 5)
            self.assertAlmostEqual(float(row["cpu_seconds"]), s["cpu_seconds"], 4)
            self.assertEqual(int(row["elements"]), s["elements"]["initial"])
            self.assertIn(row["run"], r.stdout)
        at = lambda row: (float(row["cpu_seconds"]), float(row["error"]))
        for row in rows:
            beaten = any(at(o)[0] <= at(row)[0] and at(o)[1] <= at(row)[1] and at(o) != at(row) for o in rows)
            self.assertEqual(row["on_front"], "0" if beaten else "1", row["run"])
        self.assertEqual(os.path.exists(os.path.join(self.dir, "study", "trade.png")), self.draws)

        # what has ended is kept, what was interrupted goes on, another case is not taken for this one
        def stamp():
            return {row["run"]: os.stat(os.path.join(self.dir, "study", row["run"], "run.h5")).st_mtime_ns for row in rows}

        before = stamp()
        os.remove(os.path.join(self.dir, "study", "erosion-4", "summary.json"))  # it owes the summary
        self.assertEqual(self.trade().returncode, r.returncode)
        self.assertEqual({k: v for k, v in stamp().items() if k != "erosion-4"}, {k: v for k, v in before.items() if k != "erosion-4"})
        self.assertEqual([row["error"] for row in self.rows()], [row["error"] for row in rows])
        refused = self.trade("--set", "body.projectile.velocity=[0, 0, -5000]")
        self.assertEqual(refused.returncode, 2)
        self.assertIn("hybrid-4: holds something else than this run", refused.stderr)
        self.assertEqual(self.trade("--set", "body.projectile.velocity=[0, 0, -5000]", "--force").returncode, r.returncode)
        self.assertNotEqual([row["error"] for row in self.rows()], [row["error"] for row in rows])

    def test_trade_without_references(self):
        r = self.trade("--modes", "hybrid")
        self.assertEqual(r.returncode, 0 if self.draws else 3, r.stderr)
        coarse, fine = self.rows()
        self.assertEqual(float(fine["error"]), 0)
        self.assertGreater(float(coarse["error"]), 0)
        self.assertIn("judged by hybrid-6", r.stdout)

    def test_errors(self):
        for arguments, says in ((["--fidelities", "4,rough"], "unknown fidelity 'rough'; valid: draft, standard, fine, reference"),
                                (["--fidelities", "1"], "run.elements_across"),
                                (["--modes", "hybrid,fast"], "valid: hybrid, erosion, fem, sph")):
            r = self.ejecta("trade", "case.toml", "--out", "study", *arguments)
            self.assertEqual(r.returncode, 2, r.stdout + r.stderr)
            self.assertIn(says, r.stderr)
            self.assertFalse(os.path.exists(os.path.join(self.dir, "study")))

    def test_an_interrupted_study_goes_on(self):
        long = ["trade", "case.toml", "--fidelities", "8", "--modes", "hybrid", "--out", "study", "--set", 'run.end="2 us"', "--threads", "1"]
        study = subprocess.Popen([PROGRAM, *long], cwd=self.dir, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, start_new_session=True)
        history = os.path.join(self.dir, "study", "hybrid-8", "history.csv")
        limit = time.time() + 60
        while time.time() < limit and not (os.path.exists(history) and os.path.getsize(history) > 2000):
            time.sleep(0.01)
        study.send_signal(signal.SIGINT)  # to the study alone: it hands it on
        self.assertEqual(study.wait(60), 130)
        self.assertEqual(self.summary(os.path.join(self.dir, "study", "hybrid-8"))["stop_reason"], "interrupted")
        r = self.ejecta(*long)
        self.assertEqual(r.returncode, 0 if self.draws else 3, r.stderr)
        self.assertIn("going on at", r.stdout)
        self.assertTrue(self.summary(os.path.join(self.dir, "study", "hybrid-8"))["completed"])


class Interrupt(Folder):
    """Ctrl-C, kill, and going on."""

    def states(self, folder):
        with h5py.File(os.path.join(folder, "run.h5")) as f:
            last = sorted(k for k in f if k.startswith("step"))[-1]
            found = {}
            f[last].visititems(lambda name, o: found.__setitem__(name, o[()].tobytes()) if isinstance(o, h5py.Dataset) else None)
            return last, found

    def same_end(self, a, b):
        x, y = self.summary(a), self.summary(b)
        self.assertEqual(x["steps"], y["steps"])
        self.assertEqual(x["measurements"], y["measurements"])
        self.assertEqual(x["conservation"], y["conservation"])
        # not pair_updates: it counts what the lists hold, skin and all, and lists are made anew after a resume
        for key in ("element_updates", "element_updates_asleep", "element_updates_slowed", "particle_updates"):
            self.assertEqual(x["work"][key], y["work"][key], key)
        if h5py:
            self.assertEqual(self.states(a), self.states(b))

    def test_ctrl_c_and_resume(self):
        # so long that the signal arrives well before the end, however busy the machine is; all matter as particles takes ten times as long
        long = ["--set", 'run.end="6 us"', "--set", "run.elements_across=8", "--set", 'output.every="1 us"', "--threads", "1"]
        shots = {"hybrid": long, "sph": ["--mode", "sph", "--set", 'run.end="0.6 us"', *long[2:]]}
        for mode, sig in (("hybrid", signal.SIGINT), ("hybrid", signal.SIGTERM), ("sph", signal.SIGINT)):
            self.interrupted_and_resumed(mode, sig, shots[mode])

    def interrupted_and_resumed(self, mode, sig, long):
        whole = os.path.join(self.dir, "whole-" + mode)
        if not os.path.exists(whole):
            r = self.ejecta("run", "case.toml", "--out", whole, *long)
            self.assertEqual(r.returncode, 0, r.stderr)
        out = self.out + mode + str(int(sig))
        p = subprocess.Popen([PROGRAM, "run", "case.toml", "--out", out, *long], cwd=self.dir, stdout=subprocess.PIPE,
                             stderr=subprocess.STDOUT, text=True, env=dict(os.environ, OMP_NUM_THREADS="1"))
        seen = ""
        for line in p.stdout:  # a line every tenth: interrupt after the first, when much has been converted
            seen += line
            if "10." in line.split("%")[0] and "%" in line:
                p.send_signal(sig)
                break
        seen += p.stdout.read()
        self.assertEqual(p.wait(timeout=60), 130, seen)
        p.stdout.close()
        self.assertIn("resume", seen)
        self.assertTrue(os.path.exists(os.path.join(out, "checkpoint.h5")))
        self.nothing_half_written(out)
        summary = self.summary(out)
        self.assertIs(summary["completed"], False)
        self.assertEqual(summary["stop_reason"], "interrupted")
        self.assertGreater(summary["particles"]["created"], 0, "interrupted before any conversion: no evidence")
        r = self.ejecta("resume", out, "--threads", "1" if sig == signal.SIGINT else "2")
        self.assertEqual(r.returncode, 0, r.stdout + r.stderr)
        self.nothing_half_written(out)
        self.same_end(whole, out)
        with open(os.path.join(whole, "history.csv")) as f, open(os.path.join(out, "history.csv")) as g:
            self.assertEqual(sorted(set(f)), sorted(set(g)), "the histories differ")
        with open(os.path.join(out, "history.csv")) as f:
            times = [row["time_s"] for row in csv.DictReader(f)]
        self.assertEqual([t for t in times if times.count(t) > 1], [], "rows are there twice")

    def test_a_killed_run_goes_on_from_its_last_checkpoint(self):
        more = ["--set", 'run.end="6 us"', "--set", "run.elements_across=8", "--set", 'output.every="1 us"', "--set",
                'output.checkpoint_every="0.2 s"', "--threads", "1"]
        whole = os.path.join(self.dir, "whole")
        self.assertEqual(self.ejecta("run", "case.toml", "--out", whole, *more).returncode, 0)
        p = subprocess.Popen([PROGRAM, "run", "case.toml", "--out", self.out, *more], cwd=self.dir, stdout=subprocess.DEVNULL,
                             stderr=subprocess.DEVNULL, env=dict(os.environ, OMP_NUM_THREADS="1"))
        until = time.time() + 20
        while not os.path.exists(os.path.join(self.out, "checkpoint.h5")) and time.time() < until:
            time.sleep(0.01)
        time.sleep(0.15)
        p.kill()
        p.wait()
        r = self.ejecta("resume", self.out, "--threads", "1")
        self.assertEqual(r.returncode, 0, r.stdout + r.stderr)
        self.same_end(whole, self.out)
        self.nothing_half_written(self.out)

    def test_a_run_killed_between_its_last_state_and_its_summary_owes_the_summary(self):
        self.assertEqual(self.ejecta("run", "case.toml", "--out", self.out, "--threads", "1").returncode, 0)
        whole = os.path.join(self.dir, "whole")
        shutil.copytree(self.out, whole)
        for name in ("summary.json", "fragments.csv"):
            os.remove(os.path.join(self.out, name))
        history = os.path.join(self.out, "history.csv")
        with open(history) as f:
            rows = f.readlines()
        with open(history, "w") as f:
            f.writelines(rows[:-1])
        for _ in range(2):  # the second time there is nothing left to do
            r = self.ejecta("resume", self.out, "--threads", "1")
            self.assertEqual(r.returncode, 0, r.stdout + r.stderr)
            self.same_end(whole, self.out)
            self.nothing_half_written(self.out)
            with open(history) as f:
                self.assertEqual(f.readlines(), rows)
        self.assertIn("already", r.stdout)


class FullDisk(Folder):
    """No room left: exit 3, says so, and what was there stays good."""

    def check_stopped(self, r, out):
        said = r.stdout + r.stderr
        self.assertEqual(r.returncode, 3, said)
        self.assertTrue("space" in said or "room" in said or "written" in said, said)
        self.assertNotIn("terminate called", said)
        self.nothing_half_written(out)
        # nobody is told to go on from what is not there
        stored = os.path.exists(os.path.join(out, "checkpoint.h5"))
        self.assertFalse("ejecta resume" in said and not stored, said)
        self.assertFalse("start anew" in said and stored, said)
        return said

    def limited(self, size):
        def set_limit():
            signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
            resource.setrlimit(resource.RLIMIT_FSIZE, (size, size))
        return set_limit

    def test_file_size_limit(self):
        # a run that is stopped early leaves a checkpoint; going on with no room must not harm it
        self.assertEqual(self.ejecta("run", "case.toml", "--out", self.out, "--set", 'run.end="0.2 us"').returncode, 0)
        case = os.path.join(self.out, "case.toml")
        with open(case) as f:
            text = f.read()
        longer = [line if not line.startswith("end =") else 'end = "0.4 us"' for line in text.splitlines()]
        with open(case, "w") as f:
            f.write("\n".join(longer) + "\n")
        with open(os.path.join(self.out, "checkpoint.h5"), "rb") as f:
            before = f.read()
        history = os.path.join(self.out, "history.csv")
        with open(history) as f:
            rows = f.read()
        for size in (100, 5000, 60000, len(before) - 1):
            r = self.ejecta("resume", self.out, preexec_fn=self.limited(size))
            said = self.check_stopped(r, self.out)
            self.assertTrue(size < 5000 or "go on with: ejecta resume" in said, said)
            with open(os.path.join(self.out, "checkpoint.h5"), "rb") as f:
                self.assertEqual(f.read(), before, f"the checkpoint was harmed under a limit of {size} bytes")
            with open(history) as f:
                self.assertEqual(f.read()[:len(rows)], rows, f"the history was harmed under a limit of {size} bytes")
        with open(history, "a") as f:
            f.write(rows.splitlines()[-1][:20])  # a row for which there was no room
        r = self.ejecta("resume", self.out)
        self.assertEqual(r.returncode, 0, r.stdout + r.stderr)
        with open(history) as f:
            after = f.read()
        self.assertEqual(after[:len(rows)], rows)
        self.assertEqual({line.count(",") for line in after.splitlines()}, {rows.splitlines()[0].count(",")})

    def test_printing(self):
        self.assertEqual(self.ejecta("run", "case.toml", "--out", self.out, "--set", 'run.end="0.02 us"').returncode, 0)
        for command in (["materials"], ["materials", "Be"], ["hugoniot", "Be"], ["check", "case.toml", "--no-cost"], ["measure", self.out],
                        ["bench", "octree", "--size", "1000"]):
            with open("/dev/full", "w") as full:
                r = subprocess.run([PROGRAM, *command], cwd=self.dir, stdout=full, stderr=subprocess.PIPE, text=True, timeout=100)
            self.assertEqual(r.returncode, 3, command)
            self.assertIn("space", r.stderr)

    def test_ulimit(self):
        # as from a shell: nobody told the program to ignore SIGXFSZ
        r = self.ejecta("run", "case.toml", "--out", self.out,
                        preexec_fn=lambda: (signal.signal(signal.SIGXFSZ, signal.SIG_DFL), resource.setrlimit(resource.RLIMIT_FSIZE, (20000, 20000))))
        self.check_stopped(r, self.out)

    def test_from_the_start(self):
        for size in (0, 200, 20000):
            out = self.out + str(size)
            r = self.ejecta("run", "case.toml", "--out", out, preexec_fn=self.limited(size))
            self.assertNotIn("ejecta resume", self.check_stopped(r, out))
        r = self.ejecta("run", "case.toml", "--out", self.out, preexec_fn=self.limited(400000))  # room for the first state, not for that of the end
        self.assertIn("start anew with: ejecta run CASE --out", self.check_stopped(r, self.out))

    def test_a_small_disk(self):
        disk = os.path.join(self.dir, "disk")
        os.mkdir(disk)
        if os.geteuid() != 0 or subprocess.run(["mount", "-t", "tmpfs", "-o", "size=600k", "tmpfs", disk], capture_output=True).returncode:
            self.skipTest("cannot mount a small tmpfs here (needs root and the right to mount)")
        try:
            out = os.path.join(disk, "out")
            r = self.ejecta("run", "case.toml", "--out", out, "--set", 'output.checkpoint_every="0.05 s"')
            self.check_stopped(r, out)
        finally:
            subprocess.run(["umount", disk])


class Memory(Folder):
    """What a run holds at most: its state once, whatever is written and measured."""

    def peak(self, *more):
        with open(PROGRAM, "rb") as f:
            if b"__asan_init" in f.read():
                self.skipTest("a sanitizer's own memory is many times that of the state")
        r = self.ejecta("run", "case.toml", "--out", self.out, "--threads", "1", *more)
        self.assertEqual(r.returncode, 0, r.stderr)
        summary = self.summary(self.out)
        program = 25e6  # libraries, buffers
        n = summary["elements"]["initial"]
        print(f"{n} elements: {(summary['peak_memory_bytes'] - program) / n:.0f} bytes each at most", flush=True)
        return n, (summary["peak_memory_bytes"] - program) / n

    def test_elements(self):
        n, each = self.peak("--mode", "fem", "--set", 'run.end="5 ns"', "--set", 'run.symmetry="none"', "--set", 'output.every="1 ns"', "--set", 'body.bumper.thickness="3 mm"',
                            "--set", 'body.bumper.center=["0 mm", "0 mm", "-1.5 mm"]', "--set", "run.elements_across=16", "--set", 'body.bumper.fine_radius="6 mm"')
        self.assertGreater(n, 1e5)
        self.assertLess(each, 700)  # 513 of elements and their nodes, contact

    def test_quarter(self):
        n, each = self.peak("--mode", "fem", "--set", 'run.end="5 ns"', "--set", 'body.bumper.thickness="3 mm"', "--set", 'body.bumper.center=["0 mm", "0 mm", "-1.5 mm"]',
                            "--set", "run.elements_across=20", "--set", 'body.bumper.fine_radius="6 mm"')
        self.assertGreater(n, 1e5)
        self.assertLess(each, 800)  # measured as a whole all the same

    def test_particles(self):
        n, each = self.peak("--mode", "sph", "--set", 'run.end="5 ns"', "--set", 'run.symmetry="none"', "--set", 'body.bumper.thickness="1 mm"', "--set",
                            'body.bumper.center=["0 mm", "0 mm", "-0.5 mm"]', "--set", "run.elements_across=12", "--set", 'body.bumper.fine_radius="6 mm"')
        self.assertGreater(n, 5e4)
        self.assertLess(each, 2700)

    def test_check_of_particles_that_are_measured_on_their_way(self):
        wall = CASE[CASE.rindex("[[body]]"):CASE.index("[output]")].replace("bumper", "wall").replace("-0.15 mm", "-1.15 mm")
        self.write("case.toml", CASE + wall)
        more = ["--mode", "sph", "--set", "run.elements_across=16", "--set", 'run.end="0.25 us"']
        self.peak(*more)
        with open(os.path.join(self.out, "run.h5"), "rb") as f:
            self.assertIn(b"frozen:cloud.mass", f.read())
        r = self.ejecta("check", "case.toml", "--threads", "1", *more)
        said = float(re.search(r"([0-9.]+) GiB of", r.stdout).group(1)) * 2**30
        self.assertGreater(said, 0.7 * self.summary(self.out)["peak_memory_bytes"])


class Tables(Folder):
    """`ejecta eos table` and a run on what it wrote."""

    MATERIAL = """
[materials.al]
base = "Al2024-T351"
eos = { model = "sesame", file = "al.ses", number = 77 }
"""

    made = None  # the table and what was printed, once for all tests

    def setUp(self):
        super().setUp()
        if not Tables.made:
            r = self.ejecta("eos", "table", "Al", "--out", "al.ses", "--number", "77")
            self.assertEqual(r.returncode, 0, r.stderr)
            self.assertIn('eos = { model = "sesame", file = "al.ses", number = 77 }', r.stdout)
            with open(os.path.join(self.dir, "al.ses")) as f:
                Tables.made = f.read()
        self.write("al.ses", Tables.made)
        text = CASE.replace('material = "Al2024-T351"', 'material = "al"').replace("0.4 us", "0.1 us")
        self.case = self.write("case.toml", text + self.MATERIAL)

    def cooled(self, highest):
        """al.ses without the isotherms above a temperature [K]."""
        lines = Tables.made.splitlines()
        at = next(i for i, line in enumerate(lines) if line[8:14].strip() == "301")
        count = int(lines[at][14:20])
        words = [line[k:k + 15] for line in lines[at + 1:at + 1 + (count + 4) // 5] for k in range(0, 75, 15)][:count]
        n, k = int(float(words[0])), int(float(words[1]))
        keep = sum(float(t) <= highest for t in words[2 + n:2 + n + k])
        part = [words[2 + n + k + b * n * k:][:n * keep] for b in range(3)]
        new = [f"{n:15.8E}", f"{keep:15.8E}", *words[2:2 + n], *words[2 + n:2 + n + keep], *part[0], *part[1], *part[2]]
        cards = ["".join(new[i:i + 5]).ljust(75) + "11111" for i in range(0, len(new), 5)]
        header = lines[at][:14] + f"{len(new):6d}" + lines[at][20:]
        self.write("al.ses", "\n".join(lines[:at] + [header] + cards + [" 2"]) + "\n")

    def test_hugoniot(self):
        r = self.ejecta("hugoniot", "al", "--case", "case.toml")
        self.assertEqual(r.returncode, 0, r.stderr)
        self.assertEqual(self.ejecta("hugoniot", "al", "--case", self.dir).stdout, r.stdout)
        row = next(line.split() for line in r.stdout.splitlines() if line.split()[0] == "4.000")
        # Us = 5350 + 1.34 up of the table's 2700 kg/m3, scaled to 2785: Us' = sqrt(k) ..., k = 2700/2785, up' = up/sqrt(k)
        k = 2700 / 2785
        Us = k ** 0.5 * (5350 + 1.34 * 4000 / k ** 0.5)
        self.assertAlmostEqual(float(row[2]), 2785 * Us * 4000e-9, delta=0.01 * float(row[2]))

    def test_run_on_the_table(self):
        r = self.ejecta("run", "case.toml", "--out", self.out)
        self.assertEqual(r.returncode, 0, r.stdout + r.stderr)
        self.assertEqual(self.summary(self.out)["warnings"], [])
        r = self.ejecta("check", os.path.join(self.out, "case.toml"))  # the resolved case finds its table
        self.assertEqual(r.returncode, 0, r.stdout + r.stderr)

    def test_leaving_the_table_is_told_once(self):
        self.cooled(1000)
        r = self.ejecta("run", "case.toml", "--out", self.out)
        self.assertEqual(r.returncode, 0, r.stdout + r.stderr)
        said = self.summary(self.out)["warnings"]
        self.assertEqual(len(said), 1, said)
        for part in ("material 'al' has left its table", "number 77", "rho = ", "e = ", "the table covers"):
            self.assertIn(part, said[0])
        with open(os.path.join(self.out, "log.txt")) as f:
            self.assertEqual(f.read().count("warning: "), 1)
        self.assertIn("warning: material 'al'", r.stderr)

    def test_errors(self):
        self.write("case.toml", CASE + self.MATERIAL.replace("number = 77", "number = 78"))
        r = self.ejecta("check", "case.toml")
        self.assertEqual(r.returncode, 2)
        for part in ("case.toml:", "al.ses:", "material 78", "valid: 77"):
            self.assertIn(part, r.stderr)
        r = self.ejecta("eos", "table", "Xx")
        self.assertEqual(r.returncode, 2)
        self.assertIn("valid: Al, Cu, Fe, Ti", r.stderr)


if __name__ == "__main__":
    PROGRAM = os.path.abspath(sys.argv[1])
    unittest.main(argv=[sys.argv[0], *sys.argv[2:]], verbosity=2)
