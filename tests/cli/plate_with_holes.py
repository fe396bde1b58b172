"""Writes a control mesh with sharp edges of a plate with N x N square holes, which is its own limit surface: what layout and
matching of features cost.

Usage: plate_with_holes.py N FILE.obj

Then `export FILE.obj -o FILE.step`, and `fit FILE.step --cage FILE.obj --max-levels 0 -o FITTED.obj` or `cage FILE.step -o CAGE.obj`.
"""
import sys

EDGE_MM = 10.0
# Of a cell's box: corners of its six faces, by their outward directions.
FACES = {
    (1, 0, 0): [(1, 0, 0), (1, 1, 0), (1, 1, 1), (1, 0, 1)],
    (-1, 0, 0): [(0, 0, 0), (0, 0, 1), (0, 1, 1), (0, 1, 0)],
    (0, 1, 0): [(0, 1, 0), (0, 1, 1), (1, 1, 1), (1, 1, 0)],
    (0, -1, 0): [(0, 0, 0), (1, 0, 0), (1, 0, 1), (0, 0, 1)],
    (0, 0, 1): [(0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)],
    (0, 0, -1): [(0, 0, 0), (0, 1, 0), (1, 1, 0), (1, 0, 0)],
}


def plate(holes):
    """@return points, faces and sharp edges; cells with two odd numbers are holes"""
    cells = {(i, j, 0) for i in range(2 * holes + 1) for j in range(2 * holes + 1) if not (i % 2 and j % 2)}
    numbers, faces, directions = {}, [], {}
    for cell in sorted(cells):
        for out, corners in FACES.items():
            if tuple(a + b for a, b in zip(cell, out)) in cells:
                continue
            face = [numbers.setdefault(tuple(a + b for a, b in zip(cell, c)), len(numbers)) for c in corners]
            faces.append(face)
            for a, b in zip(face, face[1:] + face[:1]):
                directions.setdefault((min(a, b), max(a, b)), set()).add(out)
    return list(numbers), faces, [edge for edge, outs in directions.items() if len(outs) > 1]


def main():
    points, faces, sharp = plate(int(sys.argv[1]))
    with open(sys.argv[2], "w", encoding="ascii") as file:
        for p in points:
            print("v", *(EDGE_MM * x for x in p), file=file)
        for face in faces:
            print("f", *(v + 1 for v in face), file=file)
        for a, b in sharp:
            print(f"t crease 2/1/0 {a} {b} 10", file=file)


if __name__ == "__main__":
    main()
