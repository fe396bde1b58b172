"""FreeCAD's window on a virtual display: a script clicks through the workbench's three commands.

Usage: gui_test.py PATCHWRIGHT SAMPLES_DIR PICTURES [unittest arguments]
The add-on is installed as a user's: as a folder in Mod. PICTURES is a folder for screenshots. Exit code 77: FreeCAD or Xvfb is not installed.
"""
import json
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

PROGRAMS = ("freecad", "xvfb-run")
for name in PROGRAMS:
    if shutil.which(name) is None:
        print(f"SKIPPED: {name} is not installed")
        sys.exit(77)
PATCHWRIGHT, SAMPLES, PICTURES = (pathlib.Path(argument).resolve() for argument in sys.argv[1:4])
HERE = pathlib.Path(__file__).resolve().parent
# No start page, which needs a browser's sandbox; the program as a user sets it.
SETTINGS = """<?xml version="1.0" encoding="UTF-8" standalone="no" ?>
<FCParameters><FCParamGroup Name="Root"><FCParamGroup Name="BaseApp"><FCParamGroup Name="Preferences">
<FCParamGroup Name="General"><FCText Name="AutoloadModule">PatchwrightWorkbench</FCText></FCParamGroup>
<FCParamGroup Name="View"><FCBool Name="Gradient" Value="0"/><FCBool Name="Simple" Value="1"/>
<FCUInt Name="BackgroundColor" Value="4294967295"/></FCParamGroup>
<FCParamGroup Name="Mod"><FCParamGroup Name="Patchwright"><FCText Name="Program">{}</FCText></FCParamGroup></FCParamGroup>
</FCParamGroup></FCParamGroup></FCParamGroup></FCParameters>
"""


class Window(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        PICTURES.mkdir(parents=True, exist_ok=True)
        for file in PICTURES.iterdir():
            file.unlink()
        with tempfile.TemporaryDirectory(prefix="patchwright") as home:
            add_ons = pathlib.Path(home) / "Mod"
            add_ons.mkdir()
            shutil.copytree(HERE.parents[1] / "tools/freecad", add_ons / "Patchwright")
            (pathlib.Path(home) / "user.cfg").write_text(SETTINGS.format(PATCHWRIGHT))
            settings = {"FREECAD_USER_HOME": home, "PATCHWRIGHT_GUI_TEST": str(PICTURES), "PATCHWRIGHT_GUI_WING": str(SAMPLES / "wing/wing.igs")}
            cls.process = subprocess.run(
                ["xvfb-run", "-a", "-s", "-screen 0 1600x1000x24", "freecad", str(HERE / "gui_clicks.py")],
                env={**os.environ, **settings}, capture_output=True, text=True, timeout=400)
        file = PICTURES / "result.json"
        assert file.exists(), cls.process.stdout + cls.process.stderr
        cls.result = json.loads(file.read_text())
        assert "error" not in cls.result, cls.result["error"]

    def test_convert(self):
        found = self.result["convert"]
        self.assertTrue(self.result["proposed"].endswith("samples/wing/wing_patches.step"))
        self.assertTrue(found["verdict"].startswith("met 1e-3: one closed valid solid, 6 patches"), found["verdict"])
        self.assertIn("fit", self.result["stages"])
        tree = dict(found["tree"])
        self.assertEqual([label.split(",")[0] for label in tree["wing as patches"]], ["wing", "Worst places", "6 patches", "Deviation"])
        self.assertEqual(len([name for name in tree["6 patches"] if "/root/" in name]), 1)
        self.assertEqual(len(found["rows"]), 10)

    def test_place(self):
        place = self.result["place"]
        self.assertLess(place["height"], 0.3 * self.result["convert"]["height"])
        (model, faces), (places, vertices) = place["selected"]
        self.assertEqual((model, places, vertices), ("wing", "Worst places", ["Vertex1"]))
        self.assertTrue(faces[0].startswith("Face"))

    def test_cancel(self):
        self.assertEqual(self.result["cancel"], "cancelled; no file was written or changed")
        self.assertFalse((PICTURES / "cancelled.step").exists())

    def test_compare(self):
        self.assertTrue(self.result["compare"]["verdict"].startswith("MISSED: "), self.result["compare"]["verdict"])
        self.assertLessEqual({"output to input", "input to output"}, {what for what, _ in self.result["compare"]["rows"]})
        # Nothing lies over what is shown: neither the input nor the field of the conversion.
        visible = self.result["compare"]["visible"]
        for name in ("wing", "Deviation", "Worst places"):
            self.assertEqual(len([label for label in visible if label.startswith(name) and "patches" not in label and "compared" not in label]), 1, name)

    def test_colours(self):
        """At 1e-3 most is blue; at 2e-5 the same deviation is red in places, also in a document that is opened again."""
        (blue, red), (less_blue, more_red), before, after = self.result["colours"]
        self.assertGreater(blue, 0.5)
        self.assertLess(less_blue, blue)
        self.assertGreater(more_red, red)
        self.assertGreater(more_red, 0.05)
        for share, opened in zip(before, after):
            self.assertAlmostEqual(opened, share, delta=0.01)

    def test_inspect(self):
        found = self.result["inspect"]
        self.assertEqual(self.result["preselected"], "wing")
        self.assertEqual(found["verdict"], "closed, valid: 6 faces (6 bspline 3x3)")
        self.assertEqual(len([what for what, value in found["rows"] if value.startswith("B-spline 3x3")]), 6)
        (model, faces), = found["selected"]
        self.assertEqual((model, len(faces)), ("wing", 1))

    def test_preferences(self):
        self.assertEqual(self.result["preferences"], str(PATCHWRIGHT))


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[4:]])
