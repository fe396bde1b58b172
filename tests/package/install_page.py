"""What the page src/docs/install.rst says, block by block; the tests run it where the package is installed."""
import pathlib
import re
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "docs"))
from docs_test import DOCS, blocks, says


def follow(test, run, headings):
    """Runs the commands under these headings with run(text), which gives their output, and looks for what the page shows of it."""
    page = re.split(r"^(\S.*)\n-+\n", (DOCS / "install.rst").read_text(), flags=re.MULTILINE)
    sections = dict(zip(page[1::2], page[2::2]))
    for heading in headings:
        output = None
        for kind, _, text in blocks(sections[heading]):
            if kind == "sh":
                output = run(text)
            for line in text.splitlines() if kind == "text" else []:
                test.assertTrue(says(line, output), f"{heading}: '{line}' is not in:\n{output}")
