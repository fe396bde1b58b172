"""Fits that are made in other ways than by least squares over the search's foot points.

Usage: fit_test.py PATCHWRIGHT SAMPLES_DIR [unittest arguments]
"""
import sys
import unittest

from command_line import CliTest, run, SAMPLES, WING

CAGE = WING / "wing_cage.obj"
CUBE = SAMPLES / "cages" / "cube.obj"


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


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
