"""Cages as arrays, limit points, masks and Jacobians, against closed forms, the command line and differences."""
import json
import math
import pathlib
import re
import shutil
import subprocess

from module import CUBE_FACES, CUBE_POINTS, PATCHWRIGHT, SAMPLES, WING, ModuleTest, main, np, pw, random_places

CORNERS = [[0, 0], [1, 0], [1, 1], [0, 1]]


class Arrays(ModuleTest):
    def test_round_trip(self):
        cage = pw.Cage(CUBE_POINTS, CUBE_FACES, creases=[[0, 1], [1, 3]], crease_sharpness=[2.5, np.inf], corners=[7],
                       pins=[4], groups=[0, 0, 1, -1, -1, -1], group_names=["low", "side"])
        self.assertTrue((cage.points == CUBE_POINTS).all())
        self.assertTrue((cage.faces == CUBE_FACES).all())
        edges, sharpness = cage.creases
        self.assertEqual({(*sorted(edge), s) for edge, s in zip(edges.tolist(), sharpness)},
                         {(0, 1, 2.5), (1, 3, math.inf)})
        self.assertEqual([list(a) for a in cage.corners], [[7], [math.inf]])
        self.assertEqual(list(cage.pins), [4])
        self.assertEqual(cage.groups[1], ["low", "side"])
        self.assertEqual(list(cage.groups[0]), [0, 0, 1, -1, -1, -1])
        self.assertEqual(cage.summary["creases"], 2)

    def test_file(self):
        cage = pw.Cage.read(WING / "wing_cage.obj")
        cage.write(self.folder / "copy.obj", unit="in")
        copy = pw.Cage.read(self.folder / "copy.obj", unit="in")
        np.testing.assert_allclose(copy.points, cage.points, rtol=1e-15)
        self.assertTrue((copy.faces == cage.faces).all())
        self.assertEqual(copy.summary, cage.summary)

    def test_points_are_no_copy(self):
        given = CUBE_POINTS.copy()
        cage = pw.Cage(given, CUBE_FACES)
        view = cage.points
        for array in (given, view, cage.points):
            self.assertTrue(np.shares_memory(array, cage.points))
        given[0] = [-3, -3, -3]
        self.assertEqual(list(cage.points[0]), [-3, -3, -3])
        np.testing.assert_array_equal(cage.evaluate([0], [[0, 0]]), pw.Cage(given.copy(), CUBE_FACES).evaluate([0], [[0, 0]]))
        cage.points *= 2
        self.assertEqual(list(view[0]), [-6, -6, -6])
        self.assertEqual(list(given[0]), [-6, -6, -6])
        given.shape = (4, 6)  # of the caller's array alone
        self.assertEqual(cage.points.shape, (8, 3))
        view.shape = (6, 4)
        self.assertEqual(cage.copy().points.shape, (8, 3))
        address = view.ctypes.data
        del cage, given
        self.assertEqual(view[0, 0], -6)  # the view keeps what it looks at
        self.assertEqual(view.ctypes.data, address)
        # Results of the library are not copied either.
        points = pw.Cage.read(WING / "wing_cage.obj").points
        self.assertFalse(points.flags.owndata)
        self.assertGreater(len(points), 0)

    def test_what_is_copied(self):
        fixed = CUBE_POINTS.copy()
        fixed.flags.writeable = False
        for given in (fixed, CUBE_POINTS.astype(np.float32), np.asfortranarray(CUBE_POINTS), CUBE_POINTS.copy()[::-1], CUBE_POINTS.tolist()):
            cage = pw.Cage(given, CUBE_FACES)
            self.assertFalse(np.shares_memory(np.asarray(given), cage.points))
            cage.points[0] = 9
            self.assertTrue((np.asarray(given) != 9).all())
        # An inner vertex with two faces goes: there are other points.
        points = np.array([[0, 0, 0], [2, 0, 0], [2, 2, 0], [0, 2, 0], [1, 0, 0], [1, 2, 0], [1, 1, 0]], float)
        less = pw.Cage(points, [[0, 4, 6, 5, 3], [4, 1, 2, 5, 6]])
        self.assertEqual(less.points.tolist(), points[:6].tolist())
        self.assertFalse(np.shares_memory(points, less.points))

    def test_faces_are_no_copy(self):
        cage = pw.Cage(CUBE_POINTS.copy(), CUBE_FACES)
        faces = cage.faces
        self.assertTrue(np.shares_memory(faces, cage.faces))
        self.assertTrue(np.shares_memory(faces, cage.copy().faces))
        with self.assertRaises(ValueError):
            faces[0, 0] = 1
        del cage
        self.assertEqual(faces.tolist(), CUBE_FACES.tolist())

    def test_copies_are_independent(self):
        cage = pw.Cage(CUBE_POINTS.copy(), CUBE_FACES)
        other, third = cage.copy(), cage.with_points(CUBE_POINTS + 1)
        cage.points[:] = 0
        self.assertTrue((other.points == CUBE_POINTS).all())
        self.assertTrue((third.points == CUBE_POINTS + 1).all())

    def test_polygons(self):
        tetrahedron = pw.Cage([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]])
        sizes, vertices = tetrahedron.polygons
        self.assertEqual(list(sizes), [3, 3, 3, 3])
        self.assertEqual(list(vertices[:3]), [0, 2, 1])
        with self.assertRaisesRegex(pw.UsageError, "face 0 is no quad"):
            tetrahedron.faces
        mixed = pw.Cage([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [2, 0, 0]], [[0, 1, 2, 3], [1, 4, 2]])
        self.assertEqual(list(mixed.polygons[0]), [4, 3])
        same = pw.Cage(mixed.points, mixed.polygons[1], sizes=mixed.polygons[0])
        self.assertEqual(list(same.polygons[1]), list(mixed.polygons[1]))


