"""What the command line does, on files, models and cages in memory.

Lengths (tolerance, size, ...) are texts with a unit, "0.05mm" or "1e-4rel" (of the diagonal), or numbers of
millimetres. All calls release the interpreter's lock; progress is called on the calling thread, and returning False
from it, or setting the threading.Event given as cancel, ends the call with CancelledError and leaves files alone.
"""
from __future__ import annotations

import json
import os
import pathlib
from typing import Any, Mapping, NamedTuple, Sequence, Union

import numpy.typing as npt

from . import _checks, _core
from ._checks import Event, Floats, Indices, Length, Progress
from .cage import Cage
from .errors import InputError, UsageError
from .model import Model, ModelLike, as_model
from .results import Comparison, Conversion, Export, Fit, Grid, Inspection, MadeCage, Refit

__all__ = ["GridPlaces", "compare", "convert", "export", "fit", "grid", "grid_blocks", "grid_places", "inspect", "make_cage", "refit"]

_LENGTHS = {"tolerance", "size", "first_cell", "layer_height", "thickness", "farfield", "smallest"}
_NUMBERS = {"time_limit", "target_faces", "max_levels", "samples", "cap_depth", "points", "levels", "coarsen", "layers",
            "growth", "sensor_jump"}
_FLAGS = {"join", "curvature", "smooth", "interpolate"}


Rules = Union[Sequence[Mapping[str, Any]], str, "os.PathLike[str]"]


def _rules(rules: object) -> str:
    """As JSON."""
    if isinstance(rules, (str, os.PathLike)):
        try:
            return pathlib.Path(_checks.path(rules, "rules")).read_text()
        except (OSError, UnicodeDecodeError) as error:
            raise InputError(f"{_checks.shown(rules)}: cannot be read: {error}") from None
    try:
        return json.dumps(rules)
    except (TypeError, ValueError) as error:
        raise UsageError(f"rules: a sequence of dictionaries is needed, not {_checks.shown(rules)}: {error}") from None


def _options(**given: Any) -> dict[str, Any]:
    """Of the types that the module takes; words where nothing else is said. Values are checked by the library."""
    checked: dict[str, Any] = {}
    for name, value in given.items():
        if name in _LENGTHS:
            checked[name] = _checks.length(value, name)
        elif name in _NUMBERS:
            checked[name] = _checks.number(value, name)
        elif name in _FLAGS:
            checked[name] = _checks.flag(value, name)
        elif name == "rules":
            checked[name] = None if value is None else _rules(value)
        elif name in ("size_field", "sensor"):
            checked[name] = None if value is None else _checks.floats(value, name, 4)
        elif name in ("crease_rule", "hanging_nodes", "normal_tolerance"):
            checked[name] = None if value is None else _checks.text(value, name)
        else:
            checked[name] = _checks.texts(value, name) if name == "clusters" else _checks.text(value, name)
    return checked


def _cage_of(cage: object) -> _core.Cage:
    if isinstance(cage, Cage):
        return cage._held
    return Cage.read(_checks.path(cage, "cage"))._held


def _output(output: object, inputs: Sequence[object]) -> pathlib.Path:
    path = pathlib.Path(_checks.path(output, "output"))
    for given in inputs:
        file = given.file if isinstance(given, Model) else given if isinstance(given, (str, os.PathLike)) else None
        if file is not None and path.exists() and os.path.exists(file) and os.path.samefile(path, file):
            raise UsageError(f"{path}: output is the input as well; give another file")
    return path


