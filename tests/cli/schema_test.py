"""Every subcommand's JSON report, also that of a run that failed, against src/report/report.schema.json.

Usage: schema_test.py PATCHWRIGHT SAMPLES_DIR [unittest arguments]
Exit code 77: python3-jsonschema is not installed.
"""
import json
import os
import shutil
import subprocess
import sys
import unittest

try:
    import jsonschema
except ImportError:
    print("SKIPPED: python3-jsonschema is not installed")
    sys.exit(77)

from command_line import CliTest, PATCHWRIGHT, run, SAMPLES, WING

SCHEMA = json.loads((SAMPLES.parent / "src" / "report" / "report.schema.json").read_text())
CUBE = SAMPLES / "cages" / "cube.obj"


class Schema(CliTest):
    def valid(self, *arguments, code=0):
        report = self.report(*arguments, code=code)
        jsonschema.Draft202012Validator(SCHEMA).validate(report)
        self.assertEqual(report["options"]["command"], arguments[0])
        return report

    def check_deviation(self, deviation, faces):
        """What is told face by face is what is told of the whole."""
        self.assertEqual(max(face["max"] for face in deviation["faces"]), deviation["max"])
        self.assertEqual(sum(face["samples"] for face in deviation["faces"]), deviation["samples"])
        self.assertEqual(len(deviation["faces"]), faces)
        self.assertAlmostEqual(sum(deviation["histogram"]["shares"]), 1.0, places=9)
        self.assertAlmostEqual(deviation["histogram"]["width"] * len(deviation["histogram"]["shares"]), deviation["max"])

    def test_names_that_are_not_utf_8(self):
        """Names of files are bytes; reports replace what is no UTF-8."""
        cage = os.fsencode(self.folder) + b"/cube\xff.obj"
        shutil.copy(SAMPLES / "cages" / "cube.obj", cage)
        for arguments, code in ((["export", cage, "-o", self.path("a.step"), "--report", self.path("a.html")], 0),
                                (["export", cage + b"x", "-o", self.path("a.step")], 2)):
            result = subprocess.run([PATCHWRIGHT, *arguments, "--json", self.path("a.json")], capture_output=True)
            self.assertEqual(result.returncode, code, result.stderr)
            self.assertIn("cube\ufffd.obj", self.path("a.json").read_text())
            self.path("a.json").unlink()

    def test_convert_compare_and_inspect(self):
        step = self.path("a.step")
        report = self.valid("convert", WING / "wing.igs", "--cage", WING / "wing_cage.obj", "-o", step, "--tolerance", "1e-3rel",
                            "--refine", "global")
        self.assertEqual(report["schema_version"], 1)
        self.assertEqual(report["options"]["tolerance"], "1e-3rel")
        self.assertEqual(report["options"]["refine"], "global")
        self.assertEqual(report["options"]["continuity"], "g1")
        self.assertEqual(report["options"]["time-limit"], "60")
        self.assertEqual(report["options"]["quiet"], "false")
        self.check_deviation(report["deviation"]["output_to_input"], report["solid"]["faces"])
        self.check_deviation(report["deviation"]["input_to_output"], report["input"]["faces"])
        report = self.valid("compare", WING / "wing.igs", step)
        self.check_deviation(report["deviation"]["output_to_input"], report["solid"]["faces"])
        self.valid("compare", WING / "wing.igs", step, "--tolerance", "1e-9rel", code=3)
        self.valid("inspect", WING / "wing.igs")

    def test_a_turned_plane_has_its_angle_on_every_face(self):
        def square(name, slope):
            return self.path(name, f"v 0 0 0\nv 100 0 {100 * slope}\nv 100 100 {100 * slope}\nv 0 100 0\nf 1 2 3\nf 1 3 4\n")
        report = self.valid("compare", square("a.obj", 0.0), square("b.obj", 0.01), "--samples", 500)
        faces = report["deviation"]["output_to_input"]["faces"]
        self.assertEqual(len(faces), 2)
        for face in faces:
            self.assertAlmostEqual(face["normal_max_deg"], 0.5729386, places=6)  # atan(0.01)
            self.assertAlmostEqual(face["normal_rms_deg"], 0.5729386, places=6)

    def test_the_others(self):
        self.valid("cage", WING / "wing.step", "-o", self.path("a.obj"), "--tolerance", "1e-3rel")
        self.valid("fit", WING / "wing.step", "--cage", WING / "wing_cage.obj", "-o", self.path("a.obj"), "--tolerance", "1e-2rel")
        self.valid("refit", WING / "wing_cage.obj", WING / "wing.step", "-o", self.path("a.obj"), "--cad-out", self.path("a.step"),
                   "--tolerance", "1e-2rel")
        copy = self.path("copy.step", (WING / "wing.step").read_text())
        report = self.valid("family", WING / "wing_cage.obj", WING / "wing.step", copy, "-o", self.path("{name}.obj"),
                            "--modes", 1, "--tolerance", "1e-2rel")
        self.assertEqual(report["family"]["modes"], [])
        rows = sum(line.startswith("v ") for line in (WING / "wing_cage.obj").read_text().splitlines())
        modes = self.path("modes.csv", "".join(f"{i},0,0,0,0,1\n" for i in range(rows)))
        self.valid("member", WING / "wing_cage.obj", "--modes", modes, "--weights", 1, "-o", self.path("a.obj"))
        nodes = self.path("nodes.csv", "".join(f"{x},{y},{z},0,0,{x}\n" for x in (-50, 50) for y in (-50, 50) for z in (-50, 50)))
        forces = self.path("forces.csv", "0,0.5,0.5,0,0,1\n")
        report = self.valid("morph", CUBE, "--displacements", nodes, "-o", self.path("a.obj"), "--cad-out", self.path("a.step"),
                            "--forces", forces, "--forces-out", self.path("loads.csv"))
        self.assertEqual(report["morph"]["forces"]["force"], [0, 0, 1])
        self.path("more.csv", nodes.read_text())
        self.valid("morph", CUBE, "--displacements", nodes, self.path("more.csv"), "-o", self.path("{step}.obj"), "--cad-out",
                   self.path("{step}.step"), "--grid-out", self.path("{step}.cgns"))
        self.valid("export", CUBE, "-o", self.path("a.step"))
        self.valid("grid", CUBE, "-o", self.path("a.cgns"), "--points", 9, "--layers", 3, "--layer-height", "1e-3rel")
        report = self.valid("grid", CUBE, "-o", self.path("a.vtu"), "--points", 3, "--size-field", self.path("sizes.csv", "9,9,9,1\n0,0,0,50\n"),
                            "--hanging-nodes", "quads")
        self.assertGreater(report["grid"]["levels"], 0)
        self.assertIn("hanging_nodes", report["grid"])
        self.valid("subdivide", CUBE, "-n", 2, "-o", self.path("a.obj"))

    def test_failures(self):
        bad = self.path("bad.step", "no STEP file")
        report = self.valid("convert", bad, "-o", self.path("a.step"), "--tolerance", "0.1mm", code=2)
        self.assertEqual(report["error"]["exit_code"], 2)
        self.assertIn("bad.step", report["error"]["message"])
        self.assertEqual(report["options"]["tolerance"], "0.1mm")
        self.assertNotIn("verdict", report)
        report = self.valid("grid", CUBE, "-o", self.path("a.cgns"), "--layers", 3, "--size", "1mm", code=1)
        self.assertIn("--layers", report["error"]["message"])
        result = run("inspect", bad, "--json", "-")
        self.assertEqual(result.returncode, 2)
        jsonschema.Draft202012Validator(SCHEMA).validate(json.loads(result.stdout))


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
