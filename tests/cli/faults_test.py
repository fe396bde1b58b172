"""Faults at any moment: full disks, limits of file size and memory, signals. Old files stay as they are, no temporary is left,
and what is said is true.

Usage: faults_test.py PATCHWRIGHT SAMPLES_DIR [--all] [unittest arguments]
Without --all a slice of a quarter of a minute. Exit codes: 0 all passed, 1 not so, 77 none failed but a full disk could not be made.
"""
import contextlib
import json
import os
import pathlib
import random
import re
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import unittest

PATCHWRIGHT = str(pathlib.Path(sys.argv[1]).resolve())
SAMPLES = pathlib.Path(sys.argv[2]).resolve()
ALL = "--all" in sys.argv
WING, CAGES = SAMPLES / "wing", SAMPLES / "cages"

# Of every subcommand one that writes all it can, into the folder it runs in.
REPORTS = ["--json", "r.json", "--report", "r.html"]
COMMANDS = {
    "convert": ["convert", WING / "wing.igs", "-o", "a.step", "--cage-out", "a.obj", "--tolerance", "1e-3rel", *REPORTS],
    "cage": ["cage", WING / "wing.step", "-o", "a.obj", "--tolerance", "1e-3rel", *REPORTS],
    "fit": ["fit", WING / "wing.step", "--cage", WING / "wing_cage.obj", "-o", "a.obj", "--tolerance", "1e-3rel", *REPORTS],
    "export": ["export", CAGES / "genus2.obj", "-o", "a.igs", *REPORTS],
    "compare": ["compare", WING / "wing.igs", WING / "wing.step", "--tolerance", "1e-3rel", *REPORTS],
    "inspect": ["inspect", WING / "wing.igs", *REPORTS],
    "grid": ["grid", WING / "wing_cage.obj", "-o", "a.vtm", "--size", "10mm", *REPORTS],
    "grid layers": ["grid", CAGES / "cube.obj", "-o", "a.cgns", "--layers", 20, "--layer-height", "1e-3rel", *REPORTS],
    "eval": ["eval", CAGES / "cube.obj", "--at", "0,0.5,0.5", "--json", "r.json"],
    "subdivide": ["subdivide", CAGES / "cube.obj", "-n", 7, "-o", "a.obj", "--json", "r.json"],
}
OLD = {name: f"old {name}" for name in ("a.step", "a.igs", "a.obj", "a.vtm", "a.cgns", "a.xyz", "r.json", "r.html", "a/a_0.vts")}
STOPPING = {signal.SIGINT: "interrupted", signal.SIGTERM: "terminated", signal.SIGHUP: "hung up",
            signal.SIGXFSZ: "limit of file sizes", signal.SIGPIPE: "nothing reads"}


class Faults(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="patchwright"))
        self.addCleanup(shutil.rmtree, self.folder)
        self.fill(self.folder)

    def fill(self, folder):
        for path in folder.iterdir():
            shutil.rmtree(path) if path.is_dir() else path.unlink()
        (folder / "a").mkdir()
        for name, text in OLD.items():
            (folder / name).write_text(text)

    def start(self, command, folder=None, **options):
        return subprocess.Popen([PATCHWRIGHT, *map(str, COMMANDS[command])], cwd=folder or self.folder, stdout=subprocess.DEVNULL,
                                stderr=subprocess.PIPE, text=True, **options)

    def limited(self, command, limit, size):
        process = self.start(command, preexec_fn=lambda: resource.setrlimit(limit, (size, size)))
        _, error = process.communicate(timeout=300)
        return process.returncode, error

    def check_untouched(self, folder=None):
        """But for the JSON report, which may tell the error."""
        folder = folder or self.folder
        for name, text in OLD.items():
            found = (folder / name).read_text()
            if name == "r.json" and found != text:
                self.assertIn("message", json.loads(found)["error"])
            else:
                self.assertEqual(found, text)
        self.assertEqual({str(p.relative_to(folder)) for p in folder.rglob("*")}, {*OLD, "a"})

    def check_finished(self):
        """All that the run was to write is there, and nothing else but what was there."""
        self.assertEqual([p for p in self.folder.rglob(".*")], [])
        self.assertNotEqual((self.folder / "r.json").read_text(), OLD["r.json"])
        self.fill(self.folder)

    def said(self, error):
        lines = [line for line in error.splitlines() if not line.startswith("note: ")]
        self.assertEqual(len(lines), 1, error)
        self.assertTrue(lines[0].startswith("patchwright: "), error)
        return lines[0]

    def seconds(self, command):
        start = time.monotonic()
        process = self.start(command)
        _, error = process.communicate(timeout=300)
        self.assertIn(process.returncode, (0, 3), error)
        self.check_finished()
        return time.monotonic() - start


