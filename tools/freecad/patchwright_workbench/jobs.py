"""The three commands without a display: what the program is called with, and what its answer becomes in the document."""
import os
import shlex
from dataclasses import dataclass, field as dataclass_field

from . import document, preferences, results
from .field import read_field
from .program import ProgramError

REPORT, FIELD = "report.json", "field.vtp"


@dataclass(frozen=True)
class Source:
    """What is read: a file, or an object of the document."""

    file: str = ""
    thing: object = None

    @property
    def label(self):
        return self.thing.Label if self.thing else os.path.splitext(os.path.basename(self.file))[0]

    def path(self, folder):
        if self.thing:
            return document.export(self.thing, folder)
        if not os.path.isfile(self.file):
            raise ProgramError(f"{self.file or 'the input'}: no such file")
        return os.path.abspath(self.file)


@dataclass(frozen=True)
class Row:
    """A line of the list: where it leads to, if anywhere."""

    what: str
    value: str
    at: tuple = None
    model: object = None        # the object that the place is on
    element: str = ""           # its face; empty: the nearest
    marks: tuple = ()           # (object, element) to select as well


@dataclass
class Shown:
    """What a job has put into the document."""

    group: object
    model: object
    rows: list = dataclass_field(default_factory=list)
    notices: list = dataclass_field(default_factory=list)


def split_options(text):
    try:
        return shlex.split(text)
    except ValueError as error:
        raise ProgramError(f"further options: {error}") from error


def _rows_of_places(doc, group, report, output, given):
    places = report.places()
    if not places:
        return []
    marks = document.add_places(doc, group, output, places)
    return [Row(p.what, p.value, p.at, output if p.on_output or given is None else given, marks=((marks, f"Vertex{i + 1}"),))
            for i, p in enumerate(places)]


def _add_field(doc, group, report, folder, output):
    measured = read_field(os.path.join(folder, FIELD), report.scale)
    return document.add_field(doc, group, measured, report.largest_mm(), document.box_of(output))


@dataclass
class Convert:
    source: Source
    output: str
    tolerance: str = "1e-4rel"
    time_limit: int = 60
    more: str = ""

    def arguments(self, folder):
        if not self.output:
            raise ProgramError("choose the file to write")
        return ["convert", self.source.path(folder), "-o", os.path.abspath(self.output), "--tolerance", self.tolerance,
                "--time-limit", self.time_limit, "--field", FIELD, "--json", REPORT, *split_options(self.more)]

    def show(self, doc, report, folder):
        group = document.add_group(doc, f"{self.source.label} as patches", report)
        solid = document.add_model(doc, group, os.path.abspath(self.output), os.path.splitext(os.path.basename(self.output))[0])
        document.colour_patches(solid)
        document.hide_earlier(doc, group)
        if self.source.thing:
            self.source.thing.Visibility = False  # it is where the output is
        shown = Shown(group, solid, _rows_of_places(doc, group, report, solid, self.source.thing))
        faces = len(solid.Shape.Faces)
        if faces <= preferences.most_patches():
            document.add_patches(doc, group, solid)
        else:
            shown.notices.append(f"{faces} patches have no objects of their own (Preferences > Patchwright: at most "
                                 f"{preferences.most_patches()})")
        _add_field(doc, group, report, folder, solid)
        return shown


@dataclass
class Compare:
    a: Source
    b: Source
    tolerance: str = ""
    more: str = ""

    def arguments(self, folder):
        tolerance = ["--tolerance", self.tolerance] if self.tolerance else []
        folders = [os.path.join(folder, name) for name in ("a", "b")]  # both objects may have one name
        for each in folders:
            os.mkdir(each)
        return ["compare", self.a.path(folders[0]), self.b.path(folders[1]), *tolerance, "--field", FIELD, "--json", REPORT,
                *split_options(self.more)]

    def show(self, doc, report, folder):
        group = document.add_group(doc, f"{self.b.label} compared with {self.a.label}", report)
        given, output = (s.thing or document.add_model(doc, group, s.file, s.label, report.scale) for s in (self.a, self.b))
        document.hide_earlier(doc, group)
        given.Visibility = False  # it is where the output is
        output.Visibility = True
        shown = Shown(group, output, _rows_of_places(doc, group, report, output, given))
        _add_field(doc, group, report, folder, output)
        return shown


@dataclass
class Inspect:
    source: Source
    more: str = ""

    def arguments(self, folder):
        return ["inspect", self.source.path(folder), "--json", REPORT, *split_options(self.more)]

    def show(self, doc, report, folder):
        group = document.add_group(doc, f"{self.source.label} inspected", report)
        model = self.source.thing or document.add_model(doc, group, self.source.file, self.source.label, report.scale)
        document.hide_earlier(doc, group)
        shown = Shown(group, model, _rows_of_places(doc, group, report, model, None))
        for number, face in enumerate(document.shape_of(model).Faces if hasattr(model, "Shape") else []):
            shown.rows.append(Row(document.patch_name(model, number), document.describe_patch(face), tuple(face.CenterOfMass), model,
                                  f"Face{number + 1}"))
        doc.recompute()
        shown.notices += report.data.get("notices", [])
        return shown


def read_report(run, folder):
    """The report of a run that has ended.
    @throw ProgramError  when it ended without a result"""
    code = run.poll()
    if code not in (0, 3):
        raise ProgramError(run.error())
    return results.Report.read(os.path.join(folder, REPORT))
