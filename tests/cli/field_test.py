"""Fields (--field) and pictures (--picture) as VTK reads them: against planes whose distance is known, and sample models.

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

from command_line import CliTest, run, SAMPLES, WING

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


class Pictures(CliTest):
    def picture(self, *arguments, size="320x200"):
        """Rows of red, green, blue, from the top."""
        file = self.path("a.png")
        result = run(*arguments, "--picture", file, "--picture-size", size)
        self.assertEqual(result.returncode, 0, result.stderr)
        reader = vtk.vtkPNGReader()
        reader.SetFileName(str(file))
        reader.Update()
        image = reader.GetOutput()
        width, height, _ = image.GetDimensions()
        self.assertEqual(f"{width}x{height}", size)
        pixels = vtk_to_numpy(image.GetPointData().GetScalars()).reshape(height, width, 4)[::-1].astype(int)
        self.assertEqual(pixels[..., 3].min(), 255)
        return pixels[..., :3]

    def planes_from(self, view, layer="deviation"):
        flat = self.path("flat.obj", "v 0 0 0\nv 100 0 0\nv 100 50 0\nv 0 50 0\nf 1 2 3 4\n")
        turned = self.path("turned.obj", "v 0 0 0\nv 100 0 1\nv 100 50 1\nv 0 50 0\nf 1 2 3 4\n")
        return self.picture("compare", flat, turned, "--picture-view", view, "--picture-layer", layer)

    def test_a_plane_from_above(self):
        """100 x 50 mm, seen from above: in the middle, its deviation from 0 on the left to red on the right."""
        pixels = self.planes_from("top")
        rows, columns = np.nonzero((pixels != 255).any(axis=2))
        width, height = np.ptp(columns) + 1, np.ptp(rows) + 1
        self.assertAlmostEqual(width / height, 2.0, delta=0.06)
        self.assertAlmostEqual(width, 0.94 * 320, delta=4)
        middle = pixels[100]
        left, right = middle[columns.min() + 8], middle[columns.max() - 8]
        self.assertGreater(left[2], 2 * left[0])
        self.assertGreater(right[0], 2 * right[2])
        self.assertGreater(middle[160][1], middle[160][2])  # green
        edge_on = self.planes_from("front")
        rows = np.nonzero((edge_on != 255).any(axis=(1, 2)))[0]
        self.assertLess(np.ptp(rows), 14)  # 1 mm of 50

    def test_layers_of_a_sphere_like_cage(self):
        cube = SAMPLES / "cages" / "cube.obj"
        seen = {layer: self.picture("export", cube, "-o", self.path("a.step"), "--picture-layer", layer)
                for layer in ("plain", "patches", "curvature", "zebra")}
        drawn = {layer: pixels[(pixels != 255).any(axis=2)] for layer, pixels in seen.items()}
        spread = {layer: np.median(np.ptp(colours, axis=1)) for layer, colours in drawn.items()}
        self.assertLess(spread["plain"], 16)
        self.assertGreater(spread["patches"], 30)
        self.assertGreater(np.mean(drawn["curvature"][:, 2] > drawn["curvature"][:, 0]), 0.9)  # bends away all over
        dark, bright = drawn["zebra"].max(axis=1) < 50, drawn["zebra"].min(axis=1) > 200
        self.assertGreater(np.mean(dark | bright), 0.75)
        self.assertGreater(min(np.mean(dark), np.mean(bright)), 0.15)

    def share(self, pixels, predicate):
        return predicate(*np.moveaxis(pixels, 2, 0)).mean()

    def test_a_cage_from_a_direction_and_near(self):
        """The sample cube is 100 mm wide; its cage, half as wide as what is seen, covers a quarter."""
        cube = SAMPLES / "cages" / "cube.obj"
        out = self.path("a.obj")
        for view in (["--picture-view", "front"], ["--picture-direction=0,0,2"]):
            pixels = self.picture("subdivide", cube, "-n", "0", "-o", out, "--picture-zoom", "0,0,0,200", *view, size="200x200")
            self.assertAlmostEqual(self.share(pixels, lambda r, g, b: r + g + b < 750), 0.25, delta=0.01)
        pixels = self.picture("subdivide", cube, "-n", "0", "-o", out, "--picture-zoom", "0,0,0,20", "--picture-view", "top", size="200x200")
        self.assertEqual(self.share(pixels, lambda r, g, b: r + g + b < 750), 1)
        moved = self.picture("subdivide", cube, "-n", "0", "-o", out, "--picture-zoom=-50,0,0,200", "--picture-view", "top", size="200x200")
        self.assertEqual(self.share(moved[:, :99], lambda r, g, b: r + g + b < 750), 0)

    def test_edges_of_cages(self):
        """Green where sharp, red at a border, and thin elsewhere."""
        green, red = (lambda r, g, b: (g > r + 60) & (g > b + 40)), (lambda r, g, b: (r > 150) & (g < 80) & (b < 80))
        seen = {name: self.picture("subdivide", SAMPLES / "cages" / f"{name}.obj", "-n", "1", "-o", self.path("a.obj"), "--picture-layer", "plain")
                for name in ("cube", "cube_rim", "dish")}
        self.assertGreater(self.share(seen["cube_rim"], green), 0.005)
        self.assertGreater(self.share(seen["dish"], red), 0.005)
        for name, colour in (("cube", green), ("cube", red), ("cube_rim", red), ("dish", green)):
            self.assertEqual(self.share(seen[name], colour), 0, name)

    def test_grids(self):
        """Blocks, lines, red sides; a surface and its layers look alike."""
        cube = SAMPLES / "cages" / "cube.obj"
        seen = [self.picture("grid", cube, "-o", self.path("a.xyz"), "--points", "9", *layers)
                for layers in ([], ["--layers", "2", "--layer-height", "1mm"])]
        np.testing.assert_array_equal(*seen)
        self.assertGreater(self.share(seen[0], lambda r, g, b: (r > 150) & (g < 80) & (b < 80)), 0.005)
        self.assertGreater(self.share(seen[0], lambda r, g, b: np.maximum(np.maximum(r, g), b) < 90), 0.02)
        metres = self.picture("grid", cube, "-o", self.path("a.xyz"), "--points", "9", "--unit", "m", "--picture-zoom", "0,0,0,0.2")
        near = self.picture("grid", cube, "-o", self.path("a.xyz"), "--points", "9", "--picture-zoom", "0,0,0,200")
        np.testing.assert_array_equal(metres, near)

    def test_made_cages(self):
        pixels = self.picture("cage", WING / "wing.igs", "-o", self.path("a.obj"))
        self.assertGreater(self.share(pixels, lambda r, g, b: (g > r + 60) & (g > b + 40)), 0.001)  # trailing edge, root

    def test_refused(self):
        for arguments in (["--picture", self.path("a.jpg")], ["--picture", self.path("a.png"), "--picture-size", "0x5"],
                          ["--picture", self.path("a.png"), "--picture-view", "inside"],
                          ["--picture", self.path("a.png"), "--picture-direction", "0,0,0"], ["--picture", self.path("a.png"), "--picture-direction", "1,2"],
                          ["--picture", self.path("a.png"), "--picture-view", "top", "--picture-direction", "0,0,1"],
                          ["--picture", self.path("a.png"), "--picture-zoom", "0,0,0,0"], ["--picture", self.path("a.png"), "--picture-zoom", "0,0,0,x"]):
            self.check_refused(["inspect", WING / "wing.step", *arguments], 1, "--picture")


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
