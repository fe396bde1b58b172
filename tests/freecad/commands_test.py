"""The FreeCAD workbench's commands without a display: what they call, and what they put into a document.

Usage: commands_test.py PATCHWRIGHT SAMPLES_DIR [unittest arguments]
FreeCAD's modules are imported instead of running under freecadcmd, which hides exit codes. Exit code 77: FreeCAD is not installed.
"""
import os
import pathlib
import signal
import sys
import tempfile
import time
import unittest

sys.path[:0] = [str(pathlib.Path(__file__).parents[1] / "cli"), str(pathlib.Path(__file__).parents[2] / "tools/freecad")]
from command_line import CliTest, PATCHWRIGHT, SAMPLES, WING

sys.path.append("/usr/lib/freecad-python3/lib")
home = tempfile.TemporaryDirectory(prefix="patchwright")  # the user's preferences stay as they are
os.environ["FREECAD_USER_HOME"] = home.name
try:
    import FreeCAD
    import Mesh
    import Part
except ImportError as missing:
    print(f"SKIPPED: FreeCAD is not installed: {missing}")
    sys.exit(77)
from patchwright_workbench import document, field, jobs, preferences, program, results

INCH = 25.4


class Workbench(CliTest):
    def setUp(self):
        super().setUp()
        self.doc = FreeCAD.newDocument("Test")
        self.addCleanup(FreeCAD.closeDocument, self.doc.Name)

    def run_job(self, job, code=0):
        """The run, its report, and what it shows."""
        folder = tempfile.mkdtemp(dir=self.folder)
        run = program.Run(PATCHWRIGHT, job.arguments(folder), folder)
        self.assertEqual(run.wait(), code, run.messages)
        report = jobs.read_report(run, folder)
        return run, report, job.show(self.doc, report, folder)

    def add_shape(self, label, shape):
        thing = self.doc.addObject("Part::Feature", "Shape")
        thing.Label, thing.Shape = label, shape
        return thing

    def child(self, group, label):
        found = [thing for thing in group.Group if thing.Label.startswith(label)]
        self.assertEqual(len(found), 1, [thing.Label for thing in group.Group])
        return found[0]

    def distance(self, thing, point):
        return thing.Shape.distToShape(Part.Vertex(*point))[0]