class LimitSurface(ModuleTest):
    def test_corners_of_a_cube(self):
        # Valence 3, smooth: (9 v + 4 sum(e) + sum(f)) / 24 = 12/24 of the corner.
        cage = pw.Cage(CUBE_POINTS, CUBE_FACES)
        points = cage.evaluate(np.repeat(np.arange(6), 4), CORNERS * 6)
        np.testing.assert_allclose(points, 0.5 * CUBE_POINTS[CUBE_FACES.reshape(-1)], atol=1e-14)

    def test_sphere_is_approached_by_fit(self):
        # Interpolating the vertices of a refined cube on the sphere of radius 1: linear, by masks alone.
        cage = pw.Cage(CUBE_POINTS, CUBE_FACES).refined(3)
        directions = cage.points / np.linalg.norm(cage.points, axis=1, keepdims=True)
        first = {}
        for face, row in enumerate(cage.faces):
            for corner, vertex in enumerate(row):
                first.setdefault(int(vertex), (face, CORNERS[corner]))
        places = [first[v] for v in range(len(directions))]
        masks = cage.masks([f for f, _ in places], [uv for _, uv in places])
        import scipy.sparse.linalg
        solved = scipy.sparse.linalg.spsolve(masks.tocsc(), directions)
        sphere = cage.with_points(solved)
        faces, uv = random_places(2000, len(cage.faces), 1)
        radii = np.linalg.norm(sphere.evaluate(faces, uv), axis=1)
        self.assertLess(abs(radii - 1).max(), 5e-4)
        normals = np.cross(*np.moveaxis(sphere.evaluate(faces, uv, order=1)[:, 1:], 1, 0))
        points = sphere.evaluate(faces, uv)
        normals /= np.linalg.norm(normals, axis=1, keepdims=True)
        self.assertGreater((normals * points).sum(axis=1).min(), 0.999)

    def test_masks_give_the_points(self):
        for file in ("cages/cube_rim.obj", "cages/torus.obj", "wing/wing_cage.obj", "wing_tip/cage.obj"):
            cage = pw.Cage.read(SAMPLES / file)
            faces, uv = random_places(500, cage.summary["faces"], 2)
            for order, rows in ((0, 1), (1, 3), (2, 6)):
                masks = cage.masks(faces, uv, order=order)
                self.assertEqual(masks.shape, (500 * rows, len(cage.points)))
                values = cage.evaluate(faces, uv, order=order).reshape(-1, 3)
                scale = abs(values).max()
                np.testing.assert_allclose(masks @ cage.points, values, atol=1e-12 * scale)
                sums = np.asarray(masks.sum(axis=1)).reshape(500, rows)
                np.testing.assert_allclose(sums[:, 0], 1, atol=1e-12)
                np.testing.assert_allclose(sums[:, 1:], 0, atol=1e-9)
            self.assertTrue(masks.has_sorted_indices)

    def test_affine_invariance(self):
        cage = pw.Cage.read(WING / "wing_cage.obj")
        rng = np.random.default_rng(3)
        matrix, shift = rng.standard_normal((3, 3)), rng.standard_normal(3) * 1000
        faces, uv = random_places(300, cage.summary["faces"], 3)
        moved = cage.with_points(cage.points @ matrix + shift)
        np.testing.assert_allclose(moved.evaluate(faces, uv), cage.evaluate(faces, uv) @ matrix + shift, rtol=1e-10,
                                   atol=1e-8)

    def test_jacobian_is_the_difference(self):
        for file in ("cages/cube_rim.obj", "wing/wing_cage.obj"):
            cage = pw.Cage.read(SAMPLES / file)
            faces, uv = random_places(40, cage.summary["faces"], 4)
            jacobian = cage.jacobian(faces, uv)
            self.assertEqual(jacobian.shape, (3 * 40, 3 * len(cage.points)))
            self.assertEqual(jacobian.getformat(), "csr")
            rng = np.random.default_rng(5)
            for variable in rng.integers(0, cage.points.size, 30):
                step = np.zeros(cage.points.size)
                step[variable] = 1e-3 * np.ptp(cage.points)
                step = step.reshape(-1, 3)
                difference = (cage.with_points(cage.points + step).evaluate(faces, uv)
                              - cage.with_points(cage.points - step).evaluate(faces, uv)) / (2 * step.max())
                np.testing.assert_allclose(jacobian[:, int(variable)].toarray().reshape(-1, 3), difference, atol=1e-7)

    def test_derivatives_are_differences(self):
        cage = pw.Cage.read(SAMPLES / "cages" / "torus.obj")
        faces, uv = random_places(100, cage.summary["faces"], 6)
        uv, step = 0.1 + 0.8 * uv, 1e-4
        at = cage.evaluate(faces, uv, order=2)
        for axis in (0, 1):
            move = step * np.eye(2)[axis]
            before, after = cage.evaluate(faces, uv - move, order=1), cage.evaluate(faces, uv + move, order=1)
            scale = abs(at[:, 1:]).max()
            np.testing.assert_allclose((after[:, 0] - before[:, 0]) / (2 * step), at[:, 1 + axis], atol=1e-7 * scale)
            np.testing.assert_allclose((after[:, 1 + axis] - before[:, 1 + axis]) / (2 * step), at[:, 3 + 2 * axis],
                                       atol=1e-6 * scale)

    def test_the_command_line_says_the_same(self):
        file = SAMPLES / "cages" / "cube_rim.obj"
        cage = pw.Cage.read(file)
        faces, uv = random_places(20, cage.summary["faces"], 7)
        uv[:4] = CORNERS
        arguments = [f"--at={f},{u!r},{v!r}" for f, (u, v) in zip(faces, uv.tolist())]
        told = subprocess.run([PATCHWRIGHT, "eval", str(file), *arguments, "--json", "-"], capture_output=True,
                              text=True, check=True)
        values, kinds = cage.evaluate(faces, uv, order=2), cage.smoothness(faces, uv)
        masks = cage.masks(faces, uv)
        for i, place in enumerate(json.loads(told.stdout)):
            self.assertEqual(place["position"], values[i, 0].tolist())
            for row, name in enumerate(("du", "dv", "duu", "duv", "dvv"), 1):
                self.assertEqual(place.get(name, [0, 0, 0]), values[i, row].tolist())
            self.assertEqual(place["exists"], ["position only", "tangent plane only", "derivatives"][kinds[i]])
            mask = masks[i].toarray()[0]
            np.testing.assert_allclose(mask[place["mask"]["vertices"]], place["mask"]["position"], atol=1e-16)

    def test_refinement_keeps_the_limit(self):
        cage = pw.Cage.read(SAMPLES / "cages" / "genus2.obj")
        fine = cage.refined()
        faces, uv = random_places(200, cage.summary["faces"], 8)
        child = np.array([[0, 3], [1, 2]])[(uv[:, 0] > 0.5).astype(int), (uv[:, 1] > 0.5).astype(int)]
        np.testing.assert_allclose(fine.evaluate(4 * faces + child, 2 * uv % 1), cage.evaluate(faces, uv), atol=1e-10)

    def test_rules_at_creases(self):
        """A parabola over four faces: its second derivative at the border is 2 with a runout, 0 without."""
        i, j = np.meshgrid(np.arange(5), np.arange(4), indexing="ij")
        height = i**2 - np.where((i == 0) | (i == 4), 0.0, 1 / 3)
        points = np.stack([i, j, height], axis=-1).reshape(-1, 3).astype(float)
        at = lambda a, b: 4 * a + b
        faces = [[at(a, b), at(a + 1, b), at(a + 1, b + 1), at(a, b + 1)] for a in range(4) for b in range(3)]
        for rule, second in (("catmull-clark", 0.0), ("runout", 2.0)):
            cage = pw.Cage(points, faces, boundary_corners=True, crease_rule=rule)
            self.assertEqual(cage.crease_rule, rule)
            self.assertEqual(cage.copy().crease_rule, rule)
            rows = cage.evaluate([1], [[0.0, 0.5]], order=2)
            self.assertAlmostEqual(rows.reshape(-1, 3)[3, 2], second, places=12)
            cage.write(self.folder / "rule.obj")
            self.assertEqual(pw.Cage.read(self.folder / "rule.obj").crease_rule, rule)
        with self.assertRaisesRegex(pw.UsageError, "crease_rule: 'sharp' is none of catmull-clark, runout"):
            pw.Cage(points, faces, crease_rule="sharp")

    def test_tagged_sectors(self):
        # A square whose corner at the origin spans 90 degrees and faces up: points around it are adjusted.
        text = "v 0 0 0\nv 1 0 0.3\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n#patchwright sector 0 0 90 0 0 1\n"
        (self.folder / "square.obj").write_text(text)
        cage = pw.Cage.read(self.folder / "square.obj")
        with self.assertRaisesRegex(pw.UsageError, "sectors"):
            cage.masks([0], [[0.5, 0.5]])
        rows = cage.evaluate([0], [[0, 0]], order=1)[0]
        normal = np.cross(rows[1], rows[2])
        np.testing.assert_allclose(normal / np.linalg.norm(normal), [0, 0, 1], atol=1e-12)

    def test_threads_change_no_bit(self):
        cage = pw.Cage.read(SAMPLES / "cages" / "genus2.obj")
        faces, uv = random_places(20000, cage.summary["faces"], 9)
        results = []
        for threads in (1, 2, 0):
            pw.set_thread_count(threads)
            results.append((cage.evaluate(faces, uv, order=2), cage.masks(faces, uv)))
        for values, masks in results[1:]:
            self.assertTrue((values == results[0][0]).all())
            self.assertEqual((masks != results[0][1]).nnz, 0)


