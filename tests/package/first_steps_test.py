"""src/docs/first_steps.rst on an empty bookworm, command by command, in less than ten minutes.

first_steps_test.py PATCHWRIGHT SAMPLES_DIR [unittest arguments]
Needs root, debootstrap and a network; mirrors are those of debootstrap. On a quiet machine. Programs with windows run without one: Chromium takes
a screenshot, FreeCAD's workbench is clicked through under Xvfb. What this takes besides is not counted.
"""
import os
import pathlib
import resource
import shutil
import subprocess
import sys
import tempfile
import time
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "cli"))
from command_line import SAMPLES
from install_page import DOCS, blocks, says

ROOT = SAMPLES.resolve().parent
INSIDE = {"PATH": "/usr/sbin:/usr/bin:/sbin:/bin", "HOME": "/root", "LC_ALL": "C.UTF-8", "DEBIAN_FRONTEND": "noninteractive",
          "NODE_EXTRA_CA_CERTS": "/etc/ssl/certs/ca-certificates.crt"}
MINUTES = 10
# Windows' commands and what is run in their place.
WINDOWS = {
    "chromium ": "chromium --no-sandbox --headless --use-gl=angle --use-angle=swiftshader --screenshot=/root/report.png "
                 "--window-size=1200,900 --virtual-time-budget=10000 file:///root/patchwright/build/demo/wing.html && test -s /root/report.png && "
                 "grep -q '<script>' build/demo/wing.html",
    "PATH=": "python3 tests/freecad/gui_test.py build/release/bin/patchwright samples /root/pictures"}


class FirstSteps(unittest.TestCase):
    def setUp(self):
        self.root = pathlib.Path(tempfile.mkdtemp(prefix="patchwright-bookworm"))
        self.addCleanup(shutil.rmtree, self.root)
        subprocess.run(["debootstrap", "--variant=minbase", "--include=ca-certificates", "bookworm", self.root], check=True,
                       stdout=subprocess.DEVNULL)
        for kind, place in (("proc", "proc"), ("sysfs", "sys"), ("tmpfs", "dev/shm")):
            (self.root / place).mkdir(exist_ok=True)
            subprocess.run(["mount", "-t", kind, kind, self.root / place], check=True)
            self.addCleanup(subprocess.run, ["umount", "-l", self.root / place], check=True)
        # Those of this network, where it has its own.
        for certificate in pathlib.Path("/usr/local/share/ca-certificates").glob("*.crt"):
            shutil.copy(certificate, self.root / "usr/local/share/ca-certificates")
        subprocess.run(["chroot", self.root, "update-ca-certificates"], check=True, env=INSIDE, stdout=subprocess.DEVNULL)
        tracked = subprocess.run(["git", "ls-files", "-z"], cwd=ROOT, capture_output=True, text=True, check=True).stdout
        for name in filter(None, tracked.split("\0")):
            target = self.root / "root" / "patchwright" / name
            target.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(ROOT / name, target, follow_symlinks=False)

    def run_inside(self, text):
        done = subprocess.run(["chroot", self.root, "bash", "-euo", "pipefail", "-c", "cd ~/patchwright; " + text], env=INSIDE, text=True,
                              timeout=1800, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
        self.assertEqual(done.returncode, 0, f"{text}\n{done.stdout}")
        return done.stdout

    def test_page(self):
        output, total, processor = "", 0.0, 0.0
        for kind, caption, text in blocks((DOCS / "first_steps.rst").read_text()):
            for line in text.splitlines() if kind == "text" else []:
                self.assertTrue(says(line, output), f"'{line}' is not in:\n{output}")
            if kind == "setup":
                self.run_inside(caption)
            if kind != "sh":
                continue
            window = next((command for start, command in WINDOWS.items() if text.startswith(start)), None)
            if window and "gui_test" in window:
                self.run_inside("apt-get install --yes --no-install-recommends xvfb xauth python3-numpy")
            begin, before = time.monotonic(), resource.getrusage(resource.RUSAGE_CHILDREN)
            output = self.run_inside(window or text)
            seconds, after = time.monotonic() - begin, resource.getrusage(resource.RUSAGE_CHILDREN)
            used = sum(getattr(after, field) - getattr(before, field) for field in ("ru_utime", "ru_stime"))
            total, processor = total + seconds, processor + used
            print(f"{seconds:6.1f} s, {used:6.1f} s of processor time: {text.splitlines()[0]}", flush=True)
        print(f"{total / 60:.1f} min, {processor:.0f} s of processor time")
        self.assertLess(total, 60 * MINUTES)


if __name__ == "__main__":
    if os.geteuid() != 0 or not shutil.which("debootstrap"):
        print("SKIPPED: needs root and debootstrap (tools/install-packages deb)")
        sys.exit(77)
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]], verbosity=2)
