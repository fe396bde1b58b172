"""Files: results against the command line's JSON, errors, exchange of shapes, cancelling, and threads that go on."""
import json
import os
import pathlib
import re
import signal
import subprocess
import sys
import textwrap
import threading
import time

from module import CUBE_FACES, CUBE_POINTS, PATCHWRIGHT, SAMPLES, WING, ModuleTest, main, np, pw

import patchwright.testing

# What may differ between two runs, or tells where files are.
VARIES = {"seconds", "peak_memory_mb", "options", "file", "notices", "tool"}


def same(report):
    """The report without what may differ."""
    if isinstance(report, dict):
        return {key: same(value) for key, value in report.items() if key not in VARIES}
    return [same(value) for value in report] if isinstance(report, list) else report


class AsTheCommandLine(ModuleTest):
    def report(self, *arguments, code=0):
        file = self.folder / "report.json"
        result = subprocess.run([PATCHWRIGHT, *map(str, arguments), "--json", str(file)], capture_output=True, text=True)
        self.assertEqual(result.returncode, code, result.stderr)
        return json.loads(file.read_text())

    def check_same(self, result, report):
        mine, told = same(result.report), same(report)
        for level in (*mine.get("fit", {}).get("levels", []), *told.get("fit", {}).get("levels", [])):
            level.pop("seconds", None)
        self.assertEqual(mine, told)
        self.assertEqual(result.verdict.sentence if result.verdict else None,
                         report.get("verdict", {}).get("sentence"))

    def test_convert(self):
        a, b = self.folder / "a.step", self.folder / "b.step"
        report = self.report("convert", WING / "wing.igs", "--cage", WING / "wing_cage.obj", "-o", a, "--cage-out",
                             self.folder / "a.obj")
        result = pw.convert(WING / "wing.igs", b, cage=WING / "wing_cage.obj")
        self.assertTrue(result.met)
        self.check_same(result, report)
        self.assertEqual(a.read_bytes().replace(b"'a'", b"''"), b.read_bytes().replace(b"'b'", b"''"))
        result.cage.write(self.folder / "b.obj")
        self.assertEqual((self.folder / "a.obj").read_bytes(), (self.folder / "b.obj").read_bytes())
        self.assertLess(result.deviation_mm, 1e-4 * pw.read(WING / "wing.igs").diagonal)
        self.assertTrue(str(result).startswith(result.verdict.sentence))

    def test_a_miss_is_a_verdict(self):
        report = self.report("compare", WING / "wing.step", SAMPLES / "cages" / "cube.obj", "--tolerance", "1mm", code=3)
        result = pw.compare(WING / "wing.step", SAMPLES / "cages" / "cube.obj", tolerance=1)
        self.assertFalse(result.met)
        self.assertTrue(result.verdict.sentence.startswith("MISSED"))
        self.check_same(result, report)

    def test_compare_and_inspect(self):
        models = pw.read(WING / "wing.igs"), pw.read(WING / "wing.step")
        self.check_same(pw.compare(*models, tolerance="1e-4rel", samples=3000),
                        self.report("compare", WING / "wing.igs", WING / "wing.step", "--tolerance", "1e-4rel",
                                    "--samples", 3000))
        for model in models:
            self.check_same(pw.inspect(model), self.report("inspect", model.file))

    def test_export_fit_and_grid(self):
        cube = SAMPLES / "cages" / "cube_rim.obj"
        self.check_same(pw.export(cube, self.folder / "a.step", color="kind"),
                        self.report("export", cube, "-o", self.folder / "a.step", "--color", "kind"))
        self.check_same(pw.fit(self.folder / "a.step", cage=cube, tolerance="1e-3rel"),
                        self.report("fit", self.folder / "a.step", "--cage", cube, "--tolerance", "1e-3rel", "-o",
                                    self.folder / "fitted.obj"))
        self.check_same(pw.grid(cube, self.folder / "a.xyz", size=5, layers=3, layer_height="0.5mm"),
                        self.report("grid", cube, "-o", self.folder / "b.xyz", "--size", "5mm", "--layers", 3,
                                    "--layer-height", "0.5mm"))
        self.assertEqual((self.folder / "a.xyz").read_bytes(), (self.folder / "b.xyz").read_bytes())

    def test_fit_by_interpolation(self):
        words = ("--cage", WING / "wing_cage.obj", "--tolerance", "1e-2rel")
        report = self.report("fit", WING / "wing.igs", *words, "--interpolate", "-o", self.folder / "a.obj")
        result = pw.fit(WING / "wing.igs", cage=WING / "wing_cage.obj", tolerance="1e-2rel", interpolate=True)
        self.check_same(result, report)
        self.assertIn("interpolated_max", result.report["fit"]["levels"][0])
        result.cage.write(self.folder / "b.obj")
        self.assertEqual((self.folder / "a.obj").read_bytes(), (self.folder / "b.obj").read_bytes())
        for wrong in ({"refine": "global"}, {"symmetry": "y"}, {"max_levels": 0}):
            with self.assertRaisesRegex(pw.UsageError, "interpolate"):
                pw.fit(WING / "wing.igs", interpolate=True, **wrong)

    def test_grid_rules_and_sizes(self):
        cage, a, b = WING / "wing_cage.obj", self.folder / "a.xyz", self.folder / "b.xyz"
        rules = [{"at": [1000, 0, 0], "cells": 28, "spacing": "tanh", "near": "0.5mm"}]
        (self.folder / "rules.json").write_text(json.dumps(rules))
        sizes = np.array([[0, 0, 0, 5], [1000, 500, 0, 40.5]])
        np.savetxt(self.folder / "sizes.csv", sizes, delimiter=",")
        report = self.report("grid", cage, "-o", a, "--rules", self.folder / "rules.json", "--size-field", self.folder / "sizes.csv")
        for given in (rules, self.folder / "rules.json"):
            self.check_same(pw.grid(cage, b, rules=given, size_field=sizes), report)
            self.assertEqual(a.read_bytes(), b.read_bytes())
        self.assertGreater(report["grid"]["points"], pw.grid(cage, b).report["grid"]["points"])
        blocks = pw.grid_blocks(cage, rules=rules, size_field=sizes.tolist())
        self.assertEqual(sum(block.size for block in blocks.values()), 3 * report["grid"]["points"])
        for wrong, part in (({"rules": [{"at": [0, 0, 0], "size": 3}]}, "rules: rule 1 has an unknown key 'size'"),
                            ({"rules": [{"at": [0, 0, 1e301]}]}, "rule 1 has a coordinate above"),
                            ({"rules": [object()]}, "a sequence of dictionaries"), ({"rules": "{"}, "cannot be read"),
                            ({"size_field": [[0, 0, 0, -1]]}, "size 0 is -1; it must be positive"),
                            ({"size_field": []}, "rows of x, y, z and a size"),
                            ({"size_field": [[0, 0, 0, 1]], "levels": 1}, "do not go together"),
                            ({"sensor": [[0, 0, 0]]}, "sensor"), ({"sensor": [[0, 0, 0, 1]], "levels": 1}, "sensor and levels"),
                            ({"sensor": [[0, 0, 0, 1]], "sensor_jump": 0}, "sensor_jump")):
            with self.assertRaisesRegex(pw.PatchwrightError, part):
                pw.grid_blocks(cage, **wrong)

    def test_modes(self):
        """Cages that differ by two fields: two modes, which give the members again and are orthogonal on the surface."""
        cage = pw.Cage.read(WING / "wing_cage.obj")
        rng = np.random.default_rng(5)
        fields = rng.standard_normal((2, *cage.points.shape))
        members = [cage.with_points(cage.points + np.tensordot(weights, fields, 1)) for weights in rng.standard_normal((6, 2))]
        modes = pw.Modes(members, 4)
        self.assertEqual((len(modes), modes.shapes.shape, modes.weights.shape), (2, (2, *cage.points.shape), (6, 2)))
        for member, weights in zip(members, modes.weights):
            np.testing.assert_allclose(modes.member(weights).points, member.points, atol=1e-9)
        np.testing.assert_allclose(modes.member([]).points, np.mean([m.points for m in members], axis=0), atol=1e-9)
        self.assertAlmostEqual(modes.shares[-1], 1.0, 12)
        np.testing.assert_allclose(modes.weights.std(axis=0), modes.deviations, rtol=1e-9)
        for arguments in (([cage], 1), ([cage, 3], 1), (members, 0), ([cage, pw.Cage.read(SAMPLES / "cages" / "cube.obj")], 1)):
            with self.assertRaises(pw.UsageError):
                pw.Modes(*arguments)
        with self.assertRaises(pw.UsageError):
            modes.member([1, 2, 3])

    def test_grid_by_a_sensor_and_with_hanging_nodes(self):
        cage, a, b = WING / "wing_cage.obj", self.folder / "a.vtu", self.folder / "b.vtu"
        at = np.concatenate([block.reshape(-1, 3) for block in pw.grid_blocks(cage, points=17).values()])
        field = np.column_stack([at, np.tanh(at[:, 0] / 100 - 1)])
        np.savetxt(self.folder / "field.csv", field, delimiter=",", fmt="%.17g")
        report = self.report("grid", cage, "-o", self.folder / "a.xyz", "--sensor", self.folder / "field.csv", "--sensor-jump", 0.1)
        self.check_same(pw.grid(cage, self.folder / "b.xyz", sensor=field, sensor_jump=0.1), report)
        self.assertEqual((self.folder / "a.xyz").read_bytes(), (self.folder / "b.xyz").read_bytes())
        for form in ("polygons", "quads"):
            report = self.report("grid", cage, "-o", a, "--sensor", self.folder / "field.csv", "--smallest", "4mm", "--hanging-nodes", form)
            self.check_same(pw.grid(cage, b, sensor=field, smallest=4, hanging_nodes=form), report)
            self.assertEqual(a.read_bytes(), b.read_bytes())
        for wrong, part in (({}, "size_field or sensor"), ({"sensor": field, "layers": 2, "thickness": 1}, "layers"), ({"sensor": field, "hanging_nodes": "x"}, "polygons")):
            with self.assertRaisesRegex(pw.PatchwrightError, part):
                pw.grid(cage, b, **{"hanging_nodes": "quads", **wrong})

    def test_smooth_grid(self):
        """As the command line's; places give the points."""
        cage = pw.Cage.read(SAMPLES / "wing_fuselage" / "smooth.obj")
        report = self.report("grid", SAMPLES / "wing_fuselage" / "smooth.obj", "-o", self.folder / "a.xyz", "--size", "90mm", "--smooth")
        self.check_same(pw.grid(cage, self.folder / "b.xyz", size=90, smooth=True), report)
        self.assertEqual((self.folder / "a.xyz").read_bytes(), (self.folder / "b.xyz").read_bytes())
        blocks, places = (f(cage, size=90, smooth=True) for f in (pw.grid_blocks, pw.grid_places))
        for name, points in blocks.items():
            at = places[name]
            again = cage.evaluate(at.faces.ravel(), at.uv.reshape(-1, 2))
            np.testing.assert_allclose(again.reshape(-1, 3), points.reshape(-1, 3), atol=1e-9)
        with self.assertRaisesRegex(pw.UsageError, "smooth"):
            pw.grid(cage, self.folder / "c.vtu", smooth=True, hanging_nodes="quads", size_field=[[0, 0, 0, 9.0]])

    def test_morph(self):
        """Affine motions exactly; cages and forces as the command line's, and their work."""
        cage = pw.Cage.read(WING / "wing_cage.obj")
        rng = np.random.default_rng(11)
        low, high = cage.points.min(axis=0), cage.points.max(axis=0)
        points = low + (high - low) * rng.random((60, 3))
        matrix, shift = np.eye(3) + 0.1 * rng.standard_normal((3, 3)), [3, -2, 1]
        transfer = pw.PointTransfer(points, cage)
        self.assertEqual(transfer.shape, (len(cage.points), 60))
        self.assertLess(transfer.extrapolation, 5)
        moved = pw.morph(cage, transfer, points @ matrix + shift - points)
        np.testing.assert_allclose(moved.points, cage.points @ matrix + shift, atol=1e-8)
        self.assertTrue((moved.faces == cage.faces).all())
        displacements = 0.02 * np.ptp(cage.points) * np.sin(points / 100)
        faces, uv = np.repeat(np.arange(len(cage.faces)), 2), rng.random((2 * len(cage.faces), 2))
        forces = rng.standard_normal((len(faces), 3))
        for name, table in (("moves.csv", np.hstack([points, displacements])), ("forces.csv", np.hstack([faces[:, None], uv, forces]))):
            np.savetxt(self.folder / name, table, delimiter=",", fmt="%.17g")
        out = {name: self.folder / name for name in ("moved.obj", "carried.csv")}
        self.report("morph", WING / "wing_cage.obj", "--displacements", self.folder / "moves.csv", "-o", out["moved.obj"],
                    "--forces", self.folder / "forces.csv", "--forces-out", out["carried.csv"])
        moved = pw.morph(WING / "wing_cage.obj", points, displacements)
        moved.write(self.folder / "mine.obj")
        self.assertEqual((self.folder / "mine.obj").read_bytes(), out["moved.obj"].read_bytes())
        carried = transfer.apply_transposed(cage.masks(faces, uv).T @ forces)
        told = np.loadtxt(out["carried.csv"], delimiter=",", skiprows=1)[:, 3:]
        np.testing.assert_allclose(carried, told, atol=1e-9 * abs(told).max())
        velocities = rng.standard_normal((60, 3))
        surface = cage.masks(faces, uv) @ transfer.apply(velocities)
        self.assertAlmostEqual((surface * forces).sum(), (velocities * carried).sum(), places=8)
        for call in (lambda: pw.morph(cage, points, displacements[1:]), lambda: transfer.apply(points[1:]),
                     lambda: transfer.apply_transposed(points), lambda: pw.morph(cage.refined(), transfer, displacements),
                     lambda: pw.PointTransfer(points * [1, 1, 0], cage), lambda: pw.PointTransfer([[0, 0, 0]] * 5, cage),
                     lambda: pw.morph(cage, points, 1e299 * displacements)):
            with self.assertRaises(pw.PatchwrightError):
                call()

    def test_refit(self):
        cage, words = WING / "wing_cage.obj", ("--tolerance", "1e-3rel")
        a, b = self.folder / "a.step", self.folder / "b.step"
        report = self.report("refit", cage, WING / "wing.step", "-o", self.folder / "a.obj", *words)
        result = pw.refit(cage, WING / "wing.step", tolerance="1e-3rel")
        self.assertIsNone(result.output)
        self.check_same(result, report)
        result.cage.write(self.folder / "b.obj")
        self.assertEqual((self.folder / "a.obj").read_bytes(), (self.folder / "b.obj").read_bytes())
        self.check_same(pw.refit(result.cage, WING / "wing.step", b, tolerance="1e-3rel"),
                        self.report("refit", self.folder / "a.obj", WING / "wing.step", "-o", self.folder / "c.obj", "--cad-out", a,
                                    *words))
        self.assertTrue(b.exists())
        self.check_same(pw.refit(cage, WING / "wing.step", from_=WING / "wing.step", tolerance="1e-3rel"),
                        self.report("refit", cage, WING / "wing.step", "--from", WING / "wing.step", "-o", self.folder / "c.obj", *words))
        with self.assertRaises(pw.InputError):
            pw.refit(SAMPLES / "cages" / "cube.obj", WING / "wing.step")
        with self.assertRaisesRegex(pw.InputError, "6 faces"):
            pw.refit(result.cage, WING / "wing.step", from_=b)

    def test_foot_points_of_the_kernel(self):
        file = self.folder / "slope.step"
        pw.export(pw.Cage([[0, 0, 0], [100, 0, 100], [100, 80, 100], [0, 80, 0]], [[0, 1, 2, 3]]), file)
        # The limit surface is in the plane z = x.
        points = np.array([[45, 40, 55], [60, 35, 40], [50, 45, 50.5]])
        models = [pw.read(file, foot_points=way) for way in ("search", "kernel")]
        for model in models:
            feet, distances = model.foot_points(points)
            np.testing.assert_allclose(distances, abs(points[:, 2] - points[:, 0]) / np.sqrt(2), atol=1e-9)
            np.testing.assert_allclose(feet[:, [0, 2]], points[:, [0, 2]].mean(axis=1)[:, None] * [1, 1], atol=1e-6)
        for a, b in zip(*(model.foot_points([[-50, -20, 3], [0, 200, 90]]) for model in models)):
            np.testing.assert_allclose(a, b, atol=1e-6)
        with self.assertRaisesRegex(pw.UsageError, "search, kernel"):
            pw.read(file, foot_points="occ")
        with self.assertRaisesRegex(pw.InputError, "triangles"):
            pw.read(SAMPLES / "cages" / "cube.obj", foot_points="kernel")

    def test_make_cage(self):
        report = self.report("cage", WING / "wing.igs", "-o", self.folder / "a.obj")
        result = pw.make_cage(WING / "wing.igs")
        self.check_same(result, report)
        result.cage.write(self.folder / "b.obj")
        self.assertEqual((self.folder / "a.obj").read_bytes(), (self.folder / "b.obj").read_bytes())
        self.assertEqual(len(result.layout), 1)
        self.assertIn("wing", result.layout[0])

    def test_errors(self):
        half = self.folder / "half.step"
        half.write_bytes((WING / "wing.step").read_bytes()[:20000])
        old = self.folder / "old.step"
        old.write_text("old")
        cases = [(pw.InputError, 2, [half, old]), (pw.InputError, 2, [self.folder / "none.step", old]),
                 (pw.InputError, 2, [self.folder / "none.xyz", old]),
                 (pw.OutputError, 4, [WING / "wing.step", self.folder / "none" / "a.step"])]
        for kind, code, (model, output) in cases:
            told = subprocess.run([PATCHWRIGHT, "convert", str(model), "-o", str(output)], capture_output=True, text=True)
            self.assertEqual(told.returncode, code)
            with self.assertRaises(kind) as raised:
                pw.convert(model, output)
            self.assertEqual(raised.exception.exit_code, code)
            self.assertIn(str(raised.exception), told.stderr)
        for arguments, part in (({"tolerance": "0.1"}, "'0.1' has no unit"), ({"tolerance": "-1mm"}, "is no length"),
                                ({"layout": "best"}, "'best' is none of auto, aligned, remesh"),
                                ({"samples": 0}, "samples: '0' is no number from 1"),
                                ({"unit": "furlong"}, "furlong"), ({"max_levels": 1.5}, "no whole number")):
            with self.assertRaises(pw.UsageError) as raised:
                pw.convert(WING / "wing.step", old, **arguments)
            self.assertIn(part, str(raised.exception))
            self.assertIsInstance(raised.exception, ValueError)
        with self.assertRaisesRegex(pw.UsageError, "is the input as well"):
            pw.convert(half, half)
        self.assertEqual(old.read_text(), "old")

    def test_time_limit(self):
        with self.assertRaisesRegex(pw.TimeLimitError, "MISSED: the time limit"):
            pw.convert(WING / "wing.step", self.folder / "a.step", time_limit=1e-3)
        self.assertEqual(os.listdir(self.folder), [])


