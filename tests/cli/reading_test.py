"""CAD files that are read in part, not at all, or for ever, on the command line.

Usage: reading_test.py PATCHWRIGHT SAMPLES_DIR [unittest arguments]
"""
import os
import pathlib
import re
import signal
import subprocess
import sys
import time
import unittest

from command_line import CliTest, PATCHWRIGHT, run, SAMPLES, WING

PATIENCE_S = 60  # for what takes a moment on an idle machine


def processes_with(text):
    """Numbers of the processes that have the text among their arguments."""
    found = []
    for place in pathlib.Path("/proc").glob("[0-9]*"):
        try:
            if text in (place / "cmdline").read_text().split("\0"):
                found.append(int(place.name))
        except OSError:
            pass  # it has ended meanwhile
    return found


class Reading(CliTest):
    def wait_for(self, condition):
        deadline = time.monotonic() + PATIENCE_S
        while not condition():
            self.assertLess(time.monotonic(), deadline)
            time.sleep(0.02)

    def edited(self, old, new, name="edited.step"):
        text = (WING / "wing.step").read_text()
        self.assertIn(old, text)
        return self.path(name, text.replace(old, new, 1))

    def test_lost_faces_are_an_error_unless_allowed(self):
        file, cage = self.edited("ADVANCED_FACE", "FANCY_FACE"), WING / "wing_cage.obj"
        for arguments in (["inspect", file], ["convert", file, "-o", "{out}.step"], ["cage", file, "-o", "{out}.obj"],
                          ["fit", file, "--cage", cage, "-o", "{out}.obj"], ["compare", file, WING / "wing.step"],
                          ["compare", WING / "wing.step", file]):
            with self.subTest(arguments[0]):
                self.check_refused(arguments, 2, str(file), "FANCY_FACE: unknown entity", "--allow-loss")
        result = run("inspect", file, "--allow-loss")
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn("FANCY_FACE: unknown entity is lost", result.stderr)

    def test_an_unknown_unit_is_an_error_unless_given(self):
        file = self.edited("SI_UNIT(.MILLI.,.METRE.)", "SI_UNIT(.MILLY.,.METRE.)")
        self.check_refused(["inspect", file], 2, str(file), "unit of length #", "--input-unit")
        report = self.report("inspect", file, "--input-unit", "mm")
        sound = self.report("inspect", WING / "wing.step")
        self.assertAlmostEqual(report["input"]["diagonal"], sound["input"]["diagonal"])

    def test_coordinates_beyond_numbers_are_an_error_of_the_file(self):
        file = self.folder / "dish.brep"
        run("export", SAMPLES / "cages" / "dish.obj", "-o", file)
        curve = " 18.309732638888889 9.0255638888888896 "  # the first two coordinates of a control point
        text = file.read_text()
        self.assertIn(curve, text)
        file.write_text(re.sub(re.escape(curve) + r"\S+", curve + "1E308", text, count=1))
        self.check_refused(["inspect", file, "--no-heal"], 2, str(file), "beyond what numbers hold")

    def test_a_border_with_damaged_knots_ends(self):
        # The kernel takes minutes to say whether points lie within such a border.
        file = self.folder / "cube.igs"
        run("export", SAMPLES / "cages" / "cube.obj", "-o", file)
        knots = "1.,1.,0.,0.,0.,0.,0.25,0.25,0.5,0.75,0.75,1.,1.,1.,1.,1.,1."
        parts = file.read_text().split(knots + ",1.,")
        self.assertEqual(len(parts), 7)
        for i in range(1, 7):  # a comma of one of the curves
            file.write_text(f"{knots},1.,".join(parts[:i]) + f"{knots}$1.," + f"{knots},1.,".join(parts[i:]))
            result = run("inspect", file, "--no-heal")
            self.assertIn(result.returncode, (0, 2), result.stderr)

    def test_a_crash_of_the_kernel_is_one_line(self):
        file = self.edited("VERTEX_POINT('',#", "VERTEX_POINT('',#99")
        self.check_refused(["convert", file, "-o", "{out}.step"], 2, str(file), "the CAD kernel crashes on #")

    def test_signals_end_the_reading_process_too(self):
        for number, code in ((signal.SIGINT, 130), (signal.SIGKILL, -signal.SIGKILL)):
            with self.subTest(number.name):
                pipe = self.folder / f"{number.name}.step"
                os.mkfifo(pipe)  # nobody writes to it: to read it takes for ever
                process = subprocess.Popen([PATCHWRIGHT, "inspect", pipe], stderr=subprocess.PIPE, text=True)
                self.wait_for(lambda: len(processes_with(str(pipe))) == 3)  # one starts another for the file
                process.send_signal(number)
                process.communicate(timeout=PATIENCE_S)
                self.assertEqual(process.returncode, code)
                self.wait_for(lambda: not processes_with(str(pipe)))

    def test_the_time_limit_counts_while_reading(self):
        pipe = self.folder / "endless.step"
        os.mkfifo(pipe)
        result = run("convert", pipe, "-o", self.folder / "out.step", "--time-limit", "0.5")
        self.assertEqual(result.returncode, 3, result.stderr)
        self.assertIn("time limit", result.stderr)
        self.wait_for(lambda: not processes_with(str(pipe)))


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
