"""Converts CAD files without a cage and prints a table of the results.

Usage: convert_table.py PATCHWRIGHT FILE_OR_FOLDER... [--tolerance 1e-3rel] [--seconds 120] [--at-least N]

With --at-least it fails when fewer files meet the tolerance, or when any run crashes, takes too long, or leaves a file that is
not valid or not closed although the input is. samples/write_tables uses the functions.
"""
import argparse
import json
import pathlib
import subprocess
import sys
import tempfile

SUFFIXES = {".stl", ".step", ".stp", ".iges", ".igs", ".brep", ".brp"}
HEADER = ("| input | patches | extraordinary vertices | deviation: out to in, in to out (of the diagonal) | verdict "
          "| long sharp curves kept | seconds |")


def run_convert(program, source, folder, options=(), seconds=None):
    """One conversion: {"code": exit code or None after `seconds`, "error": last line of stderr, "report": JSON or None}.

    There is no report where nothing was written; that of a run whose time limit came before a first result is on its input only.
    """
    report = pathlib.Path(folder) / "report.json"
    report.unlink(missing_ok=True)
    command = [program, "convert", source, "-o", pathlib.Path(folder) / "out.step", "--json", report, "-q", *options]
    try:
        run = subprocess.run(list(map(str, command)), capture_output=True, text=True, timeout=seconds)
    except subprocess.TimeoutExpired:
        return {"code": None, "error": f"more than {seconds:g} s", "report": None}
    lines = run.stderr.strip().splitlines()
    found = json.loads(report.read_text()) if run.returncode in (0, 3) and report.exists() else {}
    return {"code": run.returncode, "error": lines[-1] if lines else "", "report": found if "solid" in found else None}


def deviations(report):
    """Largest distances, output to input and input to output, as fractions of the diagonal."""
    return [report["deviation"][way]["max"] / report["input"]["diagonal"] for way in ("output_to_input", "input_to_output")]


def lost_curves(report):
    return report.get("sharp_curves", {}).get("long", {}).get("missed", [])


def state(result):
    """met, missed, refused (input not usable) or failed (crash, time, or a file that is not what the input asks for)."""
    report = result["report"]
    if report is None:  # 3: no result within the time limit
        return {2: "refused", 3: "missed"}.get(result["code"], "failed")
    solid = report["solid"]
    # An open model stays open; a closed one must become a valid solid.
    if not solid["valid"] or (report["input"]["solids"] > 0 and not solid["closed"]):
        return "failed"
    return "met" if result["code"] == 0 else "missed"


def verdict(result):
    """The program's sentence; where there is none, why not."""
    report = result["report"]
    if report is None:
        return f"exit {result['code']}: {result['error'][-200:]}"
    return report.get("verdict", {}).get("sentence") or state(result)


def row(name, result):
    """A line of the table with HEADER."""
    report = result["report"]
    text = verdict(result).replace("|", "/")
    if report is None:
        return f"| {name} | | | | {text} | | |"
    curves = report.get("sharp_curves", {}).get("long")
    kept = f"{curves['count'] - len(curves['missed'])} of {curves['count']}" if curves else "-"
    out, back = deviations(report)
    return (f"| {name} | {report['patches']['count']} | {report['cage']['extraordinary']} | {out:.1e}, {back:.1e} | {text} | {kept} "
            f"| {report['seconds']['total']:.1f} |")


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("program", type=pathlib.Path)
    parser.add_argument("inputs", nargs="+", type=pathlib.Path)
    parser.add_argument("--tolerance", default="1e-3rel")
    parser.add_argument("--seconds", type=float, default=120)
    parser.add_argument("--time-limit", type=float, help="of each conversion, seconds; the same as --seconds where not given")
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
            # Results do not depend on how fast the machine is.
            options = ["--tolerance", args.tolerance, "--time-limit", args.time_limit or args.seconds]
            result = run_convert(args.program, file, folder, options, args.seconds)
            report = result["report"]
            too_many = report and args.most_patches is not None and report["patches"]["count"] > args.most_patches
            lost = report and args.all_curves and lost_curves(report)
            states.append("failed" if too_many or lost else state(result))
            print(row(file.name, result), flush=True)
    counts = {s: states.count(s) for s in ("met", "missed", "refused", "failed")}
    print("\n" + ", ".join(f"{n} {s}" for s, n in counts.items()))
    if args.at_least is not None and (counts["met"] < args.at_least or counts["failed"] > 0):
        sys.exit(1)


if __name__ == "__main__":
    main()