class Package(ModuleTest):
    def test_stubs_name_what_there_is(self):
        import ast
        import inspect
        stubs = ast.parse((pathlib.Path(pw.__file__).parent / "_core.pyi").read_text())
        functions = {node.name for node in stubs.body if isinstance(node, ast.FunctionDef)}
        classes = {node.name: {f.name for f in node.body if isinstance(f, ast.FunctionDef)} for node in stubs.body
                   if isinstance(node, ast.ClassDef)}
        there = {name for name in dir(pw._core) if not name.startswith("_")}
        self.assertEqual(functions | classes.keys(), there)
        for name, members in classes.items():
            self.assertEqual(members, {m for m in dir(getattr(pw._core, name)) if not m.startswith("_")})
        self.assertTrue((pathlib.Path(pw.__file__).parent / "py.typed").exists())
        for name in pw.__all__:
            value = getattr(pw, name)
            self.assertTrue(inspect.getdoc(value), name)

    def test_types(self):
        if shutil.which("mypy") is None:
            self.skipTest("SKIPPED: no mypy")
        done = subprocess.run(["mypy", "--strict", "--ignore-missing-imports", "--cache-dir", str(self.folder),
                               pathlib.Path(pw.__file__).parent], capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stdout)

    def test_version(self):
        told = subprocess.run([PATCHWRIGHT, "--version"], capture_output=True, text=True, check=True)
        self.assertEqual(told.stdout.split()[-1], pw.__version__)


if __name__ == "__main__":
    main()