class Conversions(Workbench):
    def test_wing_in_inches(self):
        step = self.path("wing.step")
        run, report, shown = self.run_job(jobs.Convert(jobs.Source(str(WING / "wing.igs")), str(step), "1e-3rel"))
        self.assertTrue(report.met)
        self.assertTrue(shown.group.Verdict.startswith("met 1e-3: one closed valid solid"))
        self.assertEqual(run.progress.percent, 100)
        self.assertIn("note: 4 faces turned", " ".join(run.messages))
        solid, data = shown.model.Shape, report.data
        self.assertAlmostEqual(solid.Volume / (data["solid"]["volume"] * INCH ** 3), 1, delta=1e-4)
        # Names are at the right faces: the root is the only one in its plane.
        names = shown.model.PatchNames
        flat = [i for i, face in enumerate(solid.Faces) if face.BoundBox.YLength < 1e-6]
        self.assertEqual([i for i, name in enumerate(names) if "/root/" in name], flat)
        patches = self.child(shown.group, f"{len(solid.Faces)} patches").Group
        self.assertEqual([patch.Label for patch in patches], list(names))
        for patch, face in zip(patches, solid.Faces):
            self.assertAlmostEqual(patch.Shape.Area, face.Area)
            self.assertFalse(patch.Visibility)
        self.check_field(shown, report)
        self.check_places(shown, report)
        _, _, inspected = self.run_job(jobs.Inspect(jobs.Source(str(step))))
        self.assertEqual([row.what for row in inspected.rows if row.element], list(names))

    def check_field(self, shown, report):
        mesh = self.child(shown.group, "Deviation")
        box, solid = mesh.Mesh.BoundBox, shown.model.Shape
        self.assertFalse(box.intersect(solid.BoundBox))  # beside it
        bound = INCH * report.data["deviation"]["output_to_input"]["bound"]
        self.assertTrue(0.5 * bound < max(mesh.Deviation) <= bound)
        scale = INCH * 1e-3 * report.data["input"]["diagonal"]
        self.assertAlmostEqual(report.largest_mm() / scale, 1)
        self.assertEqual(len(mesh.Deviation), mesh.Mesh.CountPoints)
        self.assertEqual(len(mesh.VertexColors), mesh.Mesh.CountPoints)
        self.assertAlmostEqual(mesh.VertexColors[0][2], field.colour(mesh.Deviation[0] / scale)[2], places=2)
        for point in mesh.Mesh.Points[::2000]:
            self.assertLess(self.distance(shown.model, point.Vector - mesh.Placement.Base), 1e-3)

    def check_places(self, shown, report):
        worst = report.data["deviation"]["output_to_input"]["worst"]
        rows = [row for row in shown.rows if row.what == "output to input"]
        self.assertEqual(len(rows), len(worst))
        marks = self.child(shown.group, "Worst places")
        self.assertEqual(len(marks.Shape.Vertexes), len(shown.rows))
        for row, place in zip(rows, worst):
            nearest = document.nearest_face(shown.model, row.at)
            for name in (nearest, f"Face{place['face'] + 1}"):  # two where the place is on their edge
                self.assertLess(shown.model.Shape.getElement(name).distToShape(Part.Vertex(*row.at))[0], 1e-3)
            self.assertAlmostEqual(document.normal_at(shown.model, nearest, row.at).Length, 1)
            (thing, name), = row.marks
            self.assertLess(thing.Shape.getElement(name).Point.distanceToPoint(FreeCAD.Vector(*row.at)), 1e-9)

    def test_object_and_few_patches_in_the_tree(self):
        part = self.add_shape("a part/of two", Part.makeCylinder(30, 80))
        preferences._group().SetInt("MostPatches", 3)
        self.addCleanup(preferences._group().RemInt, "MostPatches")
        job = jobs.Convert(jobs.Source(thing=part), str(self.path("b.step")), "1e-3rel", more="--layout remesh --unit m")
        _, report, shown = self.run_job(job)
        self.assertEqual(report.unit, "m")
        self.assertAlmostEqual(shown.model.Shape.Volume / part.Shape.Volume, 1, delta=0.01)
        self.assertEqual(len(shown.notices), 1)
        self.assertEqual(len(shown.group.Group), 3)  # model, places, field

    def test_cancelled(self):
        step = self.path("c.step")
        job = jobs.Convert(jobs.Source(str(WING / "wing.igs")), str(step), "1e-8rel")
        run = program.Run(PATCHWRIGHT, job.arguments(self.folder), self.folder)
        while run.progress is None:
            self.assertIsNone(run.poll())
            time.sleep(0.01)
        run.cancel()
        self.assertIn(run.wait(), program.CANCELLED)
        self.assertTrue(run.is_cancelled)
        self.assertEqual(os.listdir(self.folder), [])

    def test_cancelled_where_interrupts_are_ignored(self):
        before = signal.signal(signal.SIGINT, signal.SIG_IGN)
        self.addCleanup(signal.signal, signal.SIGINT, before)
        self.test_cancelled()

    def test_failures(self):
        with self.assertRaisesRegex(program.ProgramError, "none.step: no such file"):
            jobs.Convert(jobs.Source("none.step"), "o.step").arguments(self.folder)
        with self.assertRaisesRegex(program.ProgramError, "Preferences > Patchwright"):
            program.find_program("no-such-program")
        with self.assertRaisesRegex(program.ProgramError, "further options"):
            jobs.Convert(jobs.Source(str(WING / "wing.igs")), "o.step", more="'").arguments(self.folder)
        bad = self.path("bad.step", "no STEP")
        run = program.Run(PATCHWRIGHT, jobs.Inspect(jobs.Source(str(bad))).arguments(self.folder), self.folder)
        self.assertEqual(run.wait(), 2)
        with self.assertRaisesRegex(program.ProgramError, "^[^ ]*bad.step: "):
            jobs.read_report(run, self.folder)


