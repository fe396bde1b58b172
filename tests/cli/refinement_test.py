"""Grids refined by sizes and by a solution: whole lines, and single cells with hanging nodes, read back by VTK and the CGNS library.

Usage: refinement_test.py PATCHWRIGHT SAMPLES_DIR [unittest arguments]
"""
import ctypes
import ctypes.util
import re
import shutil
import subprocess
import sys
import unittest

import numpy
import vtk
from vtk.util.numpy_support import vtk_to_numpy

from command_line import SAMPLES, WING, CliTest, run
from eval_test import table
from grid_files import cgns_arrays, vtk_blocks
from vtu_test import vtu_of, write_vtu

TORUS = SAMPLES / "cages" / "torus.obj"
DISH = SAMPLES / "cages" / "dish.obj"  # with a border
WING_CAGE = WING / "wing_cage.obj"
PYRAMID = "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nv 0 0 2\nf 4 3 2 1\nf 1 2 5\nf 2 3 5\nf 3 4 5\nf 4 1 5\n"


def read_vtu(file):
    reader = vtk.vtkXMLUnstructuredGridReader()
    reader.SetFileName(str(file))
    reader.Update()
    return reader.GetOutput()


def feature_edges(grid, **wanted):
    """How many edges there are of these kinds."""
    surface = vtk.vtkGeometryFilter()
    surface.SetInputData(grid)
    edges = vtk.vtkFeatureEdges()
    edges.SetInputConnection(surface.GetOutputPort())
    for kind in ("BoundaryEdges", "FeatureEdges", "NonManifoldEdges", "ManifoldEdges"):
        getattr(edges, f"{kind}{'On' if wanted.get(kind) else 'Off'}")()
    edges.Update()
    return edges.GetOutput().GetNumberOfCells()


def points_of(grid):
    return vtk_to_numpy(grid.GetPoints().GetData())


def corners_of(grid):
    cells = []
    for c in range(grid.GetNumberOfCells()):
        ids = grid.GetCell(c).GetPointIds()
        cells.append([ids.GetId(k) for k in range(ids.GetNumberOfIds())])
    return cells


def read_cgns(file):
    """Points, corners of cells and free sides of the only zone, as the CGNS library reads them."""
    library = ctypes.CDLL(ctypes.util.find_library("cgns"))

    def call(name, *arguments):
        pass_on = [a if isinstance(a, (int, bytes, ctypes.Array, type(None))) else ctypes.byref(a) for a in arguments]
        assert getattr(library, name)(*pass_on) == 0, name
    handle, count, kind, first, last, size, ignored = (ctypes.c_int() for _ in range(7))
    name, sizes = ctypes.create_string_buffer(33), (ctypes.c_int * 9)()
    call("cg_open", str(file).encode(), 0, handle)
    call("cg_zone_read", handle.value, 1, 1, name, sizes)
    axes = []
    for axis in "XYZ":
        values = (ctypes.c_double * sizes[0])()
        call("cg_coord_read", handle.value, 1, 1, f"Coordinate{axis}".encode(), 4, ctypes.c_int(1), ctypes.c_int(sizes[0]), values)
        axes.append(values[:])
    cells, free = [], []
    call("cg_nsections", handle.value, 1, 1, count)
    for section in range(1, count.value + 1):
        call("cg_section_read", handle.value, 1, 1, section, name, kind, first, last, ignored, ignored)
        call("cg_ElementDataSize", handle.value, 1, 1, section, size)
        nodes, ends = (ctypes.c_int * size.value)(), (ctypes.c_int * (last.value - first.value + 2))()
        bars, quads, polygons = 3, 7, 22
        if kind.value == polygons:
            call("cg_poly_elements_read", handle.value, 1, 1, section, nodes, ends, None)
        else:
            call("cg_elements_read", handle.value, 1, 1, section, nodes, None)
            ends = range(0, size.value + 1, {bars: 2, quads: 4}[kind.value])
        (free if kind.value == bars else cells).extend([node - 1 for node in nodes[a:b]] for a, b in zip(ends, ends[1:]))
    call("cg_close", handle.value)
    assert sizes[1] == len(cells)
    return numpy.column_stack(axes), cells, free


def sides_of(grid):
    """Both ends of each side of the cells, by corners alone."""
    ends = []
    for c in range(grid.GetNumberOfCells()):
        ids = grid.GetCell(c).GetPointIds()
        n = ids.GetNumberOfIds()
        ends += [(ids.GetId(k), ids.GetId((k + 1) % n)) for k in range(n)]
    return points_of(grid)[numpy.array(ends)]


