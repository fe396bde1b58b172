"""Reads grids back with other programs: cgnscheck, cgnsdiff, VTK, Gmsh.

Usage: grid_check.py FOLDER NAME...   for files as write_grids makes them
Exit codes: 0 all agree, 1 not so, 77 a program is missing (named on standard output).
"""
import pathlib
import re
import shutil
import subprocess
import sys

import numpy as np

try:
    import vtk
    from vtk.util.numpy_support import vtk_to_numpy
except ImportError:
    vtk = None

FOLDER = pathlib.Path(sys.argv[1])
PLOT3D = {"binary_little": (True, False, False), "binary_big": (True, False, True),
          "fortran_little": (True, True, False), "fortran_big": (True, True, True), "ascii": (False, False, False)}
failures = []


def expect(condition, text):
    if not condition:
        failures.append(text)
        print(f"FAILED: {text}")


def check_cgns(path):
    """cgnscheck finds neither errors nor warnings; -v lists the connections it compared."""
    result = subprocess.run([shutil.which("cgnscheck"), "-v", str(path)], capture_output=True, text=True, timeout=120)
    text = result.stdout + result.stderr
    # Blocks in a plane x, y or z = constant, as wing roots are, draw one warning that says just that.
    flat = text.count("WARNING:coordinate range is 0")
    text = text.replace("WARNING:coordinate range is 0", "").replace(f"{flat} warnings ({flat} shown)", "")
    found = [line for line in text.splitlines() if re.search(r"ERROR|WARNING", line, re.IGNORECASE)]
    expect(result.returncode == 0 and not found, f"{path.name}: cgnscheck: {found[:3]} {text[-300:] if not text else ''}")
    return len(re.findall(r"checking 1to1 connectivity", text))


def cgns_differences(a, b):
    """What cgnsdiff finds in the nodes of two files and the data they hold. The library's own differences are not data: HDF5 stores
    times in its object headers, and CGNS leaves the bytes behind the end of a name as they were in memory."""
    result = subprocess.run([shutil.which("cgnsdiff"), "-d", str(a), str(b)], capture_output=True, text=True, timeout=120)
    return (result.stdout + result.stderr).splitlines()


def check_repetition(name):
    """Two runs write equal data; cgnsdiff does see other coordinates."""
    found = cgns_differences(FOLDER / f"{name}.cgns", FOLDER / f"{name}_again.cgns")
    expect(not found, f"{name}.cgns: a second run wrote other data: {found[:3]}")
    expect(cgns_differences(FOLDER / f"{name}.cgns", FOLDER / f"{name}_m.cgns"), f"{name}_m.cgns: cgnsdiff found no difference")


def blocks_of(reader):
    reader.Update()
    data = reader.GetOutput()
    return [data.GetBlock(b) for b in range(data.GetNumberOfBlocks())]


def read_vtm(path):
    reader = vtk.vtkXMLMultiBlockDataReader()
    reader.SetFileName(str(path))
    blocks = blocks_of(reader)
    expect(len(blocks) > 0, f"{path.name}: no blocks")
    for block in blocks:
        fields = [block.GetCellData().GetArrayName(k) for k in range(block.GetCellData().GetNumberOfArrays())]
        expect({"minimum angle [degrees]", "skewness", "aspect ratio"} <= set(fields), f"{path.name}: fields {fields}")
        angles = vtk_to_numpy(block.GetCellData().GetArray("minimum angle [degrees]"))
        expect(len(angles) == block.GetNumberOfCells() and angles.min() >= 0 and angles.max() <= 90.001,
               f"{path.name}: angles")
    return blocks


def read_plot3d(path, binary, records, big):
    reader = vtk.vtkMultiBlockPLOT3DReader()
    reader.SetFileName(str(path))
    reader.AutoDetectFormatOff()
    reader.SetBinaryFile(binary)
    reader.SetHasByteCount(records)
    reader.SetByteOrder(0 if big else 1)
    reader.SetMultiGrid(True)
    reader.SetDoublePrecision(True)
    return blocks_of(reader)


def points_of(block):
    return vtk_to_numpy(block.GetPoints().GetData())


def check_vtk(name, kinds):
    """VTK reads the same blocks, to the last bit, from its own format and from kinds of Plot3D."""
    expected = read_vtm(FOLDER / f"{name}.vtm")
    for kind in kinds:
        options = PLOT3D[kind]
        path = FOLDER / f"{name}_{kind}.xyz"
        blocks = read_plot3d(path, *options)
        expect(len(blocks) == len(expected), f"{path.name}: {len(blocks)} blocks for {len(expected)}")
        for block, other in zip(blocks, expected):
            expect(block.GetDimensions() == other.GetDimensions(), f"{path.name}: {block.GetDimensions()}")
            a, b = points_of(block), points_of(other)
            expect(a.shape == b.shape and np.array_equal(a, b), f"{path.name}: points differ")


def check_gmsh(name):
    """Gmsh meshes nothing here: it reads the Plot3D blocks and counts their quads."""
    path = FOLDER / f"{name}_ascii.xyz"
    copy = FOLDER / f"{name}.p3d"
    shutil.copy(path, copy)
    mesh = FOLDER / f"{name}.msh"
    result = subprocess.run([shutil.which("gmsh"), "-save", str(copy), "-o", str(mesh), "-format", "msh22"],
                            capture_output=True, text=True, timeout=120)
    lines = mesh.read_text().splitlines() if mesh.exists() else []
    quads = 0
    if "$Elements" in lines:
        elements = lines[lines.index("$Elements") + 2:lines.index("$EndElements")]
        quads = sum(1 for line in elements if line.split()[1] == "3")
    words = path.read_text().split()
    count = int(words[0])
    sizes = np.array([int(w) for w in words[1:1 + 3 * count]]).reshape(-1, 3)
    expect(quads == int(((sizes[:, 0] - 1) * (sizes[:, 1] - 1)).sum()), f"{path.name}: Gmsh has {quads} quads: {result.stdout[-300:]}")


def main():
    missing = []
    for name in sys.argv[2:]:
        if shutil.which("cgnscheck"):
            connections = check_cgns(FOLDER / f"{name}.cgns")
            check_cgns(FOLDER / f"{name}_m.cgns")
            check_cgns(FOLDER / f"{name}_layers.cgns")
            print(f"{name}: cgnscheck compared {connections} connections")
        if shutil.which("cgnsdiff"):
            check_repetition(name)
        if vtk:
            check_vtk(name, PLOT3D)
            check_vtk(f"{name}_layers", ["binary_little"])
        if shutil.which("gmsh"):
            check_gmsh(name)
    missing = [tool for tool in ("cgnscheck", "cgnsdiff", "gmsh") if not shutil.which(tool)] + ([] if vtk else ["python3-vtk9"])
    if missing:
        print("missing: " + ", ".join(missing))
    return 1 if failures else 77 if missing else 0


if __name__ == "__main__":
    sys.exit(main())
