"""Conversions of scaled, moved and slender models at the command line.

Usage: scales_test.py PATCHWRIGHT SAMPLES_DIR [unittest arguments]
"""
import re
import sys
import unittest

from command_line import CliTest, run, WING

POINT = re.compile(r"CARTESIAN_POINT\s*\(('[^']*'),\(([^(),]*),([^(),]*),([^(),]*)\)\)")
BOX = [(x, y, z) for z in (0, 1) for y in (0, 1) for x in (0, 1)]
FACES = [(1, 3, 4, 2), (5, 6, 8, 7), (1, 2, 6, 5), (3, 7, 8, 4), (1, 5, 7, 3), (2, 4, 8, 6)]


def scaled(step, scale, shift):
    """A STEP file of splines only with all its points in space scaled and moved."""
    def point(match):
        numbers = ",".join("%.16E" % (scale * float(x) + shift) for x in match.groups()[1:])
        return f"CARTESIAN_POINT({match[1]},({numbers}))"
    return POINT.sub(point, step)


class Scales(CliTest):
    def wing(self):
        step = self.path("wing.step")
        self.assertEqual(run("export", WING / "wing_cage.obj", "-o", step, "-q").returncode, 0)
        return step.read_text()

    def convert(self, text):
        return self.report("convert", self.path("in.step", text), "-o", self.path("out.step"), "--tolerance", "1e-3rel")

    def test_scaled_and_moved_models_give_the_same_result(self):
        step = self.wing()
        unit = self.convert(step)
        for scale, shift in ((1e-3, 0.0), (1e6, 0.0), (1.0, 1e9)):
            with self.subTest(scale=scale, shift=shift):
                report = self.convert(scaled(step, scale, shift))
                self.assertEqual(report["patches"]["count"], unit["patches"]["count"])
                # The fit samples the same places; points that were rounded are fitted, not the same ones.
                for figure in ("rms", "max"):
                    fitted = [r["fit"]["levels"][-1][figure] for r in (report, unit)]
                    self.assertAlmostEqual(fitted[0] / scale / fitted[1], 1.0, delta=0.02)
                # Samples of the check are elsewhere after rounding: their largest distance may miss a narrow peak, their mean does not.
                for way in ("output_to_input", "input_to_output"):
                    self.assertAlmostEqual(report["deviation"][way]["rms"] / scale / unit["deviation"][way]["rms"], 1.0, delta=0.05)
                self.assertAlmostEqual(report["solid"]["volume"] / scale**3 / unit["solid"]["volume"], 1.0, delta=1e-3)

    def test_models_so_far_off_that_rounding_shows_are_refused(self):
        text = scaled(self.wing(), 1.0, 1e12)
        self.check_refused(["convert", self.path("far.step", text), "-o", "{out}.step"], 2, "far.step", "move it")

    def test_slender_boxes_keep_their_volume(self):
        for size in ((1000.0, 1000.0, 0.001), (1e6, 1.0, 1.0)):
            with self.subTest(size=size):
                cage = "".join("v %r %r %r\n" % tuple(c * s for c, s in zip(p, size)) for p in BOX)
                cage += "".join("f %d %d %d %d\n" % f for f in FACES)
                edges = {tuple(sorted((f[k], f[(k + 1) % 4]))) for f in FACES for k in range(4)}
                cage += "".join("t crease 2/1/0 %d %d inf\n" % (a - 1, b - 1) for a, b in sorted(edges))
                step = self.path("box.step")
                result = run("export", self.path("box.obj", cage), "-o", step)
                self.assertEqual(result.returncode, 0, result.stderr + result.stdout)
                report = self.convert(step.read_text())
                self.assertAlmostEqual(report["solid"]["volume"] / (size[0] * size[1] * size[2]), 1.0, delta=0.01)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
