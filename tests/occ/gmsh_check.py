"""Lets Gmsh, an independent reader, import CAD files and mesh their solids.

Usage: gmsh_check.py FILE...
Exit codes: 0 every file was meshed with tetrahedra and without an error, 1 not so, 77 Gmsh is missing.
"""
import pathlib
import shutil
import subprocess
import sys
import tempfile

GMSH = shutil.which("gmsh")


def problems(path):
    with tempfile.TemporaryDirectory() as folder:
        mesh = pathlib.Path(folder) / "mesh.msh"
        result = subprocess.run([GMSH, "-3", str(path), "-o", str(mesh), "-format", "msh22", "-clscale", "0.7"],
                                capture_output=True, text=True, timeout=600)
        found = [line for line in (result.stdout + result.stderr).splitlines() if line.startswith("Error")]
        if result.returncode != 0 or not mesh.exists():
            return found + [f"exit code {result.returncode}"]
        lines = mesh.read_text().splitlines()
    elements = lines[lines.index("$Elements") + 2:lines.index("$EndElements")]
    tetrahedra = sum(1 for line in elements if line.split()[1] == "4")
    print(f"{path}: {tetrahedra} tetrahedra")
    return found + ([] if tetrahedra > 0 else ["no tetrahedra"])


def main():
    if GMSH is None:
        print("Gmsh is missing")
        return 77
    bad = {path: found for path in sys.argv[1:] if (found := problems(path))}
    for path, found in bad.items():
        print(f"{path}: {'; '.join(found)}")
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
