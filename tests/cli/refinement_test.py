"""Grids refined by a solution, read back by VTK.

Usage: refinement_test.py PATCHWRIGHT SAMPLES_DIR [unittest arguments]
"""
import sys
import unittest

import numpy
import vtk
from vtk.util.numpy_support import vtk_to_numpy

from command_line import SAMPLES, CliTest, run
from eval_test import vtk_blocks
from vtu_test import vtu_of, write_vtu

TORUS = SAMPLES / "cages" / "torus.obj"


def read_vtu(file):
    reader = vtk.vtkXMLUnstructuredGridReader()
    reader.SetFileName(str(file))
    reader.Update()
    return reader.GetOutput()


def points_of(grid):
    return vtk_to_numpy(grid.GetPoints().GetData())


class Sensor(CliTest):
    def grid(self, *arguments, cage=TORUS):
        return self.report("grid", cage, "-o", self.path("grid.vtm"), *arguments)["grid"]

    def solution(self, function, name="field.vtu", points=33, **options):
        """Values on the points of an earlier grid, of all blocks, as a solver writes them."""
        self.grid("--points", points)
        at = numpy.concatenate([p for _, p, _ in vtk_blocks(self.path("grid.vtm"))])
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
        spread = numpy.ptp(pressure(numpy.concatenate([p for _, p, _ in vtk_blocks(self.path("grid.vtm"))])))
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


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
