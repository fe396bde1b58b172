"""Sphinx site: the guide beside this file, and a page for each room's public headers, written here from what there is."""
import os
import pathlib
import re

ROOT = pathlib.Path(__file__).resolve().parents[2]
HEADERS = ROOT / "include" / "patchwright"

project = "patchwright"
version = release = re.search(r"project\(patchwright VERSION ([\d.]+)", (ROOT / "CMakeLists.txt").read_text())[1]
extensions = ["breathe"]
html_theme = "alabaster"
html_theme_options = {"description": "Legacy CAD to a few smooth, untrimmed patches", "page_width": "1100px"}
html_show_copyright = False
html_copy_source = False
pygments_style = "sphinx"
primary_domain = highlight_language = "cpp"

breathe_projects = {"patchwright": os.environ["PATCHWRIGHT_DOXYGEN_XML"]}
breathe_default_project = "patchwright"
breathe_show_include = False


def underlined(text, character):
    return f"{text}\n{character * len(text)}\n"


def write_api_pages(folder):
    """A page a room, in the order of src/README.md: its line there, its headers' first sentences, what they declare."""
    rows = re.findall(r"^\| `(\w+)` \| (.*?) \| .* \|$", (ROOT / "src" / "README.md").read_text(), re.MULTILINE)
    rooms = [(room, text) for room, text in rows if (HEADERS / room).is_dir()]
    folder.mkdir(exist_ok=True)
    for room, text in rooms:
        headers = []
        for header in sorted((HEADERS / room).glob("*.h")):
            comment = re.match(r"((?://.*\n)*)", header.read_text())[1]
            headers.append(f"``<patchwright/{room}/{header.name}>``\n" + re.sub(r"^// ?", "   ", comment, flags=re.MULTILINE))
        (folder / f"{room}.rst").write_text("\n".join([
            underlined(room, "="), re.sub("`", "``", text[0].upper() + text[1:] + "."), "", *headers,
            f".. doxygennamespace:: patchwright::{room}\n   :members:\n   :undoc-members:\n   :content-only:\n"]))
    (folder / "index.rst").write_text(underlined("C++ reference", "=") + """
From the public headers, ``include/patchwright/ROOM/``. Each room may use those before it that the table in ``src/README.md`` names. Lengths are
millimetres and angles radians unless a name says otherwise; wrong input throws ``base::InputError`` or ``base::InvalidArgument``.

.. toctree::
   :maxdepth: 2

""" + "".join(f"   {room}\n" for room, _ in rooms))


def setup(app):
    write_api_pages(pathlib.Path(app.srcdir) / "api")
