"""Looks at a CAD file with FreeCAD, an independent reader, and prints what it finds as JSON.

Exit codes: 0 all expectations hold, 1 some do not (named under "problems"), 77 FreeCAD is missing.
It imports FreeCAD's modules instead of running under freecadcmd, which hides exit codes.
"""
import argparse
import json
import sys

sys.path.append("/usr/lib/freecad-python3/lib")
try:
    import FreeCAD  # noqa: F401  Part needs it loaded first
    import Part
except ImportError as error:
    print(f"FreeCAD is missing: {error}")
    sys.exit(77)


def is_bicubic(surface):
    return (surface.TypeId == "Part::GeomBSplineSurface" and (surface.UDegree, surface.VDegree) == (3, 3)
            and not surface.isURational() and not surface.isVRational())


def is_untrimmed(face):
    """The face covers its surface's whole domain."""
    if face.Surface.TypeId != "Part::GeomBSplineSurface" or len(face.Wires) != 1:
        return False
    if any(abs(a - b) > 1e-9 for a, b in zip(face.ParameterRange, face.Surface.bounds())):
        return False
    # Areas are integrated to 1e-5 or so, differently where sides consist of several edges.
    whole = face.Surface.toShape()
    return abs(face.Area - whole.Area) <= 1e-4 * whole.Area


def edge_uses(shape):
    """How many edges are used by one, two, ... faces."""
    uses = {}
    for face in shape.Faces:
        for edge in face.Edges:
            if not edge.Degenerated:
                uses.setdefault(edge.hashCode(), []).append(edge)
    counts = {}
    for edges in uses.values():
        while edges:
            same = [edge for edge in edges if edge.isSame(edges[0])]
            edges = [edge for edge in edges if not edge.isSame(same[0])]
            counts[len(same)] = counts.get(len(same), 0) + 1
    return counts


def boolean_check(shape):
    try:
        shape.check(True)
        return "ok"
    except ValueError as error:
        return str(error)


def inspect(path, each_face):
    shape = Part.read(path)
    box = shape.BoundBox
    return {
        "file": path,
        "solids": len(shape.Solids),
        "shells": len(shape.Shells),
        "faces": len(shape.Faces),
        "closed": bool(shape.Shells) and all(shell.isClosed() for shell in shape.Shells),
        "valid": shape.isValid(),
        "boolean_check": boolean_check(shape),
        **({"bad_faces": [i for i, face in enumerate(shape.Faces) if boolean_check(face) != "ok"]} if each_face else {}),
        "edge_uses": edge_uses(shape),
        "bicubic_faces": sum(is_bicubic(face.Surface) for face in shape.Faces),
        "untrimmed_faces": sum(is_untrimmed(face) for face in shape.Faces),
        "volume": shape.Volume,
        "area": shape.Area,
        "box": [box.XMin, box.YMin, box.ZMin, box.XMax, box.YMax, box.ZMax],
    }


def problems(found, args):
    def expect(name, value, wanted):
        return [] if value == wanted else [f"{name}: {value}, expected {wanted}"]

    result = expect("valid", found["valid"], True) + expect("boolean_check", found["boolean_check"], "ok")
    result += expect("bad_faces", found.get("bad_faces", []), [])
    if args.solids is not None:
        result += expect("solids", found["solids"], args.solids)
    if args.solids:
        result += expect("closed", found["closed"], True)
        result += expect("edges not used twice", sum(n for k, n in found["edge_uses"].items() if k != 2), 0)
    if args.faces is not None:
        result += expect("faces", found["faces"], args.faces)
    if args.bicubic:
        result += expect("bicubic faces", found["bicubic_faces"], found["faces"])
        result += expect("untrimmed faces", found["untrimmed_faces"], found["faces"])
    for name in ("volume", "area"):
        wanted = getattr(args, name)
        if wanted is not None and abs(found[name] - wanted) > args.tolerance * abs(wanted):
            result.append(f"{name}: {found[name]}, expected {wanted} within a share of {args.tolerance}")
    return result


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("file")
    parser.add_argument("--solids", type=int)
    parser.add_argument("--faces", type=int)
    parser.add_argument("--volume", type=float, help="mm3")
    parser.add_argument("--area", type=float, help="mm2")
    parser.add_argument("--tolerance", type=float, default=1e-6, help="of volume and area, relative")
    parser.add_argument("--bicubic", action="store_true",
                        help="every face an untrimmed, non-rational bicubic B-spline surface")
    parser.add_argument("--each-face", action="store_true",
                        help="the boolean check of each face alone too: numbers of those that fail")
    args = parser.parse_args()
    found = inspect(args.file, args.each_face)
    found["problems"] = problems(found, args)
    print(json.dumps(found, indent=2))
    sys.exit(1 if found["problems"] else 0)


if __name__ == "__main__":
    main()
