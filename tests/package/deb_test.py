"""The Debian package on an empty bookworm: built, installed in a chroot by apt, used as src/docs/install.rst says.

deb_test.py PATCHWRIGHT SAMPLES_DIR BUILD    BUILD is where the package is built, or a package
Needs root, debootstrap and a network; mirrors are those of debootstrap.
"""
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "cli"))
from command_line import SAMPLES
from install_page import follow

ROOT = SAMPLES.resolve().parent
INSIDE = {"PATH": "/usr/sbin:/usr/bin:/sbin:/bin", "HOME": "/root", "LC_ALL": "C.UTF-8", "DEBIAN_FRONTEND": "noninteractive"}


def build_package(build):
    subprocess.run(["cmake", "-S", ROOT, "-B", build, "-G", "Ninja", "-C", ROOT / "tools" / "cmake" / "deb.cmake"], check=True)
    for old in build.glob("patchwright_*.deb"):
        old.unlink()
    subprocess.run(["cmake", "--build", build, "--target", "package"], check=True)
    return next(build.glob("patchwright_*.deb"))


class Bookworm(unittest.TestCase):
    def setUp(self):
        given = pathlib.Path(sys.argv[3])
        package = given if given.is_file() else build_package(given)
        self.root = pathlib.Path(tempfile.mkdtemp(prefix="patchwright-bookworm"))
        self.addCleanup(shutil.rmtree, self.root)
        subprocess.run(["debootstrap", "--variant=minbase", "bookworm", self.root], check=True, stdout=subprocess.DEVNULL)
        subprocess.run(["mount", "-t", "proc", "proc", self.root / "proc"], check=True)
        self.addCleanup(subprocess.run, ["umount", self.root / "proc"], check=True)
        home = self.root / "root"
        shutil.copy(package, home)
        for folder in ("samples", "tools", "src/docs", "tests/cli", "tests/docs"):
            shutil.copytree(ROOT / folder, home / folder)

    def run_inside(self, text):
        if "tools/install-packages" in text:  # how the package is built
            return ""
        done = subprocess.run(["chroot", self.root, "bash", "-euo", "pipefail", "-c", "cd; " + text], env=INSIDE, text=True, timeout=1800,
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
        print(f"$ {text.strip()}\n{done.stdout[-1500:]}", flush=True)
        self.assertEqual(done.returncode, 0, text)
        return done.stdout

    def test_install_page(self):
        follow(self, self.run_inside, ["Debian package", "C++ with CMake", "C++ with pkg-config"])
        # The guide, and round-trip tests in a project of one's own.
        self.run_inside("python3 tests/docs/docs_test.py /usr/bin/patchwright samples Guide")
        self.run_inside("cmake -S samples/round_trip -B build/round_trip && ctest --test-dir build/round_trip --output-on-failure --no-tests=error")
        # Where Debian's FreeCAD and Blender look, which are not installed here.
        for place in ("freecad/Mod/Patchwright/InitGui.py", "blender/scripts/addons/patchwright_cage/__init__.py"):
            self.assertTrue((self.root / "usr" / "share" / place).exists(), place)
        self.run_inside("dpkg --verify patchwright && apt-get remove --yes patchwright && test ! -e /usr/lib/python3/dist-packages/patchwright")


if __name__ == "__main__":
    if os.geteuid() != 0 or not shutil.which("debootstrap"):
        print("SKIPPED: needs root and debootstrap (tools/install-packages deb)")
        sys.exit(77)
    unittest.main(argv=[sys.argv[0], *sys.argv[4:]], verbosity=2)
