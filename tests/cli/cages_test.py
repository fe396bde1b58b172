"""Cages at the command line: what is refused, what is said.

Usage: cages_test.py PATCHWRIGHT SAMPLES_DIR [unittest arguments]
"""
import json
import math
import sys
import unittest

from command_line import CliTest, run, SAMPLES

CUBE = [(x, y, z) for z in (-50, 50) for y in (-50, 50) for x in (-50, 50)]
FACES = "f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n"


def cube(scale=1.0, shift=0.0, rest="", faces=FACES):
    return "".join("v %r %r %r\n" % tuple(scale * x + shift for x in p) for p in CUBE) + faces + rest


def spindle(sides):
    """A prism whose ends are polygons of so many sides, and two poles above them of as many triangles."""
    ring = lambda z: ["v %r %r %r\n" % (40 * math.cos(2 * math.pi * i / sides), 40 * math.sin(2 * math.pi * i / sides), z)
                      for i in range(sides)]
    text = "".join(ring(-20.0) + ring(20.0)) + "v 0 0 50\n"
    for i in range(sides):
        a, b = i + 1, (i + 1) % sides + 1
        text += f"f {a} {b} {sides + b} {sides + a}\nf {sides + a} {sides + b} {2 * sides + 1}\n"
    return text + "f " + " ".join(str(i) for i in range(sides, 0, -1)) + "\n"


