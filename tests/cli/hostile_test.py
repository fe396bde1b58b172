"""Hostile files, one subtest for each row of ../shared/hostile/INDEX.tsv.

Usage: hostile_test.py PATCHWRIGHT SAMPLES_DIR HOSTILE_DIR [unittest arguments]
Exit codes: 0 all passed, 1 not so, 77 none failed but some were skipped, since HOSTILE_DIR is not there.

Required of every run: no signal, an end within its limit, one line of error where it fails; where it ends with anything
but 0 and 3, the old output is as it was; where it ends with 0, what it wrote is valid for `inspect`.
"""
import csv
import dataclasses
import json
import os
import pathlib
import re
import subprocess
import sys
import unittest

from command_line import CliTest, PATCHWRIGHT, run, SAMPLES

FOLDER = pathlib.Path(sys.argv[3])
HANG_S = 120  # runs that take longer are taken for endless; no row needs a quarter of it
OLD = "old content"


@dataclasses.dataclass
class Row:
    """One run. In the arguments FILE is the hostile file, OUT an existing output without its extension, CUBE a sound model."""
    file: str
    arguments: str
    codes: tuple
    says: str = ""  # part of standard error
    solid: bool = False  # where it ends with 0, a closed solid of positive volume was written


ROWS = [
    # CAD files that lose faces or units.
    Row("lost_unknown_face.step", "inspect FILE", (2,), "#17 FANCY_FACE: unknown entity"),
    Row("lost_unknown_face.step", "inspect FILE --allow-loss", (0,), "#17 FANCY_FACE"),
    Row("lost_unknown_face.step", "convert FILE -o OUT.step", (2,), "#17 FANCY_FACE"),
    Row("lost_hole_gone.step", "inspect FILE", (2,), "#402 ADVANCED_FACE"),
    Row("lost_hole_gone.step", "convert FILE -o OUT.step", (2,), "#402 ADVANCED_FACE"),
    Row("lost_hole_neg.step", "inspect FILE", (2,), "#402 ADVANCED_FACE"),
    Row("lost_hole_neg.step", "convert FILE -o OUT.step", (2,), "#402 ADVANCED_FACE"),
    Row("lost_neg_radius.step", "inspect FILE", (2,), "#17 ADVANCED_FACE"),
    Row("lost_neg_radius.step", "convert FILE -o OUT.step", (2,), "#17 ADVANCED_FACE"),
    Row("lost_no_unit.step", "inspect FILE", (2,), "#346"),
    Row("lost_no_unit.step", "convert FILE -o OUT.step", (2,), "--input-unit"),
    Row("lost_no_unit.step", "inspect FILE --input-unit mm", (0,)),
    # CAD files that bring the kernel down.
    Row("step_missing_point.step", "inspect FILE", (2,), "#17 ADVANCED_FACE"),
    Row("step_wrong_type.step", "inspect FILE", (2,), "#17 ADVANCED_FACE"),
    Row("step_cyclic_edge.step", "inspect FILE", (2,), "endless recursion"),
    Row("iges_crash.igs", "inspect FILE", (2,), "the CAD kernel crashes"),
    Row("iges_crash2.igs", "inspect FILE", (2,), "the CAD kernel crashes"),
    # CAD models of extreme proportions.
    Row("compare_hang.step", "compare FILE CUBE", (0, 2, 3)),
    Row("tinyhole.step", "convert FILE -o OUT.step --tolerance 1e-3rel", (0,), "1 hole narrower", solid=True),
    Row("tinyhole.step", "fit FILE -o OUT.obj --tolerance 1e-3rel", (0,), "1 hole narrower"),
    Row("tinyhole.step", "cage FILE -o OUT.obj --tolerance 1e-3rel", (0,), "1 hole narrower"),
    Row("aspect.step", "convert FILE -o OUT.step", (0, 3)),
    Row("plate.step", "convert FILE -o OUT.step --tolerance 1e-3rel", (0, 2, 3), solid=True),
    # Cages.
    Row("big_z.obj", "export FILE -o OUT.step", (2,), "beyond 1e+07 mm"),
    Row("long_name.obj", "export FILE -o OUT.step", (0,), "6 names of faces", solid=True),
    Row("name_l20000.obj", "export FILE -o OUT.step", (0,), "6 names of faces", solid=True),
    Row("eval_nan.obj", "eval FILE --at 0,0.5,0.5", (2,), "line 9: vertex 8"),
    Row("flat100.obj", "export FILE -o OUT.step", (3,)),
    Row("random4.obj", "export FILE -o OUT.step", (3,)),
    Row("point.obj", "export FILE -o OUT.step", (2,), "in one place"),
    Row("s1e-9.obj", "export FILE -o OUT.step", (2,), "less than 0.01 mm"),
    Row("s1e-9_sharp.obj", "export FILE -o OUT.step", (2,), "less than 0.01 mm"),
    Row("invalid_1e30.obj", "export FILE -o OUT.step", (2,), "beyond 1e+07 mm"),
    Row("invalid_1e308.obj", "export FILE -o OUT.step", (2,), "line 5: vertex 4"),
    Row("off1e12_sharp.obj", "export FILE -o OUT.step", (2,), "beyond 1e+07 mm"),
    Row("two_sector.obj", "export FILE -o OUT.step", (2,), "sector at vertex 1"),
    Row("hang_dart_sector.obj", "export FILE -o OUT.step", (2,), "two infinitely sharp edges"),
    Row("valence64.obj", "export FILE -o OUT.step", (0,), solid=True),
    Row("group40.obj", "grid FILE -o OUT.cgns", (0,)),
    Row("group_slash.obj", "grid FILE -o OUT.cgns", (0,)),
]