class Sensor(CliTest):
    def grid(self, *arguments, cage=TORUS):
        return self.report("grid", cage, "-o", self.path("grid.vtm"), *arguments)["grid"]

    def solution(self, function, name="field.vtu", points=33, **options):
        """Values on the points of an earlier grid, of all blocks, as a solver writes them."""
        self.grid("--points", points)
        at = numpy.concatenate([p for _, _, p, _, _ in vtk_blocks(self.path("grid.vtm"))])
        return write_vtu(self.path(name), vtu_of(at, mach=0 * at[:, 0], pressure=function(at)), **options)

    def changes(self, function):
        """Largest change along a side of a cell."""
        worst = 0.0
        reader = vtk.vtkXMLMultiBlockDataReader()
        reader.SetFileName(str(self.path("grid.vtm")))
        reader.Update()
        for b in range(reader.GetOutput().GetNumberOfBlocks()):
            block = reader.GetOutput().GetBlock(b)
            ni, nj, _ = block.GetDimensions()
            values = function(points_of(block)).reshape(nj, ni)
            worst = max(worst, abs(numpy.diff(values, axis=0)).max(), abs(numpy.diff(values, axis=1)).max())
        return worst

    def test_no_side_changes_by_more_than_the_share(self):
        def pressure(p):
            return numpy.tanh(p[:, 0] / 20) * 100
        field = self.solution(pressure)
        spread = numpy.ptp(pressure(numpy.concatenate([p for _, _, p, _, _ in vtk_blocks(self.path("grid.vtm"))])))
        start = self.grid("--points", 5)
        for share in (0.1, 0.03):
            fine = self.grid("--points", 5, "--sensor", field, "--sensor-array", "pressure", "--sensor-jump", share)
            self.assertGreater(fine["cells"], start["cells"])
            self.assertLess(self.changes(pressure), 1.25 * share * spread)  # of its linear reconstruction between points
            self.assertGreater(self.changes(pressure), 0.3 * share * spread)
        # The same as text, and 0.05 unless given.
        expected = self.grid("--points", 5, "--sensor", field, "--sensor-array", "pressure")
        at = points_of(read_vtu(field))
        numpy.savetxt(self.path("field.csv"), numpy.column_stack([at, pressure(at)]), delimiter=",", fmt="%.17g")
        self.assertEqual(self.grid("--points", 5, "--sensor", self.path("field.csv"), "--sensor-jump", 0.05), expected)
        # With sizes: what either asks for.
        sizes = self.path("sizes.csv")
        numpy.savetxt(sizes, numpy.column_stack([at, numpy.where(numpy.linalg.norm(at - at[0], axis=1) < 25, 1, 100)]), delimiter=",", fmt="%.17g")
        both = self.grid("--points", 5, "--sensor", field, "--sensor-array", "pressure", "--size-field", sizes)
        self.assertGreater(both["cells"], max(expected["cells"], self.grid("--points", 5, "--size-field", sizes)["cells"]))

    def test_a_shock_ends_at_the_smallest_cell(self):
        field = self.solution(lambda p: numpy.where(p[:, 0] < 7.3, 1.0, 2.0), points=17)
        cells = [self.grid("--points", 5, "--sensor", field, "--sensor-array", "pressure", "--smallest", length)["cells"] for length in ("4mm", "1mm", "0.25mm")]
        self.assertLess(cells[0], cells[1])
        self.assertLess(cells[1], cells[2])
        usual = self.grid("--points", 5, "--sensor", field, "--sensor-array", "pressure")["cells"]
        self.assertEqual(usual, self.grid("--points", 5, "--sensor", field, "--sensor-array", "pressure", "--smallest", "1e-3rel")["cells"])

    def test_refused(self):
        field = self.solution(lambda p: p[:, 0])
        out = self.path("x.vtm")
        self.check_error(run("grid", TORUS, "-o", out, "--sensor", field), 2, "field.vtu", "'mach', 'pressure'", "name one")
        self.check_error(run("grid", TORUS, "-o", out, "--sensor", field, "--sensor-array", "q"), 2, "no array 'q'")
        self.check_error(run("grid", TORUS, "-o", out, "--sensor", field, "--sensor-array", "mach", "--levels", 1), 1, "--sensor", "--levels")
        self.check_error(run("grid", TORUS, "-o", out, "--sensor", field, "--sensor-jump", 0), 1, "--sensor-jump")
        self.check_error(run("grid", TORUS, "-o", out, "--smallest", "1mm"), 1, "--smallest")
        self.check_error(run("grid", TORUS, "-o", out, "--sensor-array", "q"), 1, "--sensor-array")
        self.check_error(run("grid", TORUS, "-o", out, "--sensor", self.path("none.vtu")), 2, "none.vtu", "cannot be read")
        self.check_error(run("grid", TORUS, "-o", out, "--sensor", self.path("bad.csv", "1,2,3\n")), 2, "bad.csv", "3 numbers")
        self.assertFalse(out.exists())


