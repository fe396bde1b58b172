"""Fits that are made in other ways than by least squares over the search's foot points.

Usage: fit_test.py PATCHWRIGHT SAMPLES_DIR [unittest arguments]
"""
import sys
import unittest

from command_line import CliTest, run, SAMPLES, WING

CAGE = WING / "wing_cage.obj"
CUBE, TORUS = (SAMPLES / "cages" / f"{name}.obj" for name in ("cube", "torus"))


class Interpolates(CliTest):
    def exported_cube(self):
        """A round body, and where its cage's vertices are."""
        step = self.path("cube.step")
        self.report("export", CUBE, "-o", step)
        return step

    def test_the_wing(self):
        """tests/occ measures with the kernel where limit points come to lie; here that is told."""
        out = self.path("out.obj")
        report = self.report("fit", WING / "wing.igs", "--cage", CAGE, "--interpolate", "-o", out, "--tolerance", "1e-2rel")
        (level,) = report["fit"]["levels"]
        self.assertLessEqual(level["interpolated_max"], 1e-9 * report["input"]["diagonal"])
        self.assertEqual(report["cage"]["vertices"], sum(line.startswith("v ") for line in CAGE.read_text().splitlines()))
        self.assertEqual(report["fit"]["symmetry"], "none")
        self.assertTrue(report["verdict"]["met"])
        self.assertNotIn("interpolated_max", self.report("fit", WING / "wing.igs", "--cage", CAGE, "-o", self.path("least.obj"),
                                                         "--tolerance", "1e-2rel", "--max-levels", 0)["fit"]["levels"][0])
        # What interpolates already stays as it is, but for rounding.
        again = self.path("again.obj")
        self.report("fit", WING / "wing.igs", "--cage", out, "--interpolate", "-o", again, "--tolerance", "1e-2rel")
        for a, b in zip(out.read_text().splitlines(), again.read_text().splitlines()):
            if a.startswith("v "):
                for x, y in zip(a.split()[1:], b.split()[1:]):
                    self.assertAlmostEqual(float(x), float(y), delta=1e-6)
        self.assertIn("interpolated", run("fit", WING / "wing.igs", "--cage", CAGE, "--interpolate", "-o", out, "-v").stdout)

    def test_a_made_cage(self):
        report = self.report("fit", WING / "wing.igs", "--interpolate", "-o", self.path("out.obj"), "--tolerance", "1e-2rel")
        self.assertLessEqual(report["fit"]["levels"][0]["interpolated_max"], 1e-9 * report["input"]["diagonal"])

    def test_a_miss_is_a_verdict(self):
        report = self.report("fit", WING / "wing.igs", "--cage", CAGE, "--interpolate", "-o", self.path("out.obj"), "--tolerance", "1e-9rel",
                             code=3)
        self.assertFalse(report["verdict"]["met"])

    def test_refused(self):
        for words in (("--max-levels", 3), ("--refine", "global"), ("--symmetry", "y")):
            self.check_refused(["fit", WING / "wing.igs", "--cage", CAGE, "--interpolate", "-o", "{out}.obj", *words], 1,
                               "--interpolate", words[0])
        step = self.exported_cube()
        pinned = self.path("pinned.obj", CUBE.read_text() + "#patchwright pin 3\n")
        self.check_refused(["fit", step, "--cage", pinned, "--interpolate", "-o", "{out}.obj"], 2, "pinned.obj", "vertex 3 is pinned")
        # Eight masks that depend on each other; a corner pulled out asks for what they cannot do.
        lines = CUBE.read_text().splitlines()
        first = next(i for i, line in enumerate(lines) if line.startswith("v "))
        lines[first] = "v " + " ".join(repr(1.4 * float(x) + 3.0 * k) for k, x in enumerate(lines[first].split()[1:]))
        bent = self.path("bent.obj", "\n".join(lines) + "\n")
        self.check_refused(["fit", step, "--cage", bent, "--interpolate", "-o", "{out}.obj"], 2, "bent.obj", "subdivide the cage once")
        self.report("subdivide", bent, "-n", 1, "-o", self.path("fine.obj"))
        report = self.report("fit", step, "--cage", self.path("fine.obj"), "--interpolate", "-o", self.path("out.obj"), "--tolerance", "0.1rel")
        self.assertLessEqual(report["fit"]["levels"][0]["interpolated_max"], 1e-9 * report["input"]["diagonal"])


