"""The sample wing's cage carried along with points of a structural model, and forces back to them.

Usage: morph_test.py PATCHWRIGHT SAMPLES_DIR [unittest arguments]
"""
import json
import sys
import unittest

import numpy

from command_line import CliTest, run, SAMPLES, WING
from grid_files import cgns_arrays, vtk_blocks

CAGE = WING / "wing_cage.obj"
CUBE = SAMPLES / "cages" / "cube.obj"


def points_of(cage):
    return numpy.array([[float(x) for x in line.split()[1:4]] for line in cage.read_text().splitlines() if line.startswith("v ")])


def all_but_points(cage):
    return [line for line in cage.read_text().splitlines() if not line.startswith("v ")]


def table(file):
    return numpy.loadtxt(file, delimiter=",", skiprows=1, ndmin=2)


def ribs(stations=30):
    """Ten points a rib in the wing's box."""
    low, high = points_of(CAGE).min(axis=0), points_of(CAGE).max(axis=0)
    shares = [numpy.linspace(0.0, 1.0, n) for n in (5, stations, 2)]
    return low + (high - low) * numpy.stack(numpy.meshgrid(*shares), axis=-1).reshape(-1, 3)


def bend(points, tip):
    """Upwards by tip * (share of the span)^2, with sections that turn along."""
    low, high = points_of(CAGE)[:, 1].min(), points_of(CAGE)[:, 1].max()
    share = (points[:, 1] - low) / (high - low)
    slope = numpy.arctan(2.0 * tip * share / (high - low))
    middle = points_of(CAGE)[:, 2].mean()
    moved = numpy.zeros_like(points)
    moved[:, 1] = -numpy.sin(slope) * (points[:, 2] - middle)
    moved[:, 2] = tip * share**2 + (numpy.cos(slope) - 1.0) * (points[:, 2] - middle)
    return moved


