"""Arguments of wrong shapes, types and values: the interpreter stays, and what is raised is a PatchwrightError.

fuzz_test.py PATCHWRIGHT SAMPLES_DIR [CASES [FIRST]]   the cases run in a process of their own, which is to end well
"""
import os
import pathlib
import subprocess
import sys
import tempfile

from module import CUBE_FACES, CUBE_POINTS, PATCHWRIGHT, SAMPLES, np, pw

CASES, A_CALL_S = 300, 20.0
REFUSED = "refused"
WRONG = [None, "", "text", b"bytes", -1, 0, 1, 2**31, 2**63, 2**100, -2**40, 0.5, float("nan"), float("inf"), -float("inf"),
         1e308, 1j, True, [], {}, (), [[]], [[[]]], [1, [2, 3]], [[1, 2], [3]], [None], ["a"], object, object(), "nanmm",
         "1e-4rel", "-1mm", "1e400mm", "\0", "/", "/dev/null", pathlib.Path("none.step"), np.array(5), np.array("text"),
         np.zeros(0), np.zeros((0, 3)), np.zeros((3, 0)), np.zeros((2, 3, 4)), np.full((8, 3), np.nan),
         np.full((8, 3), 1e300), np.zeros((8, 3), complex), np.zeros((8, 3), object), np.zeros((8, 3), "U3"),
         np.zeros((8, 3), [("a", "f8")]), np.array(["2020-01-01"], "M8[D]"), np.full((6, 4), -1), np.full((6, 4), 7),
         np.full((6, 4), 2**40), np.full((6, 4), 2**63, np.uint64), np.arange(24).reshape(6, 4), np.zeros((6, 4), np.int8),
         np.ma.masked_all((8, 3)), np.lib.stride_tricks.as_strided(np.zeros(1), (8, 3), (0, 0)), np.zeros((8, 3), ">f8"),
         np.zeros((8, 3), np.float16), np.asfortranarray(CUBE_POINTS), CUBE_POINTS[::-1], range(8), iter([1, 2]),
         lambda *a: False, lambda *a: 1 / 0, lambda: None]


class Array:
    def __array__(self, *args):
        raise RuntimeError("no array")


WRONG.append(Array())


def good_calls(folder):
    """Function and arguments that are right, of every kind of call; cheap ones."""
    cage, wing = pw.Cage(CUBE_POINTS, CUBE_FACES), pw.read(SAMPLES / "cages" / "cube.obj")
    transfer = pw.PointTransfer(CUBE_POINTS, cage)
    places = {"faces": [0, 5], "uv": [[0.5, 0.5], [0, 1]]}
    return [
        (pw.Cage, {"points": CUBE_POINTS, "faces": CUBE_FACES, "creases": [[0, 1]], "crease_sharpness": 2.0,
                   "corners": [0], "corner_sharpness": [1.0], "pins": [1], "groups": [0] * 6, "group_names": ["a"],
                   "boundary_corners": True}),
        (pw.Cage, {"points": CUBE_POINTS, "faces": CUBE_FACES.reshape(-1), "sizes": [4] * 6}),
        (cage.evaluate, {**places, "order": 1, "sectors": [0, 0]}),
        (cage.masks, {**places, "order": 2}),
        (cage.jacobian, places),
        (cage.smoothness, places),
        (cage.with_points, {"points": CUBE_POINTS}),
        (cage.refined, {"levels": 1}),
        (cage.write, {"file": folder / "cage.obj", "unit": "mm"}),
        (pw.Cage.read, {"file": SAMPLES / "cages" / "cube.obj", "unit": "in"}),
        (pw.read, {"file": SAMPLES / "cages" / "cube.obj", "input_unit": "mm", "sharp_angle": 30.0, "read_limit": 5.0,
                   "progress": None, "cancel": None}),
        (pw.Model.from_brep, {"brep": b"no shape"}),
        (wing.foot_points, {"points": CUBE_POINTS}),
        (wing.field, {"other": wing, "progress": None}),
        (pw.compare, {"a": wing, "b": wing, "tolerance": 1.0, "samples": 20, "progress": None, "cancel": None}),
        (pw.inspect, {"model": wing, "progress": None}),
        (pw.export, {"cage": cage, "output": folder / "a.step", "tolerance": 1e-3, "unit": "mm", "schema": "ap214",
                     "continuity": "g1", "patches": "charts", "color": "none", "cap_depth": 3}),
        (pw.fit, {"model": wing, "cage": cage, "tolerance": 1.0, "max_levels": 0, "time_limit": 5.0, "refine": "local",
                  "symmetry": "none"}),
        (pw.refit, {"cage": SAMPLES / "cages" / "cube.obj", "model": wing, "output": folder / "a.step", "tolerance": 1.0,
                    "time_limit": 5.0, "symmetry": "none", "progress": None, "cancel": None}),
        (pw.grid, {"cage": cage, "output": folder / "a.xyz", "points": 3, "levels": 0, "spacing": "uniform",
                   "layers": 1, "layer_height": 0.1, "growth": 1.2, "form": "ascii", "clusters": [],
                   "rules": [{"at": [0, 0, 0], "cells": 3}], "size_field": [[0, 0, 0, 1.0]]}),
        (pw.grid, {"cage": cage, "output": folder / "a.vtu", "points": 3, "hanging_nodes": "quads", "smallest": 1.0,
                   "sensor": [[0, 0, 0, 1.0], [0, 0, 9, 2.0]], "sensor_jump": 0.5}),
        (pw.PointTransfer, {"points": CUBE_POINTS, "targets": cage}),
        (transfer.apply, {"values": CUBE_POINTS}),
        (transfer.apply_transposed, {"values": CUBE_POINTS}),
        (pw.morph, {"cage": cage, "transfer": transfer, "displacements": CUBE_POINTS}),
        (pw.grid_blocks, {"cage": cage, "points": 3, "blocks": "faces", "join": True, "curvature": False, "smooth": True}),
        (pw.grid_places, {"cage": cage, "points": 3, "spacing": "cosine", "rules": [], "size_field": [[0, 0, 0, 1.0]]}),
        (pw.set_thread_count, {"threads": 2}),
    ]