def convert(model: ModelLike, output: str | os.PathLike[str], *, cage: Cage | str | os.PathLike[str] | None = None,
            tolerance: Length = "1e-4rel", time_limit: float | None = 60.0, layout: str = "auto",
            target_faces: int | None = None, refine: str = "local", symmetry: str = "detect",
            crease_rule: str | None = None, max_levels: int | None = None, samples: int = 20000, unit: str = "input", schema: str = "ap214",
            continuity: str = "g1", patches: str = "charts", color: str = "none", cap_depth: int | None = None,
            normal_tolerance: str | None = None, progress: Progress = None, cancel: Event | None = None) -> Conversion:
    """Converts a model to a few smooth patches that form one solid, writes it and measures what was written.

    output: .step .stp .igs .iges .brep; nothing is changed there until all is done.
    cage: a control mesh to fit; by default cages are made from the model.
    Other options are those of `patchwright convert --help`. time_limit is in seconds; None: none.

    Missing the tolerance is no error: see Conversion.verdict. Raises UsageError, InputError, OutputError,
    TimeLimitError when there is no result in time, CancelledError.
    """
    path = _output(output, [model, cage])
    given = as_model(model, progress, cancel)
    options = _options(tolerance=tolerance, time_limit=time_limit, layout=layout,
               target_faces=target_faces, refine=refine, symmetry=symmetry, crease_rule=crease_rule, max_levels=max_levels,
               samples=samples, unit=unit, schema=schema, continuity=continuity, patches=patches,
               color=color, cap_depth=cap_depth, normal_tolerance=normal_tolerance)
    report, text, fitted = _core.convert(given._held, os.fspath(path), None if cage is None else _cage_of(cage),
                                         options, _checks.callback(progress, cancel))
    return Conversion(report, text, path, Cage._of(fitted))


def fit(model: ModelLike, *, cage: Cage | str | os.PathLike[str] | None = None, tolerance: Length = "1e-4rel",
        time_limit: float | None = None, layout: str = "auto", target_faces: int | None = None, refine: str = "local",
        symmetry: str = "detect", crease_rule: str | None = None, max_levels: int | None = None, interpolate: bool = False,
        normal_tolerance: str | None = None, progress: Progress = None, cancel: Event | None = None) -> Fit:
    """Fits a cage, given or made, to a model: its limit surface then lies on the model. Options and errors: convert.

    interpolate: put the limit points of all vertices on the model, in place of least squares over many samples and
    refinement: not together with refine, symmetry, crease_rule and max_levels. Raises InputError for cages whose limit points
    cannot all be reached.
    """
    options = _options(tolerance=tolerance, time_limit=time_limit, layout=layout, target_faces=target_faces, refine=refine,
                       symmetry=symmetry, crease_rule=crease_rule, max_levels=max_levels, interpolate=interpolate, normal_tolerance=normal_tolerance)
    if interpolate and (refine != "local" or symmetry != "detect" or crease_rule is not None or max_levels is not None):
        raise UsageError("interpolate: does not go together with refine, symmetry, crease_rule and max_levels: the cage is not refined, "
                         "and no plane is kept")
    given = as_model(model, progress, cancel)
    report, text, fitted = _core.fit(given._held, None if cage is None else _cage_of(cage), options,
                                     _checks.callback(progress, cancel))
    return Fit(report, text, Cage._of(fitted))


def refit(cage: Cage | str | os.PathLike[str], model: ModelLike, output: str | os.PathLike[str] | None = None, *,
          from_: ModelLike | None = None, tolerance: Length = "1e-4rel", time_limit: float | None = None,
          symmetry: str = "detect", progress: Progress = None, cancel: Event | None = None) -> Refit:
    """Fits a fitted cage to a model that has changed: vertices, faces, names and tags stay, points are carried along.

    output: CAD of the new limit surface, written and checked as by convert(). Options and errors: convert.
    from_: what the cage was fitted to, with the same faces as the model by name or order: points go with these, however
    far. Raises InputError where faces do not correspond, or the cage was not fitted to it.
    """
    path = None if output is None else _output(output, [model, cage, from_])
    given = as_model(model, progress, cancel)
    earlier = None if from_ is None else as_model(from_, progress, cancel)._held
    options = _options(tolerance=tolerance, time_limit=time_limit, symmetry=symmetry)
    report, text, fitted = _core.refit(given._held, earlier, None if path is None else os.fspath(path), _cage_of(cage), options,
                                       _checks.callback(progress, cancel))
    return Refit(report, text, path, Cage._of(fitted))


