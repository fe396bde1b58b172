"""Checks the include arrows between the rooms, where the kernel's headers appear, and the top level.

Usage: check_layering.py ROOT        prints every violation as file:line: reason
       check_layering.py --self-test plants one violation of each kind and expects it to be found
"""
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

ARROWS = {  # room: the rooms that it may include; what those may include, it may include as well
    "base": [],
    "geom": ["base"],
    "mesh": ["geom"],
    "subd": ["mesh"],
    "measure": ["subd"],
    "fit": ["measure"],
    "patch": ["subd"],
    "grid": ["patch"],
    "adapt": ["grid"],
    "report": ["fit", "patch", "adapt"],
    "occ": ["fit", "patch"],
    "cage": ["fit"],
    "convert": ["report", "cage", "occ"],
    "python": ["convert"],
}
TEST_ARROWS = {  # room: rooms that its tests may include besides, for the reason given
    "cage": ["occ", "patch"],  # models as users have them: read from files or assembled from patches
}
TOP_LEVEL = {"src", "include", "tools", "tests", "samples", "CMakeLists.txt", "README.md"}
INCLUDE = re.compile(r'\s*#\s*include\s*([<"])([^>"]+)[>"]')
KERNEL_HEADER = re.compile(r"\.(hxx|lxx|gxx)$")
STANDARD_HEADER = re.compile(r"^[a-z_0-9]+$")


def reach(room):
    rooms = {room}
    for other in ARROWS[room]:
        rooms |= reach(other)
    return rooms


def reach_of_tests(room):
    return set().union(*(reach(other) for other in [room, *TEST_ARROWS.get(room, [])]))


def place_of(path):
    """(tree, room) of a file; room is None for files that belong to no room."""
    parts = path.parts
    if parts[:2] == ("include", "patchwright"):
        return "include", parts[2]
    if parts[0] == "src":
        return "src", parts[1]
    if parts[0] == "tests" and parts[1] in ARROWS:
        return "tests", parts[1]
    return parts[0], None


def included_room(header, quoted, path):
    """The room that a header of this project belongs to; None for others and for the own folder."""
    parts = header.split("/")
    if parts[0] == "patchwright" and len(parts) > 2:
        return parts[1]
    if quoted and len(parts) > 1 and parts[0] != "support":
        return parts[0]
    return None


def check_include(path, header, quoted):
    tree, room = place_of(path)
    if KERNEL_HEADER.search(header):
        generator = path.parent.as_posix() == "tools" and path.name.startswith("make_")
        if not ((tree in ("src", "tests") and room == "occ") or generator):
            yield f"OpenCASCADE header <{header}> outside src/occ, tests/occ and tools/make_*"
        return
    if ".." in header.split("/"):
        yield f"'{header}' leaves its folder"
        return
    other = included_room(header, quoted, path)
    if other and other not in ARROWS:
        yield f"'{header}' is in no room"
    elif other and room and other not in (reach_of_tests if tree == "tests" else reach)(room):
        yield f"{room} may not include {other} ('{header}')"
    elif other == "occ" and path.parts[:2] == ("tests", "support"):
        yield f"test support serves the core and may not include occ ('{header}')"
    if tree == "include" and (quoted or not (
            header.startswith("patchwright/") or header == "Eigen/Core" or STANDARD_HEADER.match(header))):
        yield f"a public header may include <Eigen/Core>, std and <patchwright/...> only, not '{header}'"


def check_visibility(path, text):
    """Public headers declare what the shared library exports: after the includes, all of it."""
    namespaces = text.find("\nnamespace ")
    if namespaces >= 0 and not (text[:namespaces].endswith("\n#pragma GCC visibility push(default)")
                                and text.endswith("\n#pragma GCC visibility pop\n")):
        yield f"{path}:1: a public header opens with '#pragma GCC visibility push(default)' before its namespace, ends with '... pop'"


def check_includes(root):
    for tree in ("include", "src", "tests", "tools"):
        for file in sorted((root / tree).rglob("*")):
            if file.suffix not in (".h", ".cpp", ".hpp", ".in"):
                continue
            path = file.relative_to(root)
            room = place_of(path)[1]
            if room and room not in ARROWS:
                yield f"{path}:1: folder '{room}' is no room"
                continue
            text = file.read_text()
            if tree == "include":
                yield from check_visibility(path, text)
            for number, line in enumerate(text.splitlines(), 1):
                match = INCLUDE.match(line)
                if match:
                    for reason in check_include(path, match[2], match[1] == '"'):
                        yield f"{path}:{number}: {reason}"


def top_level_names(root):
    """What git tracks or would add; the folder's content when it is no git repository."""
    git = subprocess.run(["git", "-C", root, "ls-files", "--cached", "--others", "--exclude-standard"],
                         capture_output=True, text=True)
    if git.returncode == 0 and (root / ".git").exists():
        return {line.split("/")[0].strip('"') for line in git.stdout.splitlines()}
    return {entry.name for entry in root.iterdir()} - {"build"}


def check_top_level(root):
    for name in sorted(top_level_names(root)):
        if name not in TOP_LEVEL and not name.startswith("."):
            yield f"{name}:1: the top level holds {', '.join(sorted(TOP_LEVEL))} and dotfiles only"


