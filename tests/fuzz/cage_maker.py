"""Cages and triangles for fuzz_cages.py: sound ones, and what mutations make of them. All from one random.Random."""
import math

WILD_NUMBERS = ["nan", "inf", "-inf", "1e308", "-1e308", "1e30", "1e71", "1e-320", "2147483648", "-2147483648", "4294967296", "1e12",
                "0x1p3", "1e", "--5", "", "1,5", "0", "-0.0", "1e-9", "9" * 400]
# Finite ones of 6 and more make patches of more than 4^6 control points a face, which take longer than a case may.
SHARPNESSES = ["0", "0.3", "1", "1.5", "2.75", "4.5", "10", "1e9", "inf", "nan", "-1"]
NAMES = ["wing", "wing/upper", "a" * 40, "b" * 300, "c" * 20000, "Flügel", "翼" * 30, "it's", "a;b", "#1=", "\\X2\\00FC", "*/", "..", "/",
         "tab\tname", "\x01\x02", "naïve\x00nul", " ", "%s%n", "\udcff\udcfe", "DataClass", "x" * 32, "x" * 33]


class Cage:
    """Vertices, faces (numbers count from 0), a name a face, and lines of tags."""

    def __init__(self, points, faces):
        self.points = [[repr(float(x)) for x in p] for p in points]
        self.faces = [list(f) for f in faces]
        self.names = [None] * len(faces)
        self.tags = []

    def text(self, negative=False):
        lines = ["v " + " ".join(p) for p in self.points]
        name = None
        for face, own in zip(self.faces, self.names):
            if own != name:
                name = own
                lines.append("g" if own is None else "g " + own)
            lines.append("f " + " ".join(str(v - len(self.points) if negative else v + 1) for v in face))
        return "\n".join(lines + self.tags) + "\n"

    def numbers(self):
        """Coordinates; None where one is no number."""
        try:
            return [[float(x) for x in p] for p in self.points]
        except ValueError:
            return None

    def move(self, change):
        points = self.numbers()
        if points:
            self.points = [[repr(x) for x in change(p)] for p in points]

    def edges(self):
        return [(f[i], f[(i + 1) % len(f)]) for f in self.faces for i in range(len(f)) if len(f) > 1]


def box(rng, nx, ny, nz):
    """The surface of a block of nx x ny x nz cubes."""
    number, points, faces = {}, [], []

    def vertex(i, j, k):
        if (i, j, k) not in number:
            number[i, j, k] = len(points)
            points.append((100.0 * i / nx - 50, 80.0 * j / ny - 40, 60.0 * k / nz - 30))
        return number[i, j, k]
    for a in range(nx):
        for b in range(ny):
            faces.append([vertex(a, b, 0), vertex(a, b + 1, 0), vertex(a + 1, b + 1, 0), vertex(a + 1, b, 0)])
            faces.append([vertex(a, b, nz), vertex(a + 1, b, nz), vertex(a + 1, b + 1, nz), vertex(a, b + 1, nz)])
    for a in range(nx):
        for c in range(nz):
            faces.append([vertex(a, 0, c), vertex(a + 1, 0, c), vertex(a + 1, 0, c + 1), vertex(a, 0, c + 1)])
            faces.append([vertex(a, ny, c), vertex(a, ny, c + 1), vertex(a + 1, ny, c + 1), vertex(a + 1, ny, c)])
    for b in range(ny):
        for c in range(nz):
            faces.append([vertex(0, b, c), vertex(0, b, c + 1), vertex(0, b + 1, c + 1), vertex(0, b + 1, c)])
            faces.append([vertex(nx, b, c), vertex(nx, b + 1, c), vertex(nx, b + 1, c + 1), vertex(nx, b, c + 1)])
    return Cage(points, faces)


def sheet(rng, nu, nv):
    points = [(20.0 * i, 20.0 * j, rng.uniform(-5, 5)) for i in range(nu + 1) for j in range(nv + 1)]
    at = lambda i, j: i * (nv + 1) + j
    return Cage(points, [[at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)] for i in range(nu) for j in range(nv)])


