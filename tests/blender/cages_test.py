"""The Blender add-on: cages imported, edited and exported by Blender, read by patchwright before and after.

Usage: cages_test.py PATCHWRIGHT SAMPLES_DIR [unittest arguments]
The add-on is installed as a user's. Exit code 77: Blender is not installed.
"""
import json
import math
import os
import pathlib
import shutil
import subprocess
import sys
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).parents[1] / "cli"))
from command_line import CliTest, run, SAMPLES, WING

BLENDER = shutil.which("blender")
if BLENDER is None:
    print("SKIPPED: Blender is not installed")
    sys.exit(77)
HERE = pathlib.Path(__file__).resolve().parent
SAME = 1e-12   # of the diagonal: what Blender did not change
DOUBLE = 1e-15  # of a coordinate: its own precision, far from the origin
MOVED = 1e-6   # of the diagonal: what it did, in single precision
# Triangles, quads and a pentagon; every kind of tag; far from the origin.
TAGGED = """# comment
v 1000000 0 0.1
v 1000003 0 0
v 1000003 2 0
v 1000000 2 0
v 1000000 0 1.7
v 1000003 0 1
v 1000003 2 1
v 1000000 2 1
v 1000001.523456789 -1.3141592653589793 0.5
v 1000001.5 0 1.25
f 1/1 4 3 2
g a name with spaces
f -6 10 6 7 8
g a name that is longer than the sixty-three bytes which Blender keeps of each, part 1
f 2 3 7 6
g a name that is longer than the sixty-three bytes which Blender keeps of each, part 2
f 3 4 8 7
g
f 4 1 5 8
o a name with spaces
f 1 2 9
f 2 6 10 9
f 9 10 \\
  5 1
t crease 4/2/0 0 1 1 2 2.3 0.7
t crease 2/1/0 2 3 10
t crease 6/3/0 5 6 6 7 3 7 10 10 11
t crease 2/1/0 5 9 1.2345678
t corner 2/1/0 6 7 1.5
t corner 1/1/0 4 12
t interpolateboundary 1/0/0 2
#patchwright pin 3
#patchwright pin 5 8
#patchwright crease-rule runout
#patchwright sector 3 3 90
#patchwright sector 6 1 270.5 0 0.6 0.8
"""


class Blender(CliTest):
    def play(self, *cases):
        """What Blender answers to each case."""
        scripts = self.folder / "scripts"
        if not scripts.exists():
            shutil.copytree(HERE.parents[1] / "tools/blender/patchwright_cage", scripts / "addons/patchwright_cage")
        file = self.path("cases.json", json.dumps(cases))
        result = subprocess.run(
            [BLENDER, "--background", "--factory-startup", "--addons", "patchwright_cage", "--python-exit-code", "1",
             "--python", HERE / "play.py", "--", file],
            env={**os.environ, "BLENDER_USER_SCRIPTS": str(scripts)}, capture_output=True, text=True, timeout=300)
        self.assertEqual(result.returncode, 0, result.stdout + result.stderr)
        return json.loads(file.with_suffix(".answers").read_text())

    def read(self, cage):
        """As patchwright reads it: points and all other lines."""
        file = self.path("read.obj")
        result = run("subdivide", cage, "-n", "0", "-o", file)
        self.assertEqual(result.returncode, 0, result.stderr)
        lines = file.read_text().splitlines()
        points = [tuple(map(float, line.split()[1:])) for line in lines if line.startswith("v ")]
        return points, [line for line in lines if not line.startswith("v ")]

    def diagonal(self, points):
        return math.dist(*[[pick(axis) for axis in zip(*points)] for pick in (min, max)])

    def check_same(self, before, after, moved=()):
        """Vertices in their order, faces, names and tags."""
        (old, old_rest), (new, new_rest) = self.read(before), self.read(after)
        self.assertEqual(new_rest, old_rest, before)
        self.assertEqual(len(new), len(old))
        for number, (a, b) in enumerate(zip(old, new)):
            if number not in moved:
                self.assertLessEqual(math.dist(a, b), SAME * self.diagonal(old) + DOUBLE * max(map(abs, a)), (before, number))
        return old, new