def make_cage(model: ModelLike, *, tolerance: Length = "1e-4rel", layout: str = "auto", target_faces: int | None = None,
              progress: Progress = None, cancel: Event | None = None) -> MadeCage:
    """A cage whose limit surface is near a model, for a fit, or to be edited first. Raises as convert().

    tolerance: what it is to be fitted to. target_faces: about how many; by default as the shape asks for.
    """
    given = as_model(model, progress, cancel)
    options = _options(tolerance=tolerance, layout=layout, target_faces=target_faces)
    report, text, cage, recognised = _core.make_cage(given._held, options, _checks.callback(progress, cancel))
    return MadeCage(report, text, Cage._of(cage), recognised)


def export(cage: Cage | str | os.PathLike[str], output: str | os.PathLike[str], *, tolerance: Length = "1e-4rel",
           unit: str = "mm", schema: str = "ap214", continuity: str = "g1", patches: str = "charts",
           color: str = "none", cap_depth: int | None = None, progress: Progress = None,
           cancel: Event | None = None) -> Export:
    """Writes the limit surface of a cage as CAD: .step .stp .igs .iges .brep. Raises as convert()."""
    path = _output(output, [cage])
    options = _options(tolerance=tolerance, unit=unit, schema=schema,
               continuity=continuity, patches=patches, color=color, cap_depth=cap_depth)
    report, text = _core.export(_cage_of(cage), os.fspath(path), options, _checks.callback(progress, cancel))
    return Export(report, text, path)


def compare(a: ModelLike, b: ModelLike, *, tolerance: Length | None = None, normal_tolerance: str | None = None,
            samples: int = 20000, progress: Progress = None, cancel: Event | None = None) -> Comparison:
    """Two-sided deviation; a counts as the input and b as the output.

    tolerance: gives the comparison a verdict: on the distances both ways, on a's sharp curves that are longer than
    100 times this, and on whether b is closed and valid. normal_tolerance: of the angle between normals beyond 0.002 of
    the diagonal from a's edges, "0.5deg", for that verdict. samples: each way.
    """
    second = as_model(b, progress, cancel)
    first = as_model(a, progress, cancel)
    options = _options(tolerance=tolerance, normal_tolerance=normal_tolerance, samples=samples)
    return Comparison(*_core.compare(first._held, second._held, options, _checks.callback(progress, cancel)))


def inspect(model: ModelLike, *, progress: Progress = None, cancel: Event | None = None) -> Inspection:
    """What is in a model: counts, sizes, tolerances, features, mass; as `patchwright inspect --json`."""
    given = as_model(model, progress, cancel)
    return Inspection(*_core.inspect(given._held, _checks.callback(progress, cancel)))


def grid(cage: Cage | str | os.PathLike[str], output: str | os.PathLike[str], *, blocks: str = "groups",
         join: bool = True, size: Length | None = None, points: int = 17, levels: int = 0, coarsen: int = 0,
         spacing: str = "uniform", curvature: bool = False, smooth: bool = False, first_cell: Length | None = None,
         clusters: Sequence[str] = (), rules: Rules | None = None, size_field: npt.ArrayLike | None = None,
         sensor: npt.ArrayLike | None = None, sensor_jump: float = 0.05, smallest: Length | None = None, hanging_nodes: str | None = None,
         layers: int = 0, layer_height: Length | None = None, thickness: Length | None = None, growth: float = 1.2,
         farfield: Length | None = None, unit: str = "mm", form: str = "binary",
         endian: str = "little", progress: Progress = None, cancel: Event | None = None) -> Grid:
    """Writes a block-structured grid on the limit surface, or with layers off it: .cgns, .xyz, .p3d or .vtm.

    With hanging_nodes ("polygons" or "quads"), where single cells are divided instead of whole lines: .cgns or .vtu.
    Options are those of `patchwright grid --help`; clusters are a sequence of those texts.
    rules: for single block edges, such as [{"at": [0, 0, 0], "cells": 40, "near": "0.1mm"}], or the file that holds them.
    size_field: rows of x, y, z and a size, mm: cells are halved until none is longer than the size at the nearest point.
    sensor: rows of x, y, z and a value of a solution: cells are halved until it changes by no more than sensor_jump of its range along each.
    smallest: no smaller cells come of these two; with a sensor 1e-3rel unless given.
    The verdict is on folded and negative cells.
    """
    path = _output(output, [cage])
    options = _options(blocks=blocks, join=join, size=size, points=points, levels=levels,
                             coarsen=coarsen, spacing=spacing, curvature=curvature, smooth=smooth,
                             first_cell=first_cell, clusters=clusters, rules=rules,
                             size_field=size_field, sensor=sensor, sensor_jump=sensor_jump, smallest=smallest,
                             hanging_nodes=hanging_nodes, layers=layers,
                             layer_height=layer_height, thickness=thickness, growth=growth, farfield=farfield, unit=unit,
                             form=form, endian=endian)
    report, text = _core.grid(_cage_of(cage), os.fspath(path), options, _checks.callback(progress, cancel))
    return Grid(report, text, path)