class Comparisons(Workbench):
    def test_boxes_of_which_one_is_higher(self):
        a = self.add_shape("box", Part.makeBox(100, 80, 50))
        b = self.add_shape("box", Part.makeBox(100, 80, 50.5))
        _, report, shown = self.run_job(jobs.Compare(jobs.Source(thing=a), jobs.Source(thing=b), "0.2mm"), code=3)
        self.assertIs(report.met, False)
        self.assertIn("MISSED", shown.group.Verdict)
        self.assertEqual(shown.model, b)
        ways = {what: [row for row in shown.rows if row.what == what] for what in ("output to input", "input to output")}
        for (what, rows), thing, z in zip(ways.items(), (b, a), (50.5, 50)):
            self.assertEqual((rows[0].value, rows[0].model), ("0.5 mm", thing), what)
            self.assertAlmostEqual(rows[0].at[2], z)
        mesh = self.child(shown.group, "Deviation")
        for point, deviation, colour in zip(mesh.Mesh.Points, mesh.Deviation, mesh.VertexColors):
            self.assertAlmostEqual(deviation, max(point.z - 50, 0), places=5)
            if deviation == 0 or deviation >= 0.2:  # blue, and red from the tolerance on
                self.assertEqual(colour[0] > colour[2], deviation > 0)

    def test_objects_that_parts_have_moved(self):
        part = self.doc.addObject("App::Part", "Part")
        part.Placement.Base = FreeCAD.Vector(0, 0, 7)
        inner = self.add_shape("inner", Part.makeBox(100, 80, 50))
        inner.Placement.Base = FreeCAD.Vector(0, 0, -6.5)
        part.addObject(inner)
        mesh = self.doc.addObject("Mesh::Feature", "Mesh")
        ball = Mesh.Mesh()
        ball.addFacets(Part.makeBox(100, 80, 50).tessellate(1))
        mesh.Mesh = ball
        mesh.Placement.Base = FreeCAD.Vector(0, 0, -6.75)
        part.addObject(mesh)
        self.doc.recompute()
        self.assertEqual([thing.Label for thing in document.models(self.doc)], ["inner", "Mesh"])
        _, report, shown = self.run_job(jobs.Compare(jobs.Source(thing=inner), jobs.Source(thing=mesh)))
        self.assertAlmostEqual(report.data["deviation"]["output_to_input"]["max"], 0.25, places=5)
        row = next(row for row in shown.rows if row.model == inner)
        point = FreeCAD.Vector(*row.at)
        self.assertLess(document.shape_of(inner).distToShape(Part.Vertex(point))[0], 1e-6)
        self.assertNotEqual(document.nearest_face(inner, row.at), "")

    def test_files(self):
        source = jobs.Source(str(WING / "wing.step"))
        _, report, shown = self.run_job(jobs.Compare(source, source))
        self.assertIsNone(report.met)
        self.assertRegex(shown.group.Verdict, "largest distance .* mm")
        self.assertEqual([thing.Label for thing in shown.group.Group][0], "wing")


