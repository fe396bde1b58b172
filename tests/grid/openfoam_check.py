"""Volume grids of the paper's three cases, read and checked by OpenFOAM: plot3dToFoam, then checkMesh.

Usage: openfoam_check.py PATCHWRIGHT SAMPLES_DIR
Sizes, layers and cages are those of samples/convert_cases. Prints what checkMesh measures.
Exit codes: 0 no failed check, 1 not so, 77 OpenFOAM or FreeCAD, which makes the cases, is missing.
"""
import importlib.machinery
import importlib.util
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

ETC = pathlib.Path("/usr/share/openfoam")  # of Debian's package, which sets no variables
CONTROL = """FoamFile { version 2.0; format ascii; class dictionary; object controlDict; }
application none; startFrom startTime; startTime 0; stopAt endTime; endTime 1; deltaT 1; writeControl timeStep; writeInterval 1;
"""
SCHEMES = "FoamFile { version 2.0; format ascii; class dictionary; object fvSchemes; }\n" + " ".join(
    f"{kind}Schemes {{ default {scheme}; }}" for kind, scheme in (
        ("ddt", "steadyState"), ("grad", "Gauss linear"), ("div", "none"), ("laplacian", "Gauss linear corrected"),
        ("interpolation", "linear"), ("snGrad", "corrected")))
SOLUTION = "FoamFile { version 2.0; format ascii; class dictionary; object fvSolution; }\n"


def sample_cases(samples):
    loader = importlib.machinery.SourceFileLoader("convert_cases", str(samples / "convert_cases"))
    module = importlib.util.module_from_spec(importlib.util.spec_from_loader(loader.name, loader))
    loader.exec_module(module)
    return module.CASES


def volume_grid(patchwright, cage, source, case, folder, *options):
    """In metres, as OpenFOAM has them."""
    fitted, grid = folder / "fitted.obj", folder / "layers.xyz"
    subprocess.run([patchwright, "fit", source, "--cage", cage, "-o", fitted, "-q"], check=True)
    subprocess.run([patchwright, "grid", fitted, "-o", grid, "--plot3d", "ascii", "--unit", "m", "--size", case["size"], "--smooth",
                    "--layers", case["layers"], "--layer-height", case["first"], "-q", *options], check=True)
    return grid


def write_case(folder, **files):
    """Files of an OpenFOAM case: system/controlDict is system__controlDict."""
    for name, text in files.items():
        path = folder / name.replace("__", "/")
        path.parent.mkdir(exist_ok=True)
        path.write_text(text)


def said_by(folder, *commands):
    """What the last one says of those that are run: up to the first that fails."""
    environment = {**os.environ, "PWD": str(folder)}
    if ETC.exists():
        environment.setdefault("WM_PROJECT_DIR", str(ETC))
    said = ""
    for command in commands:
        result = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, timeout=1200)
        said = result.stdout + result.stderr
        if result.returncode != 0:
            break
    return said


def checked(grid, folder):
    """What checkMesh says of the grid."""
    write_case(folder, system__controlDict=CONTROL, system__fvSchemes=SCHEMES, system__fvSolution=SOLUTION)
    (folder / "constant").mkdir()
    return said_by(folder, ["plot3dToFoam", "-noBlank", grid], ["checkMesh"])


def main():
    patchwright, samples = pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(sys.argv[2]).resolve()
    if not shutil.which("plot3dToFoam") or not shutil.which("checkMesh"):
        print("OpenFOAM is missing")
        return 77
    failed = False
    with tempfile.TemporaryDirectory() as name:
        made = pathlib.Path(name)
        code = subprocess.run([sys.executable, samples / "make_cases", made, made], check=False).returncode
        if code != 0:
            return code
        for case, wanted in sample_cases(samples).items():
            folder = made / f"{case}_foam"
            folder.mkdir()
            grid = volume_grid(patchwright, samples / case / "cage.obj", made / case / f"{case}.step", wanted, folder)
            said = checked(grid, folder)
            print(f"{case}:", *re.findall(r"^ +(?:cells:|Max|Mesh non-orth|\*+[A-Z]).*$", said, re.MULTILINE), sep="\n")
            if "Mesh OK." not in said:
                failed = True
                print(said[-2000:])
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
