"""What `cmake --install` of a build with the shared library gives: its symbols and name, and samples/cpp with CMake and pkg-config.

install_test.py PATCHWRIGHT SAMPLES_DIR PREFIX
"""
import functools
import gzip
import os
import pathlib
import platform
import re
import subprocess
import sys
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "cli"))
from command_line import SAMPLES, CliTest
from install_page import follow

PREFIX = pathlib.Path(sys.argv[3])
LIBRARY = next(PREFIX.glob("lib/**/libpatchwright.so"))


def output_of(*command, **options):
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, timeout=600, **options)
    if done.returncode != 0:
        raise AssertionError(f"{command}: exit code {done.returncode}\n{done.stdout}")
    return done.stdout


@functools.cache
def public_words(room):
    """All words in the public headers of a room, comments left out."""
    text = "".join(header.read_text() for header in (PREFIX / "include" / "patchwright" / room).glob("*.h"))
    return set(re.findall(r"\w+", re.sub(r"//.*", "", text)))


class Install(CliTest):
    def setUp(self):
        super().setUp()
        (self.folder / "samples").symlink_to(SAMPLES.resolve())
        self.environment = {**os.environ, "CMAKE_PREFIX_PATH": str(PREFIX), "CMAKE_GENERATOR": "Ninja", "CMAKE_BUILD_PARALLEL_LEVEL": "2",
                            "PKG_CONFIG_PATH": str(LIBRARY.parent / "pkgconfig"), "LD_LIBRARY_PATH": str(LIBRARY.parent)}

    def run_block(self, text):
        return output_of("bash", "-euo", "pipefail", "-c", text, cwd=self.folder, env=self.environment) if "apt-get" not in text else ""

    def test_symbols(self):
        """Only what public headers name is exported: functions and classes in patchwright::ROOM."""
        names = output_of("nm", "-DC", "--defined-only", LIBRARY).splitlines()
        self.assertGreater(len(names), 300)
        for line in names:
            found = re.search(r"\bpatchwright::(\w+)::(\w+)", line)
            self.assertTrue(found, line)
            self.assertIn(found[2], public_words(found[1]), line)

    def test_names(self):
        version = re.search(r'PACKAGE_VERSION "(\d+\.\d+)\.\d+"', next(PREFIX.glob("lib/**/patchwrightConfigVersion.cmake")).read_text())[1]
        soname = f"libpatchwright.so.{version}"
        self.assertIn(f"soname: [{soname}]", output_of("readelf", "-d", LIBRARY))
        self.assertTrue((LIBRARY.parent / soname).exists())
        for user in (PREFIX / "bin" / "patchwright", *PREFIX.glob("lib/python*/*/patchwright/_*o*r*")):
            if user.suffix in ("", ".so"):
                self.assertIn(f"[{soname}]", output_of("readelf", "-d", user), user)
        clean = {"PATH": "/usr/bin:/bin"}
        self.assertIn(version, output_of(PREFIX / "bin" / "patchwright", "--version", env=clean))

    def test_versions(self):
        """One version everywhere, and the changelog has a section for it."""
        version = re.search(r'PACKAGE_VERSION "([\d.]+)"', next(PREFIX.glob("lib/**/patchwrightConfigVersion.cmake")).read_text())[1]
        told = output_of("pkg-config", "--modversion", "patchwright", env=self.environment)
        self.assertEqual(told.strip(), version)
        share = PREFIX / "share"
        for file, words in (("freecad/Mod/Patchwright/package.xml", f"<version>{version}</version>"),
                            ("blender/scripts/addons/patchwright_cage/__init__.py", f'"version": ({version.replace(".", ", ")})'),
                            ("doc/patchwright/changelog.rst", f"\n{version}\n-")):
            self.assertIn(words, (share / file).read_text())

    def test_examples_with_cmake(self):
        follow(self, self.run_block, ["C++ with CMake"])

    def test_example_with_pkg_config(self):
        follow(self, self.run_block, ["C++ with pkg-config"])
        self.assertTrue((self.folder / "torus.step").exists())

    def test_other_flags(self):
        """Matrices of the library are freed by programs that are compiled for other instructions, and with a sanitizer."""
        for flag in ("-march=native", "-fsanitize=address"):
            self.run_block(f"g++ -std=c++20 -O1 {flag} samples/cpp/own_surface.cpp -o own_surface $(pkg-config --cflags --libs patchwright)\n"
                           "ASAN_OPTIONS=detect_leaks=0 ./own_surface torus.step")
        if platform.machine() == "x86_64":  # where AVX asks for more alignment
            with self.assertRaisesRegex(AssertionError, "definitions that patchwright's CMake and pkg-config files give"):
                self.run_block("g++ -std=c++20 -fsyntax-only -mavx samples/cpp/own_surface.cpp $(pkg-config --cflags-only-I patchwright)")

    def test_add_ons(self):
        for file in ("freecad/Mod/Patchwright/InitGui.py", "blender/scripts/addons/patchwright_cage/__init__.py"):
            self.assertTrue((PREFIX / "share" / file).exists(), file)

    def test_manual_and_completions(self):
        """Each names every subcommand."""
        share = PREFIX / "share"
        texts = [gzip.decompress((share / "man/man1/patchwright.1.gz").read_bytes()).decode(),
                 *((share / file).read_text() for file in ("bash-completion/completions/patchwright", "fish/vendor_completions.d/patchwright.fish",
                                                           "zsh/site-functions/_patchwright"))]
        listed = output_of(PREFIX / "bin" / "patchwright", "--help", env=self.environment).split("Subcommands:\n")[1].split("\n\n")[0]
        commands = re.findall(r"^  (\w+) ", listed, re.MULTILINE)
        self.assertGreater(len(commands), 10)
        for text in texts:
            for command in commands:
                self.assertRegex(text, rf"\b{command}\b")


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[4:]], verbosity=2)
