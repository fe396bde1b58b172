"""Converts CAD files without a cage and prints a table of what came out.

Usage: convert_table.py PATCHWRIGHT FILE_OR_FOLDER... [--tolerance 1e-3rel] [--seconds 120] [--at-least N]

With --at-least it fails when fewer files meet the tolerance as valid solids, or when any run crashes, takes too long or leaves
a file that is not valid.
"""
import argparse
import json
import pathlib
import subprocess
import sys
import tempfile

SUFFIXES = {".stl", ".step", ".stp", ".iges", ".igs", ".brep", ".brp"}
HEADER = ("| input | faces in | cage faces | extraordinary vertices | patches | closed, valid | "
          "deviation out to in, in to out (of the diagonal) | tolerance | long sharp curves kept | seconds |")


def kept(report):
    """How many of the input's sharp curves longer than 100 times the tolerance lie within it of edges of the output."""
    curves = report.get("sharp_curves", {}).get("long")
    return f"{curves['count'] - len(curves['missed'])} of {curves['count']}" if curves else "-"


def convert(program, file, tolerance, seconds, folder, most_patches=None, all_curves=False):
    """(state, row): state is met, missed, refused or failed."""
    report, output = folder / "report.json", folder / "out.step"
    for old in (report, output):
        old.unlink(missing_ok=True)
    command = [program, "convert", file, "-o", output, "--tolerance", tolerance, "--json", report, "-q"]
    try:
        run = subprocess.run(list(map(str, command)), capture_output=True, text=True, timeout=seconds)
    except subprocess.TimeoutExpired:
        return "failed", f"| {file.name} | more than {seconds} s | | | | | | | | |"
    if run.returncode == 2:
        return "refused", f"| {file.name} | {run.stderr.strip().splitlines()[-1]} | | | | | | | | |"
    if run.returncode not in (0, 3):
        return "failed", f"| {file.name} | exit {run.returncode}: {run.stderr.strip()[-200:]} | | | | | | | | |"
    r = json.loads(report.read_text())
    diagonal = r["input"]["diagonal"]
    out, back = (r["deviation"][way]["max"] / diagonal for way in ("output_to_input", "input_to_output"))
    solid = r["solid"]
    state = "met" if run.returncode == 0 else "missed"
    # An open model stays open; a closed one must become a valid solid.
    if not solid["valid"] or (r["input"]["solids"] > 0 and not solid["closed"]):
        state = "failed"
    if most_patches is not None and r["patches"]["count"] > most_patches:
        state = "failed"
    if all_curves and r.get("sharp_curves", {}).get("long", {}).get("missed"):
        state = "failed"
    return state, (f"| {file.name} | {r['input']['faces']} | {r['cage']['faces']} | {r['cage']['extraordinary']} | {r['patches']['count']} | "
                   f"{'yes' if solid['closed'] else 'open'}, {'yes' if solid['valid'] else 'no'} | {out:.1e}, {back:.1e} | "
                   f"{tolerance}: {state} | {kept(r)} | {r['seconds']['total']:.1f} |")


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("program", type=pathlib.Path)
    parser.add_argument("inputs", nargs="+", type=pathlib.Path)
    parser.add_argument("--tolerance", default="1e-3rel")
    parser.add_argument("--seconds", type=float, default=120)
    parser.add_argument("--at-least", type=int)
    parser.add_argument("--most-patches", type=int, help="more than these count as failed")
    parser.add_argument("--all-curves", action="store_true", help="a long sharp curve that is lost counts as failed")
    args = parser.parse_args()
    files = [f for i in args.inputs for f in (sorted(i.iterdir()) if i.is_dir() else [i]) if f.suffix.lower() in SUFFIXES]
    print(HEADER)
    print("|" + "---|" * HEADER.count(" |"))
    states = []
    with tempfile.TemporaryDirectory() as folder:
        for file in files:
            state, row = convert(args.program, file, args.tolerance, args.seconds, pathlib.Path(folder), args.most_patches, args.all_curves)
            states.append(state)
            print(row, flush=True)
    counts = {s: states.count(s) for s in ("met", "missed", "refused", "failed")}
    print("\n" + ", ".join(f"{n} {s}" for s, n in counts.items()))
    if args.at_least is not None and (counts["met"] < args.at_least or counts["failed"] > 0):
        sys.exit(1)


if __name__ == "__main__":
    main()