class Options(ModuleTest):
    # Of the command line alone: files that Python has as values, and what a terminal is for.
    ELSEWHERE = {"output", "cage-out", "cad-out", "json", "report", "field", "picture", "picture-view", "picture-direction", "picture-zoom",
                 "picture-layer", "picture-size", "quiet", "verbose", "threads", "help", "progress", "config", "cage-unit", "time-stamp", "size-array",
                 "sensor-array"}
    OTHER_NAMES = {"cluster": "clusters", "plot3d": "form", "no-heal": "heal", "no-join": "join", "from": "from_"}

    def test_python_has_the_options_of_the_command_line(self):
        import inspect
        reading = set(inspect.signature(pw.read).parameters)
        for command, function in (("convert", pw.convert), ("fit", pw.fit), ("refit", pw.refit), ("cage", pw.make_cage), ("export", pw.export),
                                  ("compare", pw.compare), ("inspect", pw.inspect), ("grid", pw.grid)):
            text = subprocess.run([PATCHWRIGHT, "help", command], capture_output=True, text=True, check=True).stdout
            options = set(re.findall(r"^ +(?:-\w,)?--([\w-]+)", text, re.MULTILINE)) - self.ELSEWHERE
            names = {self.OTHER_NAMES.get(option, option).replace("-", "_") for option in options}
            known = set(inspect.signature(function).parameters) | (reading if command not in ("export", "grid") else set())
            self.assertEqual(names - known, set(), command)


