"""Mutated cages and STL files through the command line.

Usage: fuzz_cages.py PATCHWRIGHT [--cases N] [--seed S] [--seconds T] [--jobs J] [--keep FOLDER] [--only CASE]
Each case is made from the seed and its number alone. Required of every run: no signal, no internal error, an end within
30 s of processor time, one line of error where it fails; the old output as it was and nothing beside it unless it ends with 0 or 3. Of what
`export` calls met: valid and, where each edge of the cage has two faces, closed for `inspect`, and of the volume that the
refined cages tend to. Coordinates that are written are finite. Exit codes: 0 nothing found, 1 failures.
"""
import argparse
import collections
import concurrent.futures
import json
import math
import os
import pathlib
import random
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import time

from cage_maker import make_cage, make_stl

HANG_S = 30  # of processor time, which other programs do not take away
WAIT_S = 600
MEMORY_BYTES = 4 << 30
OLD = b"old content"
STL_SHARE = 0.15


class Failure(Exception):
    pass


def require(holds, text):
    if not holds:
        raise Failure(text)


def limit():
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY_BYTES, MEMORY_BYTES))
    resource.setrlimit(resource.RLIMIT_CPU, (HANG_S, HANG_S + 1))


def run(arguments):
    try:
        result = subprocess.run([str(a) for a in arguments], capture_output=True, timeout=WAIT_S, preexec_fn=limit)
    except subprocess.TimeoutExpired:
        raise Failure(f"no end within {WAIT_S} s") from None
    require(result.returncode not in (-signal.SIGXCPU, -signal.SIGKILL), f"no end within {HANG_S} s")
    return result


def choose(rng, is_stl, folder):
    """Arguments behind the program's name, INPUT for the input, and the outputs."""
    if is_stl:
        if rng.random() < 0.9:
            return ["inspect", "INPUT", "--json", "-", "-q"], []
        out = folder / "out.obj"
        return ["cage", "INPUT", "-o", out, "-q"], [out]
    command = rng.choices(["export", "eval", "grid", "subdivide"], [55, 15, 15, 15])[0]
    if command == "eval":
        places = [f"{rng.randrange(6)},{rng.choice([0, 1, 0.5, 1e-9, 0.37])},{rng.choice([0, 1, 0.5, 1e-12, 0.61])}"
                  + rng.choice(["", "", ",0", ",2"]) for _ in range(2)]
        return ["eval", "INPUT", "--json", "-", *(x for p in places for x in ("--at", p))], []
    if command == "subdivide":
        out = folder / "out.obj"
        return ["subdivide", "INPUT", "-n", str(rng.choice([0, 1, 2, 3])), "-o", out, "-q"], [out]
    if command == "grid":
        out = folder / rng.choice(["out.cgns", "out.xyz", "out.xyz", "out.vtm"])
        more = rng.choice([[], ["--points", "3"], ["--size", "0.1rel"], ["--blocks", "faces"], ["--no-join"],
                           ["--layers", "2", "--thickness", "0.01rel"],
                           ["--layers", "2", "--thickness", "0.01rel", "--farfield", "10rel"], ["--curvature"], ["--smooth"], ["--points", "1000000"]])
        return ["grid", "INPUT", "-o", out, "--plot3d", "ascii", "--points", "5", *more][:None if "--points" not in more else 6] + (
            more if "--points" in more else []), [out]
    out = folder / rng.choice(["out.step", "out.step", "out.step", "out.igs", "out.brep"])
    more = rng.choice([[], [], ["--tolerance", "1e-2rel"], ["--patches", "faces"], ["--continuity", "refined"]])
    return ["export", "INPUT", "-o", out, "-q", *more], [out]


def polyhedron_volume(file):
    """Of an OBJ file's polygons in fans around their middles, relative to the first point."""
    points, total = [], 0.0
    for line in file.read_text(errors="replace").splitlines():
        words = line.split()
        if words[:1] == ["v"]:
            points.append([float(x) for x in words[1:4]])
        elif words[:1] == ["f"]:
            corners = [[x - o for x, o in zip(points[int(w) - 1], points[0])] for w in words[1:]]
            m = [sum(x) / len(corners) for x in zip(*corners)]
            for a, b in zip(corners, corners[1:] + corners[:1]):
                total += m[0] * (a[1] * b[2] - a[2] * b[1]) + m[1] * (a[2] * b[0] - a[0] * b[2]) + m[2] * (a[0] * b[1] - a[1] * b[0])
    return total / 6.0


def is_closed(cage):
    uses = collections.Counter(frozenset(e) for e in cage.edges())
    return set(uses.values()) == {2}


def is_one_part(cage):
    part = list(range(len(cage.points)))

    def root(v):
        while part[v] != v:
            v = part[v]
        return v
    for a, b in cage.edges():
        part[root(a)] = root(b)
    return len({root(v) for f in cage.faces for v in f}) == 1