class Morphs(CliTest):
    def csv(self, name, *columns, head=""):
        rows = numpy.hstack(columns)
        return self.path(name, head + "".join(",".join(map(repr, map(float, row))) + "\n" for row in rows))

    def forces(self, count=400):
        random = numpy.random.default_rng(2)
        faces = sum(line.startswith("f ") for line in CAGE.read_text().splitlines())
        places = random.random((count, 3))
        places[:, 0] = random.integers(0, faces, count)
        places[0, 1:] = 0.0  # a vertex
        force = random.normal(size=(count, 3)) + [0.0, 0.0, 2.0]
        return places, force, self.csv("forces.csv", places, force, head="face,u,v,fx,fy,fz\n")

    def surface(self, cage, places):
        file = self.csv("places.csv", places)
        result = run("eval", cage, "--at-file", file, "-o", self.path("points.csv"))
        self.assertEqual(result.returncode, 0, result.stderr)
        return table(self.path("points.csv"))[:, :3]

    def test_a_bent_wing(self):
        points = ribs()
        out, step, same = self.path("bent.obj"), self.path("bent.step"), self.path("same.obj")
        self.report("subdivide", CAGE, "-n", 0, "-o", same)  # as patchwright writes it
        for tip in (5.0, 150.0, -300.0):
            with self.subTest(tip=tip):
                file = self.csv("nodes.csv", points, bend(points, tip))
                report = self.report("morph", CAGE, "--displacements", file, "-o", out, "--cad-out", step)
                self.assertTrue(report["verdict"]["met"], report["verdict"])
                self.assertTrue(report["solid"]["valid"] and report["solid"]["closed"])
                self.assertEqual(all_but_points(out), all_but_points(same))
                self.assertEqual(report["morph"]["points"], 300)
                moved = points_of(out) - points_of(CAGE)
                self.assertAlmostEqual(report["morph"]["largest_moved"], numpy.linalg.norm(moved, axis=1).max(), delta=1e-9)
                # The closed form at the control points, as near as 30 ribs tell it.
                self.assertLess(abs(moved - bend(points_of(CAGE), tip)).max(), 0.01 * abs(tip))
        self.report("compare", step, self.exported(out), "--tolerance", "1e-9rel")

    def exported(self, cage):
        step = self.path("exported.step")
        self.report("export", cage, "-o", step)
        return step

    def test_steps_of_a_motion(self):
        """Each step as in a run of its own; grids of constant blocks whose points stay at their places, with exact velocities."""
        points, tips = ribs(), (20.0, 80.0, 180.0)
        velocity = numpy.random.default_rng(4).normal(size=points.shape)
        files = [self.csv(f"t{i}.csv", points, bend(points, tip), (i + 1) * velocity) for i, tip in enumerate(tips)]
        outputs = {name: self.path(name) for name in ("{step}.obj", "{step}.step", "{step}.vtm", "v_{step}.csv")}
        report = self.report("morph", CAGE, "--displacements", *files, "-o", outputs["{step}.obj"], "--cad-out", outputs["{step}.step"],
                             "--grid-out", outputs["{step}.vtm"], "--velocities-out", outputs["v_{step}.csv"], "--points", 7)
        steps = report["morph"]["steps"]
        self.assertEqual([step["file"] for step in steps], [str(file) for file in files])
        self.assertEqual(report["verdict"]["met"], True)
        at_rest = list(vtk_blocks(self.grid(CAGE, "--points", 7)))
        for i, (tip, file) in enumerate(zip(tips, files)):
            with self.subTest(tip=tip):
                single = self.report("morph", CAGE, "--displacements", file, "-o", self.path("s.obj"), "--cad-out", self.path("s.step"))
                for name in ("obj", "step"):
                    written = self.path(f"t{i}.{name}").read_bytes().replace(b"'t%d'" % i, b"'s'")
                    self.assertEqual(written, self.path(f"s.{name}").read_bytes())
                self.assertEqual({**steps[i]["solid"], "file": ""}, {**single["solid"], "file": ""})
                self.assertEqual(steps[i]["largest_moved"], single["morph"]["largest_moved"])
                self.assertTrue(steps[i]["verdict"]["met"])
                self.assertEqual(steps[i]["grid"]["folded"], 0)
                moved = points_of(self.path(f"t{i}.obj")) - points_of(CAGE)
                self.assertLess(abs(moved - bend(points_of(CAGE), tip)).max(), 0.01 * tip)
                velocities = table(self.path(f"v_t{i}.csv"))
                blocks = list(vtk_blocks(self.path(f"t{i}.vtm")))
                self.assertEqual(len(blocks), len(at_rest))
                for (name, size, grid, places, speed), (known, known_size, _, known_places, _) in zip(blocks, at_rest):
                    self.assertEqual((name, size), (known, known_size))
                    for a, b in zip(places, known_places):
                        numpy.testing.assert_array_equal(a, b)
                    rows = numpy.column_stack(places)
                    # Limit points at these places, by masks instead of the grid's pieces: rounding.
                    self.assertLess(abs(self.surface(self.path(f"t{i}.obj"), rows) - grid).max(), 1e-12 * abs(grid).max())
                    self.assertLess(abs(self.surface(self.of_points(velocities[:, 3:]), rows) - speed).max(), 1e-11 * abs(speed).max())
        # CGNS: the same, at the vertices of a deforming grid.
        self.report("morph", CAGE, "--displacements", *files, "-o", outputs["{step}.obj"], "--grid-out", self.path("{step}.cgns"), "--points", 7)
        zones = cgns_arrays(self.path("t2.cgns"), "ArbitraryGridMotion_t")
        for name, _, _, _, speed in vtk_blocks(self.path("t2.vtm")):
            numpy.testing.assert_array_equal(numpy.stack([zones[name][f"GridVelocity{c}"] for c in "XYZ"], axis=1), speed)

    def grid(self, cage, *words):
        file = self.path("rest.vtm")
        self.report("grid", cage, "-o", file, *words)
        return file

    def of_points(self, points):
        """The wing's cage with other points."""
        rows = iter(points)
        lines = ["v " + " ".join(map(repr, map(float, next(rows)))) if line.startswith("v ") else line
                 for line in CAGE.read_text().splitlines()]
        return self.path("of_points.obj", "\n".join(lines) + "\n")

    def test_a_missed_step_is_the_runs_verdict(self):
        """The middle one is pressed into a plane: CAD without a volume."""
        points = ribs()
        flat = numpy.zeros_like(points)
        flat[:, 2] = -points[:, 2]
        files = [self.csv(f"{name}.csv", points, moved) for name, moved in (("a", bend(points, 10.0)), ("b", flat), ("c", bend(points, 30.0)))]
        words = ["morph", CAGE, "--displacements", *files, "-o", self.path("{step}.obj"), "--cad-out", self.path("{step}.step")]
        report = self.report(*words, code=3)
        self.assertEqual([step["verdict"]["met"] for step in report["morph"]["steps"]], [True, False, True])
        self.assertEqual(report["verdict"], report["morph"]["steps"][1]["verdict"])
        self.assertEqual(report["solid"]["file"], str(self.path("b.step")))
        result = run(*words)
        self.assertIn(f"note: {files[1]}: MISSED", result.stderr)
        self.assertTrue(result.stdout.startswith("MISSED"))

    def test_steps_refused(self):
        points = ribs(5)
        a, b = self.csv("a.csv", points, points), self.csv("b.csv", points, 2 * points)
        both = ["morph", CAGE, "--displacements", a, b]
        self.check_refused([*both, "-o", "{out}.obj"], 1, "--output", "2 files", "{step}")
        for option, name in (("--cad-out", "x.step"), ("--grid-out", "x.cgns"), ("--velocities-out", "x.csv")):
            self.check_refused([*both, "-o", self.path("{step}.obj"), option, self.path(name)], 1, option, "{step}")
        self.path("other").mkdir()
        twin = self.csv("other/a.csv", points, points)
        self.check_refused(["morph", CAGE, "--displacements", a, twin, "-o", self.path("{step}.obj")], 1, "a.csv", "'a'", "rename")
        self.check_refused([*both, "-o", self.path("{step}.obj"), "--forces", a, "--forces-out", self.path("{step}.csv")], 1, "--forces-out")
        self.check_refused([*both, "-o", self.path("{step}.csv")], 1, "{step}.csv".replace("{step}", "a"))
        rows = b.read_text().splitlines()
        for lines, *parts in ((rows[:3] + ["1,2,3,0,0,0"] + rows[4:], "line 4", "line 4 of", "a.csv"),
                              (rows[:-1], "line 49", "49 points", "50"), (rows + ["1,2,3,0,0,0"], "line 51", "not in"),
                              ([row + ",0,0,0" for row in rows], "line 1", "9 numbers", "6")):
            b.write_text("\n".join(lines) + "\n")
            self.check_refused([*both, "-o", self.path("{step}.obj")], 2, "b.csv", *parts)
            self.assertFalse(self.path("a.obj").exists())

    def test_affine_maps_are_exact(self):
        points, cage = ribs(), points_of(CAGE)
        by = numpy.array([[0.02, 0.1, 0.0], [-0.1, 0.0, 0.03], [0.0, 0.2, -0.1]])
        file = self.csv("nodes.csv", points, points @ by + [3.0, 4.0, -500.0], head="# of a solver\nx y z dx dy dz\n")
        self.report("morph", CAGE, "--displacements", file, "-o", self.path("a.obj"))
        wanted = cage + cage @ by + [3.0, 4.0, -500.0]
        self.assertLess(abs(points_of(self.path("a.obj")) - wanted).max(), 1e-12 * abs(wanted).max())
        # Nothing moves where nothing is displaced.
        self.report("morph", CAGE, "--displacements", self.csv("nodes.csv", points, 0.0 * points), "-o", self.path("b.obj"))
        self.assertTrue((points_of(self.path("b.obj")) == cage).all())

    def test_forces_are_conserved(self):
        points, (places, force, forces) = ribs(), self.forces()
        moved = bend(points, 150.0)
        out, loads = self.path("bent.obj"), self.path("loads.csv")
        report = self.report("morph", CAGE, "--displacements", self.csv("nodes.csv", points, moved), "-o", out, "--forces", forces,
                             "--forces-out", loads)
        carried = table(loads)
        self.assertTrue((carried[:, :3] == points).all())
        size = numpy.linalg.norm(force, axis=1).sum()
        self.assertLess(abs(carried[:, 3:].sum(axis=0) - force.sum(axis=0)).max(), 1e-12 * size)
        # Of the shape as it was and of the displaced one, about the origin and the tip.
        for cage, nodes in ((CAGE, points), (out, points + moved)):
            surface = self.surface(cage, places)
            for centre in numpy.array([[0.0, 0.0, 0.0], [500.0, 3000.0, 0.0]]):
                moment = numpy.cross(surface - centre, force).sum(axis=0)
                arm = numpy.linalg.norm(surface - centre, axis=1).max()
                self.assertLess(abs(numpy.cross(nodes - centre, carried[:, 3:]).sum(axis=0) - moment).max(), 1e-12 * size * arm)
        told = report["morph"]["forces"]
        self.assertEqual(told["places"], len(places))
        self.assertLess(max(told["force_error"], told["moment_error"]), 1e-12)
        numpy.testing.assert_allclose(told["force"], force.sum(axis=0), rtol=0, atol=1e-12 * size)
        moment = numpy.cross(self.surface(CAGE, places), force).sum(axis=0)
        numpy.testing.assert_allclose(told["moment"], moment, rtol=0, atol=1e-9 * abs(moment).max())

    def test_velocities_and_virtual_work(self):
        points, (places, force, forces) = ribs(), self.forces()
        velocity = numpy.random.default_rng(3).normal(size=points.shape)
        self.report("morph", CAGE, "--displacements", self.csv("nodes.csv", points, bend(points, 50.0), velocity), "-o",
                    self.path("a.obj"), "--velocities-out", self.path("v.csv"), "--forces", forces, "--forces-out", self.path("loads.csv"))
        velocities = table(self.path("v.csv"))
        self.assertTrue((velocities[:, :3] == points_of(self.path("a.obj"))).all())
        # A cage whose points are velocities: its limit points are those of the surface.
        on_surface = self.surface(self.of_points(velocities[:, 3:]), places)
        work = (on_surface * force).sum()
        self.assertLess(abs((table(self.path("loads.csv"))[:, 3:] * velocity).sum() - work), 1e-12 * abs(on_surface * force).sum())
        # They are the difference quotient of two morphs, which is exact for a linear map.
        for name, step in (("b.obj", 1.0), ("c.obj", -1.0)):
            self.report("morph", CAGE, "--displacements", self.csv("n.csv", points, bend(points, 50.0) + step * velocity), "-o", self.path(name))
        quotient = 0.5 * (points_of(self.path("b.obj")) - points_of(self.path("c.obj")))
        numpy.testing.assert_allclose(velocities[:, 3:], quotient, rtol=0, atol=1e-10)

    def test_units(self):
        points = ribs()
        file = self.csv("nodes.csv", points, bend(points, 150.0))
        report = [self.report("morph", CAGE, "--displacements", file, "-o", self.path(f"{unit}.obj"), "--cad-out", self.path("a.step"),
                              "--cage-unit", unit) for unit in ("mm", "in")]
        numpy.testing.assert_allclose(points_of(self.path("mm.obj")), points_of(self.path("in.obj")), rtol=0, atol=1e-9)
        self.assertAlmostEqual(report[0]["solid"]["volume"] / report[1]["solid"]["volume"], 1.0, places=9)
        self.assertEqual(report[1]["unit"], "in")

    def test_text_and_notes(self):
        points, (_, _, forces) = ribs(), self.forces()
        arguments = ["morph", CAGE, "-o", self.path("a.obj"), "--cad-out", self.path("a.step"), "--forces", forces, "--forces-out",
                     self.path("f.csv"), "--displacements"]
        result = run(*arguments, self.csv("nodes.csv", points, bend(points, 150.0)))
        self.assertEqual((result.returncode, result.stderr), (0, ""))
        self.assertLessEqual(len(result.stdout.splitlines()), 15)
        self.assertIn("control points by up to", result.stdout)
        # In metres.
        result = run(*arguments, self.csv("nodes.csv", 1e-3 * points, 1e-3 * bend(points, 150.0)))
        self.assertIn("add points around the cage, in its unit", result.stderr)

    def test_two_runs_give_equal_bytes(self):
        points, (_, _, forces) = ribs(), self.forces()
        file = self.csv("nodes.csv", points, bend(points, 150.0), points)
        files = [self.path(name) for name in ("a.obj", "a.step", "v.csv", "f.csv")]
        written = []
        for threads in (1, 2):
            self.report("morph", CAGE, "--displacements", file, "-o", files[0], "--cad-out", files[1], "--velocities-out", files[2],
                        "--forces", forces, "--forces-out", files[3], "--threads", threads)
            written.append([file.read_bytes() for file in files])
        self.assertEqual(*written)

    def test_refused(self):
        points = ribs(5)
        good = self.csv("good.csv", points, points)
        rows = good.read_text().splitlines()

        def refused(lines, code, *parts, words=("-o", "{out}.obj"), cage=CAGE):
            file = self.path("bad.csv", "\n".join(lines) + "\n")
            self.check_refused(["morph", cage, "--displacements", file, *words], code, *parts)

        refused(rows[:9] + rows[3:4] + rows[9:], 2, "bad.csv", "line 4 and line 10 are in one place")
        refused(rows[:9] + ["1,2,x,0,0,0"], 2, "bad.csv", "line 10", "'x'")
        refused(rows[:9] + ["1,2,nan,0,0,0"], 2, "bad.csv", "line 10", "nan")
        refused(rows[:9] + ["1,2,1e99,0,0,0"], 2, "bad.csv", "line 10", "1e+99")
        refused([f"{1e-8 * x},{1e-8 * y},{1e-8 * z},{x}e69,0,0" for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], 2, "bad.csv", "beyond 1e+70")
        refused(rows[:9] + ["1,2,3,0,0"], 2, "bad.csv", "line 10", "5 numbers")
        refused([row + ",1" for row in rows], 2, "bad.csv", "line 1", "7 numbers", "6 or 9")
        refused(rows[:3], 2, "bad.csv", "3 points", "four")
        refused([], 2, "bad.csv")
        refused([f"{i},{i * i % 7},0,1,1,1" for i in range(30)], 2, "bad.csv", "one plane")
        refused([f"{i},{2 * i},0,1,1,1" for i in range(30)], 2, "bad.csv", "one line")
        many = numpy.random.default_rng(1).random((10001, 6))
        refused([",".join(map(str, row)) for row in many], 2, "bad.csv", "10001 points", "10000", "0.8 GB")
        refused(rows, 2, "line 1", "--velocities-out", words=("-o", "{out}.obj", "--velocities-out", self.path("v.csv")))
        refused(rows, 1, ".csv", words=("-o", "{out}.obj", "--velocities-out", self.path("v.txt")))
        refused(rows, 1, ".obj", words=("-o", "{out}.step"))
        refused(rows, 1, "--forces-out", words=("-o", "{out}.obj", "--forces", good))
        refused(rows, 2, "none.csv", words=("-o", "{out}.obj", "--forces", "none.csv", "--forces-out", self.path("f.csv")))
        for row, part in (("999999,0,0,1,1,1", "999999"), ("0,2,0,1,1,1", "u and v"), ("0,0,0,1,1", "5 numbers")):
            forces = self.path("bad_forces.csv", f"face,u,v,fx,fy,fz\n{row}\n")
            refused(rows, 2, "bad_forces.csv", "line 2", part,
                    words=("-o", "{out}.obj", "--forces", forces, "--forces-out", self.path("f.csv")))
        refused(rows, 2, "cut.obj", cage=self.path("cut.obj", "v 0 0\n"))
        creases = "".join(f"t crease 2/1/0 0 {v} 10\n" for v in (1, 2))
        tagged = self.path("tagged.obj", CUBE.read_text() + creases + "#patchwright sector 0 0 90 0 0 1\n")
        refused(rows, 2, "tagged.obj", "normal", cage=tagged)
        refused(rows, 2, "tagged.obj", "--forces", cage=tagged, words=("-o", "{out}.obj", "--forces", good, "--forces-out", self.path("f.csv")))
        self.assertFalse(self.path("f.csv").exists() or self.path("v.csv").exists())
        self.check_error(run("morph", CAGE, "-o", self.path("a.obj")), 1, "--displacements")
        self.check_error(run("morph", CAGE, "--displacements", good, "-o", good), 1, "good.csv")

    def test_a_failure_is_in_the_report(self):
        report = self.path("r.json")
        result = run("morph", CAGE, "--displacements", self.path("n.csv", "1 2 3\n"), "-o", self.path("a.obj"), "--json", report)
        self.assertEqual(result.returncode, 2)
        self.assertIn("n.csv", json.loads(report.read_text())["error"]["message"])


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