class Shapes(ModuleTest):
    def test_brep(self):
        wing = pw.read(WING / "wing.step")
        copy = pw.Model.from_brep(wing.to_brep())
        self.assertAlmostEqual(pw.Model.from_brep(copy.to_brep().decode()).diagonal, wing.diagonal, delta=1e-6)
        self.assertLess(pw.compare(wing, copy, samples=500).deviation_mm, 1e-6)
        self.assertAlmostEqual(copy.diagonal, wing.diagonal, delta=1e-6)
        with self.assertRaisesRegex(pw.UsageError, "no CAD model"):
            pw.read(SAMPLES / "cages" / "cube.obj").to_brep()
        with self.assertRaises(pw.InputError):
            pw.Model.from_brep(b"no shape")

    def test_freecad(self):
        # Its shapes are TopoDS_Shape, as those of pythonOCC and OCP are.
        try:
            sys.path.append("/usr/lib/freecad-python3/lib")
            import FreeCAD  # noqa: F401
            import Part
        except ImportError as error:
            self.skipTest(f"SKIPPED: {error}")
        ball = pw.Model.from_brep(Part.makeSphere(10).exportBrepToString())
        points, distances = ball.foot_points([[20, 0, 0], [0, 0, 5], [3, 4, 0]])
        np.testing.assert_allclose(distances, [10, 5, 5], atol=1e-9)
        # At the pole, to what distances tell: the square of this.
        np.testing.assert_allclose(points, [[10, 0, 0], [0, 0, 10], [6, 8, 0]], atol=1e-6)
        shape = Part.Shape()
        shape.importBrepFromString(pw.read(WING / "wing.step").to_brep().decode())
        self.assertTrue(shape.isValid())
        volume = pw.inspect(WING / "wing.step").report["solid"]["volume"]
        self.assertAlmostEqual(shape.Volume / volume, 1, places=6)  # mm both, as that file is

    def test_field(self):
        a, b = pw.read(WING / "wing.igs"), pw.read(WING / "wing.step")
        field = a.field(b)
        self.assertEqual(field.points.shape, (len(field.deviation), 3))
        self.assertEqual(field.triangles.max(), len(field.points) - 1)
        np.testing.assert_allclose(field.deviation[::50], b.foot_points(field.points[::50])[1], atol=1e-6)
        self.assertIsNone(a.field().deviation)

    def test_grid_in_memory(self):
        cage = pw.Cage(50 * CUBE_POINTS, CUBE_FACES)
        blocks = pw.grid_blocks(cage, points=5, blocks="faces")
        self.assertEqual([b.shape for b in blocks.values()], [(5, 5, 3)] * 6)
        corners = {tuple(np.round(b[i, j], 9)) for b in blocks.values() for i in (0, -1) for j in (0, -1)}
        self.assertEqual(corners, {tuple(25 * p) for p in CUBE_POINTS})
        thick = pw.grid_blocks(cage, points=5, layers=2, thickness="10mm")
        self.assertEqual({b.shape[2:] for b in thick.values()}, {(3, 3)})
        far = pw.grid_blocks(cage, points=5, layers=2, thickness="10mm", farfield=2000)
        for block in far.values():
            np.testing.assert_allclose(np.linalg.norm(block[:, :, -1], axis=2), 2000)
        with self.assertRaisesRegex(pw.PatchwrightError, "layers"):
            pw.grid_blocks(cage, farfield=2000)

    def test_places_of_a_grid(self):
        hexagonal = [0.5 * CUBE_POINTS[i] for i in range(8)]
        for cage in (pw.Cage.read(WING / "wing_cage.obj"),
                     pw.Cage(hexagonal, [[0, 2, 3, 1], [4, 5, 7], [4, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]])):
            options = {"points": 7, "spacing": "cosine"}
            points, places = pw.grid_blocks(cage, **options), pw.grid_places(cage, **options)
            self.assertEqual(points.keys(), places.keys())
            self.assertEqual(all(p.sectors is None for p in places.values()), cage.summary["non_quads"] == 0)
            for name, block in points.items():
                found = places[name]
                self.assertEqual(found.uv.shape, (*block.shape[:2], 2))
                sectors = None if found.sectors is None else found.sectors.reshape(-1)
                at = cage.evaluate(found.faces.reshape(-1), found.uv.reshape(-1, 2), sectors=sectors)
                np.testing.assert_allclose(at.reshape(block.shape), block, atol=1e-10 * np.ptp(cage.points))

    def test_another_folder(self):
        # The reader follows the process: relative names mean what they mean here.
        before = os.getcwd()
        self.addCleanup(os.chdir, before)
        for folder in (WING, SAMPLES):
            os.chdir(folder)
            self.assertEqual(pw.read(os.path.relpath(WING / "wing.igs")).is_cad, True)