class Cages(CliTest):
    def test_scaled_and_moved_cages_give_the_same_solid(self):
        unit = self.report("export", self.path("unit.obj", cube()), "-o", self.path("unit.step"))
        for scale, shift in ((1e-4, 0.0), (1e-2, 0.0), (1e3, 0.0), (5e4, 0.0), (1.0, 1e6), (1.0, 5e6), (1e-2, 1e5)):
            with self.subTest(scale=scale, shift=shift):
                report = self.report("export", self.path("cage.obj", cube(scale, shift)), "-o", self.path("out.step"))
                self.assertTrue(report["solid"]["valid"] and report["solid"]["closed"])
                self.assertAlmostEqual(report["solid"]["volume"] / scale**3 / unit["solid"]["volume"], 1.0, delta=1e-3)

    def test_sizes_beyond_the_kernels_resolution_are_refused(self):
        for scale, shift, says in ((1e-9, 0.0, "less than 0.01 mm"), (1.0, 1e12, "beyond 1e+07 mm"), (1e28, 0.0, "beyond 1e+07 mm")):
            cage = self.path("cage.obj", cube(scale, shift))
            self.check_refused(["export", cage, "-o", "{out}.step"], 2, "cage.obj", says)

    def test_numbers_that_are_no_lengths_are_refused_with_their_line(self):
        cage = self.path("cage.obj", cube().replace("v 50.0 50.0 50.0", "v 50 50 -1e308"))
        for command in (["eval", cage, "--at", "0,0.5,0.5"], ["export", cage, "-o", "{out}.step"], ["subdivide", cage, "-o", "{out}.obj"]):
            self.check_refused(command, 2, "line 8: vertex 8", "-1e308")

    def test_a_closed_cage_without_volume_is_missed(self):
        flat = "".join("v %r %r 0\n" % p[:2] for p in CUBE) + FACES
        report = self.report("export", self.path("flat.obj", flat), "-o", self.path("out.step"), code=3)
        self.assertIn("volume", [c["name"] for c in report["verdict"]["conditions"] if not c["met"]])

    def test_layers_on_cells_without_area_are_numbers(self):
        heap = "v 1 2 3\n" * 7 + "v 50 50 50\n" + FACES
        out = self.path("out.xyz", "")
        result = run("grid", self.path("heap.obj", heap), "-o", out, "--plot3d", "ascii", "--points", 5, "--layers", 2, "--thickness", "0.01rel")
        self.assertEqual(result.returncode, 3, result.stderr)
        self.assertTrue(all(math.isfinite(float(x)) for x in out.read_text().split()))

    def test_names_that_are_too_long_are_shortened(self):
        cage = self.path("cage.obj", cube(faces="g " + "x" * 20000 + "\n" + FACES))
        result = run("export", cage, "-o", self.path("out.step"))
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn("6 names of faces", result.stderr)
        for name in ("a" * 40, "wing/upper", "wing\\upper", "..", "DataClass", "n" * 32):
            with self.subTest(name):
                cage = self.path("cage.obj", cube(faces=f"g {name}\n" + FACES))
                self.assertEqual(run("grid", cage, "-o", self.path("out.cgns")).returncode, 0)

    def test_sectors_that_no_sharp_edges_bound_are_refused(self):
        cage = self.path("cage.obj", cube(rest="t crease 2/1/0 0 2 10\n#patchwright sector 0 0 90\n"))
        self.check_refused(["export", cage, "-o", "{out}.step"], 2, "sector 0 0 (line 16)")

    def test_a_sectors_angle_has_no_patches(self):
        text = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 2 0 0\nv 2 1 0.3\nf 1 2 3 4\nf 2 5 6 3\n#patchwright sector 1 0 90\n"
        cage = self.path("cage.obj", text)
        self.check_refused(["export", cage, "-o", "{out}.step"], 2, "cage.obj: sector at vertex 1")
        self.assertEqual(run("eval", cage, "--at", "0,1,0", "-q").returncode, 0)
        self.assertEqual(run("grid", cage, "-o", self.path("out.xyz"), "--points", "5", "-q").returncode, 0)

    def test_many_sides_become_a_solid(self):
        report = self.report("export", self.path("cage.obj", spindle(48)), "-o", self.path("out.step"))
        self.assertTrue(report["solid"]["valid"] and report["solid"]["closed"])

    def test_an_inner_vertex_with_two_faces_is_removed_with_a_notice(self):
        faces = FACES.replace("f 1 3 4 2", "f 1 9 3 4 2").replace("f 1 5 7 3", "f 1 5 7 3 9")
        result = run("export", self.path("cage.obj", cube(faces="v -50 1 -50\n" + faces)), "-o", self.path("out.step"), "-q", "--progress")
        self.assertEqual(result.returncode, 0, result.stderr)
        result = run("eval", self.path("cage.obj"), "--at", "0,0,0")
        self.assertIn("1 inner vertices with two faces only were removed", result.stderr)

    def test_grids_that_memory_does_not_hold_are_refused(self):
        cage = self.path("cage.obj", cube())
        self.check_refused(["grid", cage, "-o", self.path("grid.xyz"), "--points", "1000000"], 1, "GB of memory", "points")
        self.check_refused(["grid", cage, "-o", self.path("grid.xyz"), "--points", "20000", "--layers", "5000", "--thickness", "1mm"], 1,
                           "GB of memory")
        self.assertFalse(self.path("grid.xyz").exists())

    def test_far_fields_go_on_from_layers_of_one_body(self):
        cage, grid = self.path("cage.obj", cube()), self.path("grid.cgns")
        result = run("grid", cage, "-o", grid, "--points", 5, "--layers", 3, "--thickness", "5mm", "--farfield", "20rel", "--json", "-")
        self.assertEqual(result.returncode, 0, result.stderr)
        quality = json.loads(result.stdout)["grid"]
        self.assertEqual(quality["negative_volumes"], 0)
        self.assertGreater(quality["cells"], 3 * 96)
        self.assertIn(b"BCFarfield", grid.read_bytes())
        layers = ["grid", cage, "-o", self.path("other.cgns"), "--layers", 3, "--thickness", "5mm"]
        self.check_refused(["grid", cage, "-o", self.path("other.cgns"), "--farfield", "20rel"], 1, "--layers")
        self.check_refused([*layers, "--farfield", "10mm"], 1, "does not hold the layers")
        self.check_refused(["grid", SAMPLES / "cages" / "torus.obj", *layers[2:], "--farfield", "20rel"], 1, "has a handle")
        self.assertFalse(self.path("other.cgns").exists())

    def test_a_control_mesh_is_no_input_of_conversions(self):
        for command in (["convert", "{cage}", "-o", "{out}.step"], ["cage", "{cage}", "-o", "{out}.obj"],
                        ["fit", "{cage}", "--cage", "{cage}", "-o", "{out}.obj"]):
            command = [c.replace("{cage}", str(SAMPLES / "cages" / "cube_rim.obj")) for c in command]
            self.check_refused(command, 2, "this is a control mesh", "use export")

    def test_the_likely_unit_of_a_cage_is_named(self):
        model, cage = self.path("model.step"), self.path("cage.obj", cube(1 / 25.4))
        self.report("export", self.path("cube.obj", cube()), "-o", model)
        result = run("fit", model, "--cage", cage, "-o", self.path("fitted.obj"), "--max-levels", "0", "--tolerance", "1e-1rel")
        self.assertIn("its unit is likely in: pass --cage-unit in", result.stderr)
        result = run("fit", model, "--cage", cage, "-o", self.path("fitted.obj"), "--cage-unit", "in", "--tolerance", "1e-1rel")
        self.assertNotIn("likely", result.stderr)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