def torus(rng, nu, nv):
    points, faces = [], []
    at = lambda i, j: (i % nu) * nv + j % nv
    for i in range(nu):
        for j in range(nv):
            a, b = 2 * math.pi * i / nu, 2 * math.pi * j / nv
            r = 50 + 20 * math.cos(b)
            points.append((r * math.cos(a), r * math.sin(a), 20 * math.sin(b)))
            faces.append([at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)])
    return Cage(points, faces)


def spindle(rng, n, poles):
    """Around an axis n faces: a prism of two n-gons, or triangles to two poles."""
    ring = lambda z: [(40 * math.cos(2 * math.pi * i / n), 40 * math.sin(2 * math.pi * i / n), z) for i in range(n)]
    points = ring(-20.0) + ring(20.0)
    faces = [[i, (i + 1) % n, n + (i + 1) % n, n + i] for i in range(n)]
    if poles:
        points += [(0, 0, -40.0), (0, 0, 40.0)]
        faces += [[(i + 1) % n, i, 2 * n] for i in range(n)] + [[n + i, n + (i + 1) % n, 2 * n + 1] for i in range(n)]
    else:
        faces += [list(range(n - 1, -1, -1)), list(range(n, 2 * n))]
    return Cage(points, faces)


def pair(rng):
    """Two boxes: apart, crossing or one inside the other."""
    one, two = box(rng, 1, 1, 1), box(rng, 1, rng.randint(1, 2), 1)
    scale, shift = rng.choice([0.3, 1.0, 3.0]), rng.choice([0.0, 30.0, 300.0])
    two.move(lambda p: [scale * p[0] + shift, scale * p[1], scale * p[2]])
    count = len(one.points)
    one.points += two.points
    one.faces += [[v + count for v in f] for f in two.faces]
    one.names += two.names
    return one


def sound(rng):
    few = lambda most: rng.randint(1, most)
    kind = rng.choice(["box", "box", "box", "sheet", "torus", "prism", "poles", "pair"])
    if kind == "box":
        return box(rng, few(3), few(2), few(2))
    if kind == "sheet":
        return sheet(rng, few(4), few(3))
    if kind == "torus":
        return torus(rng, rng.randint(3, 6), rng.randint(3, 5))
    if kind == "pair":
        return pair(rng)
    return spindle(rng, rng.choice([3, 4, 5, 6, 8, 12, 24]), kind == "poles")


def add_tags(rng, cage, wild):
    """Creases, corners, pins, sectors, boundary rules; wild ones name what may not exist."""
    count, edges = len(cage.points), cage.edges()
    vertex = lambda: rng.choice([-1, count, 10**9, rng.randrange(count)]) if wild and rng.random() < 0.2 else rng.randrange(count)
    sharpness = lambda: rng.choice(SHARPNESSES) if wild else rng.choice(SHARPNESSES[:8])
    for _ in range(rng.choice([0, 1, 3, 12, len(edges)])):
        a, b = (vertex(), vertex()) if wild and rng.random() < 0.1 else rng.choice(edges)
        cage.tags.append(f"t crease 2/1/0 {a} {b} {sharpness()}")
    for _ in range(rng.choice([0, 0, 1, 3])):
        cage.tags.append(f"t corner 1/1/0 {vertex()} {sharpness()}")
    for _ in range(rng.choice([0, 0, 1, 4])):
        cage.tags.append(f"#patchwright pin {vertex()}")
    for _ in range(rng.choice([0, 0, 0, 1, 2])):
        face = rng.randrange(len(cage.faces))
        v = vertex() if wild and rng.random() < 0.3 else rng.choice(cage.faces[face])
        angle = rng.choice([0, 1e-9, 30, 90, 120, 180, 200, 270, 300, 359.9, 360 if wild else 45, "nan" if wild else 60])
        normal = rng.choice(["", "", " 0 0 1", " 0 0 0", " 1 -2 0.5", " 1e40 0 0"])
        cage.tags.append(f"#patchwright sector {v} {face} {angle}{normal}")
    if rng.random() < 0.4:
        cage.tags.append(f"t interpolateboundary 1/0/0 {rng.choice([1, 2, 2, 0 if wild else 1])}")
    if wild and rng.random() < 0.2:
        cage.tags.append(rng.choice(["t", "t crease", "t crease 2/1", "t crease 9/9/9 1", "t corner -1/1/0 1", "t unknown 1/1/0 0 1",
                                     "t crease 2/1/0 0 1", "t crease 3/1/0 0 1 2 1", "t crease 2147483647/1/0 0", "usemtl x", "p 1"]))


