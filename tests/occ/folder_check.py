"""Faces, area and bounding box of every file of a folder: what `patchwright inspect` says against FreeCAD's reading.

  folder_check.py PATCHWRIGHT FOLDER

Exit codes: 0 they agree, 1 they do not, 77 the folder or FreeCAD is missing.
Both read with the same kernel underneath, but FreeCAD neither heals nor repairs, meshes for its box and integrates areas
by itself; hence the tolerances. A file that FreeCAD cannot read at all is no disagreement: it is listed.
"""
import json
import math
import pathlib
import subprocess
import sys

sys.path.append("/usr/lib/freecad-python3/lib")
try:
    import FreeCAD  # noqa: F401  Part needs it loaded first
    import Part
except ImportError as error:
    print(f"FreeCAD is missing: {error}")
    sys.exit(77)

SUFFIXES = {".step", ".stp", ".iges", ".igs", ".brep", ".brp"}
# Relative: two integrations of the same faces. Those of whole bicubic surfaces are ours, which inspect_test compares with the kernel's adaptive
# quadrature; FreeCAD takes one order for all spans and is 7e-5 off on the glider (triangles 0.005 mm off it: 8237.45 mm^2, ours 8237.30, its 8236.71).
AREA, AREA_OF_BICUBIC = 1e-6, 1e-4
BOX = 2e-6  # of the diagonal; FreeCAD's exact box has the edges' tolerances in it
MILLIMETRES = {"mm": 1.0, "cm": 10.0, "m": 1000.0, "in": 25.4, "ft": 304.8}


def inspect(program, file):
    """The report in millimetres, or the message of refusal."""
    run = subprocess.run([program, "inspect", file, "--no-heal", "--json", "-", "-q"], capture_output=True, text=True, check=False)
    if run.returncode == 2 and run.stderr.count("\n") == 1:
        return None, run.stderr.strip()
    if run.returncode != 0:
        return None, f"exit code {run.returncode}: {run.stderr}"
    report = json.loads(run.stdout)
    scale = MILLIMETRES[report["unit"]]
    solid = report["solid"]
    box = [scale * x for x in solid["bounds"]["min"] + solid["bounds"]["max"]]
    return {"faces": solid["faces"], "area": scale**2 * solid["area"], "box": box,
            "bicubic": solid["all_bicubic"],
            "tolerance": scale * solid["max_tolerance"]}, None


def freecad(file):
    shape = Part.read(str(file))
    if not shape.Faces:
        return None
    # Loose curves beside the faces are not part of the model; nor is a face counted twice.
    faces = Part.makeCompound(shape.Faces)
    box = faces.optimalBoundingBox(False)
    return {"faces": len(faces.Faces), "area": sum(face.Area for face in shape.Faces),
            "box": [box.XMin, box.YMin, box.ZMin, box.XMax, box.YMax, box.ZMax]}


def differences(ours, theirs):
    result = []
    if ours["faces"] != theirs["faces"]:
        result.append(f"{ours['faces']} faces against {theirs['faces']}")
    if abs(ours["area"] - theirs["area"]) > (AREA_OF_BICUBIC if ours["bicubic"] else AREA) * theirs["area"]:
        result.append(f"area {ours['area']} against {theirs['area']}")
    diagonal = math.dist(theirs["box"][:3], theirs["box"][3:])
    off = max(abs(a - b) for a, b in zip(ours["box"], theirs["box"]))
    if off > BOX * diagonal + ours["tolerance"]:
        result.append(f"box {ours['box']} against {theirs['box']}: {off / diagonal:.2g} of the diagonal")
    return result


def main():
    program, folder = sys.argv[1], pathlib.Path(sys.argv[2])
    files = sorted(f for f in folder.glob("*") if f.suffix.lower() in SUFFIXES) if folder.is_dir() else []
    if not files:
        print(f"skipped: no CAD files in {folder}")
        sys.exit(77)
    bad = 0
    for file in files:
        ours, refusal = inspect(program, str(file))
        theirs = freecad(file)
        if ours is None:
            found = [] if file.name in refusal else [refusal]
            text = f"refused: {refusal}"
        elif theirs is None:
            found, text = [], "FreeCAD reads no faces"
        else:
            found = differences(ours, theirs)
            text = f"{ours['faces']} faces"
        bad += bool(found)
        print(f"{'BAD ' if found else 'good'} {file.name}: {'; '.join(found) or text}", flush=True)
    sys.exit(1 if bad else 0)


if __name__ == "__main__":
    main()
