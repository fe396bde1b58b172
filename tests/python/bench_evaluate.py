"""Points of a limit surface from Python and from C++: JSON. bench_evaluate.py BENCH_LOCATIONS CAGE.obj [POINTS [REPEATS]]

BENCH_LOCATIONS evaluates the same places without Python; the repeats take turns. The ratio is of the shortest times, which other work on the machine changes least.
"""
import json
import statistics
import subprocess
import sys
import tempfile
import time

import numpy as np
import patchwright as pw


def main():
    program, file = sys.argv[1:3]
    count = int(sys.argv[3]) if len(sys.argv) > 3 else 1_000_000
    repeats = int(sys.argv[4]) if len(sys.argv) > 4 else 9
    cage = pw.Cage.read(file)
    rng = np.random.default_rng(0)
    faces = rng.integers(0, cage.summary["faces"], count, dtype=np.int32)
    uv = rng.random((count, 2))
    seconds, by_order = {"python": [], "c++": []}, {}
    with tempfile.NamedTemporaryFile() as places:
        places.write(faces.tobytes() + uv.tobytes())
        places.flush()
        for order in (0, 1):
            for _ in range(repeats):
                start = time.perf_counter()
                values = cage.evaluate(faces, uv, order=order)
                seconds["python"].append(time.perf_counter() - start)
                told = subprocess.run([program, file, places.name, str(count), str(order)], capture_output=True,
                                      text=True, check=True)
                native = json.loads(told.stdout)
                seconds["c++"].append(native["seconds"])
                assert np.isclose(native["sum"], values.sum(), rtol=1e-9), "other points"
            by_order[order] = {name: {"median_s": statistics.median(s), "least_s": min(s)} for name, s in seconds.items()}
            by_order[order]["ratio"] = min(seconds["python"]) / min(seconds["c++"])
            seconds = {"python": [], "c++": []}
    print(json.dumps({"benchmark": "evaluate", "cage": file, "points": count, "repeats": repeats,
                      "threads": pw.thread_count(), "by_order": by_order}, indent=2))


if __name__ == "__main__":
    main()