def check_export(program, file, cage, source, folder):
    """Of a run that ended with 0."""
    result = run([program, "inspect", file, "--no-heal", "--json", "-", "-q"])
    require(result.returncode == 0, f"inspect ends with {result.returncode}: {result.stderr.decode(errors='replace')}")
    solid = json.loads(result.stdout)["solid"]
    require(solid["valid"], "met, but not valid for inspect")
    if cage is None or not is_closed(cage):
        return
    require(solid["closed"], "met, but open for inspect")
    if file.suffix == ".step":
        require(solid["volume"] > 0.0, f"met, but of volume {solid['volume']}")
    if any("sector" in tag for tag in cage.tags) or not is_one_part(cage) or solid["solids"] == 0:
        return
    volumes = []
    for level in (3, 4):
        fine = folder / "fine.obj"
        require(run([program, "subdivide", source, "-n", level, "-o", fine, "-q"]).returncode == 0, "subdivide fails")
        volumes.append(polyhedron_volume(fine))
        fine.unlink()
    expected = abs(volumes[1] + (volumes[1] - volumes[0]) / 3.0)  # errors shrink to a quarter
    numbers = cage.numbers()
    size = math.prod(max(p[k] for p in numbers) - min(p[k] for p in numbers) or 1e-3 for k in range(3))
    require(abs(solid["volume"] - expected) <= 0.01 * size + abs(volumes[1] - volumes[0]),
            f"volume {solid['volume']}, of the refined cages {expected}")


def check_outputs(program, arguments, outputs, result, cage, source, folder):
    if arguments[0] == "eval":
        text = result.stdout.decode()
        require("nan" not in text.lower() and "inf" not in text.lower() and "null" not in text, "eval wrote what is not finite")
        json.loads(text)
    if arguments[0] == "subdivide" or (arguments[0] == "grid" and outputs[0].suffix == ".xyz"):
        words = outputs[0].read_text(errors="replace").lower().split()
        require("nan" not in words and "inf" not in words and "-inf" not in words and "-nan" not in words, "wrote what is not finite")
    if arguments[0] == "export" and result.returncode == 0:
        check_export(program, outputs[0], cage, source, folder)


def one_case(program, seed, number, keep):
    """@return the exit code, or what failed"""
    rng = random.Random(f"{seed} {number}")
    folder = pathlib.Path(tempfile.mkdtemp(prefix="patchwright-fuzz"))
    is_stl = rng.random() < STL_SHARE
    data, cage = (make_stl(rng), None) if is_stl else make_cage(rng)
    source = folder / ("input.stl" if is_stl else "input.obj")
    source.write_bytes(data)
    place = folder / "out"
    place.mkdir()
    arguments, outputs = choose(rng, is_stl, place)
    arguments = [source if a == "INPUT" else a for a in arguments]
    for file in outputs:
        file.write_bytes(OLD)
    start = time.monotonic()
    result = None
    try:
        result = run([program, *arguments])
        errors = result.stderr.decode(errors="replace")
        require(result.returncode >= 0, f"signal {-result.returncode}")
        require(result.returncode in (0, 1, 2, 3, 4), f"ends with {result.returncode}: {errors.strip()[-300:]}")
        if result.returncode in (0, 3):
            check_outputs(program, arguments, outputs, result, cage, source, folder)
        else:
            lines = [line for line in errors.rstrip("\n").split("\n") if not line.startswith("note: ")]
            require(len(lines) == 1, f"{len(lines)} lines of error: {errors[-300:]}")
            require(sorted(os.listdir(place)) == sorted(f.name for f in outputs), f"left {os.listdir(place)}")
            require(all(f.read_bytes() == OLD for f in outputs), "the old output is lost")
        return str(result.returncode), time.monotonic() - start
    except Failure as failure:
        if keep:
            target = pathlib.Path(keep) / str(number)
            shutil.rmtree(target, ignore_errors=True)
            shutil.copytree(folder, target)
            (target / "command").write_text(f"{failure}\n{' '.join(map(str, arguments))}\n")
        return f"case {number}: {' '.join(str(a).replace(str(folder), '') for a in arguments)}: {failure}", time.monotonic() - start
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("program")
    parser.add_argument("--cases", type=int, default=10000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--seconds", type=float, default=math.inf, help="start no case after this")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--keep", help="folder for the files of cases that fail")
    parser.add_argument("--only", type=int, help="one case")
    options = parser.parse_args()
    end = time.monotonic() + options.seconds
    cases = [options.only] if options.only is not None else range(options.cases)
    codes, failures, slowest = collections.Counter(), [], (0.0, None)

    def work(number):
        return None if time.monotonic() > end else (number, *one_case(options.program, options.seed, number, options.keep))
    with concurrent.futures.ThreadPoolExecutor(options.jobs) as pool:
        for result in pool.map(work, cases):
            if result is None:
                continue
            number, outcome, seconds = result
            slowest = max(slowest, (seconds, number))
            codes[outcome if len(outcome) == 1 else "failed"] += 1
            if len(outcome) > 1:
                failures.append(outcome)
                print(outcome, flush=True)
    print(f"seed {options.seed}: {sum(codes.values())} cases, {len(failures)} failed; ended with "
          + ", ".join(f"{code}: {count}" for code, count in sorted(codes.items()))
          + f"; slowest {slowest[0]:.1f} s (case {slowest[1]})")
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
