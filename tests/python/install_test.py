"""pip install ./src/python, from the build that there is, and a conversion with what is installed.

install_test.py PATCHWRIGHT SAMPLES_DIR BUILD
"""
import importlib.util
import os
import pathlib
import re
import subprocess
import sys
import sysconfig

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "package"))
import install_page
from module import SAMPLES, WING, ModuleTest, main, skip

SOURCES = SAMPLES.parent / "src" / "python"


class Install(ModuleTest):
    def test_pip(self):
        before = sorted(SOURCES.rglob("*"))
        environment = {**os.environ, "PATCHWRIGHT_BUILD": sys.argv[3]}
        environment.pop("PYTHONPATH")
        subprocess.run([sys.executable, "-m", "pip", "install", "--quiet", "--no-index", "--no-build-isolation",
                        "--no-deps", "--prefix", str(self.folder), str(SOURCES)], check=True, env=environment)
        self.assertEqual(sorted(SOURCES.rglob("*")), before)  # nothing is made beside the sources
        found = list(self.folder.rglob("patchwright/__init__.py"))
        self.assertEqual(len(found), 1)
        environment["PYTHONPATH"] = str(found[0].parents[1])
        program = ("import sys, patchwright, importlib.metadata; print(patchwright.__file__);"
                   "assert importlib.metadata.version('patchwright') == patchwright.__version__;"
                   "print(patchwright.convert(sys.argv[1], sys.argv[2], cage=sys.argv[3]).verdict.sentence)")
        told = subprocess.run([sys.executable, "-c", program, str(WING / "wing.igs"), str(self.folder / "a.step"),
                               str(WING / "wing_cage.obj")], env=environment, capture_output=True, text=True)
        self.assertEqual(told.returncode, 0, told.stderr)
        place, sentence = told.stdout.splitlines()
        self.assertEqual(pathlib.Path(place), found[0])
        self.assertTrue(sentence.startswith("met 1e-4: one closed valid solid"), sentence)

    def test_the_page(self):
        """What src/docs/install.rst says, from the build that there is."""
        if importlib.util.find_spec("ensurepip") is None:
            self.skipTest("SKIPPED: no python3-venv")
        for name in ("src", "samples", "tools"):
            (self.folder / name).symlink_to(SOURCES.parents[1] / name)
        environment = {**os.environ, "PATCHWRIGHT_BUILD": sys.argv[3], "PATH": f"{os.path.dirname(sys.executable)}:{os.environ['PATH']}"}
        environment.pop("PYTHONPATH")

        def run(text):
            text = re.sub("^tools/install-packages.*\n", "", text)
            done = subprocess.run(["bash", "-euo", "pipefail", "-c", text], cwd=self.folder, env=environment, text=True,
                                  stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
            self.assertEqual(done.returncode, 0, done.stdout)
            return done.stdout

        install_page.follow(self, run, ["Python by itself"])

    def test_cmake(self):
        subprocess.run(["cmake", "--install", sys.argv[3], "--prefix", str(self.folder)], check=True,
                       stdout=subprocess.DEVNULL)
        version, kind = sysconfig.get_python_version(), pathlib.Path(sysconfig.get_path("platlib")).name
        package = self.folder / "lib" / f"python{version}" / kind / "patchwright"
        if kind == "dist-packages":
            self.assertIn(f"/usr/local/lib/python{version}/{kind}", sys.path)  # where the default prefix puts it
        self.assertTrue((package / "_core.pyi").exists())
        told = subprocess.run([sys.executable, "-c", "import sys, patchwright as p; print(p.read(sys.argv[1]).is_cad)",
                               str(WING / "wing.step")], env={**os.environ, "PYTHONPATH": str(package.parent)},
                              capture_output=True, text=True, check=True)
        self.assertEqual(told.stdout.strip(), "True")


if __name__ == "__main__":
    for name in ("pip", "setuptools", "wheel"):
        if importlib.util.find_spec(name) is None:
            skip(f"no {name}")
    main()