def add_names(rng, cage):
    names = [rng.choice(NAMES) for _ in range(rng.randint(1, 4))]
    for f in range(len(cage.faces)):
        if rng.random() < 0.8:
            cage.names[f] = rng.choice(names)


def change_shape(rng, cage):
    kind = rng.choice(["jitter", "jitter", "scale", "offset", "flat", "thin", "point", "collapse", "wild", "mirror", "shuffle"])
    exponent = rng.choice([-150, -12, -9, -6, -4, -3, -2, -1, 1, 2, 3, 4, 5, 6, 9, 12, 80])
    if kind == "jitter":
        size = rng.choice([1, 10, 60])
        cage.move(lambda p: [x + rng.uniform(-size, size) for x in p])
    elif kind == "scale":
        cage.move(lambda p: [x * 10.0**exponent for x in p])
    elif kind == "offset":
        cage.move(lambda p: [x + 10.0**exponent for x in p])
    elif kind in ("flat", "thin"):
        factor = 0.0 if kind == "flat" else 10.0**rng.randint(-12, -2)
        cage.move(lambda p: [p[0], p[1], factor * p[2]])
    elif kind == "point":
        cage.move(lambda p: [1.0, 2.0, 3.0])
    elif kind == "collapse":
        for _ in range(rng.randint(1, 4)):
            a, b = rng.choice(cage.edges())
            cage.points[a] = list(cage.points[b])
    elif kind == "wild":
        rng.choice(cage.points)[rng.randrange(3)] = rng.choice(WILD_NUMBERS)
    elif kind == "mirror":
        cage.move(lambda p: [-p[0], p[1], p[2]])
    else:
        rng.shuffle(cage.points)