class RoundTrips(Blender):
    def test_sample_cages_stay_as_they_are(self):
        cages = sorted(SAMPLES.rglob("*.obj"))
        self.assertGreater(len(cages), 8)
        outputs = [str(self.path(f"{number}.obj")) for number in range(len(cages))]
        answers = self.play(*({"import": str(cage), "export": out} for cage, out in zip(cages, outputs)))
        for cage, out, answer in zip(cages, outputs, answers):
            self.assertNotIn("error", answer)
            self.check_same(cage, out)

    def test_every_kind_of_tag(self):
        cage, out = self.path("tagged.obj", TAGGED), self.path("out.obj")
        self.play({"import": str(cage), "export": str(out)})
        self.check_same(cage, out)
        lines = self.read(out)[1]
        for line in ("t crease 2/1/0 1 0 2.3", "t crease 2/1/0 3 2 10", "t interpolateboundary 1/0/0 2", "#patchwright pin 8",
                     "#patchwright crease-rule runout"):
            self.assertIn(line, lines)
        self.assertEqual(sum(line.startswith("#patchwright sector") for line in lines), 2)
        again = self.path("again.obj")
        self.play({"import": str(out), "export": str(again)})
        self.assertEqual(again.read_text(), out.read_text())

    def test_convert_edit_export(self):
        cage, out = self.path("wing.obj"), self.path("edited.obj")
        result = run("convert", WING / "wing.igs", "-o", self.path("wing.step"), "--tolerance", "1e-3rel", "--cage-out", cage)
        self.assertEqual(result.returncode, 0, result.stderr)
        number, by = 40, (3.0, -2.0, 6.0)
        answer, = self.play({"import": str(cage), "edits": [["move", number, by]], "export": str(out)})
        self.assertEqual((answer["mode"], answer["mode_after"]), ("EDIT", "EDIT"))
        old, new = self.check_same(cage, out, moved=[number])
        wanted = [x + d for x, d in zip(old[number], by)]
        self.assertLess(math.dist(new[number], wanted), MOVED * self.diagonal(old))
        creases = [line for line in self.read(out)[1] if line.startswith("t crease")]
        self.assertEqual(len(creases), 31)
        solids = [self.report("export", file, "-o", self.path("a.step"))["solid"] for file in (cage, out)]
        for solid in solids:
            self.assertEqual((solid["closed"], solid["valid"], solid["faces"]), (True, True, solids[0]["faces"]))
        change = abs(solids[1]["volume"] / solids[0]["volume"] - 1)
        self.assertTrue(1e-5 < change < 1e-2, change)  # without creases it was 7 %

    def test_object_moved(self):
        cage, out = WING / "wing_cage.obj", self.path("out.obj")
        self.play({"import": str(cage), "shift_mm": 250, "export": str(out)})
        old, new = self.check_same(cage, out, moved=range(10 ** 6))
        for (x, *yz), b in zip(old, new):
            self.assertLess(math.dist((x + 250, *yz), b), MOVED * self.diagonal(old))


class Edits(Blender):
    def ordered(self, crease):
        *start, v, w, sharpness = crease.split()
        return " ".join([*start, *sorted((v, w), key=int), sharpness])

    def test_creases_of_blender(self):
        """Its numbers count where somebody has changed them; others stay."""
        cage, out = self.path("tagged.obj", TAGGED), self.path("out.obj")
        edits = [["set_crease", 0, 1, 0.0], ["set_crease", 1, 2, 0.5], ["set_crease", 4, 7, 1.0]]
        self.play({"import": str(cage), "edits": edits, "export": str(out)})
        found = [line for line in self.read(out)[1] if line.startswith("t crease")]
        wanted = ["1 2 2.5", "2 3 10", "4 7 10", "5 6 10", "6 7 10", "3 7 10", "5 9 1.2345678"]
        self.assertEqual(sorted(self.ordered(line) for line in found), sorted("t crease 2/1/0 " + each for each in wanted))

    def test_extruded(self):
        cage, out = SAMPLES / "cages/cube_rim.obj", self.path("out.obj")
        self.play({"import": str(cage), "edits": [["extrude", 1]], "export": str(out)})
        points, lines = self.read(out)
        self.assertEqual(len(points), 12)
        self.assertEqual(len([line for line in lines if line.startswith("f")]), 10)
        solid = self.report("export", out, "-o", self.path("a.step"))["solid"]
        self.assertEqual((solid["closed"], solid["valid"]), (True, True))

    def test_mesh_of_blender(self):
        out = self.path("out.obj")
        self.play({"cube": True, "export": str(out)})
        points, lines = self.read(out)
        self.assertEqual({abs(x) for point in points for x in point}, {1000.0})
        self.assertEqual(len([line for line in lines if line.startswith("f")]), 6)

    def test_failures(self):
        bad = self.path("bad.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nt crease 2/1/0 0 7 1\n")
        short = self.path("short.obj", "v 0 0\n")
        answers = self.play({"import": str(bad)}, {"import": str(short)}, {"import": str(self.path("none.obj"))})
        for answer, text in zip(answers, ("crease 0-7: there is no such edge", "short.obj: line 1", "none.obj")):
            self.assertIn(text, answer["error"])


class Previews(Blender):
    def check_preview(self, cage, levels):
        fine = self.path("fine.obj")
        self.assertEqual(run("subdivide", cage, "-n", levels, "-o", fine).returncode, 0)
        wanted, _ = self.read(fine)
        answer, = self.play({"import": str(cage), "preview": levels})
        found = answer["preview"]
        self.assertEqual(len(found), len(wanted))
        near = 2e-6 * self.diagonal(wanted)
        cells = {}
        for point in found:
            cells.setdefault(tuple(round(x / near / 4) for x in point), []).append(point)
        for point in wanted:
            middle = [round(x / near / 4) for x in point]
            around = [(middle[0] + i, middle[1] + j, middle[2] + k) for i in (-1, 0, 1) for j in (-1, 0, 1) for k in (-1, 0, 1)]
            nearest = min((math.dist(point, p) for cell in around for p in cells.get(cell, [])), default=math.inf)
            self.assertLess(nearest, near, point)

    def test_semi_sharp(self):
        """Blender's subdivision is that of the cage: its creases mean the same sharpness."""
        text = (SAMPLES / "cages/cube.obj").read_text()
        text += "t crease 2/1/0 4 5 1.5\nt crease 2/1/0 5 7 0.7\nt crease 2/1/0 6 7 10\nt crease 2/1/0 0 1 2.3\nt corner 1/1/0 0 1.2\nt corner 1/1/0 3 10\n"
        self.check_preview(self.path("tags.obj", text), 3)

    def test_wing(self):
        self.check_preview(WING / "wing_cage.obj", 2)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
