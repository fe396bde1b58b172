"""Triangles (STL, OBJ) as input of the command line.

Usage: triangles_test.py PATCHWRIGHT [unittest arguments]
"""
import json
import math
import pathlib
import shutil
import struct
import subprocess
import sys
import tempfile
import unittest

PATCHWRIGHT = sys.argv[1]
RADIUS, HEIGHT, AROUND = 20.0, 60.0, 64


def cylinder(around=AROUND):
    """Triangles, three points each; the ends are fans around their middles."""
    ring = [(RADIUS * math.cos(2 * math.pi * i / around), RADIUS * math.sin(2 * math.pi * i / around)) for i in range(around)]
    triangles = []
    for (ax, ay), (bx, by) in zip(ring, ring[1:] + ring[:1]):
        a, b, c, d = (ax, ay, 0.0), (bx, by, 0.0), (bx, by, HEIGHT), (ax, ay, HEIGHT)
        triangles += [(a, b, c), (a, c, d), ((0.0, 0.0, 0.0), b, a), ((0.0, 0.0, HEIGHT), d, c)]
    return triangles


def box():
    """Triangles of the unit cube, outward."""
    at = lambda i: (float(i & 1), float(i >> 1 & 1), float(i >> 2))
    quads = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
    return [tuple(at(q[i]) for i in corners) for q in quads for corners in ((0, 1, 2), (0, 2, 3))]


def ascii_stl(triangles):
    facets = ("facet normal 0 0 0\nouter loop\n" + "".join("vertex %.9g %.9g %.9g\n" % p for p in t) + "endloop\nendfacet\n"
              for t in triangles)
    return ("solid tank\n" + "".join(facets) + "endsolid tank\n").encode()


def binary_stl(triangles):
    return b"solid by name only".ljust(80) + struct.pack("<I", len(triangles)) + b"".join(
        struct.pack("<12fH", 0, 0, 0, *(x for p in t for x in p), 0) for t in triangles)


def obj(triangles):
    points = sorted({p for t in triangles for p in t})
    number = {p: i + 1 for i, p in enumerate(points)}
    return ("".join("v %.9g %.9g %.9g\n" % p for p in points)
            + "".join("f %d %d %d\n" % tuple(number[p] for p in t) for t in triangles)).encode()