class HostileFiles(CliTest):
    def setUp(self):
        super().setUp()
        if not FOLDER.is_dir():
            self.skipTest(f"{FOLDER} is not there")

    def test_every_row_of_the_index_has_a_run(self):
        with open(FOLDER / "INDEX.tsv") as index:
            files = {row["file"] for row in csv.DictReader(index, delimiter="\t")}
        self.assertEqual(files - {row.file for row in ROWS}, set())

    def test_rows(self):
        for row in ROWS:
            with self.subTest(row.file, arguments=row.arguments):
                self.check(row)

    def check(self, row):
        folder, cube = self.folder / "run", self.folder / "cube.step"
        folder.mkdir(exist_ok=True)
        if "CUBE" in row.arguments:
            self.assertEqual(run("export", SAMPLES / "cages" / "cube.obj", "-o", cube).returncode, 0)
        names = {"FILE": FOLDER / row.file, "OUT": folder / "out", "CUBE": cube}
        arguments = [re.sub("FILE|OUT|CUBE", lambda name: str(names[name[0]]), a) for a in row.arguments.split()]
        outputs = [pathlib.Path(a) for a in arguments if a.startswith(str(folder))]
        for file in folder.iterdir():
            file.unlink()
        for file in outputs:
            file.write_text(OLD)
        result = subprocess.run([PATCHWRIGHT, *arguments], capture_output=True, text=True, timeout=HANG_S)
        self.assertIn(result.returncode, row.codes, result.stderr)
        self.assertIn(row.says, result.stderr)
        self.assertEqual(sorted(os.listdir(folder)), sorted(file.name for file in outputs))
        if result.returncode not in (0, 3):
            lines = [line for line in result.stderr.splitlines() if not line.startswith("note: ")]
            self.assertEqual(len(lines), 1, result.stderr)
            if row.file.endswith((".step", ".igs")):
                self.assertIn(row.file, lines[0])
            for file in outputs:
                self.assertEqual(file.read_text(), OLD)
        elif outputs and outputs[0].suffix == ".step" and result.returncode == 0:
            self.check_written(outputs[0], row.solid)

    def check_written(self, file, solid):
        result = subprocess.run([PATCHWRIGHT, "inspect", file, "--no-heal", "--json", "-"], capture_output=True,
                                text=True, timeout=HANG_S)
        self.assertEqual(result.returncode, 0, result.stderr)
        figures = json.loads(result.stdout)["solid"]
        self.assertTrue(figures["valid"])
        if solid:
            self.assertTrue(figures["closed"])
            self.assertGreater(figures["volume"], 0.0)


if __name__ == "__main__":
    result = unittest.main(argv=[sys.argv[0], *sys.argv[4:]], exit=False).result
    sys.exit(1 if not result.wasSuccessful() else 77 if result.skipped and not FOLDER.is_dir() else 0)