class CreaseRule(CliTest):
    def test_patches_follow_from_the_cage_and_its_tag(self):
        step, cage = self.path("wing.step"), self.path("wing.obj")
        report = self.report("convert", SAMPLES / "wing/wing.step", "-o", step, "--cage-out", cage, "--tolerance", "1e-3rel",
                             "--crease-rule", "runout")
        tag = "#patchwright crease-rule runout\n"
        self.assertIn(tag, cage.read_text())
        off = report["fit"]["off_catmull_clark"]
        self.assertGreater(off, 1e-5 * report["input"]["diagonal"])
        # A fit of the cage keeps its rule, unless another one is asked for.
        again = self.path("again.obj")
        self.report("fit", SAMPLES / "wing/wing.step", "--cage", cage, "-o", again, "--tolerance", "1e-3rel")
        self.assertIn(tag, again.read_text())
        self.report("fit", SAMPLES / "wing/wing.step", "--cage", cage, "-o", again, "--tolerance", "1e-2rel", "--crease-rule",
                    "catmull-clark")
        self.assertNotIn(tag, again.read_text())
        plain = self.path("plain.obj", cage.read_text().replace(tag, ""))
        for given, code in ((cage, 0), (plain, 3)):
            exported = self.path("again.step")
            self.assertEqual(run("export", given, "-o", exported).returncode, 0)
            result = run("compare", step, exported, "--tolerance", "1e-8rel")
            self.assertEqual(result.returncode, code, result.stderr)
        # Other programs see a surface that is no farther off than the report says.
        self.assertEqual(run("compare", step, exported, "--tolerance", f"{1.1 * off}mm").returncode, 0)

    def test_by_default_other_programs_see_the_same_surface(self):
        cage = self.path("wing.obj")
        report = self.report("convert", SAMPLES / "wing/wing.step", "-o", self.path("wing.step"), "--cage-out", cage, "--tolerance",
                             "1e-3rel")
        self.assertNotIn("crease-rule", cage.read_text())
        self.assertNotIn("off_catmull_clark", report["fit"])


class FootPointsOfTheKernel(CliTest):
    def test_a_fit_has_the_same_figures(self):
        """On a small body; tests/occ has the sample wing."""
        step = self.path("torus.step")
        self.report("export", TORUS, "-o", step)
        larger = ["v " + " ".join(repr(1.01 * float(x)) for x in line.split()[1:]) if line.startswith("v ") else line
                  for line in TORUS.read_text().splitlines()]
        cage = self.path("larger.obj", "\n".join(larger) + "\n")
        a, b = (self.report("fit", step, "--cage", cage, "-o", self.path(f"{way}.obj"), "--tolerance", "1e-2rel", "--max-levels", 0,
                            "--foot-points", way) for way in ("search", "kernel"))
        self.assertEqual(b["options"]["foot-points"], "kernel")
        for of_search, of_kernel in zip(a["fit"]["levels"], b["fit"]["levels"]):
            self.assertEqual(of_search["projections"], of_kernel["projections"])
            for figure in ("max", "rms", "reverse_max", "curve_max"):
                self.assertAlmostEqual(of_search[figure], of_kernel[figure], delta=1e-9 * a["input"]["diagonal"])

    def sheets(self):
        """Two patches with one corner at two heights."""
        for name, height in (("a", 20), ("b", 22)):
            sheet = self.path(f"{name}.obj", f"v 0 0 0\nv 100 0 0\nv 100 100 {height}\nv 0 100 0\nf 1 2 3 4\n")
            self.report("export", sheet, "-o", self.path(f"{name}.step"))

    def test_a_conversion_has_the_same_figures(self):
        self.sheets()
        a, b = (self.report("convert", self.path("a.step"), "--cage", self.path("b.obj"), "-o", self.path(f"{way}.step"), "--tolerance",
                            "1e-2rel", "--max-levels", 0, "--samples", 100, "--foot-points", way) for way in ("search", "kernel"))
        self.assertEqual(b["options"]["foot-points"], "kernel")
        # Samples are spread by what else a search knows: largest distances are refined, and the same.
        for side in ("output_to_input", "input_to_output"):
            self.assertGreater(a["deviation"][side]["max"], 1e-5 * a["input"]["diagonal"])
            self.assertAlmostEqual(a["deviation"][side]["max"], b["deviation"][side]["max"], delta=1e-9 * a["input"]["diagonal"])

    def test_comparing_has_the_same_figures(self):
        self.sheets()
        compared = [self.report("compare", self.path("a.step"), self.path("b.step"), "--samples", 200, "--foot-points", way)
                    for way in ("search", "kernel")]
        for side in ("output_to_input", "input_to_output"):
            a, b = (report["deviation"][side] for report in compared)
            self.assertEqual(a["samples"], b["samples"])
            self.assertGreater(a["max"], 0.1)
            for figure in ("max", "rms", "p50", "p95"):
                self.assertAlmostEqual(a[figure], b[figure], delta=1e-9 * compared[0]["input"]["diagonal"])

    def test_refused(self):
        stl = self.path("one.stl", "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 9 0 0\nvertex 0 9 0\nendloop\nendfacet\nendsolid\n")
        self.check_refused(["fit", stl, "--cage", CUBE, "-o", "{out}.obj", "--foot-points", "kernel"], 2, "one.stl", "triangles")
        self.check_refused(["fit", WING / "wing.igs", "-o", "{out}.obj", "--foot-points", "occ"], 1, "'occ'", "search, kernel")


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
