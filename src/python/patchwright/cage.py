"""Control meshes, and points of their limit surfaces."""
from __future__ import annotations

import os
from typing import Any, Sequence

import numpy as np
import numpy.typing as npt
import scipy.sparse

from . import _checks, _core
from ._checks import Floats, Indices
from .errors import UsageError

__all__ = ["Cage"]


def _split_faces(faces: object, given_sizes: object) -> tuple[Indices, Indices]:
    """Sizes and vertices of faces."""
    if given_sizes is not None:
        return _checks.indices(given_sizes, "sizes"), _checks.indices(faces, "faces")
    try:
        rows = list(faces)  # type: ignore[call-overload]
        sizes = [len(row) for row in rows]
    except TypeError:
        raise UsageError("faces: an array of shape (n, k) or rows of vertex numbers are needed") from None
    if len(set(sizes)) == 1:
        vertices = _checks.indices(faces if isinstance(faces, np.ndarray) else rows, "faces", sizes[0])
    else:
        vertices = _checks.indices([vertex for row in rows for vertex in row], "faces")
    return np.array(sizes, np.int32), vertices.reshape(-1)


CREASE_RULES = ("catmull-clark", "runout")


class Cage:
    """A Catmull-Clark control mesh: connectivity with tags, and one point a vertex, in millimetres.

    points: (n, 3), finite. A contiguous, writeable float64 array is not copied: cage and caller share it.
    faces: (m, k) vertex numbers from 0, counter-clockwise seen from outside; or rows of different lengths; or with
        sizes (m,) the vertices of all faces one after the other (sum of sizes,): see polygons.
    creases: (c, 2) vertex numbers of edges; crease_sharpness: (c,), or one for all; infinite by default.
    corners: (j,) vertices; corner_sharpness likewise.
    pins: vertices that a fit must not move.
    groups: (m,) numbers into group_names, or -1: names of faces.
    boundary_corners: whether boundary vertices with one face are corners.
    crease_rule: how the limit surface ends at sharp edges: "catmull-clark" or "runout", as `patchwright fit --help` says.

    Raises UsageError for arrays of other shapes or kinds, InputError for meshes that are not manifold, faces that
    repeat vertices, tags on what does not exist; the message names the element.
    """

    _held: _core.Cage

    def __init__(self, points: npt.ArrayLike, faces: Any, *, sizes: npt.ArrayLike | None = None,
                 creases: npt.ArrayLike = (), crease_sharpness: npt.ArrayLike = np.inf,
                 corners: npt.ArrayLike = (), corner_sharpness: npt.ArrayLike = np.inf, pins: npt.ArrayLike = (), groups: npt.ArrayLike = (),
                 group_names: Sequence[str] = (), boundary_corners: bool = False, crease_rule: str = "catmull-clark") -> None:
        face_sizes, vertices = _split_faces(faces, sizes)
        edges = _checks.indices(creases, "creases", 2)
        tips = _checks.indices(corners, "corners")
        edge_sharpness = _sharpness(crease_sharpness, "crease_sharpness", len(edges))
        tip_sharpness = _sharpness(corner_sharpness, "corner_sharpness", len(tips))
        numbers = _checks.indices(groups, "groups", begin=-1)
        if _checks.text(crease_rule, "crease_rule") not in CREASE_RULES:
            raise UsageError(f"crease_rule: '{crease_rule}' is none of {', '.join(CREASE_RULES)}")
        self._held = _core.Cage.build(
            _checks.shared_floats(points, "points", 3), face_sizes, vertices, edges, edge_sharpness, tips, tip_sharpness,
            _checks.indices(pins, "pins"), _checks.flag(boundary_corners, "boundary_corners"),
            crease_rule == CREASE_RULES[1], _checks.texts(group_names, "group_names"), numbers)

    @classmethod
    def _of(cls, core: _core.Cage) -> Cage:
        cage = cls.__new__(cls)
        cage._held = core
        return cage

    @classmethod
    def read(cls, file: str | os.PathLike[str], unit: str = "mm") -> Cage:
        """Reads an OBJ file with the tags of OpenSubdiv whose numbers are in mm, cm, m, in or ft.

        Raises InputError naming file and line.
        """
        return cls._of(_core.Cage.read(_checks.path(file, "file"), _checks.text(unit, "unit")))

    def write(self, file: str | os.PathLike[str], unit: str = "mm") -> None:
        """Writes an OBJ file from which read() gives the same cage; raises OutputError."""
        self._held.write(_checks.path(file, "file"), _checks.text(unit, "unit"))

    @property
    def points(self) -> Floats:
        """(n, 3) control points in millimetres: a view without a copy, which may be changed in place."""
        return self._held.points

    @points.setter
    def points(self, values: npt.ArrayLike) -> None:
        array = _checks.floats(values, "points", 3)
        if len(array) != len(self._held.points):
            raise UsageError(f"points: {len(array)} for {len(self._held.points)} vertices")
        self._held.points[:] = array

    @property
    def faces(self) -> Indices:
        """(m, 4) vertex numbers: a read-only view without a copy. Raises UsageError where a face is no quad: see polygons."""
        sizes, vertices = self.polygons
        if (sizes != 4).any():
            raise UsageError(f"face {int(np.argmax(sizes != 4))} is no quad; use polygons")
        return vertices.reshape(-1, 4)

    @property
    def polygons(self) -> tuple[Indices, Indices]:
        """Sizes of the faces (m,), and their vertices one after the other, these as a read-only view without a copy."""
        return self._held.faces()

    @property
    def creases(self) -> tuple[Indices, Floats]:
        """Edges with a tag (c, 2), and their sharpnesses (c,)."""
        return self._held.creases()

    @property
    def corners(self) -> tuple[Indices, Floats]:
        """Vertices with a tag (j,), and their sharpnesses (j,)."""
        return self._held.corners()

    @property
    def pins(self) -> Indices:
        """Vertices that a fit must not move."""
        return self._held.pins()

    @property
    def crease_rule(self) -> str:
        """How the limit surface ends at sharp edges: "catmull-clark" or "runout"."""
        return CREASE_RULES[self._held.has_runout_rule()]

    @property
    def groups(self) -> tuple[Indices, list[str]]:
        """Number of each face's name (m,), -1 for none, and the names."""
        names, numbers = self._held.groups()
        return np.array(numbers, np.int32), names

    @property
    def summary(self) -> dict[str, int]:
        """Numbers of vertices, faces, non_quads, extraordinary vertices, creases, corners, boundary_edges, pins."""
        return self._held.summary()

    def copy(self) -> Cage:
        """The same connectivity, which is shared, with points of its own."""
        return Cage._of(self._held.copy())

    def with_points(self, points: npt.ArrayLike) -> Cage:
        """The same connectivity with other points (n, 3), not copied where Cage() would not."""
        return Cage._of(self._held.with_points(_checks.shared_floats(points, "points", 3)))

    def refined(self, levels: int = 1) -> Cage:
        """After so many Catmull-Clark steps: another cage of the same limit surface."""
        return Cage._of(self._held.refined(_checks.whole(levels, "levels")))

    def _places(self, faces: object, uv: object, sectors: object) -> tuple[Indices, Floats, Indices]:
        number = _checks.indices(faces, "faces", end=self._held.summary()["faces"])
        parameters = _checks.floats(uv, "uv", 2)
        if len(parameters) != len(number):
            raise UsageError(f"uv: {len(parameters)} rows for {len(number)} faces")
        sector = np.empty(0, np.int32) if sectors is None else _checks.indices(sectors, "sectors")
        if sectors is not None and len(sector) != len(number):
            raise UsageError(f"sectors: {len(sector)} for {len(number)} faces")
        return number, parameters, sector

    def evaluate(self, faces: npt.ArrayLike, uv: npt.ArrayLike, *, order: int = 0,
                 sectors: npt.ArrayLike | None = None) -> Floats:
        """Points of the limit surface, and derivatives, at many places; uses all threads.

        faces: (n,) from 0. uv: (n, 2) in [0, 1]: (0, 0) at the face's first vertex, u to the second, v to the last.
        sectors: (n,) for faces that are no quads: the vertex that (0, 0) is at; (1, 1) is the face's middle.
        order: 0, 1 or 2.

        Returns (n, 3) for order 0, (n, 3, 3) for order 1: point, d/du, d/dv; (n, 6, 3) for order 2: and d2/du2,
        d2/dudv, d2/dv2; millimetres. Rows of what does not exist are zero: see smoothness().
        """
        return self._held.evaluate(*self._places(faces, uv, sectors), _checks.whole(order, "order"))

    def smoothness(self, faces: npt.ArrayLike, uv: npt.ArrayLike, *,
                   sectors: npt.ArrayLike | None = None) -> npt.NDArray[np.uint8]:
        """(n,): 2 where first and second derivatives exist; 1 at extraordinary vertices, where d/du and d/dv are
        directions in the tangent plane; 0 where there is none."""
        return self._held.smoothness(*self._places(faces, uv, sectors))

    def masks(self, faces: npt.ArrayLike, uv: npt.ArrayLike, *, order: int = 0,
              sectors: npt.ArrayLike | None = None) -> scipy.sparse.csr_matrix:
        """The matrix M with M @ points the rows of evaluate(): (n, vertices), (3 n, ...) or (6 n, ...).

        Rows of points sum to 1, those of derivatives to 0. Raises UsageError for cages with tagged sectors, whose
        points are adjusted before they are evaluated.
        """
        if self._held.has_sectors():
            raise UsageError("the cage has tagged sectors: its limit points are no fixed combinations of its points")
        weights, columns, begin = self._held.masks(*self._places(faces, uv, sectors), _checks.whole(order, "order"))
        shape = (len(begin) - 1, len(self._held.points))
        return scipy.sparse.csr_matrix((weights, columns, begin), shape=shape)

    def jacobian(self, faces: npt.ArrayLike, uv: npt.ArrayLike, *,
                 sectors: npt.ArrayLike | None = None) -> scipy.sparse.csr_matrix:
        """d point / d control point, (3 n, 3 vertices): both as points.reshape(-1). Has no unit."""
        return scipy.sparse.kron(self.masks(faces, uv, sectors=sectors), scipy.sparse.identity(3), format="csr")

    def __repr__(self) -> str:
        s = self.summary
        return f"<patchwright.Cage: {s['vertices']} vertices, {s['faces']} faces, {s['creases']} creases>"


def _sharpness(values: npt.ArrayLike, name: str, count: int) -> Floats:
    array = np.full(count, values) if isinstance(values, (int, float)) else values
    result = _checks.floats(array, name, finite=False)
    if len(result) != count:
        raise UsageError(f"{name}: {len(result)} for {count}")
    return result