def change_faces(rng, cage):
    kind = rng.choice(["delete", "repeat", "turn", "join", "poke", "split", "flap", "twice", "unused", "index", "short", "turn all"])
    f = rng.randrange(len(cage.faces))
    face = cage.faces[f]

    def put(faces):
        cage.faces += faces
        cage.names += [cage.names[f]] * len(faces)
    if kind == "delete" and len(cage.faces) > 1:
        for _ in range(rng.randint(1, max(1, len(cage.faces) // 3))):
            del cage.faces[-1], cage.names[-1]
    elif kind == "repeat":
        put([list(face)])
    elif kind == "turn":
        face.reverse()
    elif kind == "turn all":
        for other in cage.faces:
            other.reverse()
    elif kind == "join":
        a, b = face[0], face[1]
        for g, other in enumerate(cage.faces):
            if g != f and a in other and b in other:
                i, j = other.index(a), other.index(b)
                if other[(j + 1) % len(other)] == a:
                    rest = other[(i + 1):] + other[:i]
                    cage.faces[f] = [a] + rest[:-1] + [b] + face[2:]
                    del cage.faces[g], cage.names[g]
                    break
    elif kind == "poke":
        cage.points.append([str(rng.uniform(-60, 60)) for _ in range(3)])
        middle = len(cage.points) - 1
        put([[face[i], face[(i + 1) % len(face)], middle] for i in range(1, len(face))])
        cage.faces[f] = [face[0], face[1], middle]
    elif kind == "split":
        a, b = face[0], face[1]
        cage.points.append([str(rng.uniform(-60, 60)) for _ in range(3)])
        for other in cage.faces:
            for i in range(len(other)):
                if {other[i], other[(i + 1) % len(other)]} == {a, b}:
                    other.insert(i + 1, len(cage.points) - 1)
                    break
    elif kind == "flap":
        cage.points.append([str(rng.uniform(-60, 60)) for _ in range(3)])
        put([[face[0], face[1], len(cage.points) - 1]])
    elif kind == "twice":
        face.append(rng.choice(face))
    elif kind == "unused":
        cage.points.append(["0", "0", "0"])
    elif kind == "index":
        face[0] = rng.choice([10**6, -5, rng.randrange(len(cage.points))])
    elif kind == "short":
        cage.faces[f] = face[:rng.randint(0, 2)]


def change_text(rng, text):
    kind = rng.choice(["cut", "bytes", "crlf", "tail", "lines", "slashes"])
    if kind == "cut":
        return text[:rng.randrange(len(text))]
    if kind == "crlf":
        return text.replace("\n", "\r\n")
    if kind == "tail":
        return text + "\\"
    if kind == "lines":
        lines = text.split("\n")
        for _ in range(3):
            lines[rng.randrange(len(lines))] = rng.choice(lines)
        return "\n".join(lines)
    if kind == "slashes":
        return "\n".join(" ".join([w[0], *(v + rng.choice(["/1", "//1", "/1/1"]) for v in w[1:])]) if w and w[0] == "f" else " ".join(w)
                         for w in (line.split() for line in text.split("\n"))) + "\n"
    characters = list(text)
    for _ in range(rng.randint(1, 8)):
        characters[rng.randrange(len(characters))] = chr(rng.randrange(1, 128))
    return "".join(characters)


def make_cage(rng):
    """Bytes of an OBJ file, and the cage they come from where no mutation of the text followed."""
    cage = sound(rng)
    wild = rng.random() < 0.3
    for _ in range(rng.choice([0, 0, 1, 1, 2])):
        change_shape(rng, cage)
    for _ in range(rng.choice([0, 0, 0, 0, 1, 2])):
        if cage.faces and min(map(len, cage.faces)) > 1:
            change_faces(rng, cage)
    if cage.faces and min(map(len, cage.faces)) > 1 and rng.random() < 0.7:
        add_tags(rng, cage, wild)
    if rng.random() < 0.2:
        add_names(rng, cage)
    text = cage.text(negative=rng.random() < 0.1)
    is_changed = rng.random() < 0.15
    if is_changed:
        text = change_text(rng, text)
    return text.encode("utf-8", "surrogateescape"), None if is_changed else cage


def make_stl(rng):
    """Bytes of an STL file."""
    cage = sound(rng)
    for _ in range(rng.choice([0, 1, 2])):
        change_shape(rng, cage)
    for _ in range(rng.choice([0, 0, 1, 2])):
        if cage.faces and min(map(len, cage.faces)) > 1:
            change_faces(rng, cage)
    triangles = [(f[0], f[i], f[i + 1]) for f in cage.faces for i in range(1, len(f) - 1)]
    inside = lambda t: [cage.points[v] if -len(cage.points) <= v < len(cage.points) else ["0", "0", "0"] for v in t]
    if rng.random() < 0.5:
        text = f"solid {rng.choice(NAMES)}\n" + "".join(
            "facet normal 0 0 0\nouter loop\n" + "".join("vertex " + " ".join(p) + "\n" for p in inside(t)) + "endloop\nendfacet\n"
            for t in triangles) + "endsolid\n"
        return (change_text(rng, text) if rng.random() < 0.3 else text).encode("utf-8", "surrogateescape")
    import struct

    def single(word):
        try:
            return struct.pack("<f", float(word))
        except (ValueError, OverflowError):
            return struct.pack("<I", rng.choice([0x7FC00000, 0x7F800000, 0x7F7FFFFF, 1]))
    count = len(triangles) if rng.random() < 0.9 else rng.choice([0, 1, 2**31, 2**32 - 1])
    data = bytearray(rng.choice([b"solid x", b"binary"]).ljust(80) + struct.pack("<I", count) + b"".join(
        bytes(12) + b"".join(single(x) for p in inside(t) for x in p) + bytes(2) for t in triangles))
    if rng.random() < 0.2:
        data = data[:rng.randrange(len(data))]
    if data and rng.random() < 0.2:
        for _ in range(5):
            data[rng.randrange(len(data))] = rng.randrange(256)
    return bytes(data)