class Signals(Faults):
    def stop(self, command, number, delay):
        """@return seconds from the signal to the end"""
        process = self.start(command)
        time.sleep(delay)
        process.send_signal(number)
        start = time.monotonic()
        _, error = process.communicate(timeout=60)
        took = time.monotonic() - start
        if process.returncode == 128 + number:
            self.assertIn(STOPPING[number], self.said(error))
            self.check_untouched()
        elif process.returncode == -number:  # before main() began
            self.check_untouched()
        else:
            self.assertIn(process.returncode, (0, 3), error)
            self.check_finished()
        return process.returncode, took

    def test_signals_at_random_moments(self):
        anywhere = random.Random(1)
        names = list(COMMANDS)
        seconds = {}
        longest, counts = 0.0, {}
        for i in range(200 if ALL else 12):
            command = names[i % len(names)]
            if command not in seconds:
                seconds[command] = self.seconds(command) if ALL else 0.6
            number = list(STOPPING)[i // len(names) % 2 if not ALL else anywhere.choice((0, 1, 0, 1, 2))]
            delay = anywhere.uniform(0.0, seconds[command])
            with self.subTest(command=command, number=number, delay=delay):
                code, took = self.stop(command, number, delay)
                longest = max(longest, took)
                counts[code] = counts.get(code, 0) + 1
        print(f"signals: exit codes {dict(sorted(counts.items()))}, longest stop {longest:.2f} s")

    def test_the_other_signals(self):
        for number in (signal.SIGHUP, signal.SIGXFSZ, signal.SIGPIPE):
            with self.subTest(number):
                self.stop("convert", number, 0.4)

    def test_killed(self):
        anywhere = random.Random(2)
        names = list(COMMANDS)
        for i in range(50 if ALL else 5):
            process = self.start(names[i % len(names)])
            time.sleep(anywhere.uniform(0.0, 3.0 if ALL else 0.5))
            process.kill()
            process.communicate()
            if process.returncode == -signal.SIGKILL:
                for name, text in OLD.items():
                    found = (self.folder / name).read_text()
                    # Several renames are not one; each file is the old or the new one.
                    self.assertTrue(found == text or len(found) > 100, name)
            for left in self.folder.rglob(".*"):
                self.assertRegex(left.parts[len(self.folder.parts)], r"^\.patchwright-[0-9a-f]{16}$")
            self.fill(self.folder)


class Limits(Faults):
    def test_sizes_of_files(self):
        for command in COMMANDS if ALL else ("export", "grid", "grid layers", "subdivide"):
            for size in (0, 1 << 10, 1 << 14, 1 << 17) if ALL else (1 << 12,):
                with self.subTest(command=command, size=size):
                    code, error = self.limited(command, resource.RLIMIT_FSIZE, size)
                    if code in (0, 3):
                        self.check_finished()
                        continue
                    self.assertEqual(code, 128 + signal.SIGXFSZ, error)
                    self.assertIn(STOPPING[signal.SIGXFSZ], self.said(error))
                    self.check_untouched()

    def address_space(self, command):
        """@return the most that a run without limits takes, bytes"""
        peak = 0
        process = self.start(command)
        while process.poll() is None:
            with contextlib.suppress(OSError):
                found = re.search(r"VmPeak:\s+(\d+) kB", pathlib.Path(f"/proc/{process.pid}/status").read_text())
                peak = max(peak, int(found[1]) * 1024 if found else 0)
            time.sleep(0.01)
        process.communicate()
        self.fill(self.folder)
        return peak

    def test_memory(self):
        steps = 20 if ALL else 3
        counts = {}
        for command in ("convert", "grid", "grid layers", "subdivide", "compare") if ALL else ("subdivide",):
            peak = self.address_space(command)
            for step in range(steps):
                size = peak * (step + 1) // (steps + 1)
                with self.subTest(command=command, size=size):
                    self.fill(self.folder)
                    code, error = self.limited(command, resource.RLIMIT_AS, size)
                    counts[code] = counts.get(code, 0) + 1
                    if code in (0, 3):
                        self.check_finished()
                        continue
                    if code == 127:  # the loader's: not even the libraries fit
                        continue
                    self.assertEqual(code, 5, error)
                    self.assertRegex(self.said(error), "out of memory|the system refuses")
                    self.check_untouched()
        print(f"memory: exit codes {dict(sorted(counts.items()))}")

    def test_memory_just_enough_to_load(self):
        """Libraries begin before main() does, and an exception takes memory too."""
        too_small, enough = 0, 1 << 30
        while enough - too_small > 1 << 14:
            size = (too_small + enough) // 2
            code, _ = self.limited("subdivide", resource.RLIMIT_AS, size)
            too_small, enough = (size, enough) if code == 127 else (too_small, size)
        self.fill(self.folder)
        for step in range(-8, 200 if ALL else 16):
            size = enough + step * (1 << 15)
            with self.subTest(size=size):
                code, error = self.limited("subdivide", resource.RLIMIT_AS, size)
                if code == 0:
                    self.check_finished()
                if code in (0, 127):
                    continue
                self.assertEqual(code, 5, error)
                self.assertRegex(self.said(error), "out of memory|the system refuses")
                self.check_untouched()


class FullDisk(Faults):
    def test_full_disk(self):
        disk = self.folder.parent / (self.folder.name + "_disk")
        disk.mkdir()
        self.addCleanup(disk.rmdir)
        for command in COMMANDS if ALL else ("export", "grid", "grid layers"):
            for kilobytes in (48, 64, 128, 1024) if ALL else (64,):
                if subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={kilobytes}k", "tmpfs", disk], capture_output=True).returncode != 0:
                    self.skipTest("no small file system can be mounted here")
                try:
                    with self.subTest(command=command, kilobytes=kilobytes):
                        self.fill(disk)
                        process = self.start(command, disk)
                        _, error = process.communicate(timeout=300)
                        if process.returncode in (0, 3):
                            self.assertEqual([p for p in disk.rglob(".*")], [])
                            continue
                        self.assertEqual(process.returncode, 4, error)
                        self.assertRegex(self.said(error), "cannot be written")
                        self.check_untouched(disk)
                finally:
                    # The process that reads CAD files may end a moment after the other one.
                    subprocess.run(["umount", "--lazy", disk], check=True)


if __name__ == "__main__":
    arguments = [a for a in sys.argv[3:] if a != "--all"]
    result = unittest.main(argv=[sys.argv[0], *arguments], exit=False).result
    sys.exit(1 if not result.wasSuccessful() else 77 if result.skipped else 0)
