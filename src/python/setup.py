"""pip install ./src/python: builds the library with CMake and puts the module beside the Python files.

PATCHWRIGHT_BUILD names a build folder of the same sources to take them from, in place of build/python-package;
with PATCHWRIGHT_SHARED the module goes on using the shared library there.
"""
import os
import pathlib
import re
import shutil
import subprocess
import sys

from setuptools import Distribution, setup
from setuptools.command.build_py import build_py

ROOT = pathlib.Path(__file__).resolve().parents[2]
WORK = ROOT / "build" / "python-package"


class Build(build_py):
    """The Python files, and what CMake makes."""

    def run(self):
        super().run()
        folder = self.compile_with_cmake()
        package = pathlib.Path(self.build_lib) / "patchwright"
        made = [*folder.glob("_core.*.so"), folder / "_reader"]
        if len(made) < 2:
            sys.exit(f"{folder}: the module was not built; see the output of CMake above")
        for file in made:
            shutil.copy2(file, package)

    def compile_with_cmake(self):
        given = os.environ.get("PATCHWRIGHT_BUILD")
        build = pathlib.Path(given) if given else WORK / "cmake"
        if not given:
            subprocess.run(["cmake", "-S", ROOT, "-B", build, "-G", "Ninja", "-C", ROOT / "tools/cmake/release.cmake",
                            "-DPATCHWRIGHT_WITH_PYTHON=ON", "-DPATCHWRIGHT_BUILD_TESTS=OFF",
                            f"-DPython3_EXECUTABLE={sys.executable}"], check=True)
            if "pybind11_DIR-NOTFOUND" in (build / "CMakeCache.txt").read_text():
                sys.exit("pybind11 is missing: tools/install-packages build python")
        subprocess.run(["cmake", "--build", build, "--target", "patchwright_python", "patchwright_reader"], check=True)
        return build / "python" / "patchwright"


class BinaryDistribution(Distribution):
    """Its wheels are for one platform."""

    def has_ext_modules(self):
        return True


(WORK / "info").mkdir(parents=True, exist_ok=True)
setup(name="patchwright",
      version=re.search(r"^project\(patchwright VERSION ([\d.]+)", (ROOT / "CMakeLists.txt").read_text(), re.MULTILINE)[1],
      description="Legacy CAD to a few clean, smooth, untrimmed patches by Catmull-Clark fitting",
      packages=["patchwright"],
      package_data={"patchwright": ["py.typed", "*.pyi"]},
      python_requires=">=3.9",
      install_requires=["numpy", "scipy"],
      cmdclass={"build_py": Build},
      distclass=BinaryDistribution,
      # Nothing is made beside the sources.
      options={"build": {"build_base": str(WORK / "build")}, "egg_info": {"egg_base": str(WORK / "info")}})
