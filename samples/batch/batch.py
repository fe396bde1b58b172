"""Converts one file and keeps a record of it; writes the table and the index page of all records.

batch.py PROGRAM INPUT REPORT.json [OPTION...]
"""
import csv
import html
import json
import pathlib
import subprocess
import sys
import urllib.parse

SUFFIXES = {".step", ".stp", ".igs", ".iges", ".brep", ".stl", ".obj"}
PRODUCTS = ["step", "glb", "html"]
# Done and met; the input is unusable, which no other run changes; written, but the verdict is not met.
FINAL = {0: "met", 2: "unusable", 3: "missed"}
COLUMNS = ["file", "result", "message", "diagonal", "unit", "faces", "patches", "deviation_rel", "seconds",
           "peak_memory_mb", *PRODUCTS, "json", "log"]


def find_inputs(folder):
    folder = pathlib.Path(folder)
    names = sorted(f.relative_to(folder).as_posix() for f in folder.rglob("*")
                   if f.suffix.lower() in SUFFIXES and f.is_file())
    if not names:
        raise SystemExit(f"{folder}: no file of these kinds: {' '.join(sorted(SUFFIXES))}")
    return names


def products(report):
    """STEP, GLB and HTML beside the report, named after the input's folder: wing.igs/wing.step."""
    return {kind: report.with_name(f"{pathlib.Path(report.parent.name).stem}.{kind}") for kind in PRODUCTS}


def convert(program, given, report, options):
    """The exit code: 0 when the record is final, else the program's; the job is then tried again in the next run."""
    files = products(report)
    report.parent.mkdir(parents=True, exist_ok=True)
    with report.with_name("run.log").open("w") as log:
        code = subprocess.run([program, "convert", given, "-o", files["step"], "--field", files["glb"], "--report",
                               files["html"], "--json", report, *options], stdout=log, stderr=subprocess.STDOUT).returncode
        log.write(f"exit code {code}\n")
    if code == 2:
        for file in files.values():  # of an earlier, usable input
            file.unlink(missing_ok=True)
    return 0 if code in FINAL else code if code > 0 else 128 - code


def describe(name, output):
    """A row of the table."""
    report = pathlib.Path(output) / name / "report.json"
    log = report.with_name("run.log")
    row = {"file": name, "result": "not done", "log": f"{name}/run.log" if log.exists() else ""}
    if not report.exists():
        if log.exists():
            lines = log.read_text(errors="replace").splitlines() or ["no message"]
            row.update(result="failed", message="; ".join(lines[-2:]))
        return row
    record = json.loads(report.read_text())
    row["json"] = f"{name}/report.json"
    row.update(seconds=f"{record['seconds']['total']:.3g}", peak_memory_mb=f"{record['peak_memory_mb']:.0f}")
    if "error" in record:
        return {**row, "result": FINAL.get(record["error"]["exit_code"], "failed"), "message": record["error"]["message"]}
    diagonal = record["input"]["diagonal"]
    row.update(result="met" if record["verdict"]["met"] else "missed", message=record["verdict"]["sentence"],
               diagonal=f"{diagonal:.6g}", unit=record["unit"], faces=record["input"]["faces"],
               patches=record["patches"]["count"],
               deviation_rel=f"{max(side['max'] for side in record['deviation'].values()) / diagonal:.2e}")
    row.update({kind: f"{name}/{file.name}" for kind, file in products(report).items() if file.exists()})
    return row


def write_page(file, rows):
    counts = {}
    for row in rows:
        counts[row["result"]] = counts.get(row["result"], 0) + 1
    linked = [*PRODUCTS, "json", "log"]

    def cell(row, column):
        text = html.escape(str(row.get(column, "")))
        return f'<a href="{urllib.parse.quote(str(row[column]))}">{column}</a>' if column in linked and text else text

    body = "\n".join(f'<tr class="{row["result"].replace(" ", "_")}">'
                     + "".join(f"<td>{cell(row, column)}</td>" for column in COLUMNS) + "</tr>" for row in rows)
    file.write_text(f"""<!DOCTYPE html>
<html lang="en"><meta charset="utf-8"><title>patchwright: {len(rows)} files</title>
<style>body {{ font: 14px sans-serif }} td, th {{ padding: 2px 8px; text-align: left }} th {{ position: sticky; top: 0; background: #eee }}
.missed {{ background: #fff3d0 }} .unusable, .failed {{ background: #fdd }} .not_done {{ color: #777 }}</style>
<h1>{len(rows)} files: {", ".join(f"{count} {result}" for result, count in sorted(counts.items()))}</h1>
<table><tr>{"".join(f"<th>{column}</th>" for column in COLUMNS)}</tr>
{body}
</table></html>
""")


def write_summary(names, output):
    output = pathlib.Path(output)
    output.mkdir(parents=True, exist_ok=True)
    rows = [describe(name, output) for name in names]
    with (output / "table.csv").open("w", newline="") as file:
        writer = csv.DictWriter(file, COLUMNS)
        writer.writeheader()
        writer.writerows(rows)
    write_page(output / "index.html", rows)


if __name__ == "__main__":
    if len(sys.argv) < 4:
        sys.exit(__doc__)
    sys.exit(convert(sys.argv[1], sys.argv[2], pathlib.Path(sys.argv[3]), sys.argv[4:]))
