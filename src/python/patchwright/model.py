"""CAD models and triangles, read once and used many times."""
from __future__ import annotations

import os
import pathlib
import tempfile
from typing import Any, NamedTuple, Union

import numpy.typing as npt

from . import _checks, _core
from ._checks import Event, Floats, Indices, Progress
from .errors import UsageError

__all__ = ["Field", "Model", "ModelLike", "read"]


class Field(NamedTuple):
    """A model's triangles with values at their vertices, in mm and radians. Faces do not share vertices."""

    points: Floats
    """(n, 3)"""
    normals: Floats
    """(n, 3) unit, outward; zero where the surface has none"""
    triangles: Indices
    """(t, 3) counter-clockwise seen from outside"""
    faces: Indices
    """(t,) numbers of the model's faces"""
    curvature: Floats
    """(n,) mean of the principal curvatures, 1/mm"""
    deviation: Floats | None
    """(n,) distance to the other model, mm; None without one"""
    normal_angle: Floats | None
    """(n,) between the tangent planes of both models, radians"""


class Model:
    """A CAD model or triangles, as read() and from_brep() give it. Immutable; any thread may use it."""

    _held: _core.Model

    @classmethod
    def _of(cls, core: _core.Model) -> Model:
        model = cls.__new__(cls)
        model._held = core
        return model

    @classmethod
    def from_brep(cls, brep: bytes | str, **options: Any) -> Model:
        """A shape of the CAD kernel, in millimetres, as the text of a BREP file; options are those of read().

        OCP: ``b = io.BytesIO(); BRepTools.Write_s(shape, b); Model.from_brep(b.getvalue())``;
        pythonOCC: ``Model.from_brep(breptools.WriteToString(shape))``; FreeCAD: ``shape.exportBrepToString()``.
        """
        if not isinstance(brep, (bytes, str)):
            raise UsageError(f"brep: bytes or text are needed, not {_checks.shown(brep)}")
        with tempfile.TemporaryDirectory(prefix="patchwright-") as folder:
            file = pathlib.Path(folder) / "shape.brep"
            file.write_bytes(brep.encode() if isinstance(brep, str) else brep)
            return read(file, **options)

    def to_brep(self) -> bytes:
        """The shape in millimetres as the text of a BREP file, which every program on OpenCASCADE reads.

        OCP: ``shape = TopoDS_Shape(); BRepTools.Read_s(shape, io.BytesIO(b), BRep_Builder())``;
        pythonOCC: ``breptools.ReadFromString(b.decode())``; FreeCAD: ``Part.Shape().importBrepFromString(b.decode())``.
        Raises UsageError for triangles.
        """
        with tempfile.TemporaryDirectory(prefix="patchwright-") as folder:
            file = pathlib.Path(folder) / "shape.brep"
            self._held.write_cad(os.fspath(file), "mm")
            return file.read_bytes()

    def write(self, file: str | os.PathLike[str], unit: str = "mm") -> None:
        """Writes STEP, IGES or BREP; raises OutputError, and UsageError for triangles."""
        self._held.write_cad(_checks.path(file, "file"), _checks.text(unit, "unit"))

    @property
    def file(self) -> str:
        """Where it was read from."""
        return self._held.file

    @property
    def unit(self) -> str:
        """Of the file: mm, cm, m, in or ft. Numbers here are millimetres all the same."""
        return self._held.unit

    @property
    def diagonal(self) -> float:
        """Of the bounding box, mm: what tolerances like 1e-4rel are fractions of."""
        return self._held.diagonal

    @property
    def is_cad(self) -> bool:
        """False for triangles."""
        return self._held.is_cad

    @property
    def notices(self) -> list[str]:
        """What reading repaired or found odd, one line each."""
        return self._held.notices

    def foot_points(self, points: npt.ArrayLike) -> tuple[Floats, Floats]:
        """The nearest points of the surface (n, 3) to points (n, 3), and the distances (n,); millimetres."""
        return self._held.foot_points(_checks.floats(points, "points", 3))

    def field(self, other: ModelLike | None = None, *, progress: Progress = None, cancel: Event | None = None) -> Field:
        """Deviation from another model, and curvature, all over this one: for plots."""
        core = None if other is None else as_model(other)._held
        values = _core.field(self._held, core, _checks.callback(progress, cancel))
        return Field._make(values.get(name) for name in Field._fields)

    def __repr__(self) -> str:
        return f"<patchwright.Model: {self.file}, {self.diagonal:.4g} mm across>"


ModelLike = Union[Model, str, "os.PathLike[str]"]
"""A model, or the file to read it from."""


def read(file: str | os.PathLike[str], *, input_unit: str | None = None, allow_loss: bool = False, heal: bool = True,
         sharp_angle: float | None = None, read_limit: float | None = None, foot_points: str = "search",
         progress: Progress = None, cancel: Event | None = None) -> Model:
    """Reads STEP, IGES, BREP, or triangles from STL and OBJ.

    input_unit: mm, cm, m, in or ft, in place of what the file says; triangles have none: mm.
    allow_loss: go on without the faces that cannot be transferred.
    heal: sew loose faces and turn them outward.
    sharp_angle: edges whose faces differ by more degrees are sharp; by default 20, for triangles 35.
    read_limit: seconds of processor time; by default 15, and 15 for each MB.
    foot_points: what finds nearest points of CAD: search, or kernel, the CAD kernel's extrema (another opinion, tens of
    times slower).

    CAD files are read by a program of its own, so that a file on which the CAD kernel crashes is an InputError.
    Raises InputError, CancelledError.
    """
    options = {"input_unit": None if input_unit is None else _checks.text(input_unit, "input_unit"),
               "allow_loss": _checks.flag(allow_loss, "allow_loss"), "heal": _checks.flag(heal, "heal"),
               "sharp_angle": _checks.number(sharp_angle, "sharp_angle"),
               "read_limit": _checks.number(read_limit, "read_limit"), "foot_points": _checks.text(foot_points, "foot_points")}
    return Model._of(_core.read(_checks.path(file, "file"), options, _checks.callback(progress, cancel)))


def as_model(model: ModelLike, progress: Progress = None, cancel: Event | None = None, **options: Any) -> Model:
    if isinstance(model, Model):
        return model
    return read(_checks.path(model, "model"), progress=progress, cancel=cancel, **options)