class HangingNodes(CliTest):
    def sizes(self, points):
        """Small at one point, growing away from it."""
        size = 0.01 * numpy.ptp(points) + 0.15 * numpy.linalg.norm(points - points[0], axis=1)
        numpy.savetxt(self.path("sizes.csv"), numpy.column_stack([points, size]), delimiter=",", fmt="%.17g")
        return self.path("sizes.csv")

    def cages(self):
        yield self.path("pyramid.obj", PYRAMID)
        yield TORUS
        yield DISH
        yield WING_CAGE

    def surface_points(self, cage, points=9):
        self.assertEqual(run("grid", cage, "-o", self.path("start.vtm"), "--points", points).returncode, 0)
        return numpy.concatenate([p for _, _, p, _, _ in vtk_blocks(self.path("start.vtm"))])

    def grid(self, cage, name, form, sizes, *arguments):
        return self.report("grid", cage, "-o", self.path(name), "--points", 5, "--size-field", sizes, "--hanging-nodes", form, *arguments)["grid"]

    def test_polygons_are_watertight_and_places_give_the_points(self):
        for cage in self.cages():
            with self.subTest(cage=cage.name):
                sizes = self.sizes(self.surface_points(cage))
                figures = self.grid(cage, "grid.vtu", "polygons", sizes)
                grid = read_vtu(self.path("grid.vtu"))
                points = points_of(grid)
                self.assertEqual((grid.GetNumberOfPoints(), grid.GetNumberOfCells()), (figures["points"], figures["cells"]))
                self.assertEqual(len(numpy.unique(points, axis=0)), len(points))
                corners = numpy.array([grid.GetCell(c).GetNumberOfPoints() for c in range(grid.GetNumberOfCells())])
                self.assertEqual((corners - 4).sum(), figures["hanging_nodes"])
                self.assertEqual(feature_edges(grid, NonManifoldEdges=True), 0)
                border = feature_edges(grid, BoundaryEdges=True)
                inner = feature_edges(grid, ManifoldEdges=True)
                self.assertEqual(border > 0, cage == DISH)
                self.assertEqual(2 * inner + border, corners.sum())
                # Euler: 2 of a sphere, 0 of a torus, 1 of what has one border.
                euler = 0 if cage == TORUS else 2 - (border > 0)
                self.assertEqual(len(points) - inner - border + len(corners), euler)
                levels = vtk_to_numpy(grid.GetCellData().GetArray("level"))
                self.assertEqual(levels.max(), figures["levels"])
                self.assertGreater(levels.max() - levels.min(), 2)
                data = [grid.GetPointData().GetArray("cage " + name) for name in ("face", "u", "v", "sector")]
                places = [vtk_to_numpy(array) for array in data if array]
                numpy.savetxt(self.path("places.csv"), numpy.column_stack(places), fmt="%.17g", delimiter=",")
                self.assertEqual(run("eval", cage, "--at-file", self.path("places.csv"), "-o", self.path("points.csv")).returncode, 0)
                numpy.testing.assert_allclose(table(self.path("points.csv"))[:, :3], points, rtol=0, atol=1e-12 * abs(points).max())
                # CGNS holds the same, cells family by family as well.
                for form in ("quads", "polygons"):
                    self.grid(cage, "grid.cgns", form, sizes)
                    self.grid(cage, "grid.vtu", form, sizes)
                    there, cells, free = read_cgns(self.path("grid.cgns"))
                    numpy.testing.assert_array_equal(there, points)
                    self.assertTrue(cells == corners_of(read_vtu(self.path("grid.vtu"))))  # no list of all differences
                    self.assertEqual(len(free), border)
                zone, = cgns_arrays(self.path("grid.cgns"), "UserDefinedData_t").values()
                for name, values in zip(("Face", "U", "V", "Sector"), places):
                    numpy.testing.assert_array_equal(zone[name], values)

    def test_sizes_are_kept_and_neighbours_differ_by_one_level(self):
        points = self.surface_points(TORUS)
        sizes = self.sizes(points)
        for form in ("quads", "polygons"):
            self.grid(TORUS, f"{form}.vtu", form, sizes)
        quads, polygons = (read_vtu(self.path(f"{form}.vtu")) for form in ("quads", "polygons"))
        numpy.testing.assert_array_equal(points_of(quads), points_of(polygons))
        self.assertEqual({quads.GetCellType(c) for c in range(quads.GetNumberOfCells())}, {vtk.VTK_QUAD})
        self.assertEqual({polygons.GetCellType(c) for c in range(quads.GetNumberOfCells())}, {vtk.VTK_QUAD, vtk.VTK_POLYGON})
        sides = sides_of(quads)
        middles = sides.mean(axis=1)
        wanted = numpy.loadtxt(sizes, delimiter=",")
        nearest = [numpy.linalg.norm(wanted[:, :3] - m, axis=1).argmin() for m in middles]
        self.assertLess((numpy.linalg.norm(sides[:, 1] - sides[:, 0], axis=1) / wanted[nearest, 3]).max(), 1.05)
        levels = vtk_to_numpy(polygons.GetCellData().GetArray("level"))
        by_side = {}
        for c in range(polygons.GetNumberOfCells()):
            ids = polygons.GetCell(c).GetPointIds()
            n = ids.GetNumberOfIds()
            for k in range(n):
                by_side.setdefault(frozenset((ids.GetId(k), ids.GetId((k + 1) % n))), []).append(levels[c])
        self.assertEqual({len(beside) for beside in by_side.values()}, {2})
        self.assertEqual({abs(a - b) for a, b in by_side.values()}, {0, 1})
        # Cells of a torus, planar or not: the polygons' area is that of whole lines as fine.
        def area(grid):
            surface, triangles, mass = vtk.vtkGeometryFilter(), vtk.vtkTriangleFilter(), vtk.vtkMassProperties()
            surface.SetInputData(grid)
            triangles.SetInputConnection(surface.GetOutputPort())
            mass.SetInputConnection(triangles.GetOutputPort())
            return mass.GetSurfaceArea()
        self.path("even.csv", "0,0,0,1.5\n")
        self.report("grid", TORUS, "-o", self.path("even.vtu"), "--points", 5, "--size-field", self.path("even.csv"), "--hanging-nodes", "quads")
        exact = area(read_vtu(self.path("even.vtu")))
        self.assertAlmostEqual(area(polygons) / exact, 1.0, delta=0.02)

    def test_cgns(self):
        check = shutil.which("cgnscheck")
        if not check:
            self.skipTest("cgnscheck is not installed")
        for cage in self.cages():
            sizes = self.sizes(self.surface_points(cage))
            for form in ("polygons", "quads"):
                with self.subTest(cage=cage.name, form=form):
                    self.grid(cage, "grid.cgns", form, sizes, "--unit", "m")
                    result = subprocess.run([check, "-v", str(self.path("grid.cgns"))], capture_output=True, text=True, timeout=120)
                    found = [line for line in result.stdout.splitlines() if re.search("ERROR|WARNING", line, re.IGNORECASE)]
                    self.assertEqual((result.returncode, found), (0, []), result.stdout)

    def test_sensor_refines_cells(self):
        points = self.surface_points(TORUS, 65)
        field = write_vtu(self.path("field.vtu"), vtu_of(points, p=numpy.exp(-((points - points[0]) ** 2).sum(axis=1) / 0.1)), "binary", compressor="ZLib")
        lines = self.report("grid", TORUS, "-o", self.path("lines.vtm"), "--points", 5, "--sensor", field, "--smallest", "0.002rel")["grid"]
        local = self.report("grid", TORUS, "-o", self.path("local.vtu"), "--points", 5, "--sensor", field, "--smallest", "0.002rel", "--hanging-nodes", "polygons",
                            "--picture", self.path("local.png"), "--report", self.path("local.html"))["grid"]
        self.assertLess(local["cells"], lines["cells"])
        self.assertGreater(local["hanging_nodes"], 0)
        self.assertGreater(self.path("local.png").stat().st_size, 10000)

    def test_two_runs_and_any_threads_write_equal_bytes(self):
        sizes = self.sizes(self.surface_points(WING_CAGE))
        for threads in (1, 2, 2):
            self.grid(WING_CAGE, f"{threads}.vtu", "polygons", sizes, "--threads", threads)
        self.assertEqual(self.path("1.vtu").read_bytes(), self.path("2.vtu").read_bytes())

    def test_refused(self):
        sizes = self.path("sizes.csv", "0,0,0,5\n")
        with_sizes = ("--size-field", sizes, "--hanging-nodes", "quads")
        self.check_error(run("grid", TORUS, "-o", self.path("x.vtu"), "--hanging-nodes", "quads"), 1, "--hanging-nodes", "--size-field")
        self.check_error(run("grid", TORUS, "-o", self.path("x.vtu"), "--layers", 2, "--layer-height", "1mm", *with_sizes), 1, "--layers")
        for name in ("x.vtm", "x.xyz"):
            self.check_error(run("grid", TORUS, "-o", self.path(name), *with_sizes), 1, name, ".cgns or .vtu")
        self.check_error(run("grid", TORUS, "-o", self.path("x.vtu")), 1, "x.vtu", "--hanging-nodes")
        self.check_error(run("grid", TORUS, "-o", self.path("x.vtu"), "--size-field", sizes, "--hanging-nodes", "hexagons"), 1, "hexagons")
        self.check_error(run("grid", TORUS, "-o", self.path("x.vtu"), "--size-field", self.path("tiny.csv", "0 0 0 1e-7\n"), "--hanging-nodes", "quads"), 1, "memory")


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
