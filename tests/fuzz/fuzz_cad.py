"""Mutates STEP, IGES and BREP files and runs `inspect`, for a small share `convert`, on them.

Usage: fuzz_cad.py PATCHWRIGHT SAMPLES_DIR [--also FOLDER] [--count N] [--seconds S] [--seed TEXT] [--only I] [--keep FOLDER]

File I of a seed is the same on every machine; --only I runs it alone, --keep has the files of all findings written.
A finding is a run that ends by a signal or with another exit code than 0, 2 or 3, takes more than 30 s of processor time, has not one line of
error where it fails, changes the old output or leaves another file beside it where it fails, or ends with 0 although
* of a STEP file: not as many faces were read as its text has (`inspect --no-heal`);
* a figure of the report is not finite;
* of a conversion: the STEP file written has an open end: see `problem_of_step`, which shares no code with the program.
Exit codes: 0 no finding, 1 findings, 2 nothing was run.
"""
import argparse
import collections
import concurrent.futures
import json
import math
import os
import pathlib
import random
import re
import shutil
import subprocess
import sys
import tempfile
import time

PROCESSOR_S = 30  # of a run, its child processes included
WALL_S = 300  # for the case that a run sleeps
CONVERT_EVERY = 25  # conversions take some hundred times as long
CONVERT_LIMIT_S = 5
OLD = b"old content"
NUMBER = re.compile(rb"(?<![\w.#])-?\d+(?:\.\d*)?(?:[ED][+-]?\d+)?")
ENTITY = re.compile(rb"#\d+")
KEYWORD = re.compile(rb"[A-Z][A-Z_0-9]{5,}")
EXTREME = [b"0", b"-1", b"1E30", b"-1E-30", b"2147483648", b"1E308", b"99999", b"0.5", b"NAN", b"1.", b"-0."]


def replace(data, match, text, fixed_columns):
    """Fixed columns: the text is cut or filled to the length of what it replaces."""
    if fixed_columns:
        text = text[: match.end() - match.start()].rjust(match.end() - match.start())
    return data[: match.start()] + text + data[match.end():]


def changed_number(rng, data, fixed):
    match = rng.choice(list(NUMBER.finditer(data)))
    old = match[0]
    try:
        value = float(old.replace(b"D", b"E"))
        nearby = [f"{value * f:.6G}".encode() for f in (-1, 2, 0.5, 1.001, 1e3)] + [b"%d" % (int(value) + d) for d in (-1, 1)]
    except (ValueError, OverflowError):
        nearby = EXTREME
    return replace(data, match, rng.choice(rng.choice([EXTREME, nearby])), fixed)


def changed_reference(rng, data, fixed):
    """One entity, word or number in place of another one."""
    pattern = rng.choice([ENTITY, KEYWORD, NUMBER])
    found = list(pattern.finditer(data)) or list(NUMBER.finditer(data))
    return replace(data, rng.choice(found), rng.choice(found)[0], fixed)


def flipped_bytes(rng, data, fixed):
    result = bytearray(data)
    for _ in range(rng.choice([1, 1, 2, 8])):
        result[rng.randrange(len(result))] = rng.choice([rng.randrange(256), rng.choice(b"0123456789 ,;()$*'.-#\n")])
    return bytes(result)


def changed_lines(rng, data, fixed):
    """Lines deleted, repeated or swapped."""
    lines = data.split(b"\n")
    at, other, kind = rng.randrange(len(lines)), rng.randrange(len(lines)), rng.randrange(3)
    if kind == 0:
        del lines[at: at + rng.choice([1, 1, 1, 3])]
    elif kind == 1:
        lines.insert(other, lines[at])
    else:
        lines[at], lines[other] = lines[other], lines[at]
    return b"\n".join(lines)


def cut(rng, data, fixed):
    """The end is lost, or a piece of the middle."""
    start = rng.randrange(len(data))
    return data[:start] + (b"" if rng.random() < 0.3 else data[min(len(data), start + rng.randrange(1, 2000)):])


MUTATIONS = [changed_number, changed_number, changed_reference, changed_reference, flipped_bytes, changed_lines, cut]


def mutated(rng, file):
    data = file.read_bytes()
    for _ in range(rng.choice([1, 1, 1, 2, 4])):
        data = rng.choice(MUTATIONS)(rng, data, file.suffix == ".igs") or b" "
    return data


def entities_of_step(text):
    """By number: (type, arguments as text) of the simple entities of a STEP file."""
    text = re.sub(r"/\*.*?\*/", "", text, flags=re.DOTALL)
    text = re.sub(r"'(?:[^']|'')*'", "''", text)
    return {int(n): (t, a) for n, t, a in re.findall(r"#(\d+)\s*=\s*([A-Z_0-9]*)\s*\(([^;]*)\)\s*;", text)}


def problem_of_step(file):
    """What keeps the bodies of a STEP file from being closed, oriented and finite; none: None."""
    entities = entities_of_step(file.read_text())
    uses = collections.Counter()
    for kind, arguments in entities.values():
        for reference in re.findall(r"#(\d+)", arguments):
            if int(reference) not in entities:
                return f"#{reference} is not there"
        if kind == "CARTESIAN_POINT":
            if not all(math.isfinite(float(x)) for x in re.findall(r"-?\d[\d.E+-]*", arguments)):
                return "a point is not finite"
        elif kind == "EDGE_LOOP":
            for oriented in re.findall(r"#(\d+)", arguments):
                edge, sense = re.search(r"#(\d+),\.([TF])\.", entities[int(oriented)][1]).groups()
                uses[edge, sense] += 1
    if not uses:
        return "no loops"
    closed = {int(n) for kind, arguments in entities.values() if kind == "CLOSED_SHELL" for n in re.findall(r"#(\d+)", arguments)}
    faces = sum(kind == "ADVANCED_FACE" for kind, _ in entities.values())
    if any(count != 1 for count in uses.values()):
        return "an edge is used twice in one direction"
    if len(closed) == faces and len(uses) != 2 * len({edge for edge, _ in uses}):
        return "an edge of a closed shell is used once"
    return None


