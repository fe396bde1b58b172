"""Legacy CAD to a few clean, smooth, untrimmed patches, and control meshes with their limit surfaces.

>>> import patchwright
>>> result = patchwright.convert("wing.igs", "wing.step", tolerance="1e-4rel")
>>> print(result.verdict.sentence)
>>> result.cage.write("wing.obj")

Lengths are millimetres, angles degrees where they are options and radians in arrays.
"""
import pathlib as _pathlib

from . import _checks, _core
from .cage import Cage
from .errors import (CancelledError, InputError, InternalError, OutputError, PatchwrightError, TimeLimitError,
                     UsageError)
from .model import Field, Model, read
from .modes import Modes
from .operations import (GridPlaces, compare, convert, export, fit, grid, grid_blocks, grid_places, inspect, make_cage,
                         refit)
from .results import (Comparison, Condition, Conversion, Export, Fit, Grid, Inspection, MadeCage, Refit, Result, Verdict)
from .transfer import PointTransfer, morph

__all__ = ["Cage", "CancelledError", "Comparison", "Condition", "Conversion", "Export", "Field", "Fit", "Grid", "GridPlaces",
           "InputError", "Inspection", "InternalError", "MadeCage", "Model", "Modes", "OutputError", "PatchwrightError",
           "PointTransfer", "Refit", "Result", "TimeLimitError", "UsageError", "Verdict", "compare", "convert", "export", "fit", "grid",
           "grid_blocks", "grid_places", "inspect", "make_cage", "morph", "read", "refit", "set_thread_count", "thread_count"]

__version__: str = _core.version()


def set_thread_count(threads: int) -> None:
    """How many threads calls may use; 0: as many as there are cores."""
    _core.set_thread_count(_checks.whole(threads, "threads"))


def thread_count() -> int:
    """How many threads calls may use."""
    return _core.thread_count()


_core.set_reader(str(_pathlib.Path(__file__).with_name("_reader")))
