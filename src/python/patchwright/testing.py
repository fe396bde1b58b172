"""Round-trip deviation tests for pipelines that write, read or convert CAD files; needs no test framework."""
from __future__ import annotations

from ._checks import Length
from .model import ModelLike
from .operations import compare
from .results import Comparison

__all__ = ["assert_round_trip"]


def assert_round_trip(a: ModelLike, b: ModelLike, tolerance: Length, *, samples: int = 20000) -> Comparison:
    """Fails unless b is as good as a: no point of either is farther from the other than the tolerance, a's long sharp
    curves are sharp curves of b, and b is valid, and closed where a is.

    a, b: models, or STEP, IGES, BREP, STL or OBJ files; a is the one before the trip.
    tolerance: "0.05mm", "1e-4rel" (of a's diagonal), or a number of millimetres.
    samples: on each of the two.

    Returns the comparison. Raises AssertionError with figure, place and tolerance of every condition that is missed;
    errors of input are PatchwrightError, as no trip was made.
    """
    result = compare(a, b, tolerance=tolerance, samples=samples)
    verdict = result.verdict
    assert verdict is not None  # as there is a tolerance
    if not verdict.met:
        lines = [f"  {_line(c.name, c.value, c.limit, c.at, result.report['unit'])}"
                 for c in verdict.conditions if not c.met]
        names = " and ".join(str(getattr(model, "file", model)) for model in (a, b))
        raise AssertionError("\n".join([f"{names} differ by more than {tolerance}: {verdict.sentence}", *lines]))
    return result


def _line(name: str, value: float, limit: float, at: tuple[float, float, float] | None, unit: str) -> str:
    figure = f"{name}: {value:.4g}, allowed {limit:.4g}"
    if name.startswith("distance"):
        figure = f"{name}: {value:.4g} {unit}, tolerance {limit:.4g} {unit}"
    if at is None:
        return figure
    return f"{figure}, at ({at[0]:.6g}, {at[1]:.6g}, {at[2]:.6g}) {unit}"
