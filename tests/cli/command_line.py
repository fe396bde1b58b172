"""What the tests of the command line share. The first two arguments of each are PATCHWRIGHT SAMPLES_DIR."""
import json
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

PATCHWRIGHT = sys.argv[1]
SAMPLES = pathlib.Path(sys.argv[2])
WING = SAMPLES / "wing"


def run(*arguments, **options):
    return subprocess.run([PATCHWRIGHT, *map(str, arguments)], capture_output=True, text=True, timeout=300, **options)


class CliTest(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="patchwright"))
        self.addCleanup(shutil.rmtree, self.folder)

    def path(self, name, text=None):
        path = self.folder / name
        if text is not None:
            path.write_text(text)
        return path

    def check_error(self, result, code, *parts):
        self.assertEqual(result.returncode, code, result.stderr)
        lines = [line for line in result.stderr.splitlines() if not line.startswith("note: ")]
        self.assertEqual(len(lines), 1, result.stderr)
        for part in parts:
            self.assertIn(part, lines[0])
        self.assertEqual(result.stdout, "")

    def check_refused(self, arguments, code, *parts):
        """`{out}` in the arguments is an existing file, which must stay as it is, alone in its folder."""
        folder = self.folder / "out"
        folder.mkdir(exist_ok=True)
        for suffix in (".step", ".obj"):
            (folder / f"old{suffix}").write_text("old")
        arguments = [str(a).replace("{out}", str(folder / "old")) for a in arguments]
        self.check_error(run(*arguments), code, *parts)
        self.assertEqual(sorted(os.listdir(folder)), ["old.obj", "old.step"])
        for old in folder.iterdir():
            self.assertEqual(old.read_text(), "old")

    def report(self, *arguments, code=0):
        file = self.path("report.json")
        result = run(*arguments, "--json", file)
        self.assertEqual(result.returncode, code, result.stderr)
        return json.loads(file.read_text())