def one_case(number, folder, note):
    rng = np.random.default_rng(number)
    calls = good_calls(folder)
    function, arguments = calls[rng.integers(len(calls))]
    arguments = dict(arguments)
    for _ in range(rng.integers(0, 3)):
        name = list(arguments)[rng.integers(len(arguments))]
        arguments[name] = WRONG[rng.integers(len(WRONG))]
    note(f"{number}: {getattr(function, '__qualname__', function)}({', '.join(f'{k}={v!r:.60}' for k, v in arguments.items())})")
    try:
        function(**arguments)
    except pw.InternalError as error:
        return f"{type(error).__name__}: {error}"
    except pw.PatchwrightError as error:
        return REFUSED if "\n" not in str(error) else f"of several lines: {error}"
    except (TypeError, ZeroDivisionError) as error:
        # A callback's own errors come through.
        return REFUSED if callable(arguments.get("progress")) else f"{type(error).__name__}: {error}"
    except Exception as error:
        return f"{type(error).__name__}: {error}"
    return None


def run_cases(first, count, noted):
    failures, refused = [], 0
    with tempfile.TemporaryDirectory(prefix="patchwright") as name, open(noted, "w") as notes:
        folder = pathlib.Path(name)
        os.chdir(folder)  # for names that are taken

        def note(text):
            notes.seek(0)
            notes.truncate()
            notes.write(text)
            notes.flush()
            note.last = text

        for number in range(first, first + count):
            failure = one_case(number, folder, note)
            refused += failure is REFUSED
            if failure and failure is not REFUSED:
                failures.append(f"{note.last}\n    {failure}")
    print("\n".join(failures))
    print(f"{count} cases, {refused} refused, {len(failures)} failures")
    # Neither everything nor nothing may be refused.
    return bool(failures) or not 0.1 * count < refused < 0.95 * count


def main():
    count = int(sys.argv[3]) if len(sys.argv) > 3 else CASES
    first = int(sys.argv[4]) if len(sys.argv) > 4 else 0
    with tempfile.NamedTemporaryFile("r") as noted:
        if len(sys.argv) > 5:
            sys.exit(run_cases(first, count, sys.argv[5]))
        done = subprocess.run([sys.executable, os.path.abspath(__file__), PATCHWRIGHT, str(SAMPLES), str(count), str(first), noted.name],
                              timeout=count * A_CALL_S)
        if done.returncode not in (0, 1):
            print(f"ended with {done.returncode} at {noted.read()}")
        sys.exit(done.returncode != 0)


if __name__ == "__main__":
    main()
