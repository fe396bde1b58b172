"""What the tests of the Python module share: unittest programs, run with BUILD/python on PYTHONPATH.

The first two arguments of each are PATCHWRIGHT SAMPLES_DIR. Without the module they end with 77: skipped.
"""
import pathlib
import shutil
import sys
import tempfile
import unittest

SKIPPED = 77


def skip(reason):
    print(f"SKIPPED: {reason}")
    sys.exit(SKIPPED)


try:
    import numpy as np
    import patchwright as pw
except ImportError as error:
    skip(error)

PATCHWRIGHT = str(pathlib.Path(sys.argv[1]).resolve())
SAMPLES = pathlib.Path(sys.argv[2]).resolve()
WING = SAMPLES / "wing"

# A cube of side 2 around the origin; faces counter-clockwise seen from outside.
CUBE_POINTS = np.array([[x, y, z] for z in (-1, 1) for y in (-1, 1) for x in (-1, 1)], float)
CUBE_FACES = np.array([[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]])


def random_places(count, faces, seed):
    rng = np.random.default_rng(seed)
    return rng.integers(0, faces, count), rng.random((count, 2))


class ModuleTest(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="patchwright"))
        self.addCleanup(shutil.rmtree, self.folder)


def main():
    unittest.main(argv=sys.argv[:1])
