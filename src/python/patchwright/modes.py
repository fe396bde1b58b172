"""Principal components of cages of one topology, as refits give them."""
from __future__ import annotations

from typing import Sequence

import numpy as np
import numpy.typing as npt

from . import _checks, _core
from ._checks import Floats
from .cage import Cage
from .errors import UsageError

__all__ = ["Modes"]


class Modes:
    """A family of cages as their mean and the displacements that most of their differences lie in.

    members: cages of the same vertices, faces and tags, two or more, as refit() makes them.
    count: of modes; there are fewer where the members differ in fewer ways.

    Displacements are measured on the limit surface: modes are orthogonal and have length 1 in the mean of the product
    of the surface's displacements, so that a weight is the root mean square displacement of the surface, mm.
    """

    mean: Cage
    shapes: Floats
    """(modes, vertices, 3): displacements of the control points for a weight of 1 mm."""
    weights: Floats
    """(members, modes), mm; the member farthest along a mode has a positive one."""
    deviations: Floats
    """Standard deviation of each mode's weights, mm, falling."""
    shares: Floats
    """Of the variance, in each mode and those before."""

    def __init__(self, members: Sequence[Cage], count: int) -> None:
        cages = list(members)
        for i, cage in enumerate(cages):
            if not isinstance(cage, Cage):
                raise UsageError(f"members: item {i} is no cage but {_checks.shown(cage)}")
            if cage.faces.shape != cages[0].faces.shape or (cage.faces != cages[0].faces).any():
                raise UsageError(f"members: item {i} has other faces than the first one")
        number = _checks.whole(count, "count")
        if len(cages) < 2 or number is None or number < 1:
            raise UsageError(f"{len(cages)} members, count {number}: two members and one mode are the least")
        points = [_checks.floats(cage.points, "members", 3) for cage in cages]
        mean, self.shapes, self.weights, self.deviations, variance = _core.principal_modes(cages[0]._held, points, number)
        self.mean = cages[0].with_points(mean)
        held = np.cumsum(self.deviations ** 2)
        self.shares = np.minimum(held / variance, 1.0) if variance > 0.0 else np.ones_like(held)

    def __len__(self) -> int:
        return len(self.deviations)

    def member(self, weights: npt.ArrayLike) -> Cage:
        """The cage with these weights of the first modes, mm; the others are 0."""
        given = np.asarray(weights, dtype=float)
        if given.ndim != 1 or len(given) > len(self) or not np.isfinite(given).all():
            raise UsageError(f"weights: {_checks.shown(weights)} are not up to {len(self)} numbers")
        return self.mean.with_points(self.mean.points + np.tensordot(given, self.shapes[:len(given)], 1))

    def __repr__(self) -> str:
        return f"<patchwright.Modes: {len(self)} of {len(self.weights)} members>"
