"""The command line as a user meets it: exit codes, one-line errors, reports, files left alone.

Usage: cli_test.py PATCHWRIGHT SAMPLES_DIR [unittest arguments]
"""
import json
import math
import os
import random
import signal
import subprocess
import sys
import time
import unittest

from command_line import CliTest, PATCHWRIGHT, run, SAMPLES, WING


class Grids(CliTest):
    def test_formats_report_and_coarser_levels(self):
        sizes = {}
        for name, more in (("a.cgns", []), ("a.vtm", []), ("a.xyz", []), ("b.xyz", ["--plot3d", "ascii"]),
                           ("c.xyz", ["--coarsen", 2]), ("d.xyz", ["--no-join"]), ("e.xyz", ["--unit", "m"])):
            result = run("grid", WING / "wing_cage.obj", "-o", self.path(name), "--size", "80mm", "--levels", 2,
                         "--spacing", "tanh", "--first-cell", "2mm", "--json", self.path("r.json"), *more)
            self.assertEqual(result.returncode, 0, result.stderr)
            self.assertTrue(self.path(name).exists())
            self.assertIn("smallest angle", result.stdout)
            report = json.loads(self.path("r.json").read_text())["grid"]
            sizes[name] = report["points"]
            self.assertEqual(report["folded"], 0)
            self.assertEqual(len(report["extraordinary"]), 6)
        self.assertEqual(sizes["a.cgns"], sizes["a.xyz"])
        self.assertEqual(sizes["a.vtm"], sizes["b.xyz"])
        self.assertLess(sizes["c.xyz"], sizes["a.xyz"] / 8)
        self.assertEqual(len(list((self.folder / "a").glob("*.vts"))), 6)

    def test_two_runs_give_equal_bytes(self):
        contents = []
        for name in ("a.xyz", "b.xyz"):
            run("grid", SAMPLES / "cages" / "genus2.obj", "-o", self.path(name), "--points", 33)
            contents.append(self.path(name).read_bytes())
        self.assertEqual(*contents)

    def test_rules(self):
        rules = self.path("rules.json")
        rule = {"at": [1000, 0, 0], "cells": 28, "spacing": "tanh", "near": "0.5mm"}
        reports = []
        for content in ([], [rule], [{**rule, "only": True}]):
            rules.write_text(json.dumps(content))
            result = run("grid", WING / "wing_cage.obj", "-o", self.path("a.xyz"), "--rules", rules, "--json", self.path("r.json"))
            self.assertEqual(result.returncode, 0, result.stderr)
            reports.append(json.loads(self.path("r.json").read_text())["grid"])
        self.assertGreater(reports[1]["points"], reports[0]["points"])
        self.assertEqual(reports[1]["points"], reports[2]["points"])
        self.assertNotEqual(reports[1]["min_angle_deg"], reports[2]["min_angle_deg"])
        for content, part in (("{", "JSON"), ("{}", "array"), ('[{"cells": 3}]', "rule 1"), ('[{"at": [0, 0, 0], "size": 3}]', "'size'"),
                              ('[{"at": [0, 0, 0], "near": "x"}]', "rule 1"), ('[{"at": [0, 0, 0], "spacing": "x"}]', "tanh")):
            with self.subTest(content=content):
                rules.write_text(content)
                self.check_error(run("grid", WING / "wing_cage.obj", "-o", self.path("b.xyz"), "--rules", rules), 2, "rules.json", part)
                self.assertFalse(self.path("b.xyz").exists())

    def test_layers(self):
        result = run("grid", SAMPLES / "cages" / "cube.obj", "-o", self.path("a.cgns"), "--layers", 8, "--layer-height", "1e-3rel",
                     "--json", self.path("r.json"))
        self.assertEqual(result.returncode, 0, result.stderr)
        report = json.loads(self.path("r.json").read_text())["grid"]
        self.assertEqual(report["negative_volumes"], 0)
        self.assertEqual(report["points"], 2 * 49 * 17 * 9)  # three faces in a row each

    def test_smooth(self):
        """The junction's angles before and after; coarser grids are parts of finer ones, layers grow from the points."""
        cage, angles = SAMPLES / "wing_fuselage" / "smooth.obj", []
        for smooth in ([], ["--smooth"]):
            result = run("grid", cage, "-o", self.path("a.xyz"), "--size", "60mm", *smooth, "--json", self.path("r.json"))
            self.assertEqual(result.returncode, 0, result.stderr)
            angles.append(json.loads(self.path("r.json").read_text())["grid"]["min_angle_deg"]["worst"])
        self.assertLess(angles[0], 35)
        self.assertGreater(angles[1], 55)
        result = run("grid", cage, "-o", self.path("b.cgns"), "--size", "60mm", "--levels", 1, "--coarsen", 1, "--smooth",
                     "--layers", 3, "--layer-height", "1mm")
        self.assertEqual(result.returncode, 0, result.stderr)

    def test_refused(self):
        cage = WING / "wing_cage.obj"
        out = self.path("out.cgns", "old")
        for arguments, part in ((["--size", "0"], ""), (["--cluster", "upper"], "FAMILY:FAMILY=LENGTH"),
                                (["--spacing", "tanh", "--cluster", "wing:=1mm"], "'wing'"),
                                (["--first-cell", "1mm"], "--spacing"), (["--coarsen", 1], "--levels"),
                                (["--layers", 3], "--layer-height"), (["--size", "1e-9mm"], "cells")):
            with self.subTest(arguments=arguments):
                self.check_error(run("grid", cage, "-o", out, *arguments), 1, part)
                self.assertEqual(out.read_text(), "old")
        self.check_error(run("grid", cage, "-o", "a.foo"), 1, ".cgns")
        self.check_error(run("grid", self.path("none.obj"), "-o", out), 2)
        self.check_error(run("grid", cage, "-o", self.folder / "no" / "a.cgns"), 4)
        self.check_error(run("grid", cage, "-o", self.folder / "no" / "a.vtm"), 4)


