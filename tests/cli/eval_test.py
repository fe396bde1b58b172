"""Places by the file: points, derivatives by control points, and their products with gradients; places and fields of sizes in grids.

Usage: eval_test.py PATCHWRIGHT SAMPLES_DIR [unittest arguments]
"""
import sys
import unittest

import numpy
import scipy.io
import vtk
from vtk.util.numpy_support import vtk_to_numpy

from command_line import SAMPLES, WING, CliTest, run
from grid_files import cgns_arrays, vtk_blocks

CAGES = [SAMPLES / "cages" / f"{name}.obj" for name in ("cube", "cube_rim", "torus", "dish")] + [WING / "wing_cage.obj"]


def faces_of(cage):
    return [[int(word.split("/")[0]) - 1 for word in line.split()[1:]] for line in cage.read_text().splitlines() if line.startswith("f ")]


def points_of(cage):
    return numpy.array([[float(x) for x in line.split()[1:4]] for line in cage.read_text().splitlines() if line.startswith("v ")])


def table(file):
    return numpy.loadtxt(file, delimiter=",", skiprows=1, ndmin=2)


class Places(CliTest):
    def places(self, cage, count=200):
        """Random ones on all faces, corners and edges among them."""
        random = numpy.random.default_rng(1)
        faces = faces_of(cage)
        lines = []
        for face in random.integers(0, len(faces), count):
            u, v = float(random.choice([0.0, 1.0, random.random()])), float(random.random())
            sectors = 1 if len(faces[face]) == 4 else len(faces[face])
            lines.append(f"{face},{u!r},{v!r},{random.integers(0, sectors)}")
        self.path("places.csv", "face,u,v,sector\n" + "\n".join(lines) + "\n")
        return lines

    def eval(self, cage, *arguments):
        result = run("eval", cage, "--at-file", self.path("places.csv"), *arguments)
        self.assertEqual(result.returncode, 0, result.stderr)
        return result

    def test_points_are_those_of_single_places(self):
        for cage in CAGES:
            with self.subTest(cage=cage.name):
                lines = self.places(cage)
                self.eval(cage, "-o", self.path("points.csv"))
                points = table(self.path("points.csv"))
                self.assertEqual(points.shape, (len(lines), 6))
                report = self.report("eval", cage, "--at", *lines)
                for row, single in zip(points, report):
                    numpy.testing.assert_allclose(row[:3], single["position"], rtol=0, atol=1e-12 * abs(points).max())
                    numpy.testing.assert_allclose(row[3:], single.get("normal", [0, 0, 0]), rtol=0, atol=1e-12)

    def test_rows_are_derivatives_by_control_points(self):
        """A central difference of a linear map is exact but for rounding."""
        for cage in CAGES:
            with self.subTest(cage=cage.name):
                self.places(cage, 40)
                self.eval(cage, "--jacobian", self.path("j.mtx"), "-o", self.path("points.csv"))
                matrix = scipy.io.mmread(self.path("j.mtx")).tocsr()
                control = points_of(cage)
                numpy.testing.assert_allclose(matrix @ control, table(self.path("points.csv"))[:, :3], rtol=0, atol=1e-12 * abs(control).max())
                numpy.testing.assert_allclose(matrix.sum(axis=1), 1.0, rtol=0, atol=1e-13)
                lines = cage.read_text().splitlines()
                vertices = [i for i, line in enumerate(lines) if line.startswith("v ")]
                step = 0.01 * abs(control).max()
                for vertex in (0, len(vertices) // 2):
                    moved = []
                    for sign in (1, -1):
                        x, y, z = control[vertex].tolist()
                        changed = list(lines)
                        changed[vertices[vertex]] = f"v {x + sign * float(step)!r} {y!r} {z!r}"
                        self.eval(self.path("moved.obj", "\n".join(changed) + "\n"), "-o", self.path("moved.csv"))
                        moved.append(table(self.path("moved.csv"))[:, 0])
                    numpy.testing.assert_allclose((moved[0] - moved[1]) / (2 * step), matrix[:, vertex].toarray()[:, 0], rtol=0, atol=1e-11)

    def test_the_adjoint_is_the_product_with_the_transpose(self):
        cage = WING / "wing_cage.obj"
        self.places(cage)
        gradient = numpy.random.default_rng(2).normal(size=(200, 3))
        numpy.savetxt(self.path("gradient.csv"), gradient)  # blanks between numbers
        self.eval(cage, "--jacobian", self.path("j.mtx"), "--gradient", self.path("gradient.csv"), "--adjoint", self.path("adjoint.csv"))
        adjoint = table(self.path("adjoint.csv"))
        numpy.testing.assert_allclose(adjoint, scipy.io.mmread(self.path("j.mtx")).T @ gradient, rtol=0, atol=1e-13 * 200)
        # Masks sum to one: forces on the surface and on the control points have equal sums.
        numpy.testing.assert_allclose(adjoint.sum(axis=0), gradient.sum(axis=0), rtol=0, atol=1e-13 * 200)

    def test_a_hundred_thousand_places_give_equal_bytes_on_any_threads(self):
        cage = WING / "wing_cage.obj"
        self.places(cage, 100000)
        for threads in (1, 2):
            self.eval(cage, "-o", self.path(f"{threads}.csv"), "--jacobian", self.path(f"{threads}.mtx"), "--threads", threads)
        self.assertEqual(self.path("1.csv").read_bytes(), self.path("2.csv").read_bytes())
        self.assertEqual(self.path("1.mtx").read_bytes(), self.path("2.mtx").read_bytes())

    def test_places_of_grids_give_their_points(self):
        """What a solver adapts or moves is evaluated again, also on cages that the grid refines first."""
        pyramid = self.path("pyramid.obj", "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nv 0 0 2\nf 4 3 2 1\nf 1 2 5\nf 2 3 5\nf 3 4 5\nf 4 1 5\n")
        for cage in (WING / "wing_cage.obj", SAMPLES / "cages" / "torus.obj", pyramid):
            with self.subTest(cage=cage.name):
                for name in ("grid.vtm", "grid.cgns"):
                    self.assertEqual(run("grid", cage, "-o", self.path(name), "--points", 6).returncode, 0)
                zones = cgns_arrays(self.path("grid.cgns"), "UserDefinedData_t")
                for block, _, points, places, _ in vtk_blocks(self.path("grid.vtm")):
                    self.assertEqual(len(places), 4 if cage == pyramid else 3)
                    numpy.savetxt(self.path("places.csv"), numpy.column_stack(places), fmt="%.17g", delimiter=",")
                    self.eval(cage, "-o", self.path("points.csv"))
                    numpy.testing.assert_allclose(table(self.path("points.csv"))[:, :3], points, rtol=0, atol=1e-12 * abs(points).max())
                    for name, values in zip(("Face", "U", "V", "Sector"), places):
                        numpy.testing.assert_array_equal(zones[block][name], values)

    def test_cells_are_as_long_as_a_field_of_sizes_asks_for(self):
        cage, sizes = WING / "wing_cage.obj", self.path("sizes.csv", "x,y,z,size\n0,0,0,5\n0,200,0,20\n")
        report = self.report("grid", cage, "-o", self.path("grid.vtm"), "--points", 3, "--size-field", sizes, "--cage-unit", "cm")
        self.assertGreater(report["grid"]["cells"], self.report("grid", cage, "-o", self.path("coarse.vtm"), "--points", 3)["grid"]["cells"])
        reader = vtk.vtkXMLMultiBlockDataReader()
        reader.SetFileName(str(self.path("grid.vtm")))
        reader.Update()
        for b in range(reader.GetOutput().GetNumberOfBlocks()):
            block = reader.GetOutput().GetBlock(b)
            ni, nj, _ = block.GetDimensions()
            points = vtk_to_numpy(block.GetPoints().GetData()).reshape(nj, ni, 3)
            for axis in (0, 1):
                a, b = (numpy.take(points, range(k, points.shape[axis] - 1 + k), axis=axis) for k in (0, 1))
                near = numpy.linalg.norm(0.5 * (a + b), axis=-1) < numpy.linalg.norm(0.5 * (a + b) - (0, 2000, 0), axis=-1)
                # Middles by parameters, where sizes are asked for, are not quite those of cells.
                self.assertLessEqual((numpy.linalg.norm(b - a, axis=-1) / numpy.where(near, 50, 200)).max(), 1.05)
        for text, *parts in (("0,0,0,0\n", "line 1", "size is 0"), ("0,0,0\n", "3 numbers")):
            self.check_error(run("grid", cage, "-o", self.path("x.vtm"), "--size-field", self.path("bad.csv", text)), 2, "bad.csv", *parts)
        self.check_error(run("grid", cage, "-o", self.path("x.vtm"), "--size-field", self.path("tiny.csv", "0 0 0 1e-7")), 1, "memory")
        self.check_error(run("grid", cage, "-o", self.path("x.vtm"), "--size-field", sizes, "--levels", 2), 1, "--levels")

    def test_layers_have_the_places_they_grow_from(self):
        cage = WING / "wing_cage.obj"
        run("grid", cage, "-o", self.path("surface.vtm"), "--points", 6)
        for name in ("grid.vtm", "grid.cgns"):
            self.assertEqual(run("grid", cage, "-o", self.path(name), "--points", 6, "--layers", 3, "--layer-height", "1mm").returncode, 0)
        zones = cgns_arrays(self.path("grid.cgns"), "UserDefinedData_t")
        for (block, _, points, places, _), (_, _, layers, repeated, _) in zip(vtk_blocks(self.path("surface.vtm")), vtk_blocks(self.path("grid.vtm"))):
            self.assertEqual(len(layers), 4 * len(points))
            for name, values, values_of_layers in zip(("Face", "U", "V"), places, repeated):
                numpy.testing.assert_array_equal(numpy.tile(values, 4), values_of_layers)
                numpy.testing.assert_array_equal(zones[block][name], values)

    def test_refused(self):
        cage = SAMPLES / "cages" / "cube.obj"
        out = self.path("points.csv")
        for text, *parts in (("0,0.5\n", "line 1", "2 numbers", "3 to 4"), ("0,0.5,0.5\n0,0.5,0.5,0\n", "line 2", "4 numbers"), ("0,0.5,nan\n", "line 1", "nan"),
                             ("nan,0,0\n", "line 1", "nan"), ("# none\nface,u,v\n6,0,0\n", "line 3", "no face 6"), ("0.5,0,0\n", "face 0.5"),
                             ("0,0,1.5\n", "line 1", "1.5"), ("0,0,0,1\n", "line 1", "sector 1"), ("", "no numbers"), ("0,0,0,\n", "line 1"), ("0 0 0x\n", "0x")):
            with self.subTest(text=text):
                self.check_error(run("eval", cage, "--at-file", self.path("places.csv", text), "-o", out), 2, "places.csv", *parts)
                self.assertFalse(out.exists())
        places = self.path("places.csv", "0,0.5,0.5\n1\t0.5 0.5\n")
        self.check_error(run("eval", cage, "--at-file", self.path("none.csv"), "-o", out), 2, "none.csv")
        self.check_error(run("eval", cage, "--at-file", places), 1, "--output")
        self.check_error(run("eval", cage), 1, "--at-file")
        self.check_error(run("eval", cage, "--at-file", places, "--adjoint", out), 1, "--gradient")
        self.check_error(run("eval", cage, "--at-file", places, "--gradient", self.path("g.csv", "1,2,3\n"), "--adjoint", out), 2, "g.csv", "1 rows", "2 places")
        self.check_error(run("eval", cage, "--at-file", places, "-o", places), 1, "input")
        self.check_error(run("eval", cage, "--at-file", places, "-o", self.path("points.txt")), 1, ".csv")
        sector = self.path("sector.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 2 0 0\nv 2 1 0.3\nf 1 2 3 4\nf 2 5 6 3\n#patchwright sector 1 0 90\n")
        self.check_error(run("eval", sector, "--at-file", places, "--jacobian", self.path("j.mtx")), 2, "sector.obj", "tags of sectors")


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