class Inspections(Workbench):
    def test_box(self):
        box = self.add_shape("box", Part.makeBox(100, 80, 50))
        _, _, shown = self.run_job(jobs.Inspect(jobs.Source(thing=box)))
        self.assertEqual(shown.group.Verdict, "closed, valid: 6 faces (6 plane)")
        rows = [row for row in shown.rows if row.what.startswith("patch ")]
        self.assertEqual([row.element for row in rows], [f"Face{i + 1}" for i in range(6)])
        self.assertEqual(sum(row.value == "plane, 8000 mm²" for row in rows), 2)
        self.assertEqual([row.value for row in shown.rows if row.what == "shortest edge"], ["50 mm"])

    def test_triangles(self):
        thing = self.doc.addObject("Mesh::Feature", "Ball")
        ball = Mesh.Mesh()
        ball.addFacets(Part.makeSphere(40).tessellate(0.05))
        thing.Mesh = ball
        _, report, shown = self.run_job(jobs.Inspect(jobs.Source(thing=thing)))
        self.assertEqual(shown.model, thing)
        self.assertEqual(document.nearest_face(thing, (0, 0, 40)), "")
        file = self.path("ball.stl")
        thing.Mesh.write(str(file))
        _, report, shown = self.run_job(jobs.Inspect(jobs.Source(str(file)), more="--input-unit in"))
        self.assertAlmostEqual(shown.model.Mesh.BoundBox.ZLength, 80 * INCH, delta=0.1)


class Parts(unittest.TestCase):
    def test_lines(self):
        self.assertEqual(program.parse_line("\x1b[Kself-intersection          7 %    1.1 s"),
                         program.Progress("self-intersection", 7, 1.1))
        self.assertEqual(program.parse_line("attempt 2: fit            50 %   12.0 s, 4 s left"),
                         program.Progress("attempt 2: fit", 50, 12.0, 4.0))
        self.assertEqual(program.parse_line("read                      10 %    0.1 spatchwright: a.step: is no STEP file"),
                         "patchwright: a.step: is no STEP file")
        self.assertEqual(program.parse_line("\x1b[Knote: 4 faces turned"), "note: 4 faces turned")

    def test_names(self):
        text = ("#9=CLOSED_SHELL('',(#5,#3));#3=ADVANCED_FACE('it''s',(#1),#2,.T.);\n#5 = ADVANCED_FACE ( 'a\\\\b\\X\\E9\\X2\\03B1\\X0\\',(#1),#2,.F.);"
                "#7=OPEN_SHELL('x',(#8));#8=ADVANCED_FACE('',(#1),#2,.T.);")
        self.assertEqual(results.patch_names(text), ["a\\béα", "it's", ""])

    def test_field_as_vtk_reads_it(self):
        try:
            import vtk
        except ImportError:
            self.skipTest("VTK is not installed")
        with tempfile.TemporaryDirectory() as folder:
            file = os.path.join(folder, "a.vtp")
            run = program.Run(PATCHWRIGHT, ["export", SAMPLES / "cages/cube.obj", "-o", "cube.step"], folder)
            self.assertEqual(run.wait(), 0, run.messages)
            run = program.Run(PATCHWRIGHT, ["compare", SAMPLES / "wing/wing.step", "cube.step", "--field", file], folder)
            self.assertEqual(run.wait(), 0, run.messages)
            reader = vtk.vtkXMLPolyDataReader()
            reader.SetFileName(file)
            reader.Update()
            wanted, found = reader.GetOutput(), field.read_field(file, 10.0)
        self.assertEqual(len(found.triangles), wanted.GetNumberOfPolys())
        deviation, faces = wanted.GetPointData().GetArray("deviation"), wanted.GetCellData().GetArray("face")
        for i, (point, d) in enumerate(zip(found.points, found.deviation)):
            self.assertEqual((*point, d), (*(10 * x for x in wanted.GetPoint(i)), 10 * deviation.GetTuple1(i)))
        for i, (triangle, face) in enumerate(zip(found.triangles, found.faces)):
            cell = wanted.GetNumberOfLines() + i
            ids = vtk.vtkIdList()
            wanted.GetCellPoints(cell, ids)
            self.assertEqual((*triangle, face), (*(ids.GetId(k) for k in range(3)), faces.GetTuple1(cell)))

    def test_colours(self):
        self.assertEqual(field.colour(-1), field.STOPS[0])
        self.assertEqual(field.colour(0.5), field.STOPS[2])
        for found, wanted in zip(field.colour(9), field.STOPS[-1]):
            self.assertAlmostEqual(found, wanted)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
