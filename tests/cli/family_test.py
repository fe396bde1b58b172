"""A family of sample wings: one cage fitted to all of them, modes, members by weights.

Usage: family_test.py PATCHWRIGHT SAMPLES_DIR MAKE_SAMPLE_WING [unittest arguments]
"""
import pathlib
import signal
import subprocess
import sys
import tempfile
import time
import unittest

from command_line import PATCHWRIGHT, CliTest, run, WING

MAKE_SAMPLE_WING = sys.argv[3]
# Each differs in all ways: refits that slide along the surface fold at the tips of such wings.
DESIGNS = {
    "a": ["bend=46", "twist=-1", "thickness=0.95", "sweep=1.1", "span=0.98"],
    "b": ["bend=-30", "twist=2", "thickness=1.1", "sweep=0.9", "span=1.02"],
    "c": ["bend=90", "twist=0.5", "thickness=1.05", "sweep=1", "span=1.1"],
    "d": ["bend=10", "twist=-2", "thickness=0.9", "sweep=0.95", "span=0.9"],
}


def points_of(cage):
    return [[float(x) for x in line.split()[1:4]] for line in cage.read_text().splitlines() if line.startswith("v ")]


def all_but_points(cage):
    return [line for line in cage.read_text().splitlines() if not line.startswith("v ")]


def largest_difference(a, b):
    return max(abs(x - y) for p, q in zip(a, b) for x, y in zip(p, q))