def grid_blocks(cage: Cage | str | os.PathLike[str], *, blocks: str = "groups", join: bool = True,
                size: Length | None = None, points: int = 17, levels: int = 0, coarsen: int = 0,
                spacing: str = "uniform", curvature: bool = False, smooth: bool = False, first_cell: Length | None = None,
                clusters: Sequence[str] = (), rules: Rules | None = None,
                size_field: npt.ArrayLike | None = None, sensor: npt.ArrayLike | None = None, sensor_jump: float = 0.05,
                smallest: Length | None = None, layers: int = 0, layer_height: Length | None = None,
                thickness: Length | None = None, growth: float = 1.2, farfield: Length | None = None, progress: Progress = None,
                cancel: Event | None = None) -> dict[str, Floats]:
    """The same grid in memory: by name of its block, points of shape (ni, nj, 3), with layers (ni, nj, nk, 3), mm."""
    options = _options(blocks=blocks, join=join, size=size, points=points, levels=levels,
                             coarsen=coarsen, spacing=spacing, curvature=curvature, smooth=smooth,
                             first_cell=first_cell, clusters=clusters, rules=rules,
                             size_field=size_field, sensor=sensor, sensor_jump=sensor_jump, smallest=smallest, layers=layers,
                             layer_height=layer_height, thickness=thickness, growth=growth, farfield=farfield)
    return dict(_core.grid_blocks(_cage_of(cage), options, _checks.callback(progress, cancel)))


class GridPlaces(NamedTuple):
    """Places of a block's points on the cage, as Cage.evaluate() and Cage.masks() take them, row by row."""

    faces: Indices
    """(ni, nj)"""
    uv: Floats
    """(ni, nj, 2)"""
    sectors: Indices | None
    """(ni, nj); None where all faces are quads."""


def grid_places(cage: Cage | str | os.PathLike[str], *, blocks: str = "groups", join: bool = True,
                size: Length | None = None, points: int = 17, levels: int = 0, coarsen: int = 0,
                spacing: str = "uniform", curvature: bool = False, smooth: bool = False, first_cell: Length | None = None,
                clusters: Sequence[str] = (), rules: Rules | None = None,
                size_field: npt.ArrayLike | None = None, sensor: npt.ArrayLike | None = None, sensor_jump: float = 0.05,
                smallest: Length | None = None, progress: Progress = None,
                cancel: Event | None = None) -> dict[str, GridPlaces]:
    """Where on the cage the points of grid_blocks() lie: for derivatives, and for the same grid on a changed cage."""
    options = _options(blocks=blocks, join=join, size=size, points=points, levels=levels,
                             coarsen=coarsen, spacing=spacing, curvature=curvature, smooth=smooth,
                             first_cell=first_cell, clusters=clusters, rules=rules, size_field=size_field, sensor=sensor, sensor_jump=sensor_jump, smallest=smallest)
    found = _core.grid_places(_cage_of(cage), options, _checks.callback(progress, cancel))
    return {name: GridPlaces(*places) for name, places in found}
