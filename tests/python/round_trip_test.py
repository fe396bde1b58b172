"""samples/round_trip with an installed patchwright: the script of its CI file, line by line, and what it says of a bad translator.

round_trip_test.py PATCHWRIGHT SAMPLES_DIR BUILD
"""
import importlib.util
import os
import shlex
import shutil
import subprocess
import sys

from module import SAMPLES, ModuleTest, main, skip

BUILD = sys.argv[3]


class RoundTrip(ModuleTest):
    def setUp(self):
        super().setUp()
        prefix = self.folder / "prefix"
        subprocess.run(["cmake", "--install", BUILD, "--prefix", str(prefix)], check=True, stdout=subprocess.DEVNULL)
        package = next(prefix.rglob("patchwright/__init__.py")).parents[1]
        self.environment = {**os.environ, "CMAKE_PREFIX_PATH": str(prefix), "PYTHONPATH": str(package), "CMAKE_GENERATOR": "Ninja",
                            "PATH": f"{os.path.dirname(sys.executable)}:{os.environ['PATH']}"}
        self.project = self.folder / "samples" / "round_trip"
        shutil.copytree(SAMPLES / "round_trip", self.project, ignore=shutil.ignore_patterns("__pycache__"))
        shutil.copytree(SAMPLES / "wing", self.folder / "samples" / "wing")

    def run_script(self):
        import yaml
        lines = yaml.safe_load((self.project / "ci.yml").read_text())["round_trip"]["script"]
        self.assertEqual(len(lines), 3)
        return [subprocess.run(shlex.split(line), cwd=self.project, env=self.environment, capture_output=True, text=True)
                for line in lines]

    def test_as_it_is(self):
        for done in self.run_script():
            self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        self.assertIn("3 passed", done.stdout)

    def test_a_translator_that_is_off(self):
        # A cage near the wing that was not fitted to it.
        (self.project / "translate.py").write_text(
            "import sys, patchwright\n"
            "patchwright.export(sys.argv[1].replace('.step', '_cage.obj'), sys.argv[2])\n")
        _, ctest, pytest = self.run_script()
        for done in (ctest, pytest):
            self.assertNotEqual(done.returncode, 0)
            for part in ("MISSED", "distance", "mm", " at ("):
                self.assertIn(part, done.stdout)
        self.assertIn("round_trip_step (Failed)", ctest.stdout)
        self.assertIn("3 failed", pytest.stdout)

    def test_before_script(self):
        import yaml
        lines = yaml.safe_load((self.project / "ci.yml").read_text())["round_trip"]["before_script"]
        for line in lines:
            subprocess.run(["bash", "-n", "-c", line], check=True)
        text = "\n".join(lines)
        for word in shlex.split(text):
            if word.startswith("patchwright/tools/"):
                self.assertTrue((SAMPLES.parent / word.removeprefix("patchwright/")).exists(), word)
        import platform
        if platform.freedesktop_os_release().get("VERSION_CODENAME") == "bookworm":  # as its image
            self.assertTrue(self.environment["PYTHONPATH"].endswith(
                yaml.safe_load((self.project / "ci.yml").read_text())["round_trip"]["variables"]["PYTHONPATH"]
                .removeprefix("$PREFIX")))
        for option in ("PATCHWRIGHT_WITH_PYTHON", "PATCHWRIGHT_BUILD_TESTS"):
            self.assertIn(option, text)
            self.assertIn(f"option({option} ", (SAMPLES.parent / "CMakeLists.txt").read_text())


if __name__ == "__main__":
    for name in ("yaml", "pytest"):
        if importlib.util.find_spec(name) is None:
            skip(f"no {name}")
    main()
