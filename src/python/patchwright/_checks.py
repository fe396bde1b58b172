"""What callers give, checked here so that messages can name the argument."""
from __future__ import annotations

import os
import reprlib
import warnings
from typing import Any, Callable, Optional, Protocol, Union

import numpy as np
import numpy.typing as npt

from .errors import UsageError

Floats = npt.NDArray[np.float64]
Indices = npt.NDArray[np.int32]
Length = Union[str, float]
"""With a unit, "0.05mm", or relative to the diagonal, "1e-4rel"; numbers are millimetres."""
Progress = Optional[Callable[[str, float], Any]]
"""Called with stage and fraction done, 0 to 1, on the calling thread; False from it cancels the call."""


class Event(Protocol):
    """What a call takes as cancel: a threading.Event, or anything else with is_set()."""

    def is_set(self) -> bool: ...


def shown(value: object) -> str:
    """On one line, and short."""
    try:
        return " ".join(reprlib.repr(value).split())
    except Exception:  # of somebody else's __repr__
        return type(value).__name__


def path(value: object, name: str) -> str:
    try:
        text = os.fsdecode(os.fspath(value))  # type: ignore[call-overload]
    except TypeError:
        raise UsageError(f"{name}: a path is needed, not {shown(value)}") from None
    if not text or "\0" in text:
        raise UsageError(f"{name}: {text!r} is no path")
    return text


def text(value: object, name: str) -> str:
    if not isinstance(value, str) or "\0" in value:
        raise UsageError(f"{name}: a word is needed, not {shown(value)}")
    return value


def flag(value: object, name: str) -> bool:
    if not isinstance(value, (bool, np.bool_)):
        raise UsageError(f"{name}: True or False is needed, not {shown(value)}")
    return bool(value)


def number(value: object, name: str) -> float | int | None:
    """None stays: whether it may be is for the library to say."""
    if value is None:
        return None
    array = np.asarray(value) if isinstance(value, (int, float, np.generic)) else None
    if array is None or array.dtype.kind not in "fiu":
        raise UsageError(f"{name}: a number is needed, not {shown(value)}")
    return int(array) if array.dtype.kind in "iu" else float(array)


def whole(value: object, name: str) -> int:
    given = number(value, name)
    if not isinstance(given, int) or abs(given) >= 2**31:
        raise UsageError(f"{name}: {shown(value)} is no whole number")
    return int(given)


def length(value: Length | None, name: str) -> str | None:
    if value is None or isinstance(value, str):
        return value
    return f"{float(number(value, name) or 0)!r}mm"


def texts(value: object, name: str) -> list[str]:
    if isinstance(value, (str, bytes)):
        raise UsageError(f"{name}: a sequence of texts is needed, not one")
    try:
        return [text(entry, name) for entry in value]  # type: ignore[attr-defined]
    except TypeError:
        raise UsageError(f"{name}: a sequence of texts is needed, not {shown(value)}") from None


def callback(progress: Progress, cancel: Event | None) -> Progress:
    """One for both."""
    if progress is not None and not callable(progress):
        raise UsageError("progress: a callable (stage, fraction) is needed")
    if cancel is None:
        return progress
    is_cancelled: Any = getattr(cancel, "is_set", None)
    if not callable(is_cancelled):
        raise UsageError("cancel: a threading.Event is needed")

    def check(stage: str, fraction: float) -> bool:
        if is_cancelled():
            return False
        return progress is None or progress(stage, fraction) is not False

    return check


def _array(values: object, name: str) -> npt.NDArray[np.generic]:
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error", np.VisibleDeprecationWarning)  # rows of different lengths
            array = np.asarray(values)
    except Exception as error:  # of somebody else's __array__, too
        raise UsageError(f"{name}: no array can be made of {shown(values)}: {error}") from None
    return np.zeros(array.shape) if array.size == 0 else array


def _check_shape(array: npt.NDArray[np.generic], name: str, columns: int | None) -> None:
    wanted = "(n,)" if columns is None else f"(n, {columns})"
    if columns is None and array.ndim != 1 or columns is not None and (array.ndim != 2 or array.shape[1] != columns):
        raise UsageError(f"{name}: an array of shape {wanted} is needed, not {array.shape}")


def floats(values: object, name: str, columns: int | None = None, finite: bool = True) -> Floats:
    """Contiguous float64 of shape (n,) or (n, columns); not copied where it is that already."""
    array = _array(values, name)
    if array.dtype.kind not in "fiu":
        raise UsageError(f"{name}: numbers are needed, not {array.dtype}")
    if array.size == 0 and columns is not None and array.ndim == 1:
        array = array.reshape(0, columns)
    _check_shape(array, name, columns)
    result = np.ascontiguousarray(array, dtype=np.float64)
    if finite and not np.isfinite(result).all():
        place = np.unravel_index(int(np.argmin(np.isfinite(result))), result.shape)
        raise UsageError(f"{name}: entry {', '.join(map(str, place))} is {result[place]}, not a finite number")
    return result


def shared_floats(values: object, name: str, columns: int | None = None) -> Floats:
    """The same for what is kept and may be written to."""
    return np.require(floats(values, name, columns), requirements=["C", "A", "W"])


def indices(values: object, name: str, columns: int | None = None, end: int = 2**31, begin: int = 0) -> Indices:
    """Contiguous int32 of shape (n,) or (n, columns), from begin to below end."""
    array = _array(values, name)
    if array.size and array.dtype.kind not in "iu":
        raise UsageError(f"{name}: whole numbers are needed, not {array.dtype}")
    if array.size == 0 and columns is not None and array.ndim == 1:
        array = array.reshape(0, columns)
    _check_shape(array, name, columns)
    if array.size and (array.min() < begin or array.max() >= end):
        wrong = int(array.min() if array.min() < begin else array.max())
        raise UsageError(f"{name}: {wrong} does not exist; there are {begin} to {end - 1}")
    return np.ascontiguousarray(array, dtype=np.int32)