class Readers(ModuleTest):
    def test_a_reader_that_was_ended(self):
        pw.read(WING / "wing.igs")
        children = pathlib.Path(f"/proc/self/task/{os.getpid()}/children").read_text().split()
        readers = [int(c) for c in children if pathlib.Path(f"/proc/{c}/comm").read_text().strip() == "_reader"]
        self.assertTrue(readers)
        for process in readers:
            os.kill(process, signal.SIGKILL)
        with self.assertRaises(pw.InternalError):
            pw.read(WING / "wing.igs")
        self.assertTrue(pw.read(WING / "wing.igs").is_cad)

    def test_files_that_end_the_kernel(self):
        # Every file of the folder ends as the command line does, in an interpreter that goes on.
        index = SAMPLES.parents[1] / "shared" / "hostile"
        files = sorted(f for f in index.glob("*") if f.suffix in (".step", ".stp", ".igs", ".iges", ".brep"))
        if not files:
            self.skipTest("SKIPPED: no hostile files")
        for file in files:
            try:
                pw.read(file, read_limit=5)
            except pw.InputError as error:
                self.assertNotIn("\n", str(error))

    def test_a_hole_narrower_than_the_tolerance_is_left_out(self):
        file = SAMPLES.parents[1] / "shared" / "hostile" / "tinyhole.step"
        if not file.is_file():
            self.skipTest("SKIPPED: no hostile files")
        model = pw.read(file)
        made = pw.convert(model, self.folder / "box.step", tolerance="1e-3rel")
        self.assertTrue(made.met)
        for result in (made, pw.fit(model, tolerance="1e-3rel"), pw.make_cage(model, tolerance="1e-3rel")):
            self.assertEqual(result.report["input"]["holes_left_out"], 1)
            self.assertTrue(any("1 hole narrower" in notice for notice in result.report["notices"]))


