"""Does a wing survive the exchange formats? Run with: pytest test_round_trip.py"""
import pathlib

import patchwright
import pytest
from patchwright.testing import assert_round_trip

WING = pathlib.Path(__file__).resolve().parents[1] / "wing" / "wing.step"


@pytest.mark.parametrize("suffix", [".step", ".igs", ".brep"])
def test_another_format(tmp_path, suffix):
    copy = tmp_path / f"copy{suffix}"
    patchwright.read(WING).write(copy)
    assert_round_trip(WING, copy, "1e-6rel", samples=2000)


def test_few_smooth_patches(tmp_path):
    result = patchwright.convert(WING, tmp_path / "smooth.step", tolerance="1e-4rel")
    assert result.met, result.verdict.sentence
    assert result.report["patches"]["count"] <= 9
    assert_round_trip(WING, result.output, "1e-4rel", samples=5000)
