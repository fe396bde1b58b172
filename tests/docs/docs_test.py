"""The documentation: commands and code of the guide do what it says, the site builds without warnings, its links lead somewhere.

docs_test.py PATCHWRIGHT SAMPLES_DIR
"""
import html.parser
import os
import pathlib
import re
import subprocess
import sys
import unittest
import urllib.parse

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "cli"))
from command_line import PATCHWRIGHT, SAMPLES, CliTest

try:
    import patchwright
except ImportError:  # not built
    patchwright = None

ROOT = SAMPLES.resolve().parent
DOCS = ROOT / "src" / "docs"
NUMBER = re.compile(r"\d+(?:\.\d+)?(?:e[-+]?\d+)?")
FREECAD = pathlib.Path("/usr/lib/freecad-python3/lib")


def same_number(said, found):
    """Counts are equal; deviations may move as fits do, but not to another order of magnitude."""
    if not re.search(r"[.e]", said) or said.startswith("1e-"):
        return said == found
    return 0.5 <= float(found) / float(said) <= 2 if float(said) else float(found) == 0


def says(line, output):
    """Whether a line of the output holds the words and numbers of `line`."""
    words, numbers = NUMBER.split(" ".join(line.split())), NUMBER.findall(line)
    pattern = re.compile(f"({NUMBER.pattern})".join(map(re.escape, words)))
    return any(all(map(same_number, numbers, match.groups()))
               for found in output.splitlines() for match in pattern.finditer(" ".join(found.split())))


def blocks(page):
    """(kind, caption or argument, text): code blocks, and the comments `needs`, `setup` and `exit` for this test."""
    pattern = re.compile(r"^\.\. code-block:: (\w+)\n((?:   :.*\n)*)\n((?:(?:   .*)?\n)+)|^\.\. (needs|setup|exit): (.*)\n", re.MULTILINE)
    for match in pattern.finditer(page + "\n"):
        if match[4]:
            yield match[4], match[5], ""
        else:
            caption = re.search(":caption: (.*)", match[2])
            yield match[1], caption and caption[1], re.sub("^   ", "", match[3].strip("\n"), flags=re.MULTILINE).strip() + "\n"