class Calls(ModuleTest):
    def test_progress(self):
        stages = []
        pw.convert(WING / "wing.step", self.folder / "a.step", tolerance="1e-3rel",
                   progress=lambda stage, fraction: stages.append((stage, fraction)))
        self.assertGreater(len({stage for stage, _ in stages}), 2)
        self.assertTrue(all(0 <= fraction <= 1 for _, fraction in stages))

    def test_cancel(self):
        started = time.monotonic()
        event = threading.Event()
        threading.Timer(0.3, event.set).start()
        with self.assertRaises(pw.CancelledError) as raised:
            pw.convert(WING / "wing.igs", self.folder / "a.step", tolerance="1e-8rel", cancel=event)
        self.assertEqual(raised.exception.exit_code, 130)
        self.assertLess(time.monotonic() - started, 10)
        with self.assertRaises(pw.CancelledError):
            pw.convert(WING / "wing.igs", self.folder / "a.step", progress=lambda stage, fraction: stage != "fit")
        self.assertEqual(os.listdir(self.folder), [])

    def test_what_the_callback_raises(self):
        def fail(stage, fraction):
            raise KeyError(stage)

        with self.assertRaises(KeyError):
            pw.compare(WING / "wing.igs", WING / "wing.step", progress=fail)
        for wrong in ("text", 5):
            with self.assertRaisesRegex(pw.UsageError, "progress"):
                pw.read(WING / "wing.igs", progress=wrong)
            with self.assertRaisesRegex(pw.UsageError, "cancel"):
                pw.read(WING / "wing.igs", cancel=wrong)

    def test_other_threads_go_on(self):
        """A call that takes long beside a thread that counts in Python."""
        a, b = pw.read(WING / "wing.igs"), pw.read(WING / "wing.step")
        ticks, stop = [], threading.Event()

        def count():
            while not stop.is_set():
                ticks.append(time.monotonic())
                time.sleep(0.002)

        counter = threading.Thread(target=count)
        counter.start()
        started = time.monotonic()
        try:
            pw.compare(a, b, samples=60000)
        finally:
            ended = time.monotonic()
            stop.set()
            counter.join()
        within = [t for t in ticks if started < t < ended]
        longest = max(np.diff([started, *within, ended]))
        self.assertGreater(len(within), 20)
        self.assertLess(longest, 0.5 * (ended - started))

    def test_calls_on_many_threads(self):
        model = pw.read(WING / "wing.igs")
        results = [None] * 4

        def work(i):
            results[i] = same(pw.compare(model, WING / "wing.step", samples=500).report)

        threads = [threading.Thread(target=work, args=(i,)) for i in range(4)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertIsNotNone(results[0])
        self.assertTrue(all(result == results[0] for result in results))

    def test_interrupt(self):
        program = textwrap.dedent("""
            import sys, patchwright
            print("started", flush=True)
            try:
                patchwright.convert(sys.argv[1], sys.argv[2], tolerance="1e-8rel")
            except KeyboardInterrupt:
                print("interrupted")
        """)
        process = subprocess.Popen([sys.executable, "-c", program, str(WING / "wing.igs"), str(self.folder / "a.step")],
                                   stdout=subprocess.PIPE, text=True)
        process.stdout.readline()
        time.sleep(0.7)
        process.send_signal(signal.SIGINT)
        self.assertEqual(process.communicate(timeout=30)[0].strip(), "interrupted")
        self.assertEqual(os.listdir(self.folder), [])

    def test_copies_of_the_process(self):
        import multiprocessing
        pw.read(WING / "wing.igs")
        with multiprocessing.get_context("fork").Pool(2) as pool:
            diagonals = pool.map(diagonal_of, [str(WING / "wing.igs"), str(WING / "wing.step")] * 2)
        np.testing.assert_allclose(diagonals, diagonals[0], rtol=1e-3)
        self.assertAlmostEqual(pw.read(WING / "wing.igs").diagonal, diagonals[0])


def diagonal_of(file):
    return pw.read(file).diagonal


class RoundTrips(ModuleTest):
    def test_met(self):
        result = patchwright.testing.assert_round_trip(WING / "wing.igs", WING / "wing.step", "1e-4rel")
        self.assertTrue(result.met)

    def test_missed(self):
        cage = pw.Cage(50 * CUBE_POINTS, CUBE_FACES)
        pw.export(cage, self.folder / "a.step")
        pw.export(cage.with_points(1.01 * cage.points), self.folder / "b.step")
        with self.assertRaises(AssertionError) as raised:
            patchwright.testing.assert_round_trip(self.folder / "a.step", self.folder / "b.step", 0.05)
        message = str(raised.exception)
        # The corners of the limit surface are at (25, 25, 25); elsewhere it is nearer to the middle of faces.
        figure = float(message.split("distance_to_input: ")[1].split(" mm")[0])
        farthest = 0.01 * np.linalg.norm(cage.evaluate([0], [[0.5, 0.5]])[0])
        self.assertLessEqual(figure, 0.01 * np.linalg.norm([25, 25, 25]) + 1e-3)
        self.assertGreater(figure, 0.99 * farthest)
        for part in ("a.step and", "b.step differ by more than 0.05", "tolerance 0.05 mm, at (", "distance_from_input"):
            self.assertIn(part, message)

    def test_no_trip(self):
        with self.assertRaises(pw.InputError):
            patchwright.testing.assert_round_trip(WING / "wing.igs", self.folder / "none.step", "1e-4rel")


if __name__ == "__main__":
    main()
