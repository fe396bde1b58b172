"""Curve schemes on polylines, against what their limit curves are known to be.

Usage: curves_test.py PATCHWRIGHT SAMPLES_DIR [unittest arguments]
"""
import sys
import unittest

import numpy

from command_line import CliTest, run, SAMPLES

OPEN = numpy.array([[0, 0, 0], [2, 3, 1], [5, 2, -1], [6, -2, 0], [9, 1, 2]], float)
SCHEMES = ("edge-split", "corner-cutting", "de-rham")


def obj(points, *lines):
    return "".join("v %r %r %r\n" % tuple(map(float, p)) for p in points) + "".join(f"l {' '.join(map(str, line))}\n" for line in lines)


def polylines(file):
    """Points of each, without the last of closed ones, and whether it is closed."""
    rows = [line.split() for line in file.read_text().splitlines()]
    points = numpy.array([row[1:] for row in rows if row[0] == "v"], float)
    for row in rows:
        if row[0] == "l":
            numbers = numpy.array(row[1:], int) - 1
            closed = numbers[0] == numbers[-1]
            yield points[numbers[:-1] if closed else numbers], closed


def area(points):
    x, y = points[:, 0], points[:, 1]
    return 0.5 * (x * numpy.roll(y, -1) - numpy.roll(x, -1) * y).sum()


