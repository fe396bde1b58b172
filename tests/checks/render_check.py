"""tools/render against what is known of its pictures: the share of them that a cube covers, and its colours.

Usage: render_check.py RENDER SAMPLES_DIR WORK_DIR
Exit codes: 0 all as expected, 1 not so, 77 a program or library that drawing needs is missing.
"""
import pathlib
import subprocess
import sys

import numpy as np

RENDER, SAMPLES, WORK = sys.argv[1], pathlib.Path(sys.argv[2]), pathlib.Path(sys.argv[3])
failures = []


def expect(condition, text):
    if not condition:
        failures.append(text)
        print(f"FAILED: {text}")


def picture(source, *options):
    """Rows of pixels (red, green, blue), top row first."""
    WORK.mkdir(parents=True, exist_ok=True)
    result = subprocess.run([RENDER, source, "-o", WORK / "picture.png", *options], capture_output=True, text=True, timeout=300)
    if result.returncode == 77:
        print(result.stdout)
        sys.exit(77)
    expect(result.returncode == 0, result.stderr)
    import vtk
    from vtk.util.numpy_support import vtk_to_numpy
    reader = vtk.vtkPNGReader()
    reader.SetFileName(str(WORK / "picture.png"))
    reader.Update()
    width, height, _ = reader.GetOutput().GetDimensions()
    return vtk_to_numpy(reader.GetOutput().GetPointData().GetScalars()).reshape(height, width, 3)[::-1].astype(int)


def share(pixels, predicate):
    return predicate(pixels[..., 0], pixels[..., 1], pixels[..., 2]).mean()


def main():
    inked = lambda r, g, b: r + g + b < 3 * 250
    # The cage of the sample cube is 100 mm wide.
    cube = SAMPLES / "cages" / "cube.obj"
    pixels = picture(cube, "--views", "front,top", "--size", "200", "--zoom", "0,0,0,200", "--no-edges")
    expect(pixels.shape == (200, 400, 3), f"size {pixels.shape}")
    for side in (pixels[:, :200], pixels[:, 200:]):
        expect(abs(share(side, inked) - 0.25) < 0.01, f"half as wide as the picture: {share(side, inked)}")
        expect(share(side, lambda r, g, b: b > r + 40) > 0.24, "outside is blue")
    # The bowl's normals point out of it: from above its inside is orange, its free border red.
    pixels = picture(SAMPLES / "cages" / "dish.obj", "--views", "top", "--size", "200")
    expect(share(pixels, lambda r, g, b: (r > b + 40) & (g > 60)) > 0.3, "inside is orange")
    expect(share(pixels, lambda r, g, b: (r > 150) & (g < 80)) > 0.005, "the border is red")
    # CAD; the upper side of the wing is smooth, so that its stripes are wide and of both colours.
    pixels = picture(SAMPLES / "wing" / "wing.step", "--views", "top", "--size", "200")
    expect(0.1 < share(pixels, inked) < 0.5, f"the wing covers {share(pixels, inked)}")
    pixels = picture(SAMPLES / "wing" / "wing.step", "--views", "top", "--size", "200", "--stripes", "20")
    expect(share(pixels, lambda r, g, b: r + g + b < 3 * 70) > 0.03, "dark stripes")
    expect(share(pixels, lambda r, g, b: (abs(r - 225) < 5) & (abs(b - 236) < 5)) > 0.03, "light stripes")
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