class TrianglesTest(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="patchwright"))
        self.addCleanup(shutil.rmtree, self.folder)

    def file(self, name, content=None):
        if content is not None:
            (self.folder / name).write_bytes(content)
        return self.folder / name

    def run_it(self, *arguments, code=0):
        result = subprocess.run([PATCHWRIGHT, *map(str, arguments)], capture_output=True, text=True, timeout=300)
        self.assertEqual(result.returncode, code, result.stderr)
        return result

    def report(self, *arguments, code=0):
        file = self.file("report.json")
        result = self.run_it(*arguments, "--json", file, code=code)
        return json.loads(file.read_text()), result.stderr

    def test_all_three_forms_are_the_same_body(self):
        # The prism of AROUND sides.
        volume = 0.5 * AROUND * RADIUS**2 * math.sin(2 * math.pi / AROUND) * HEIGHT
        for name, content, kind in (("a.stl", ascii_stl, "STL ASCII"), ("b.stl", binary_stl, "STL binary"), ("c.obj", obj, "OBJ")):
            report, notes = self.report("inspect", self.file(name, content(cylinder())))
            self.assertEqual(report["input"]["format"], kind)
            self.assertIn("hold no unit", notes)
            self.assertTrue(report["solid"]["closed"])
            self.assertEqual(report["solid"]["solids"], 1)
            self.assertEqual(report["solid"]["vertices"], 2 * AROUND + 2)
            self.assertAlmostEqual(report["solid"]["volume"] / volume, 1.0, delta=1e-6)
            self.assertEqual(report["details"]["sharp_curves"], 2)
            self.assertAlmostEqual(report["details"]["centre_of_mass"][2], HEIGHT / 2, delta=1e-4)

    def test_triangles_become_a_solid(self):
        output = self.file("out.step")
        report, notes = self.report("convert", self.file("tank.stl", binary_stl(cylinder())), "-o", output,
                                    "--tolerance", "1e-3rel", "--input-unit", "in")
        self.assertNotIn("hold no unit", notes)
        self.assertEqual(report["unit"], "in")
        self.assertTrue(report["solid"]["closed"] and report["solid"]["valid"] and report["solid"]["all_bicubic"])
        tolerance = 1e-3 * report["input"]["diagonal"]
        for side in ("output_to_input", "input_to_output"):
            self.assertLess(report["deviation"][side]["max"], tolerance)
        self.assertEqual(report["sharp_curves"]["input"], 2)
        self.assertEqual(report["sharp_curves"]["output"], 2)
        # The solid is that of the cylinder within chords and tolerance on all its surface.
        volume = math.pi * RADIUS**2 * HEIGHT
        chord = RADIUS * (1 - math.cos(math.pi / AROUND))
        slack = (chord + tolerance) * 2 * math.pi * RADIUS * (RADIUS + HEIGHT)
        self.assertLess(abs(report["solid"]["volume"] - volume), slack)
        compared, _ = self.report("compare", self.file("tank.stl"), output, "--input-unit", "in")
        for side in ("output_to_input", "input_to_output"):
            self.assertAlmostEqual(compared["deviation"][side]["max"], report["deviation"][side]["max"], delta=1e-6)
        turned, _ = self.report("compare", output, self.file("tank.stl"))  # without a unit the triangles are millimetres
        self.assertGreater(turned["deviation"]["output_to_input"]["max"], 1.0)

    def test_a_cage_and_a_fit(self):
        cage, fitted = self.file("cage.obj"), self.file("fitted.obj")
        stl = self.file("tank.stl", ascii_stl(cylinder()))
        self.run_it("cage", stl, "-o", cage, "--tolerance", "1e-3rel")
        text = cage.read_text()
        self.assertIn("g tank", text)
        self.assertIn("t crease", text)
        refused = self.run_it("cage", self.file("block.stl", ascii_stl(box())), "-o", self.file("no.obj"), "--layout", "aligned", code=2)
        self.assertIn("--layout remesh", refused.stderr)
        self.assertFalse(self.file("no.obj").exists())
        report, notes = self.report("fit", stl, "--cage", cage, "-o", fitted, "--tolerance", "1e-3rel")
        self.assertTrue(report["fit"]["met"])
        self.assertNotIn("facets will be followed", notes)
        _, notes = self.report("fit", stl, "--cage", cage, "-o", fitted, "--tolerance", "1e-5rel", "--max-levels", "0", code=3)
        self.assertIn("facets will be followed", notes)

    def test_sharpness_can_be_chosen(self):
        # Of eight sides each edge is 45 degrees.
        stl = self.file("prism.stl", ascii_stl(cylinder(8)))
        report, _ = self.report("inspect", stl)
        self.assertEqual(report["details"]["sharp_curves"], 24)
        report, _ = self.report("inspect", stl, "--sharp-angle", "50")
        self.assertEqual(report["details"]["sharp_curves"], 2)

    def test_broken_files_are_refused_in_one_line(self):
        whole = binary_stl(cylinder())
        crowded = cylinder()
        a, b, _ = crowded[0]
        crowded.append((a, b, (0.0, 0.0, 500.0)))
        for content, part in ((whole[:1000], "truncated"), (ascii_stl(cylinder())[:1000], "truncated"), (b"", "truncated"),
                              (binary_stl([((0.0, 0.0, math.nan), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0))]), "not finite"),
                              (binary_stl([((1.0, 1.0, 1.0),) * 3] * 5), "three different points"),
                              (binary_stl(crowded), "3 triangles meet at the side"), (b"hello", "truncated")):
            stl = self.file("broken.stl", content)
            for command in (["inspect", stl], ["convert", stl, "-o", self.file("out.step")], ["compare", stl, stl],
                            ["cage", stl, "-o", self.file("out.obj")]):
                result = self.run_it(*command, code=2)
                lines = [line for line in result.stderr.splitlines() if not line.startswith("note: ")]
                self.assertEqual(len(lines), 1, result.stderr)
                self.assertIn("broken.stl", lines[0])
                self.assertIn(part, lines[0])
            self.assertFalse(self.file("out.step").exists() or self.file("out.obj").exists())


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[2:]])
