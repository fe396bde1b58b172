"""What a call did and measured: the report of the command line's --json, with names for what is asked most."""
from __future__ import annotations

import json
import os
import pathlib
from typing import Any, NamedTuple, Optional

from . import _checks
from .cage import Cage

__all__ = ["Comparison", "Condition", "Conversion", "Export", "Fit", "Grid", "Inspection", "MadeCage", "Refit", "Result",
           "Verdict"]

_MILLIMETRES = {"mm": 1.0, "cm": 10.0, "m": 1000.0, "in": 25.4, "ft": 304.8}


class Condition(NamedTuple):
    """One thing that a result has to fulfil."""

    name: str
    """Such as distance_to_input, sharp_curves, closed, valid, folds, kinks, self_intersections."""
    value: float
    limit: float
    met: bool
    at: Optional[tuple[float, float, float]]
    """Where the value is worst, in the report's unit."""
    remedy: str
    """What to try; empty when met."""


class Verdict(NamedTuple):
    """Whether a result is good."""

    met: bool
    sentence: str
    """As the command line prints it: "met 1e-4: ..." or "MISSED: ...; try ..."."""
    conditions: tuple[Condition, ...]


def _condition(given: dict[str, Any]) -> Condition:
    at = None
    if given.get("at"):
        x, y, z = given["at"]
        at = (float(x), float(y), float(z))
    return Condition(given["name"], given["value"], given["limit"], given["met"], at, given.get("remedy") or "")


class Result:
    """Base of all results.

    report: the parsed JSON report, as the schema in the project says; lengths in report["unit"].
    """

    report: dict[str, Any]

    def __init__(self, report: str, text: str) -> None:
        self.report = json.loads(report)
        self._text = text

    @property
    def verdict(self) -> Verdict | None:
        """None where nothing was asked for: comparisons without a tolerance, inspections."""
        given = self.report.get("verdict")
        if given is None:
            return None
        return Verdict(given["met"], given["sentence"], tuple(map(_condition, given["conditions"])))

    @property
    def met(self) -> bool:
        """Whether all conditions of the verdict are met; True where there is no verdict."""
        return self.verdict is None or self.verdict.met

    @property
    def notices(self) -> list[str]:
        """What the user should know, one line each."""
        return list(self.report.get("notices", []))

    @property
    def millimetres_per_unit(self) -> float:
        """Of the lengths in the report."""
        return _MILLIMETRES[self.report["unit"]]

    def write_json(self, file: str | os.PathLike[str]) -> None:
        """Writes the report, as the command line's --json."""
        pathlib.Path(_checks.path(file, "file")).write_text(json.dumps(self.report, indent=2) + "\n")

    def __str__(self) -> str:
        """What the command line prints."""
        return self._text.rstrip()

    def __repr__(self) -> str:
        told = self.verdict.sentence if self.verdict else self.report.get("options", {}).get("command", "")
        return f"<patchwright.{type(self).__name__}: {told}>"


class _WithDeviation(Result):
    def _largest(self, way: str) -> float:
        return float(self.report["deviation"][way]["max"]) * self.millimetres_per_unit

    @property
    def deviation_mm(self) -> float:
        """The largest distance of all samples, both ways, mm."""
        return max(self._largest("output_to_input"), self._largest("input_to_output"))

    @property
    def deviation_at_mm(self) -> tuple[float, float, float]:
        """Where that is, on the model that was sampled, mm."""
        both = self.report["deviation"]
        worst = max(("output_to_input", "input_to_output"), key=self._largest)
        x, y, z = (float(c) * self.millimetres_per_unit for c in both[worst]["at"])
        return x, y, z


class Comparison(_WithDeviation):
    """Of two models: report["deviation"] both ways."""


class Conversion(_WithDeviation):
    """A model that was converted. output: the file that was written; cage: the fitted one."""

    def __init__(self, report: str, text: str, output: pathlib.Path, cage: Cage) -> None:
        super().__init__(report, text)
        self.output = output
        self.cage = cage


class Fit(Result):
    """cage: the fitted one; the verdict is on the distances that the fit's own samples see."""

    def __init__(self, report: str, text: str, cage: Cage) -> None:
        super().__init__(report, text)
        self.cage = cage


class Refit(Fit):
    """cage: the one for the changed model; output: the file that was written, or None."""

    def __init__(self, report: str, text: str, output: pathlib.Path | None, cage: Cage) -> None:
        super().__init__(report, text, cage)
        self.output = output


class MadeCage(Result):
    """cage: made from a model, not fitted yet; layout: a line for each body, what it was recognised as."""

    def __init__(self, report: str, text: str, cage: Cage, layout: list[str]) -> None:
        super().__init__(report, text)
        self.cage = cage
        self.layout = layout


class Export(Result):
    """A limit surface that was written. output: the file."""

    def __init__(self, report: str, text: str, output: pathlib.Path) -> None:
        super().__init__(report, text)
        self.output = output


class Inspection(Result):
    """What a file holds: report["solid"], report["details"]."""


class Grid(Result):
    """A grid that was written: report["grid"]. output: the file."""

    def __init__(self, report: str, text: str, output: pathlib.Path) -> None:
        super().__init__(report, text)
        self.output = output
