"""samples/batch with Snakemake, as users run it: jobs and Snakemake itself killed, files that cannot be used, a cluster.

batch_test.py PATCHWRIGHT SAMPLES_DIR [FILES]     FILES in the folder, 12 unless told, at least 6
"""
import collections
import csv
import os
import pathlib
import re
import shutil
import signal
import subprocess
import sys
import time
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "cli"))
from command_line import PATCHWRIGHT, SAMPLES, WING, CliTest

FILES = int(sys.argv[3]) if len(sys.argv) > 3 else 12
BATCH = SAMPLES / "batch"
WING_SECONDS = 0.3  # into a conversion of the wing, which takes at least 0.7 on any machine here

# Counts its calls; files in `killed` are killed in the middle of their first: the program, its caller, or
# all of the job, as a cluster does.
PROGRAM = """#!/usr/bin/env bash
here=$(dirname "$0")
name=$(basename "$2")
echo "$name" >> "$here/calls"
how=$(cat "$here/killed/$name" 2>/dev/null) || exec "{program}" "$@"
rm "$here/killed/$name"
"{program}" "$@" &
sleep {seconds}
kill -0 $! || exit 99
case $how in
    program) kill -KILL $!; wait $!; exit 137;;
    caller) kill -KILL $! $PPID;;
    job) kill -KILL 0;;
esac
"""

# Stand-ins for the cluster's programs: a job is a session of its own.
SBATCH = """#!/usr/bin/env bash
cluster=$(dirname "$0")
for option in parsable cpus-per-task=1 mem=4000 time=15 output=/dev/null; do
    [[ " $* " == *" --$option "* ]] || { echo "sbatch: no --$option in $*" >&2; exit 1; }
done
job=$(mktemp "$cluster/job_XXXXXX")
echo RUNNING > "$job"
{ if setsid --wait bash "${@: -1}"; then echo COMPLETED; else echo FAILED; fi > "$job.new"; mv "$job.new" "$job"; } </dev/null >/dev/null 2>&1 &
basename "$job"
"""
SACCT = """#!/usr/bin/env bash
cat "$(dirname "$0")/$2"
"""


def plate(number):
    """A flat rectangle of eight triangles, a bit longer than the last one, as OBJ."""
    points = [((10 + 0.1 * number) * i, 10 * j, 0) for j in range(3) for i in range(3)]
    corners = [3 * j + i + 1 for j in range(2) for i in range(2)]
    return ("".join(f"v {x} {y} {z}\n" for x, y, z in points)
            + "".join(f"f {a} {a + 1} {a + 4}\nf {a} {a + 4} {a + 3}\n" for a in corners))


