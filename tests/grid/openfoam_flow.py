"""A flow around the wing tip in a far field, computed by OpenFOAM on the grid that is written.

Usage: openfoam_flow.py PATCHWRIGHT SAMPLES_DIR
checkMesh must have no objections, and simpleFoam (laminar, 10 m/s, 30 iterations from uniform flow) must converge towards a flow whose highest
pressure is near that of stagnation and whose speed is nowhere far above the free stream's.
Exit codes: 0 so it is, 1 not so, 77 OpenFOAM or FreeCAD, which makes the case, is missing.
"""
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

from openfoam_check import said_by, sample_cases, volume_grid, write_case

CASE, RADIUS, SPEED, ITERATIONS = "wing_tip", 20, 10, 30


def header(name, kind="dictionary"):
    return f"FoamFile {{ version 2.0; format ascii; class {kind}; object {name}; }}\n"


def dictionaries():
    far = f"inletValue uniform ({SPEED} 0 0); value uniform ({SPEED} 0 0);"
    return {
        "system__controlDict": header("controlDict") + "application simpleFoam; startFrom startTime; startTime 0; stopAt endTime; deltaT 1; "
        f"endTime {ITERATIONS}; writeControl timeStep; writeInterval {ITERATIONS}; writePrecision 16;",
        "system__fvSchemes": header("fvSchemes") + """
ddtSchemes { default steadyState; }
gradSchemes { default Gauss linear; grad(U) cellLimited Gauss linear 1; }
divSchemes { default none; div(phi,U) bounded Gauss upwind; div((nuEff*dev2(T(grad(U))))) Gauss linear; }
laplacianSchemes { default Gauss linear limited 0.333; }
interpolationSchemes { default linear; }
snGradSchemes { default limited 0.333; }
""",
        "system__fvSolution": header("fvSolution") + """
solvers { p { solver GAMG; smoother GaussSeidel; tolerance 1e-9; relTol 0.01; }
          U { solver smoothSolver; smoother symGaussSeidel; tolerance 1e-9; relTol 0.1; } }
SIMPLE { nNonOrthogonalCorrectors 2; }
relaxationFactors { fields { p 0.3; } equations { U 0.7; } }
""",
        # What is near the middle is the wing; the rear half of the sphere is the outlet.
        "system__topoSetDict": header("topoSetDict") + """
actions (
    { name wing; type faceSet; action new; source patchToFace; patch defaultFaces; }
    { name wing; type faceSet; action subset; source sphereToFace; centre (0.5 0.5 0); radius 10; }
    { name outlet; type faceSet; action new; source patchToFace; patch defaultFaces; }
    { name outlet; type faceSet; action subtract; source faceToFace; set wing; }
    { name outlet; type faceSet; action subset; source boxToFace; box (0.5 -100 -100) (100 100 100); }
);
""",
        "system__createPatchDict": header("createPatchDict") + """
pointSync false;
patches ( { name wing; patchInfo { type wall; } constructFrom set; set wing; }
          { name outlet; patchInfo { type patch; } constructFrom set; set outlet; } );
""",
        "constant__transportProperties": header("transportProperties") + "transportModel Newtonian; nu 1e-3;",
        "constant__turbulenceProperties": header("turbulenceProperties") + "simulationType laminar;",
        "0__U": header("U", "volVectorField") + f"""
dimensions [0 1 -1 0 0 0 0];
internalField uniform ({SPEED} 0 0);
boundaryField {{ wing {{ type noSlip; }} defaultFaces {{ type fixedValue; value uniform ({SPEED} 0 0); }} outlet {{ type inletOutlet; {far} }} }}
""",
        "0__p": header("p", "volScalarField") + """
dimensions [0 2 -2 0 0 0 0];
internalField uniform 0;
boundaryField { wing { type zeroGradient; } defaultFaces { type zeroGradient; } outlet { type fixedValue; value uniform 0; } }
""",
    }


def values(path):
    """Of a field's cells, a list of numbers each."""
    text = path.read_text()
    text = text[text.index("internalField"):]
    text = text[text.index("(") + 1:text.index("\n)\n")]
    return [[float(x) for x in line.strip("()").split()] for line in text.split("\n") if line]


def main():
    patchwright, samples = pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(sys.argv[2]).resolve()
    if not shutil.which("simpleFoam"):
        print("OpenFOAM is missing")
        return 77
    with tempfile.TemporaryDirectory() as name:
        made = pathlib.Path(name)
        code = subprocess.run([sys.executable, samples / "make_cases", made, made], check=False).returncode
        if code != 0:
            return code
        flow = made / "flow"
        flow.mkdir()
        case = {**sample_cases(samples)[CASE], "layers": "20"}
        grid = volume_grid(patchwright, samples / CASE / "cage.obj", made / CASE / f"{CASE}.step", case, flow, "--farfield", f"{RADIUS}m")
        write_case(flow, **dictionaries())
        mesh = said_by(flow, ["plot3dToFoam", "-noBlank", grid], ["topoSet"], ["createPatch", "-overwrite"], ["checkMesh"])
        print(*re.findall(r"^ +(?:cells:|Max|Mesh non-orth|\*+[A-Z]).*$", mesh, re.MULTILINE), sep="\n")
        if "Mesh OK." not in mesh:
            print(mesh[-2000:])
            return 1
        said = said_by(flow, ["simpleFoam"])
        if not (flow / str(ITERATIONS) / "U").exists():
            print(said[-2000:])
            return 1
        residual = float(re.findall(r"Solving for Ux, Initial residual = ([0-9.e+-]+)", said)[-1])
        pressure = max(p for p, in values(flow / str(ITERATIONS) / "p")) / (0.5 * SPEED**2)
        speed = max(sum(x * x for x in u) for u in values(flow / str(ITERATIONS) / "U")) ** 0.5 / SPEED
        print(f"simpleFoam: residual of Ux {residual:.1e}, highest pressure coefficient {pressure:.2f}, highest speed {speed:.2f} of the free stream's")
        # Viscosity, and a tip in slightly faster flow, raise it above 1.
        return 0 if residual < 1e-4 and 0.8 < pressure < 1.5 and speed < 1.5 else 1


if __name__ == "__main__":
    sys.exit(main())