def infinite_figure(value):
    values = value.values() if isinstance(value, dict) else value if isinstance(value, list) else []
    return value is not None and isinstance(value, float) and not math.isfinite(value) or any(map(infinite_figure, values))


def run(arguments):
    """Exit code (negative: signal), standard output and error, processor time with children."""
    with tempfile.TemporaryFile() as out, tempfile.TemporaryFile() as error:
        process = subprocess.Popen(arguments, stdout=out, stderr=error, stdin=subprocess.DEVNULL)
        deadline = time.monotonic() + WALL_S
        while (ended := os.wait4(process.pid, os.WNOHANG))[0] == 0:
            if time.monotonic() > deadline:
                process.kill()
            time.sleep(0.01)
        process.returncode = os.waitstatus_to_exitcode(ended[1])
        out.seek(0), error.seek(0)
        return process.returncode, out.read().decode(errors="replace"), error.read().decode(errors="replace"), \
            ended[2].ru_utime + ended[2].ru_stime


def problem_of_run(patchwright, file, data, convert):
    """Exit code, and what is wrong with the run, or None."""
    folder = file.parent
    output = folder / "old.step"
    output.write_bytes(OLD)
    arguments = ["convert", file, "-o", output, "--tolerance", "1e-2rel", "--time-limit", str(CONVERT_LIMIT_S)] if convert else \
        ["inspect", file, "--no-heal", "--json", "-"]
    code, out, error, seconds = run([patchwright, *map(str, arguments)])
    lines = [line for line in error.splitlines() if not line.startswith("note: ")]
    if code not in (0, 2, 3):
        return code, f"exit {code}: {error[-300:]}"
    if seconds > PROCESSOR_S:
        return code, f"{seconds:.0f} s"
    if code not in (0, 3):
        if len(lines) != 1:
            return code, f"{len(lines)} lines of error: {error[-300:]}"
        if output.read_bytes() != OLD:
            return code, "the old output is gone"
    if sorted(f.name for f in folder.iterdir()) != sorted([file.name, output.name]):
        return code, f"files left: {os.listdir(folder)}"
    if code != 0:
        return code, None
    if convert:
        return code, problem_of_step(output)
    report = json.loads(out)
    if infinite_figure(report):
        return code, "a figure is not finite"
    if file.suffix == ".step":
        faces = sum(kind in ("ADVANCED_FACE", "FACE_SURFACE") for kind, _ in entities_of_step(data.decode("latin-1")).values())
        if report["solid"]["faces"] < faces:
            return code, f"{report['solid']['faces']} faces of {faces}"
    return code, None


def originals(patchwright, samples, also, folder):
    files = [samples / "wing" / "wing.step", samples / "wing" / "wing.igs"]
    for cage in ("cube", "cube_rim", "dish"):
        for suffix in ("step", "igs", "brep"):
            files.append(folder / f"{cage}.{suffix}")
            subprocess.run([patchwright, "export", "-q", samples / "cages" / f"{cage}.obj", "-o", files[-1]], check=True)
    if also:
        files += sorted(f for f in also.iterdir() if f.suffix in (".step", ".igs", ".brep"))
    return files


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("patchwright")
    parser.add_argument("samples", type=pathlib.Path)
    parser.add_argument("--also", type=pathlib.Path, help="folder of more files to mutate")
    parser.add_argument("--count", type=int, default=3000)
    parser.add_argument("--seconds", type=float, default=math.inf)
    parser.add_argument("--seed", default="1")
    parser.add_argument("--only", type=int)
    parser.add_argument("--keep", type=pathlib.Path)
    options = parser.parse_args()
    folder = pathlib.Path(tempfile.mkdtemp(prefix="fuzz_cad"))
    deadline = time.monotonic() + options.seconds
    codes, findings = collections.Counter(), 0
    try:
        files = originals(options.patchwright, options.samples, options.also, folder)

        def one(i):
            if time.monotonic() > deadline:
                return None
            rng = random.Random(f"{options.seed}/{i}")
            original = rng.choice(files)
            data = mutated(rng, original)
            with tempfile.TemporaryDirectory(dir=folder) as place:
                file = pathlib.Path(place) / f"mutated{original.suffix}"
                file.write_bytes(data)
                convert = i % CONVERT_EVERY == 0
                code, problem = problem_of_run(options.patchwright, file, data, convert)
            if problem and options.keep:
                options.keep.mkdir(parents=True, exist_ok=True)
                (options.keep / f"{options.seed}_{i}{original.suffix}").write_bytes(data)
            return i, original.name, convert, code, problem

        wanted = range(options.count) if options.only is None else [options.only]
        with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
            for result in filter(None, pool.map(one, wanted)):
                i, name, convert, code, problem = result
                codes[code] += 1
                if problem:
                    findings += 1
                    print(f"{i}: {name}{', convert' if convert else ''}: {problem}", flush=True)
    finally:
        shutil.rmtree(folder)
    ends = ", ".join(f"exit {code}: {count}" for code, count in sorted(codes.items()))
    print(f"seed {options.seed}: {codes.total()} files, {findings} findings ({ends})")
    return 2 if not codes else 1 if findings else 0


if __name__ == "__main__":
    sys.exit(main())
