"""Runs every row of situations.tsv, each in a folder of its own, and keeps the table in tests/README.md the same.

Usage: situations_test.py PATCHWRIGHT SAMPLES_DIR [unittest arguments]
       situations_test.py --write-table README

A row's command is run by bash in a folder with cube.obj, cube.stl, wing.step and wing.igs, and with old.step and old.obj, which
must be as before unless the exit code is 0 or 3. `message` must be in the output; errors are one line.
"""
import csv
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

HERE = pathlib.Path(__file__).parent
BEGIN, END = "<!-- table: situations -->\n", "<!-- end -->\n"


def rows():
    with open(HERE / "situations.tsv", newline="") as file:
        return list(csv.DictReader(file, delimiter="\t", quoting=csv.QUOTE_NONE))


def table():
    text = "| situation | command | exit | message |\n|---|---|---|---|\n"
    for row in rows():
        command = row["command"].replace("|", "\\|")
        text += f"| {row['situation']} | `{command}` | {row['exit']} | {row['message']} |\n"
    return text


def with_table(text):
    begin, end = text.index(BEGIN) + len(BEGIN), text.index(END, text.index(BEGIN))
    return text[:begin] + table() + text[end:]


CUBE_STL = """solid cube
{}endsolid cube
"""


def cube_stl():
    at = lambda i: (i & 1, i >> 1 & 1, i >> 2)
    quads = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
    facets = ""
    for q in quads:
        for corners in ((0, 1, 2), (0, 2, 3)):
            points = "".join("vertex %d %d %d\n" % at(q[i]) for i in corners)
            facets += f"facet normal 0 0 0\nouter loop\n{points}endloop\nendfacet\n"
    return CUBE_STL.format(facets)


class Situations(unittest.TestCase):
    def test_each_row(self):
        program, samples = pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(sys.argv[2])
        for row in rows():
            with self.subTest(row["situation"]), tempfile.TemporaryDirectory(prefix="patchwright") as name:
                folder = pathlib.Path(name)
                shutil.copy(samples / "cages" / "cube.obj", folder)
                shutil.copy(samples / "wing" / "wing.step", folder)
                shutil.copy(samples / "wing" / "wing.igs", folder)
                (folder / "cube.stl").write_text(cube_stl())
                for old in ("old.step", "old.obj"):
                    (folder / old).write_text("old")
                environment = {**os.environ, "PATH": f"{program.parent}:{os.environ['PATH']}"}
                result = subprocess.run(["bash", "-c", row["command"]], cwd=folder, env=environment, capture_output=True, text=True,
                                        timeout=120)
                code = int(row["exit"])
                self.assertEqual(result.returncode, code, result.stderr)
                self.assertIn(row["message"], result.stdout + result.stderr)
                lines = [line for line in result.stderr.splitlines() if not line.startswith("note: ")]
                if code not in (0, 3):
                    self.assertEqual(len(lines), 1, result.stderr)
                    self.assertTrue(lines[0].startswith("patchwright: "))
                    for old in ("old.step", "old.obj"):
                        self.assertEqual((folder / old).read_text(), "old")
                self.assertEqual([p for p in folder.rglob(".*")], [])

    def test_the_table_in_the_readme_is_this_one(self):
        text = (HERE.parent / "README.md").read_text()
        self.assertTrue(text == with_table(text), "run tests/cli/situations_test.py --write-table tests/README.md")


if __name__ == "__main__":
    if sys.argv[1] == "--write-table":
        readme = pathlib.Path(sys.argv[2])
        readme.write_text(with_table(readme.read_text()))
    else:
        unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