class Errors(CliTest):
    def test_usage(self):
        for arguments in ([], ["frobnicate"], ["convert"], ["export", "a.obj"], ["subdivide", "a.obj", "-n", "-1", "-o", "b.obj"],
                          ["convert", WING / "wing.igs", "-o", "x.step", "--cage", "c.obj", "--tolerance", "1parsec"],
                          ["inspect", WING / "wing.igs", "--input-unit", "furlong"],
                          ["export", SAMPLES / "cages" / "cube.obj", "-o", "x.step", "--continuity", "g3"]):
            with self.subTest(arguments=arguments):
                self.check_error(run(*arguments), 1)

    def test_help_and_version(self):
        for arguments in (["--help"], ["--version"], ["convert", "--help"]):
            result = run(*arguments)
            self.assertEqual(result.returncode, 0)
            self.assertIn("patchwright" if arguments != ["convert", "--help"] else "--tolerance", result.stdout)

    def test_unusable_cad_files(self):
        step = (WING / "wing.step").read_text()
        iges = (WING / "wing.igs").read_text()
        bad = {
            "missing.step": None,
            "text.step": "This is not a STEP file.\n",
            "empty.igs": "",
            "text.igs": "hello\n" * 40,
            "cut.step": step[: len(step) // 2],
            "cut.igs": iges[: len(iges) // 2],
            "text.brep": "no shape\n",
            "wing.dwg": "x",
        }
        for name, text in bad.items():
            with self.subTest(name=name):
                file = self.path(name, text)
                self.check_refused(["inspect", file], 2, name)
                self.check_refused(["convert", file, "--cage", WING / "wing_cage.obj", "-o", "{out}.step"], 2, name)
        self.check_refused(["inspect", self.folder], 2, str(self.folder))

    def test_unusable_cages(self):
        square = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n"
        bad = {
            "nan": ("v 0 0 nan\nv 1 0 0\nv 1 1 0\nf 1 2 3\n", "vertex 1"),
            "range": (square + "f 1 2 3 7\n", "vertex 7"),
            "nonmanifold": (square + "v 0 0 1\nv 0 0 2\nf 1 2 3 4\nf 1 2 5\nf 2 1 6\n", "edge 1-2"),
            "empty": ("", "no vertices"),
        }
        for name, (text, part) in bad.items():
            with self.subTest(name=name):
                cage = self.path(f"{name}.obj", text)
                self.check_refused(["export", cage, "-o", "{out}.step"], 2, f"{name}.obj", part)
                self.check_refused(["subdivide", cage, "-n", "1", "-o", "{out}.obj"], 2, f"{name}.obj", part)
                self.check_refused(["fit", WING / "wing.step", "--cage", cage, "-o", "{out}.obj"], 2, f"{name}.obj", part)
        self.check_refused(["export", self.folder / "none.obj", "-o", "{out}.step"], 2, "none.obj")

    def test_outputs_that_cannot_be_written(self):
        cage = SAMPLES / "cages" / "cube.obj"
        self.check_error(run("export", cage, "-o", self.folder / "no" / "such" / "folder.step"), 4, "folder.step")
        self.check_error(run("subdivide", cage, "-n", 1, "-o", self.folder), 4, str(self.folder))
        self.check_error(run("export", cage, "-o", self.folder / "a.xyz"), 1, "a.xyz")


class Results(CliTest):
    def test_export_of_every_sample_cage(self):
        for name, closed in {"cube": True, "cube_rim": True, "torus": True, "genus2": True, "dish": False}.items():
            for suffix in ("step", "brep", "igs"):
                with self.subTest(name=name, suffix=suffix):
                    report = self.report("export", SAMPLES / "cages" / f"{name}.obj", "-o", self.path(f"{name}.{suffix}"))
                    solid = report["solid"]
                    self.assertTrue(solid["valid"])
                    self.assertTrue(solid["all_bicubic"])
                    self.assertEqual(solid["closed"], closed)
                    self.assertEqual(solid["faces"], report["patches"]["count"])
                    self.assertEqual(solid["nonmanifold_edges"], 0)
                    if suffix != "igs":
                        self.assertEqual(solid["solids"], 1 if closed else 0)
                    if closed:
                        self.assertEqual(solid["free_edges"], 0)
                        self.assertGreater(solid["volume"], 0)
                    box = solid["bounds"]
                    diagonal = math.dist(box["min"], box["max"])
                    self.assertLess(report["continuity"]["max_gap"], 1e-9 * diagonal)
                    # The remaining kink at valence up to 6 with eight knot levels (MATH: 0.5 degrees at 6).
                    self.assertLess(report["continuity"]["max_kink_deg"], 1.0)
                    self.assertEqual(report["continuity"]["creases"] > 0, name == "cube_rim")

    def test_a_subdivided_cage_exports_the_same_surface(self):
        for name in ("cube", "cube_rim", "torus", "genus2", "dish"):
            with self.subTest(name=name):
                cage = SAMPLES / "cages" / f"{name}.obj"
                fine = self.path("fine.obj")
                self.report("subdivide", cage, "-n", 1, "-o", fine)
                # Deep caps: what is left of the difference inside them falls below the bound.
                self.report("export", cage, "-o", self.path("a.step"), "--cap-depth", 16)
                self.report("export", fine, "-o", self.path("b.step"), "--cap-depth", 16)
                report = self.report("compare", self.path("a.step"), self.path("b.step"), "--samples", 4000)
                diagonal = report["input"]["diagonal"]
                for side in report["deviation"].values():
                    self.assertLess(side["max"], 1e-9 * diagonal)

    def test_sharp_curves_that_are_kept_are_counted(self):
        result = self.report("compare", WING / "wing.step", WING / "wing.igs", "--tolerance", "1e-3rel")["sharp_curves"]["long"]
        self.assertGreater(result["count"], 0)
        self.assertAlmostEqual(result["longer_than"], 100 * result["tolerance"])
        self.assertEqual(result["missed"], [])
        # A cube without creases has none of the edges of one that has them.
        for name in ("cube", "cube_rim"):
            self.report("export", SAMPLES / "cages" / f"{name}.obj", "-o", self.path(f"{name}.step"))
        result = self.report("compare", self.path("cube_rim.step"), self.path("cube.step"), "--tolerance", "1e-3rel", code=3)
        curves = result["sharp_curves"]["long"]
        self.assertEqual(len(curves["missed"]), curves["count"])
        self.assertIsNone(curves["missed"][0]["distance"])
        self.check_error(run("compare", WING / "wing.step", WING / "wing.igs", "--tolerance", "3parsec"), 1, "parsec")
        self.check_error(run("compare", WING / "wing.step", WING / "wing.igs", "--normal-tolerance", "1deg"), 1, "requires --tolerance")
        for angle in ("1", "0deg", "1mm"):
            self.check_error(run("convert", WING / "wing.step", "-o", "x.step", "--normal-tolerance", angle), 1, f"'{angle}'")

    def test_a_cage_from_cad(self):
        made = self.path("made.obj")
        cage = self.report("cage", WING / "wing.igs", "-o", made, "--layout", "aligned")["cage"]
        self.assertGreater(cage["creases"], 0)
        solid = self.report("export", made, "-o", self.path("made.step"))["solid"]
        self.assertTrue(solid["closed"] and solid["valid"])
        # The limit surface of a cage that nothing was fitted to is already near.
        self.assertAlmostEqual(solid["volume"] / 121602975, 1.0, delta=0.1)
        # A smooth lump is no wing: it gets rings around its axis.
        lump = self.path("lump.step")
        self.report("export", SAMPLES / "cages" / "cube.obj", "-o", lump)
        cage = self.report("cage", lump, "-o", made, "--layout", "aligned")["cage"]
        self.assertEqual(cage["boundary_edges"], 0)
        self.assertEqual(cage["extraordinary"], 8)

    def test_units_of_the_output(self):
        cage = SAMPLES / "cages" / "cube.obj"
        volume = self.report("export", cage, "-o", self.path("mm.step"))["solid"]["volume"]
        report = self.report("export", cage, "-o", self.path("inch.step"), "--unit", "in")
        self.assertEqual(report["unit"], "in")
        self.assertAlmostEqual(report["solid"]["volume"] * 25.4**3 / volume, 1.0, delta=1e-9)
        inspected = self.report("inspect", self.path("inch.step"))
        self.assertEqual(inspected["input"]["unit"], "in")
        self.assertAlmostEqual(inspected["solid"]["volume"] * 25.4**3 / volume, 1.0, delta=1e-9)

    def test_two_runs_write_identical_bytes(self):
        cage = SAMPLES / "cages" / "genus2.obj"
        for suffix in ("step", "igs", "brep"):
            texts = []
            for i in (1, 2):
                folder = self.folder / str(i)
                folder.mkdir(exist_ok=True)
                self.report("export", cage, "-o", folder / f"a.{suffix}")
                texts.append((folder / f"a.{suffix}").read_bytes())
            self.assertEqual(texts[0], texts[1], suffix)

    def test_normals_have_a_tolerance(self):
        cage, out = WING / "wing_cage.obj", self.path("wing.step")
        report = self.report("convert", WING / "wing.step", "--cage", cage, "-o", out, "--tolerance", "1e-3rel", "--normal-tolerance", "4deg")
        angles = report["fairness"]["normals_deg"]
        self.assertLess(angles["max"], 4)
        self.assertIn("attempt 1 (110 faces): MISSED: normals differ by", " ".join(report["notices"]))
        limit = f"{0.9 * angles['max']}deg"
        missed = self.report("compare", WING / "wing.step", out, "--tolerance", "1e-3rel", "--normal-tolerance", limit, code=3)
        self.assertEqual([c["name"] for c in missed["verdict"]["conditions"] if not c["met"]], ["normals"])
        self.assertEqual(missed["fairness"], report["fairness"])  # the same file, read again
        fit = self.report("fit", WING / "wing.step", "--cage", cage, "-o", self.path("a.obj"), "--tolerance", "1e-3rel", "--normal-tolerance",
                          "4deg", code=3)
        self.assertIn("MISSED: normals differ", fit["verdict"]["sentence"])

    def test_face_names_are_written(self):
        self.report("export", WING / "wing_cage.obj", "-o", self.path("wing.step"))
        text = self.path("wing.step").read_text()
        for name in ("upper", "lower", "te", "tip", "root"):
            self.assertIn(f"{name}", text)

    def test_fit_writes_a_cage_that_exports(self):
        fitted = self.path("fitted.obj")
        report = self.report("fit", WING / "wing.step", "--cage", WING / "wing_cage.obj", "-o", fitted, "--tolerance", "1e-3rel")
        self.assertTrue(report["fit"]["met"])
        self.report("export", fitted, "-o", self.path("fitted.step"))

    def test_eval_prints_points_and_masks(self):
        result = run("eval", SAMPLES / "cages" / "cube.obj", "--at", "0,0,0", "0,0.25,1e-9", "--json", "-")
        self.assertEqual(result.returncode, 0, result.stderr)
        corner, point = json.loads(result.stdout)
        # Valence 3: (9 v + 4 sum(e) + sum(f)) / 24 is half the corner of a cube around the origin.
        self.assertEqual(corner["exists"], "tangent plane only")
        self.assertNotIn("duu", corner)
        self.assertAlmostEqual(max(corner["mask"]["position"]), 9 / 24)
        self.assertEqual({round(abs(x), 9) for x in corner["position"]}, {25.0})
        self.assertAlmostEqual(sum(point["mask"]["position"]), 1.0)
        self.assertAlmostEqual(sum(point["mask"]["duv"]), 0.0)
        text = run("eval", SAMPLES / "cages" / "cube.obj", "--at", "0,0.5,0.5").stdout
        self.assertIn("normal", text)
        for place in ("0,0", "a,0,0", "6,0,0", "0,2,0", "0,0,0,1", "0.5,0,0"):
            self.check_error(run("eval", SAMPLES / "cages" / "cube.obj", "--at", place), 1)

    def test_a_missed_tolerance_is_said_and_written(self):
        out = self.path("rough.step")
        report = self.report("convert", WING / "wing.step", "--cage", WING / "wing_cage.obj", "-o", out,
                             "--tolerance", "1e-9rel", "--max-levels", 0, code=3)
        self.assertFalse(report["fit"]["met"])
        self.assertTrue(out.exists())

    def test_the_verdict_is_the_first_and_last_line_and_decides_the_exit_code(self):
        rim, cube = self.path("cube_rim.step"), self.path("cube.step")
        for file in (rim, cube):
            result = run("export", SAMPLES / "cages" / f"{file.stem}.obj", "-o", file)
            lines = result.stdout.splitlines()
            self.assertEqual(lines[0], lines[-1])
            self.assertTrue(lines[0].startswith("met: one closed valid solid, "), lines[0])
        result = run("compare", rim, cube, "--tolerance", "1e-3rel", "--json", self.path("r.json"))
        self.assertEqual(result.returncode, 3)
        lines = result.stdout.splitlines()
        self.assertEqual(lines[0], lines[-1])
        self.assertTrue(lines[0].startswith("MISSED: "), lines[0])
        self.assertIn("; try ", lines[0])
        verdict = json.loads(self.path("r.json").read_text())["verdict"]
        self.assertFalse(verdict["met"])
        self.assertEqual(verdict["sentence"], lines[0])
        missed = {c["name"] for c in verdict["conditions"] if not c["met"]}
        self.assertIn("sharp_curves", missed)
        for condition in verdict["conditions"]:
            self.assertEqual(condition["met"], condition["remedy"] == "")
        self.assertEqual(run("compare", rim, cube).returncode, 0)
        self.assertEqual(run("compare", rim, rim, "--tolerance", "1e-6rel").returncode, 0)

    def test_faces_that_intersect_themselves_are_not_met(self):
        # A cube with its corners anywhere: two of its faces are so twisted that they cross themselves, and a third one with them
        # (found by the triangles of five refinements as well).
        anywhere = random.Random(1)
        lines = [f"v {anywhere.uniform(-50, 50):.3f} {anywhere.uniform(-50, 50):.3f} {anywhere.uniform(-50, 50):.3f}"
                 if line.startswith("v ") else line for line in (SAMPLES / "cages" / "cube.obj").read_text().splitlines()]
        cage = self.path("crossed.obj", "\n".join(lines) + "\n")
        verdict = self.report("export", cage, "-o", self.path("crossed.step"), code=3)["verdict"]
        missed = {c["name"]: c["value"] for c in verdict["conditions"] if not c["met"]}
        self.assertEqual(missed, {"self_intersections": 3})

    def test_a_cage_without_size_is_refused(self):
        cage = self.path("point.obj", "v 1 2 3\n" * 4 + "f 1 2 3 4\n")
        self.check_refused(["export", cage, "-o", "{out}.step"], 2, "point.obj", "one place")

    def test_a_time_limit_is_kept_and_said(self):
        out = self.path("wing.step")
        start = time.time()
        result = run("convert", WING / "wing.step", "-o", out, "--tolerance", "1e-8rel", "--time-limit", "2")
        self.assertEqual(result.returncode, 3)
        self.assertLess(time.time() - start, 60)
        self.assertIn("time limit", result.stderr)
        self.assertIn("--time-limit", result.stdout + result.stderr)

    def test_interrupt_stops_cleanly(self):
        out = self.path("wing.step", "old")
        process = subprocess.Popen([PATCHWRIGHT, "convert", str(WING / "wing.igs"), "--cage", str(WING / "wing_cage.obj"), "-o",
                                    str(out), "--tolerance", "1e-7rel"], stderr=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        time.sleep(0.5)
        process.send_signal(signal.SIGINT)
        _, error = process.communicate(timeout=60)
        self.assertEqual(process.returncode, 130, error)
        self.assertEqual(out.read_text(), "old")
        self.assertEqual(os.listdir(self.folder), ["wing.step"])


    def test_symmetry_and_refinement_are_options_and_reported(self):
        common = ["fit", WING / "wing.step", "--cage", WING / "wing_cage.obj", "-o", self.path("fitted.obj")]
        local = self.report(*common)["fit"]
        self.assertEqual(local["symmetry"], "y")
        self.assertTrue(local["met"])
        # Sharp chains lie on the file's curves, which the tolerance holds for too.
        self.assertEqual([level["chains_on_features"] for level in local["levels"]], [3] * len(local["levels"]))
        self.assertLess(local["levels"][-1]["curve_max"], local["tolerance"])
        whole = self.report(*common, "--refine", "global", "--symmetry", "none")["fit"]
        self.assertEqual(whole["symmetry"], "none")
        self.assertLess(local["levels"][-1]["vertices"], whole["levels"][-1]["vertices"])
        self.assertGreater(local["fairness"]["after"]["least_angle_deg"], 1.0)
        self.check_error(run(*common, "--symmetry", "x"), 1)


class Demo(CliTest):
    def test_the_sample_wing_becomes_one_closed_solid(self):
        file = self.path("wing.json")
        result = run("convert", WING / "wing.igs", "--cage", WING / "wing_cage.obj", "-o", self.path("wing.step"),
                     "--json", file, "--report", self.path("wing.html"), "--cage-out", self.path("fitted.obj"))
        self.assertEqual(result.returncode, 0, result.stderr)
        report = json.loads(file.read_text())
        solid = report["solid"]
        self.assertEqual((solid["solids"], solid["free_edges"], solid["nonmanifold_edges"]), (1, 0, 0))
        self.assertTrue(solid["closed"] and solid["valid"] and solid["all_bicubic"])
        diagonal = report["input"]["diagonal"]
        self.assertEqual(report["input"]["unit"], "in")
        self.assertLess(report["continuity"]["max_gap"], 1e-9 * diagonal)
        for side in report["deviation"].values():
            self.assertLess(side["max"], 1e-3 * diagonal)
        self.assertIn("Deviation", self.path("wing.html").read_text())


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