def violations(root):
    return [*check_includes(root), *check_top_level(root)]


class SelfTest(unittest.TestCase):
    def check(self, file, text, *expected):
        with tempfile.TemporaryDirectory() as folder:
            root = pathlib.Path(folder)
            (root / file).parent.mkdir(parents=True, exist_ok=True)
            (root / file).write_text("// comment\n" + text + "\n")
            found = violations(root)
        self.assertEqual(len(found), len(expected), found)
        for line, part in zip(found, expected):
            self.assertIn(part, line)

    def test_what_is_allowed(self):
        self.check("include/patchwright/fit/a.h", "#include <Eigen/Core>\n#include <vector>\n"
                                                  "#include <patchwright/base/b.h>")
        self.check("src/fit/a.cpp", '#include "fit/b.h"\n#include "b.h"\n#include <fmt/format.h>\n'
                                    "#include <patchwright/subd/c.h>")
        self.check("src/occ/a.cpp", "#include <gp_Pnt.hxx>\n#include <patchwright/patch/a.h>")
        self.check("tests/occ/a_test.cpp", "#include <gp_Pnt.hxx>")
        self.check("tests/fit/a_test.cpp", '#include "support/a.h"\n#include <catch2/catch.hpp>')
        self.check("tools/make_a.cpp", "#include <gp_Pnt.hxx>")
        self.check("tools/patchwright/a.cpp", "#include <patchwright/cage/a.h>")
        self.check(".hidden", "")

    def test_arrows_against_the_current(self):
        self.check("src/geom/a.cpp", "#include <patchwright/mesh/b.h>", "src/geom/a.cpp:2: geom may not include mesh")
        self.check("include/patchwright/fit/a.h", "#include <patchwright/patch/b.h>", "a.h:2: fit may not include patch")
        self.check("src/patch/a.cpp", "\n#  include <patchwright/fit/b.h>", "a.cpp:3: patch may not include fit")
        self.check("src/subd/a.cpp", '#include "fit/private.h"', "subd may not include fit")
        self.check("tests/mesh/a_test.cpp", "#include <patchwright/subd/b.h>", "mesh may not include subd")
        self.check("src/report/a.cpp", "#include <patchwright/occ/b.h>", "report may not include occ")
        self.check("tests/support/a.h", "#include <patchwright/occ/b.h>", "may not include occ")

    def test_exceptions_for_tests(self):
        self.check("tests/cage/a_test.cpp", "#include <patchwright/occ/b.h>\n#include <patchwright/patch/b.h>")
        self.check("src/cage/a.cpp", "#include <patchwright/occ/b.h>", "src/cage/a.cpp:2: cage may not include occ")
        self.check("include/patchwright/cage/a.h", "#include <patchwright/patch/b.h>", "cage may not include patch")
        self.check("tests/cage/a_test.cpp", "#include <patchwright/grid/b.h>", "cage may not include grid")

    def test_every_pair_of_rooms(self):
        for room in ARROWS:
            for other in ARROWS:
                expected = [] if other in reach(room) else [f"{room} may not include {other}"]
                self.check(f"src/{room}/a.cpp", f"#include <patchwright/{other}/b.h>", *expected)

    def test_kernel_headers_outside_their_room(self):
        for file in ("include/patchwright/occ/a.h", "src/cage/a.cpp", "tools/patchwright/a.cpp", "tests/fit/a_test.cpp"):
            self.check(file, "#include <gp_Pnt.hxx>", f"{file}:2: OpenCASCADE header <gp_Pnt.hxx>")

    def test_public_headers(self):
        for header in ("<Eigen/Dense>", "<fmt/format.h>", "<nlohmann/json.hpp>", '"b.h"', "<unistd.h>"):
            self.check("include/patchwright/geom/a.h", f"#include {header}", "a.h:2: a public header may include")

    def test_visibility(self):
        self.check("include/patchwright/fit/a.h", "\n#pragma GCC visibility push(default)\nnamespace a {\n}\n#pragma GCC visibility pop")
        for text in ("\nnamespace a {\n}", "\nnamespace a {\n}\n#pragma GCC visibility pop",
                     "\n#pragma GCC visibility push(default)\nnamespace a {\n}"):
            self.check("include/patchwright/fit/a.h", text, "a.h:1: a public header opens with")

    def test_unknown_rooms_and_ways_out(self):
        self.check("src/util/a.cpp", "", "folder 'util' is no room")
        self.check("src/fit/a.cpp", "#include <patchwright/util/b.h>", "is in no room")
        self.check("src/fit/a.cpp", '#include "../patch/b.h"', "leaves its folder")

    def test_top_level(self):
        self.check("notes.txt", "", "notes.txt:1: the top level holds")


def main():
    if sys.argv[1:] == ["--self-test"]:
        unittest.main(argv=sys.argv[:1])
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    found = violations(pathlib.Path(sys.argv[1]).resolve())
    print("\n".join(found) if found else "The layering holds.")
    sys.exit(1 if found else 0)


if __name__ == "__main__":
    main()