class Batch(CliTest):
    def setUp(self):
        super().setUp()
        self.cad, self.results = self.folder / "cad files", self.folder / "results"
        (self.cad / "part 2").mkdir(parents=True)
        self.script("program", PROGRAM.replace("{program}", PATCHWRIGHT).replace("{seconds}", str(WING_SECONDS)))
        self.environment = {**os.environ, "PATH": f"{self.folder / 'cluster'}:{os.path.dirname(sys.executable)}:{os.environ['PATH']}",
                            "PYTHONDONTWRITEBYTECODE": "1", "XDG_CACHE_HOME": str(self.folder / "cache")}

    def script(self, name, text):
        path = self.folder / name
        path.parent.mkdir(exist_ok=True)
        path.write_text(text)
        path.chmod(0o755)

    def make_files(self, plates, killed):
        for number in range(plates):
            (self.cad / ("part 2" if number % 2 else "") / f"plate {number}.{'OBJ' if number == 0 else 'obj'}").write_text(plate(number))
        (self.cad / "half.step").write_bytes((WING / "wing.step").read_bytes()[:20000])
        (self.folder / "killed").mkdir()
        for name, how in killed.items():
            shutil.copy(WING / "wing.igs", self.cad / name)
            (self.folder / "killed" / name).write_text(how)

    def command(self, profile, *more):
        return ["snakemake", "-s", str(BATCH / "Snakefile"), "--profile", str(BATCH / "profiles" / profile), "--config",
                f"input={self.cad}", f"output={self.results}", f"program={self.folder / 'program'}", *more]

    def snakemake(self, profile, *more):
        return subprocess.run(self.command(profile, *more), cwd=self.folder, env=self.environment,
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, timeout=1500)

    def calls(self):
        return collections.Counter((self.folder / "calls").read_text().splitlines())

    def table(self):
        with (self.results / "table.csv").open() as file:
            rows = {row["file"]: row for row in csv.DictReader(file)}
        page = (self.results / "index.html").read_text()
        for row in rows.values():
            for kind in ("step", "glb", "html", "json", "log"):
                self.assertEqual(f">{kind}</a>" in re.search(f"<td>{row['file']}</td>.*", page)[0], row[kind] != "")
                self.assertTrue((self.results / row[kind]).exists(), row)
            if row["result"] == "met":
                self.assertTrue(row["step"] and row["glb"] and row["html"] and row["json"], row)
                self.assertLess(float(row["deviation_rel"]), 1e-4)
        return rows

    def results_of(self, rows):
        return collections.Counter(row["result"] for row in rows.values())

    def times(self):
        return {f: f.stat().st_mtime_ns for f in self.results.rglob("*") if f.is_file() and f.parent != self.results}

    def test_killed_jobs(self):
        self.make_files(FILES - 3, {"wing 1.igs": "program", "wing 2.igs": "caller"})
        first = self.snakemake("local")
        self.assertEqual(first.returncode, 1, first.stdout)
        rows = self.table()
        self.assertEqual(self.results_of(rows), {"met": FILES - 3, "failed": 2, "unusable": 1}, first.stdout)
        self.assertIn("END-ISO-10303-21 is missing", rows["half.step"]["message"])
        self.assertIn("exit code 137", rows["wing 1.igs"]["message"])
        for number in (1, 2):
            self.assertEqual([f.name for f in (self.results / f"wing {number}.igs").iterdir() if "patchwright" not in f.name],
                             ["run.log"])
        before = {f: t for f, t in self.times().items() if "wing" not in f.parent.name}

        second = self.snakemake("local")
        self.assertEqual(second.returncode, 0, second.stdout)
        self.assertEqual(self.results_of(self.table()), {"met": FILES - 1, "unusable": 1})
        after = self.times()
        self.assertEqual({f: after[f] for f in before}, before)
        calls = self.calls()
        self.assertEqual(len(calls), FILES)
        self.assertEqual({name for name, count in calls.items() if count != 1}, {"wing 1.igs", "wing 2.igs"})
        self.assertEqual(calls["wing 1.igs"] + calls["wing 2.igs"], 4)

        self.assertEqual(self.snakemake("local").returncode, 0)
        self.assertEqual((self.calls(), self.times()), (calls, after))

        # A better copy of the corrupt file is converted, a broken one of a plate leaves nothing of the old result.
        (self.cad / "half.step").write_text((WING / "wing.step").read_text())
        (self.cad / "plate 0.OBJ").write_text("f 1 2 3\n")
        self.assertEqual(self.snakemake("local").returncode, 0)
        rows = self.table()
        self.assertEqual((rows["half.step"]["result"], rows["plate 0.OBJ"]["result"]), ("met", "unusable"))
        self.assertEqual(sorted(f.name for f in (self.results / "plate 0.OBJ").iterdir()), ["report.json", "run.log"])
        self.assertEqual(sum(self.calls().values()), sum(calls.values()) + 2)

    def test_killed_snakemake(self):
        self.make_files(4, {})
        running = subprocess.Popen(self.command("local", "--cores", "1"), cwd=self.folder, env=self.environment,
                                   stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, start_new_session=True)
        for line in running.stdout:
            if re.match("2 of .* done", line):
                break
        os.killpg(running.pid, signal.SIGKILL)
        running.communicate()
        finished = {f.parent.name for f in self.results.rglob("report.json")}
        before = self.times()
        self.assertEqual(self.snakemake("local", "--unlock").returncode, 0)
        again = self.snakemake("local")
        self.assertEqual(again.returncode, 0, again.stdout)
        self.assertEqual(self.results_of(self.table()), {"met": 4, "unusable": 1})
        # What ended in the moment of the kill is done again, as Snakemake did not see its end.
        self.assertLessEqual(sum(f.parent.name in finished and self.times()[f] != t for f, t in before.items()), 5)
        self.assertLessEqual(sum(self.calls().values()), 6)

    def test_a_cluster(self):
        self.make_files(1, {"wing.igs": "job"})
        self.script("cluster/sbatch", SBATCH)
        self.script("cluster/sacct", SACCT)
        self.script("cluster/scancel", "#!/bin/sh\n")
        first = self.snakemake("slurm")
        self.assertEqual(first.returncode, 1, first.stdout)
        self.assertEqual(self.results_of(self.table()), {"met": 1, "failed": 1, "unusable": 1}, first.stdout)
        second = self.snakemake("slurm")
        self.assertEqual(second.returncode, 0, second.stdout)
        self.assertEqual(self.results_of(self.table()), {"met": 2, "unusable": 1})
        self.assertEqual(self.calls(), {"plate 0.OBJ": 1, "half.step": 1, "wing.igs": 2})

    def test_nothing_to_do(self):
        done = self.snakemake("local")
        self.assertEqual(done.returncode, 1)
        self.assertIn("no file of these kinds: .brep", done.stdout)

    def test_what_a_run_does_not_end(self):
        """Misses are results; wrong options fail every file and are said."""
        self.make_files(0, {})
        shutil.copy(WING / "wing.igs", self.cad)
        shutil.copy(WING / "wing_cage.obj", self.folder)
        missed = self.snakemake("local", "options=--tolerance 1e-6rel --cage wing_cage.obj --max-levels 0")
        self.assertEqual(missed.returncode, 0, missed.stdout)
        rows = self.table()
        self.assertEqual((rows["wing.igs"]["result"], bool(rows["wing.igs"]["step"])), ("missed", True))
        wrong = self.snakemake("local", "options=--tolerance 0.1")
        self.assertEqual(wrong.returncode, 1)
        self.assertEqual(self.results_of(self.table()), {"failed": 2})
        self.assertIn("'0.1' has no unit", self.table()["wing.igs"]["message"])


if __name__ == "__main__":
    if shutil.which("snakemake", path=f"{os.path.dirname(sys.executable)}:{os.environ['PATH']}") is None:
        print("SKIPPED: no snakemake (tools/install-packages batch)")
        sys.exit(77)
    unittest.main(argv=sys.argv[:1] + (sys.argv[4:] or []), verbosity=2)
