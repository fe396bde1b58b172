"""The same with pytest, which needs no CMake."""
import pathlib
import subprocess
import sys

import pytest
from patchwright.testing import assert_round_trip

HERE = pathlib.Path(__file__).resolve().parent
MODEL = HERE.parent / "wing" / "wing.step"


@pytest.mark.parametrize("suffix", [".step", ".igs", ".brep"])
def test_translate(tmp_path, suffix):
    copy = tmp_path / f"copy{suffix}"
    subprocess.run([sys.executable, HERE / "translate.py", MODEL, copy], check=True)
    assert_round_trip(MODEL, copy, "1e-6rel")
