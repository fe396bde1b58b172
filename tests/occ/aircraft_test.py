"""Aircraft by seed: every kind that make_aircraft writes is valid and closed or open as asked, and the same on every run.

Usage: aircraft_test.py MAKE_AIRCRAFT PATCHWRIGHT [unittest arguments]
       aircraft_test.py MAKE_AIRCRAFT --write FOLDER SEED...   writes all kinds and variants of these seeds
"""
import json
import pathlib
import subprocess
import sys
import tempfile
import unittest

TRIMMED = ((), ("--open",))
ALL = (*TRIMMED, ("--untrimmed",), ("--untrimmed", "--open"))
VARIANTS = {"flying_wing": ALL, "blended_wing_body": ALL, "wing_body_tails": TRIMMED, "wing_body_nacelles": TRIMMED,
            "components": ((), ("--iges",))}


def make(kind, seed, folder, options=()):
    suffix = "igs" if "--iges" in options else "step"
    out = pathlib.Path(folder) / ("_".join([kind, str(seed), *(o.strip("-") for o in options)]) + "." + suffix)
    subprocess.run([MAKE, kind, str(seed), out, *options], check=True)
    return out


class Aircraft(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)

    def inspect(self, file):
        run = subprocess.run([PATCHWRIGHT, "inspect", file, "--json", "-", "-q"], capture_output=True, text=True, check=True)
        return json.loads(run.stdout)["solid"]

    def check(self, kind, seed, options):
        with self.subTest(kind=kind, options=options):
            solid = self.inspect(make(kind, seed, self.folder.name, options))
            is_open = "--open" in options
            self.assertTrue(solid["valid"])
            self.assertEqual(solid["closed"], not is_open)
            self.assertEqual((solid["solids"], solid["shells_open"]), (0, 1) if is_open else (1, 0))
            low, high = (solid["bounds"][end][1] for end in ("min", "max"))
            self.assertAlmostEqual(low / high, 0.0 if is_open else -1.0, delta=1e-3)

    def test_one_of_each_kind(self):
        self.check("flying_wing", 2, ())
        self.check("flying_wing", 3, ("--untrimmed", "--open"))
        self.check("blended_wing_body", 2, ("--untrimmed",))
        self.check("wing_body_tails", 1, ())
        self.check("wing_body_nacelles", 5, ("--open",))

    def test_components_stay_apart_sewn_or_not(self):
        # A body, a fin, and both halves of wing and tail planes, which touch.
        for options in ((), ("--iges",)):
            solid = self.inspect(make("components", 2, self.folder.name, options))
            self.assertTrue(solid["valid"] and solid["closed"])
            self.assertEqual(solid["solids"], 6)

    def test_loose_faces_are_the_same_on_every_run_and_can_be_sewn(self):
        texts = []
        for _ in range(2):
            file = make("flying_wing", 4, self.folder.name, ["--untrimmed", "--iges"])
            texts.append(file.read_bytes())
        self.assertEqual(*texts)
        solid = self.inspect(file)
        self.assertTrue(solid["valid"] and solid["closed"])

    def test_what_there_is_not_is_refused(self):
        for arguments in (["zeppelin", "1"], ["wing_body_tails", "1", "--untrimmed"], ["components", "1", "--open"]):
            arguments.insert(2, str(pathlib.Path(self.folder.name) / "none.step"))
            run = subprocess.run([MAKE, *arguments], capture_output=True, text=True)
            self.assertEqual(run.returncode, 1)
            self.assertIn("usage", run.stderr)


if __name__ == "__main__":
    MAKE = sys.argv.pop(1)
    if sys.argv[1] == "--write":
        target = pathlib.Path(sys.argv[2])
        target.mkdir(parents=True, exist_ok=True)
        for name, variants in VARIANTS.items():
            for number in sys.argv[3:]:
                for variant in variants:
                    make(name, number, target, variant)
        sys.exit()
    PATCHWRIGHT = sys.argv.pop(1)
    unittest.main()
