"""The command line on files that programs of the trade wrote.

Usage: legacy_test.py PATCHWRIGHT SAMPLES_DIR CAD_DIR [unittest arguments]
Exit codes: 0 all passed, 1 not so, 77 none failed but some were skipped, since their files are not in CAD_DIR.
"""
import json
import pathlib
import sys
import unittest

from command_line import CliTest, run, SAMPLES

FOLDER = pathlib.Path(sys.argv[3])


class LegacyFiles(CliTest):
    def file(self, name):
        if not (FOLDER / name).exists():
            self.skipTest(f"{name} is not in {FOLDER}")
        return FOLDER / name

    def test_an_airliners_half_wing_becomes_one_closed_solid(self):
        file = self.path("wing.json")
        result = run("convert", self.file("tigl_d150_wing.igs"), "--cage", SAMPLES / "d150_wing" / "cage.obj",
                     "-o", self.path("wing.step"), "--json", file, "--tolerance", "1e-3rel")
        report = json.loads(file.read_text())
        # The cage has no line along the nose, which is sharp on a part of the span: that, and nothing else, is missed.
        self.assertEqual(result.returncode, 3, result.stderr)
        self.assertEqual([c["name"] for c in report["verdict"]["conditions"] if not c["met"]], ["sharp_curves"])
        self.assertEqual(report["solid"]["solids"], 1)
        self.assertTrue(report["solid"]["closed"] and report["solid"]["valid"] and report["solid"]["all_bicubic"])
        self.assertLess(report["continuity"]["max_gap"], 1e-9 * report["input"]["diagonal"])

    def test_cages_made_by_hand_reach_the_tolerance(self):
        for name, cage, vertices in (("naca_wing_dealii.iges", "naca_wing", 100), ("iea15_blade.igs", "blade", 600)):
            with self.subTest(name):
                report = self.report("convert", self.file(name), "--cage", SAMPLES / cage / "cage.obj", "-o", self.path("out.step"))
                self.assertTrue(report["fit"]["met"])
                self.assertTrue(report["solid"]["valid"])
                self.assertLess(report["fit"]["levels"][report["fit"]["best_level"]]["vertices"], vertices)
                for side in ("output_to_input", "input_to_output"):
                    self.assertLess(report["deviation"][side]["max"], 1e-4 * report["input"]["diagonal"])

    def test_a_file_that_runs_into_column_65_is_read_with_a_notice(self):
        file = self.path("report.json")
        result = run("inspect", self.file("c172_wing_pyspline.igs"), "--json", file)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn("column 65", result.stderr)
        report = json.loads(file.read_text())
        self.assertEqual(report["input"]["faces"], 6)
        self.assertEqual(report["details"]["free_curves"], 1)

    def test_a_size_that_looks_wrong_draws_a_note(self):
        blade = self.file("iea15_blade.stp")  # 117 m, marked mm
        self.assertIn("0.117 m across", run("inspect", blade).stderr)
        self.assertNotIn("across", run("inspect", blade, "--input-unit", "m").stderr)

    def test_an_inspection_tells_details(self):
        report = json.loads(run("inspect", self.file("nosecone_sw.step"), "--json", "-").stdout)
        details = report["details"]
        self.assertEqual(details["coloured_faces"], 59)
        self.assertEqual(details["overlapping_solids"], [])
        self.assertGreater(details["sharp_curves"], 0)
        self.assertAlmostEqual(details["centre_of_mass"][2], 0.0, delta=1e-4)  # half a mould, symmetric


if __name__ == "__main__":
    result = unittest.main(argv=[sys.argv[0], *sys.argv[4:]], exit=False).result
    sys.exit(1 if not result.wasSuccessful() else 77 if result.skipped else 0)