class Guide(CliTest):
    """Each page in a folder that holds samples and tools, its files from block to block."""

    def follow(self, page):
        for name in ("samples", "tools"):
            (self.folder / name).symlink_to(ROOT / name)
        (self.folder / "bin").mkdir()
        (self.folder / "bin" / "patchwright").symlink_to(pathlib.Path(PATCHWRIGHT).resolve())
        environment = {**os.environ, "HOME": str(self.folder), "PYTHONDONTWRITEBYTECODE": "1",
                       "PATH": f"{self.folder / 'bin'}:{os.path.dirname(sys.executable)}:{os.environ['PATH']}"}
        output, code, blocks_run, printed = "", 0, 0, None
        content = list(blocks((DOCS / page).read_text()))
        # Code is one program, whose output is cut between the blocks.
        program = "\nprint('\\f')\n".join(text for kind, _, text in content if kind == "python")
        for kind, caption, text in content:
            if kind == "needs":
                if caption == "freecad" and not FREECAD.exists() or caption == "python" and not patchwright:
                    self.skipTest(f"SKIPPED: no {caption}")
            elif kind == "exit":
                code = int(caption)
            elif caption and kind not in ("sh", "python", "setup"):
                (self.folder / caption).write_text(text)
            elif kind == "text":
                self.assertTrue(output, f"{page}: no command before: {text}")
                for line in text.splitlines():
                    self.assertTrue(says(line, output), f"{page}: '{line}' is not in:\n{output}")
            elif kind == "python" and printed:
                output = printed.pop(0)
            else:
                command = [sys.executable, "-c", program] if kind == "python" else \
                    ["bash", "-euo", "pipefail", "-c", caption if kind == "setup" else text]
                done = subprocess.run(command, cwd=self.folder, env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                                      text=True, timeout=600)
                self.assertEqual(done.returncode, code, f"{page}: {text or caption}{done.stdout}")
                output, code, blocks_run = done.stdout, 0, blocks_run + 1
                if kind == "python":
                    output, *printed = output.split("\f")
        self.assertGreater(blocks_run, 0)

    def test_every_page_is_followed(self):
        # tests/package follows install.rst and first_steps.rst.
        pages = {str(p.relative_to(DOCS)) for p in DOCS.rglob("*.rst")} - {"index.rst", "first_steps.rst", "install.rst", "changelog.rst"}
        tests = {name.removeprefix("test_page_") for name in dir(self) if name.startswith("test_page_")}
        self.assertEqual({pathlib.Path(page).stem for page in pages}, tests)

    def test_page_concepts(self):
        self.follow("concepts.rst")

    def test_page_wing(self):
        self.follow("tutorials/wing.rst")

    def test_page_blender(self):
        self.follow("tutorials/blender.rst")

    def test_page_wing_fuselage(self):
        self.follow("tutorials/wing_fuselage.rst")

    def test_page_grid(self):
        self.follow("tutorials/grid.rst")

    def test_page_changes(self):
        self.follow("tutorials/changes.rst")

    def test_page_python(self):
        self.follow("tutorials/python.rst")

    def test_options(self):
        """Options that the text names, apart from commands, are those of the program."""
        known = {option for name in ("convert", "compare", "inspect", "grid", "export", "fit", "refit", "morph", "cage", "eval", "subdivide")
                 for option in re.findall(r"--[\w-]+", subprocess.run([PATCHWRIGHT, "help", name], capture_output=True, text=True).stdout)}
        for page in DOCS.rglob("*.rst"):
            for option in re.findall(r"``(--[\w-]+)", page.read_text()):
                self.assertIn(option, known, page.name)

    def test_says(self):
        """What this test takes for the same."""
        output = "note: x\nmet 1e-4: one  solid, 6 patches, 4.1e-5 of it\n"
        for line, same in (("met 1e-4: one solid, 6 patches, 5e-5 of it", True), ("one solid, 6 patches", True),
                           ("met 1e-3: one solid", False), ("7 patches", False), ("6 patches, 4.1e-6 of it", False)):
            self.assertEqual(says(line, output), same, line)


class Page(html.parser.HTMLParser):
    def __init__(self, file):
        super().__init__()
        self.links, self.ids = [], set()
        self.feed(file.read_text())

    def handle_starttag(self, tag, attributes):
        found = dict(attributes)
        self.ids.update(found[key] for key in ("id", "name") if found.get(key))
        self.links += [found[key] for key in ("href", "src") if found.get(key)]


class Site(CliTest):
    def test_it_builds_and_its_links_lead_somewhere(self):
        built = subprocess.run([DOCS / "build", self.folder / "site"], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        if built.returncode == 77:
            self.skipTest(built.stdout.strip())
        self.assertEqual(built.returncode, 0, built.stdout)
        site = self.folder / "site" / "html"
        pages = {file: Page(file) for file in site.rglob("*.html")}
        checked = 0
        for file, page in pages.items():
            for link in page.links:
                address = urllib.parse.urlsplit(link)
                if address.scheme or address.netloc:
                    continue
                target = (file.parent / urllib.parse.unquote(address.path)).resolve() if address.path else file
                self.assertTrue(target.exists(), f"{file.name}: {link}")
                if address.fragment and target in pages:
                    self.assertIn(urllib.parse.unquote(address.fragment), pages[target].ids, f"{file.name}: {link}")
                checked += 1
        self.assertGreater(checked, 1000)
        # Every room and what its headers declare.
        for header in (ROOT / "include" / "patchwright").rglob("*.h"):
            room = header.parent.name
            text = (site / "api" / f"{room}.html").read_text()
            self.assertIn(f"patchwright/{room}/{header.name}", text)
            for name in re.findall(r"^(?:class|struct|enum class) (\w+) (?:final )?(?::[^:;]*)?\{", header.read_text(), re.MULTILINE):
                self.assertRegex(text, rf'id="_CPP[^"]*{name}', header)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]], verbosity=2)
