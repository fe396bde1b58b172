"""Fields (--field) as VTK reads them: against planes whose distance is known, and the demo's wing.

Usage: field_test.py PATCHWRIGHT SAMPLES_DIR [unittest arguments]
Exit code 77: VTK is not installed.
"""
import sys
import unittest

try:
    import numpy as np
    import vtk
    from vtk.util.numpy_support import vtk_to_numpy
except ImportError:
    print("SKIPPED: python3-vtk9 is not installed")
    sys.exit(77)

from command_line import CliTest, run, WING

SLOPE = 0.01


def read_vtp(file):
    reader = vtk.vtkXMLPolyDataReader()
    reader.SetFileName(str(file))
    reader.Update()
    data = reader.GetOutput()
    points = data.GetPointData()
    arrays = {points.GetArrayName(i): vtk_to_numpy(points.GetArray(i)) for i in range(points.GetNumberOfArrays())}
    return data, vtk_to_numpy(data.GetPoints().GetData()), arrays


def read_glb(file):
    """The surface and the lines."""
    reader = vtk.vtkGLTFReader()
    reader.SetFileName(str(file))
    reader.Update()
    blocks = []
    walk = reader.GetOutput().NewIterator()
    while not walk.IsDoneWithTraversal():
        blocks.append(walk.GetCurrentDataObject())
        walk.GoToNextItem()
    return blocks


class Fields(CliTest):
    def planes(self):
        """z = 0 and, 100 mm wide, z = SLOPE x."""
        text = "v -100 -100 0\nv 200 -100 0\nv 200 200 0\nv -100 200 0\nf 1 2 3\nf 1 3 4\n"
        turned = f"v 0 0 0\nv 100 0 {100 * SLOPE}\nv 100 100 {100 * SLOPE}\nv 0 100 0\nf 1 2 3\nf 1 3 4\n"
        return self.path("flat.obj", text), self.path("turned.obj", turned)

    def test_planes(self):
        file = self.path("a.vtp")
        result = run("compare", *self.planes(), "--input-unit", "mm", "--field", file)
        self.assertEqual(result.returncode, 0, result.stderr)
        data, points, arrays = read_vtp(file)
        faces = vtk_to_numpy(data.GetCellData().GetArray("face"))
        self.assertEqual(data.GetNumberOfLines(), np.count_nonzero(faces == -1))
        self.assertGreater(data.GetNumberOfLines(), 0)
        self.assertGreater(data.GetNumberOfPolys(), 1000)
        surface = slice(0, len(points) - data.GetLines().GetNumberOfConnectivityIds())
        np.testing.assert_allclose(arrays["deviation"][surface], points[surface, 2], atol=1e-6)
        self.assertAlmostEqual(arrays["deviation"].max(), 100 * SLOPE, places=6)
        np.testing.assert_allclose(arrays["normal angle [degrees]"][surface], np.degrees(np.arctan(SLOPE)), rtol=1e-5)
        np.testing.assert_allclose(arrays["curvature"], 0, atol=1e-9)
        np.testing.assert_allclose(arrays["other curvature"], 0, atol=1e-9)
        triangles = vtk.vtkTriangleFilter()
        triangles.SetInputData(data)
        triangles.PassLinesOff()
        mass = vtk.vtkMassProperties()
        mass.SetInputConnection(triangles.GetOutputPort())
        self.assertAlmostEqual(mass.GetSurfaceArea(), 1e4 * np.hypot(1, SLOPE), places=3)

    def test_glb_in_metres_and_colours(self):
        file = self.path("a.glb")
        self.assertEqual(run("compare", *self.planes(), "--tolerance", "0.5mm", "--field", file).returncode, 3)
        surface, lines = read_glb(file)
        points = vtk_to_numpy(surface.GetPoints().GetData())
        np.testing.assert_allclose(points.max(axis=0), (0.1, 0.1 * SLOPE, 0), atol=1e-7)  # y is up
        arrays = surface.GetPointData()
        np.testing.assert_allclose(vtk_to_numpy(arrays.GetArray("_DEVIATION")), 1000 * points[:, 1], atol=1e-4)
        colours = vtk_to_numpy(arrays.GetArray("COLOR_0"))
        low, high = colours[points[:, 1].argmin()], colours[points[:, 1] > 0.0005][0]
        self.assertGreater(low[2], low[0])   # blue
        self.assertGreater(high[0], high[2])  # red from the tolerance on
        self.assertGreater(lines.GetNumberOfLines(), 10)

    def test_wing_in_inches(self):
        file = self.path("a.vtp")
        report = self.report("convert", WING / "wing.igs", "--cage", WING / "wing_cage.obj", "-o", self.path("a.step"), "--field", file)
        data, points, arrays = read_vtp(file)
        most = report["deviation"]["output_to_input"]["bound"]
        self.assertLessEqual(arrays["deviation"].max(), most)
        self.assertGreater(arrays["deviation"].max(), 0.5 * report["deviation"]["output_to_input"]["max"])
        self.assertEqual(set(np.unique(vtk_to_numpy(data.GetCellData().GetArray("face")))), {-1, *range(report["solid"]["faces"])})
        low, high = report["solid"]["bounds"]["min"], report["solid"]["bounds"]["max"]
        np.testing.assert_allclose([points.min(axis=0), points.max(axis=0)], [low, high], atol=2e-3 * report["input"]["diagonal"])

    def test_refused(self):
        self.check_refused(["compare", *self.planes(), "--field", self.path("a.vtk")], 1, "--field", ".vtp or .glb")


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