class Families(CliTest):
    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory(prefix="patchwright")
        cls.addClassCleanup(folder.cleanup)
        cls.models = pathlib.Path(folder.name)
        cls.fitted = cls.models / "fitted.obj"
        result = run("convert", WING / "wing.step", "-o", cls.models / "a.step", "--cage-out", cls.fitted)
        assert result.returncode == 0, result.stderr
        cls.designs = []
        for name, words in DESIGNS.items():
            cls.designs.append(cls.models / f"{name}.step")
            subprocess.run([MAKE_SAMPLE_WING, cls.designs[-1], *words], check=True)

    def fit(self, *more, code=0):
        return self.report("family", self.fitted, *self.designs, "-o", self.path("{name}.obj"), *more, code=code)

    def test_members_are_refits_and_modes_give_them_again(self):
        report = self.fit("--modes", 10, "--modes-out", self.path("modes.csv"))
        self.assertEqual([c["name"] for c in report["verdict"]["conditions"]], ["designs"])
        self.assertIn("met: 4 designs", report["verdict"]["sentence"])
        members, modes = report["family"]["members"], report["family"]["modes"]
        self.assertEqual([m["file"] for m in members], [str(d) for d in self.designs])
        # Four members differ in three ways at most, and what the modes leave is rounding.
        self.assertEqual(len(modes), 3)
        self.assertAlmostEqual(modes[-1]["share"], 1.0, 12)
        self.assertIn("the designs have 3 modes", report["notices"][-1])
        for design, member in zip(self.designs, members):
            self.assertTrue(member["met"], member)
            self.assertLessEqual(member["distance"], member["tolerance"])
            self.assertLess(member["off_modes"], 1e-9)
            out = self.path(f"{design.stem}.obj")
            self.assertEqual(all_but_points(out), all_but_points(self.fitted))
        # The same bytes as one by one.
        self.report("refit", self.fitted, self.designs[1], "-o", self.path("alone.obj"))
        self.assertEqual(self.path("alone.obj").read_bytes(), self.path("b.obj").read_bytes())
        self.check_member(members[2]["weights"])

    def check_member(self, weights):
        """The design c by its weights, as a cage and as a solid that is the design."""
        text = ",".join(f"{w:.17g}" for w in weights)
        out, step = self.path("m.obj"), self.path("m.step")
        report = self.report("member", self.fitted, "--modes", self.path("modes.csv"), f"--weights={text}", "-o", out,
                             "--cad-out", step)
        self.assertTrue(report["verdict"]["met"], report["verdict"])
        self.assertLess(largest_difference(points_of(out), points_of(self.path("c.obj"))), 1e-9)
        self.report("compare", self.designs[2], step, "--tolerance", "1e-4rel")
        # Without weights the mean.
        self.report("member", self.fitted, "--modes", self.path("modes.csv"), "-o", out)
        cages = [points_of(self.path(f"{name}.obj")) for name in DESIGNS]
        mean = [[sum(c[i][k] for c in cages) / len(cages) for k in range(3)] for i in range(len(cages[0]))]
        self.assertLess(largest_difference(points_of(out), mean), 1e-9)

    def test_known_earlier_model(self):
        """As refits with --from; another earlier model is refused."""
        report = self.fit("--from", WING / "wing.step")
        self.assertIn("met: 4 designs", report["verdict"]["sentence"])
        self.report("refit", self.fitted, self.designs[1], "--from", WING / "wing.step", "-o", self.path("alone.obj"))
        self.assertEqual(self.path("alone.obj").read_bytes(), self.path("b.obj").read_bytes())
        self.check_refused(["family", self.fitted, self.designs[0], "--from", self.designs[2], "-o", self.path("{name}.obj")], 2,
                           "not fitted to it", self.designs[2].name)

    def test_threads_do_not_matter(self):
        cages = [self.path(f"{t}_{n}.obj") for t in (1, 2) for n in "ab"]
        for threads in (1, 2):
            self.report("family", self.fitted, *self.designs[:2], "-o", self.path(f"{threads}_{{name}}.obj"), "--threads",
                        threads)
        self.assertEqual(cages[0].read_bytes(), cages[2].read_bytes())
        self.assertEqual(cages[1].read_bytes(), cages[3].read_bytes())

    def test_misses_are_told_by_design(self):
        report = self.report("family", self.fitted, self.designs[0], "-o", self.path("{name}.obj"), "--tolerance", "1e-7rel",
                             code=3)
        self.assertIn("MISSED: one design misses", report["verdict"]["sentence"])
        for member in report["family"]["members"]:
            self.assertTrue(member["sentence"].startswith("MISSED: "), member)
            self.assertTrue(self.path(f"{pathlib.Path(member['file']).stem}.obj").exists())

    def test_time_limit(self):
        report = self.fit("--time-limit", "0.01", "--modes", 2, code=3)
        self.assertEqual(report["verdict"]["conditions"][0]["value"], 4)
        self.assertIn("longer --time-limit", report["verdict"]["sentence"])
        self.assertFalse(self.path("a.obj").exists())

    def test_interrupted(self):
        process = subprocess.Popen([PATCHWRIGHT, "family", self.fitted, *self.designs, "-o", self.path("{name}.obj")],
                                   stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        time.sleep(1.0)
        process.send_signal(signal.SIGTERM)
        start = time.monotonic()
        process.communicate(timeout=60)
        self.assertEqual(process.returncode, 128 + signal.SIGTERM)
        self.assertLess(time.monotonic() - start, 10.0)  # asked for: 2 s, on a machine that does nothing else
        self.assertEqual(list(self.folder.iterdir()), [])

    def test_refused(self):
        cage, (a, b) = self.fitted, self.designs[:2]
        count = len(points_of(cage))
        text = self.path("text.step", "text")
        self.check_refused(["family", cage, a, "-o", "{out}.obj"], 1, "{name}")
        self.check_refused(["family", cage, a, a, "-o", self.path("{name}.obj")], 1, "two designs", "a.obj")
        self.check_refused(["family", cage, a, "-o", self.path("{name}.obj"), "--modes-out", self.path("m.csv")], 1,
                           "--modes")
        self.check_refused(["family", cage, a, text, "-o", self.path("{name}.obj")], 2, "text.step")
        self.check_refused(["family", cage, a, "-o", self.path("{name}.step")], 1, ".obj")
        self.check_refused(["family", text, a, "-o", self.path("{name}.obj")], 2, "text.step")
        modes = self.path("modes.csv", "x,y,z,dx1,dy1,dz1\n" + "0,0,0,1,1,1\n" * 3)
        self.check_refused(["member", cage, "--modes", modes, "-o", "{out}.obj"], 2, "modes.csv", "3 rows", str(count))
        self.check_refused(["member", cage, "--modes", self.path("m.csv", "1,2,3,4,5,6,7\n" * count), "-o", "{out}.obj"], 2,
                           "m.csv", "three of each mode")
        good = self.path("good.csv", "0,0,0,1,1,1\n" * count)
        self.check_refused(["member", cage, "--modes", good, "--weights", "1,2", "-o", "{out}.obj"], 1, "1 modes")
        self.check_refused(["member", cage, "--modes", good, "--weights", "1e300", "-o", "{out}.obj"], 1, "beyond")


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[4:]])
