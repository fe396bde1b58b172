"""Cages as OBJ files with OpenSubdiv's tags, as patchwright reads and writes them. Knows nothing of Blender."""
from dataclasses import dataclass, field

INFINITE = 10.0  # this sharpness and more


class CageError(Exception):
    """What is wrong with a file; one line."""


@dataclass
class Cage:
    points: list = field(default_factory=list)        # (x, y, z)
    faces: list = field(default_factory=list)         # numbers of vertices
    names: list = field(default_factory=list)         # of each face; None: it has no name
    creases: dict = field(default_factory=dict)       # (v, w) with v < w: sharpness
    corners: dict = field(default_factory=dict)       # v: sharpness
    pins: set = field(default_factory=set)
    sectors: dict = field(default_factory=dict)       # (v, face): angle in degrees, (x, y, z) of a normal or None
    crease_rule: str = "catmull-clark"                # or "runout"
    boundary_rule: int = 1                            # interpolateboundary: 1 edges, 2 edges and corners


class _Reader:
    def __init__(self, source):
        self.cage, self.source, self.line, self.name = Cage(), source, 0, None

    def fail(self, reason):
        raise CageError(f"{self.source}: line {self.line}: {reason}")

    def read(self, stream):
        statement, begin = "", 1
        for number, text in enumerate(stream, 1):
            statement += text.rstrip("\r\n")
            if statement.endswith("\\"):
                statement = statement[:-1] + " "
                continue
            self.line = begin
            try:
                self.statement(statement)
            except (ValueError, IndexError) as error:
                self.fail(f"'{statement.strip()}': {error}")
            statement, begin = "", number + 1
        if not self.cage.points:
            raise CageError(f"{self.source}: holds no vertices")
        self.check_tags()
        return self.cage

    def statement(self, text):
        words = text.split()
        if not words:
            return
        if words[0] == "v":
            self.cage.points.append((float(words[1]), float(words[2]), float(words[3])))
        elif words[0] == "f":
            self.face(words[1:])
        elif words[0] in ("g", "o"):
            self.name = text.strip()[1:].strip() or None
        elif words[0] == "t":
            self.tag(words)
        elif words[:2] == ["#patchwright", "pin"]:
            self.cage.pins.update(map(int, words[2:]))
        elif words[:2] == ["#patchwright", "crease-rule"]:
            self.cage.crease_rule = words[2]
        elif words[:2] == ["#patchwright", "sector"]:
            normal = tuple(map(float, words[5:8])) if len(words) == 8 else None
            self.cage.sectors[int(words[2]), int(words[3])] = (float(words[4]), normal)

    def face(self, words):
        known = len(self.cage.points)
        indices = [int(word.split("/")[0]) for word in words]
        vertices = [known + i if i < 0 else i - 1 for i in indices]
        if len(vertices) < 3 or not all(0 <= v < known for v in vertices):
            self.fail(f"face {len(self.cage.faces) + 1} has too few vertices, or names one that does not stand before it")
        self.cage.faces.append(vertices)
        self.cage.names.append(self.name)

    def tag(self, words):
        integers, reals, _ = map(int, words[2].split("/"))
        elements = [int(word) for word in words[3:3 + integers]]
        values = [float(word) for word in words[3 + integers:3 + integers + reals]]
        if len(elements) < integers or len(values) < reals:
            self.fail(f"tag '{words[1]}' has fewer arguments than {words[2]} says")
        if words[1] == "crease":
            pairs = [tuple(sorted(pair)) for pair in zip(elements[::2], elements[1::2])]
            self.cage.creases.update(zip(pairs, self.spread(values, len(pairs))))
        elif words[1] == "corner":
            self.cage.corners.update(zip(elements, self.spread(values, len(elements))))
        elif words[1] == "interpolateboundary":
            self.cage.boundary_rule = elements[0]

    def spread(self, values, count):
        if len(values) not in (1, count):
            self.fail(f"{len(values)} sharpness values for {count} elements")
        return values * count if len(values) == 1 else values

    def check_tags(self):
        cage = self.cage
        edges = {tuple(sorted(edge)) for face in cage.faces for edge in zip(face, face[1:] + face[:1])}
        for edge in cage.creases:
            if edge not in edges:
                raise CageError(f"{self.source}: crease {edge[0]}-{edge[1]}: there is no such edge")
        for v in [*cage.corners, *cage.pins]:
            if not 0 <= v < len(cage.points):
                raise CageError(f"{self.source}: tag of vertex {v}: there is no such vertex")
        for v, face in cage.sectors:
            if not 0 <= face < len(cage.faces) or v not in cage.faces[face]:
                raise CageError(f"{self.source}: sector {v} {face}: the vertex is not of the face")


def read_cage(file):
    with open(file, encoding="utf-8", errors="surrogateescape") as stream:
        return _Reader(str(file)).read(stream)


def number(value):
    """The shortest text that reads as the same number."""
    return repr(float(value)).removesuffix(".0")


def cage_text(cage):
    lines = [f"v {number(x)} {number(y)} {number(z)}" for x, y, z in cage.points]
    name = None
    for face, own in zip(cage.faces, cage.names):
        if own != name:
            name = own
            lines.append(f"g {name}" if name else "g")
        lines.append("f " + " ".join(str(v + 1) for v in face))
    lines.append(f"t interpolateboundary 1/0/0 {cage.boundary_rule}")
    if cage.crease_rule != "catmull-clark":
        lines.append(f"#patchwright crease-rule {cage.crease_rule}")
    lines += [f"t crease 2/1/0 {v} {w} {number(s)}" for (v, w), s in cage.creases.items()]
    lines += [f"t corner 1/1/0 {v} {number(s)}" for v, s in sorted(cage.corners.items())]
    lines += [f"#patchwright pin {v}" for v in sorted(cage.pins)]
    for (v, face), (angle, normal) in sorted(cage.sectors.items()):
        lines.append(" ".join([f"#patchwright sector {v} {face} {number(angle)}", *map(number, normal or ())]))
    return "\n".join(lines) + "\n"


def write_cage(cage, file):
    with open(file, "w", encoding="utf-8", errors="surrogateescape", newline="\n") as stream:
        stream.write(cage_text(cage))