class Curves(CliTest):
    def refined(self, text, levels, scheme):
        out = self.path("out.obj")
        self.report("subdivide", self.path("in.obj", text), "-n", levels, "--scheme", scheme, "-o", out)
        return list(polylines(out))

    def test_corner_cutting_gives_the_quadratic_b_spline(self):
        levels = 6
        ((fine, closed),) = self.refined(obj(OPEN, range(1, 6)), levels, "corner-cutting")
        self.assertFalse(closed)
        middles = 0.5 * (fine[1:] + fine[:-1])
        for k, middle in enumerate(middles):  # of the edges: on the curve, at k / 2^levels
            span = min(k >> levels, 2)
            t = k / 2**levels - span
            a, b, c = OPEN[span:span + 3]
            spline = 0.5 * (1 - t)**2 * a + (0.5 + t * (1 - t)) * b + 0.5 * t**2 * c
            self.assertLess(abs(middle - spline).max(), 1e-13)

    def test_edge_splitting_gives_the_cubic_b_spline(self):
        levels = 5
        ((fine, _),) = self.refined(obj(OPEN, range(1, 6)), levels, "edge-split")
        self.assertTrue((fine[[0, -1]] == OPEN[[0, -1]]).all())
        mirrored = numpy.vstack([2 * OPEN[0] - OPEN[1], OPEN, 2 * OPEN[-1] - OPEN[-2]])
        on_curve = (fine[:-2] + 4 * fine[1:-1] + fine[2:]) / 6  # limit points of the inner vertices
        for k, point in enumerate(on_curve, 1):
            span = k >> levels
            t = k / 2**levels - span
            basis = numpy.array([(1 - t)**3, 4 - 6 * t**2 + 3 * t**3, 1 + 3 * t + 3 * t**2 - 3 * t**3, t**3]) / 6
            self.assertLess(abs(point - basis @ mirrored[span:span + 4]).max(), 1e-13)

    def test_cutting_takes_known_areas_away(self):
        """Of a closed polygon a twelfth of the triangles of three neighbours, with cuts at a third a seventh."""
        points = numpy.array([[0, 0, 0], [4, -1, 0], [5, 3, 0], [2, 5, 0], [-1, 2, 0]], float)
        corners = sum(area(points[[i - 1, i, (i + 1) % 5]]) for i in range(5))
        levels = 9
        for scheme, share, left in (("corner-cutting", 12, 0.25), ("de-rham", 7, 2 / 9)):
            ((fine, closed),) = self.refined(obj(points, [1, 2, 3, 4, 5, 1]), levels, scheme)
            self.assertTrue(closed)
            self.assertEqual(len(fine), 5 * 2**levels)
            # What is left to be cut shrinks geometrically.
            self.assertAlmostEqual(area(fine) - left**levels * corners / share, area(points) - corners / share, delta=1e-12 * area(points))

    def test_de_rhams_curve_is_its_own_image(self):
        """The cut polygon's first and last three points give the halves of the curve of three points."""
        levels = 7
        ((whole, _),) = self.refined(obj(OPEN[:3], (1, 2, 3)), levels, "de-rham")
        cut = [(2 * OPEN[0] + OPEN[1]) / 3, (OPEN[0] + 2 * OPEN[1]) / 3, (2 * OPEN[1] + OPEN[2]) / 3, (OPEN[1] + 2 * OPEN[2]) / 3]
        halves = self.refined(obj(cut, (1, 2, 3), (2, 3, 4)), levels - 1, "de-rham")
        # Both have the two points around the middle.
        together = numpy.vstack([halves[0][0], halves[1][0][2:]])
        numpy.testing.assert_allclose(whole, together, rtol=0, atol=1e-14)
        # The ends are the middles of the outer edges, and lie along these.
        for k, inner in ((0, 1), (-1, -2)):
            middle, edge = 0.5 * (whole[k] + whole[inner]), OPEN[:3][inner] - OPEN[:3][k]
            numpy.testing.assert_allclose(middle, 0.5 * (OPEN[:3][k] + OPEN[:3][inner]), rtol=0, atol=1e-14)
            numpy.testing.assert_allclose((whole[inner] - whole[k]) * 3**levels, edge, rtol=0, atol=1e-10)

    def test_steps_follow_each_other(self):
        text = obj(OPEN, range(1, 6), [1, 2, 3, 1])
        for scheme in SCHEMES:
            self.refined(text, 2, scheme)
            twice = self.path("out.obj").read_bytes()
            self.refined(text, 1, scheme)
            self.refined(self.path("out.obj").read_text(), 1, scheme)
            self.assertEqual(self.path("out.obj").read_bytes(), twice)

    def test_elements(self):
        """Edges by themselves, as Blender writes them, negative numbers, texture coordinates; the default is that of creases."""
        edges = obj(OPEN, (2, 1), (3, 2), (3, 4), (5, 4))
        whole = self.refined(obj(OPEN, range(1, 6)), 3, "edge-split")
        for text in (edges, obj(OPEN, ("-5", "-4", "-3", "-2", "-1")), obj(OPEN, ("1/1", "2/2", "3/3", "4/4", "5/5"))):
            ((fine, closed),) = self.refined(text, 3, "edge-split")
            self.assertFalse(closed)
            forward = fine if (fine[0] == OPEN[0]).all() else fine[::-1]
            numpy.testing.assert_allclose(forward, whole[0][0], rtol=0, atol=1e-15)
        ((_, closed),) = self.refined(obj(OPEN, (1, 2), (2, 3), (3, 1)), 1, "de-rham")
        self.assertTrue(closed)
        # Three edges meet at a point: three polylines. Longer elements stay by themselves.
        self.assertEqual(len(self.refined(obj(OPEN, (1, 2), (1, 3), (1, 4)), 1, "edge-split")), 3)
        self.assertEqual(len(self.refined(obj(OPEN, (1, 2, 3), (3, 4, 5)), 1, "edge-split")), 2)
        report = self.report("subdivide", self.path("in.obj", obj(OPEN, range(1, 6), [1, 2, 3, 1])), "-n", 2, "-o", self.path("a.obj"))
        self.assertEqual(report["polylines"], {"count": 2, "closed": 1, "points": 17 + 12})
        self.assertEqual(report["options"]["scheme"], "edge-split")
        self.assertIn("2, 1 of them closed", run("subdivide", self.path("in.obj"), "-o", self.path("a.obj")).stdout)

    def test_refused(self):
        def refused(text, code, *parts, words=()):
            self.check_refused(["subdivide", self.path("in.obj", text), "-o", "{out}.obj", *words], code, "in.obj", *parts)

        refused(obj(OPEN, (1, 9)), 2, "line 6", "vertex 9", "5 vertices")
        refused(obj(OPEN, (1, "x")), 2, "line 6", "'x'")
        refused(obj(OPEN, (1,)), 2, "line 6", "two vertices")
        refused(obj(OPEN, (1, 1, 2)), 2, "line 6", "twice in a row")
        refused(obj(OPEN), 2, "no faces and no lines")
        for scheme in SCHEMES[1:]:
            refused(obj(OPEN, (1, 2, 3), (4, 5)), 2, "line 7", "edge-split", words=("--scheme", scheme))
        refused(obj(OPEN, (1, 2, 3)), 1, "--picture", words=("--picture", self.path("a.png")))
        many = self.path("many.obj", obj(OPEN, *[range(1, 6)] * 2000))
        self.check_refused(["subdivide", many, "-o", "{out}.obj", "-n", 12], 1, "12 levels", "points")
        cube = SAMPLES / "cages" / "cube.obj"
        self.check_refused(["subdivide", cube, "-o", "{out}.obj", "--scheme", "de-rham"], 1, "--scheme", "cube.obj")
        self.check_refused(["subdivide", cube, "-o", "{out}.obj", "--scheme", "cubic"], 1, "cubic", "edge-split")


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
