"""Cages that follow the points of a structural model, and forces on their surface carried back to these."""
from __future__ import annotations

import os

import numpy.typing as npt

from . import _checks, _core
from ._checks import Floats
from .cage import Cage

__all__ = ["PointTransfer", "morph"]


class PointTransfer:
    """The linear map from values at the points of a structural model to values at a cage's control points.

    It interpolates displacements, velocities and the like with radial basis functions and a linear polynomial, so that
    affine motions are carried exactly. Its transpose carries forces back: virtual work, sum and moment stay the same.

    points: (n, 3), of the structural model, not all in one plane; at most 10,000.
    targets: a cage, or (m, 3) points.

    The map is made once and serves any number of displacements. Raises InputError for two points in one place and for
    points in one plane.
    """

    _held: _core.PointTransfer

    def __init__(self, points: npt.ArrayLike, targets: Cage | npt.ArrayLike) -> None:
        to = targets.points if isinstance(targets, Cage) else targets
        self._held = _core.PointTransfer.build(_checks.floats(points, "points", 3), _checks.floats(to, "targets", 3))

    @property
    def shape(self) -> tuple[int, int]:
        """(m, n): of the map as a matrix."""
        return self._held.rows(), self._held.columns()

    @property
    def extrapolation(self) -> float:
        """How many times as far from the middle of the points the farthest target is as these are on average: errors
        grow as much there. 1 to 3 where the points are around the targets."""
        return self._held.extrapolation()

    def apply(self, values: npt.ArrayLike) -> Floats:
        """Values at the targets (m, 3) from values at the points (n, 3)."""
        return self._held.apply(_checks.floats(values, "values", 3))

    def apply_transposed(self, values: npt.ArrayLike) -> Floats:
        """Forces at the points (n, 3) that do the same work as forces at the targets (m, 3).

        Forces f at places of a cage's limit surface are ``cage.masks(faces, uv).T @ f`` at its control points.
        """
        return self._held.apply_transposed(_checks.floats(values, "values", 3))

    def __repr__(self) -> str:
        return f"<patchwright.PointTransfer: from {self.shape[1]} points to {self.shape[0]}>"


def morph(cage: Cage | str | os.PathLike[str], transfer: PointTransfer | npt.ArrayLike, displacements: npt.ArrayLike) -> Cage:
    """The cage with its points carried along with displaced points of a structural model; names and tags stay.

    transfer: to the cage's points, for many displacements; or the points of the structural model (n, 3), for one.
    displacements: (n, 3), mm.

    Raises InputError where a tag prescribes a normal, which would not turn with the cage.
    """
    if not isinstance(cage, Cage):
        cage = Cage.read(_checks.path(cage, "cage"))
    if not isinstance(transfer, PointTransfer):
        transfer = PointTransfer(transfer, cage)
    return Cage._of(_core.morph(cage._held, transfer._held, _checks.floats(displacements, "displacements", 3)))
