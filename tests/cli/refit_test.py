"""Refits of the sample wing's cage to variants of the wing.

Usage: refit_test.py PATCHWRIGHT SAMPLES_DIR MAKE_SAMPLE_WING [--all] [unittest arguments]
Without --all one variant of each kind, the one that changes the wing most.
"""
import pathlib
import subprocess
import sys
import tempfile
import unittest

from command_line import CliTest, run, WING

MAKE_SAMPLE_WING = sys.argv[3]
ALL = "--all" in sys.argv
VARIANTS = ["bend=150", "twist=5", "thickness=1.3", "sweep=0.8", "span=1.2"]
if ALL:
    VARIANTS += ["bend=5", "bend=10", "bend=50", "twist=0.5", "twist=2", "thickness=0.8", "sweep=1.2", "span=0.8"]
# Features move by more than an edge of the cage is long.
FAR = ["twist=20 sweep=1.6 span=1.3"]
if ALL:
    FAR += ["bend=-300", "twist=20", "sweep=1.6", "sweep=0.4", "span=1.6", "span=0.6", "bend=500", "bend=500 twist=10 thickness=1.3 sweep=1.4 span=1.3",
            "bend=100 twist=3 thickness=1.2 sweep=1.2 span=1.1"]


def variant(file, *words):
    subprocess.run([MAKE_SAMPLE_WING, str(file), *words], check=True)
    return file


def all_but_points(cage):
    return [line for line in cage.read_text().splitlines() if not line.startswith("v ")]


class Refits(CliTest):
    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory(prefix="patchwright")
        cls.addClassCleanup(folder.cleanup)
        cls.fitted = pathlib.Path(folder.name) / "fitted.obj"
        result = run("convert", WING / "wing.step", "-o", cls.fitted.with_name("a.step"), "--cage-out", cls.fitted)
        assert result.returncode == 0, result.stderr

    def check_variant(self, words, *options):
        model, out, step = variant(self.path("b.step"), *words.split()), self.path("b.obj"), self.path("b_out.step")
        report = self.report("refit", self.fitted, model, "-o", out, "--cad-out", step, *options)
        self.assertEqual(all_but_points(out), all_but_points(self.fitted))
        self.assertEqual(len(report["fit"]["levels"]), 1)
        for condition in report["verdict"]["conditions"]:
            self.assertTrue(condition["met"], condition)
        self.assertIn("folds", [c["name"] for c in report["verdict"]["conditions"]])

    def test_variants(self):
        for words in VARIANTS + FAR:
            with self.subTest(words=words):
                self.check_variant(words)

    def test_variants_from_the_earlier_model(self):
        for words in FAR + (VARIANTS if ALL else []):
            with self.subTest(words=words):
                self.check_variant(words, "--from", WING / "wing.step")

    def test_earlier_models_that_tell_nothing(self):
        model, other = variant(self.path("b.step"), "twist=2"), variant(self.path("c.step"), "bend=50")
        for earlier, told in ((other, "not fitted to it"), (self.fitted.with_name("a.step"), "it has 6 faces, and the new model 9")):
            self.check_refused(["refit", self.fitted, model, "--from", earlier, "-o", "{out}.obj"], 2, earlier.name, told)

    def test_both_files_are_the_changed_shape(self):
        model, out, step = variant(self.path("b.step"), "bend=50", "twist=1"), self.path("b.obj"), self.path("b_out.step")
        self.report("refit", self.fitted, model, "-o", out, "--cad-out", step)
        self.report("compare", model, step, "--tolerance", "1e-4rel")
        self.report("export", out, "-o", self.path("c.step"))
        self.report("compare", model, self.path("c.step"), "--tolerance", "1e-4rel")

    def test_the_same_shape(self):
        cage, out = self.fitted, self.path("b.obj")
        report = self.report("refit", cage, WING / "wing.step", "-o", out)
        self.assertEqual(report["fit"]["carried"], [])
        limit = 1e-4 * report["input"]["diagonal"]
        points = [[[float(x) for x in line.split()[1:4]] for line in file.read_text().splitlines() if line.startswith("v ")]
                  for file in (cage, out)]
        self.assertLess(max(abs(a - b) for p, q in zip(*points) for a, b in zip(p, q)), limit)

    def test_two_runs_give_equal_bytes(self):
        cage, model = self.fitted, variant(self.path("b.step"), "bend=50", "twist=1")
        for name, threads in (("b.obj", 1), ("c.obj", 2)):
            self.report("refit", cage, model, "-o", self.path(name), "--threads", threads)
        self.assertEqual(self.path("b.obj").read_bytes(), self.path("c.obj").read_bytes())

    def test_a_miss(self):
        result = run("refit", self.fitted, WING / "wing.step", "-o", self.path("b.obj"), "--tolerance", "1e-7rel")
        self.assertEqual(result.returncode, 3, result.stderr)
        self.assertTrue(result.stdout.startswith("MISSED"))
        self.assertIn("a new cage for this model (convert)", result.stdout)
        self.assertTrue(self.path("b.obj").exists())

    def test_refused(self):
        cage, wing = WING / "wing_cage.obj", WING / "wing.step"
        self.check_refused(["refit", cage, wing, "-o", "{out}.obj", "--input-unit", "in"], 2, "wing.step", "unit")
        self.check_refused(["refit", cage, wing, "-o", "{out}.obj", "--cage-unit", "in"], 2, "wing.step", "unit")
        self.check_refused(["refit", self.path("cut.obj", "v 0 0\n"), wing, "-o", "{out}.obj"], 2, "cut.obj")
        self.check_refused(["refit", cage, self.path("text.step", "text"), "-o", "{out}.obj"], 2, "text.step")
        self.check_refused(["refit", cage, wing, "-o", "{out}.step"], 1, ".obj")
        self.check_refused(["refit", cage, wing, "-o", "{out}.obj", "--cad-out", "a.xyz"], 1, "a.xyz")
        # A cage with a hole: its last face is gone.
        lines = cage.read_text().splitlines()
        last = max(i for i, line in enumerate(lines) if line.startswith("f "))
        open_cage = self.path("open.obj", "\n".join(lines[:last] + lines[last + 1:]) + "\n")
        self.check_refused(["refit", open_cage, wing, "-o", "{out}.obj"], 2, "wing.step", "closed")


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *(a for a in sys.argv[4:] if a != "--all")])
