"""A wing with more and more dihedral: one cage, its points moved, a STEP file and figures for each design.

design_sweep.py FOLDER [DESIGNS]
"""
import pathlib
import sys

import numpy as np
import patchwright

CAGE = pathlib.Path(__file__).resolve().parents[1] / "naca_wing" / "cage.obj"
LARGEST_RAD = np.radians(10)


def enclosed_volume(cage, cells=8):
    """By the divergence theorem: a third of the integral of point . normal, by Gauss points on cells of each face."""
    nodes, weights = np.polynomial.legendre.leggauss(3)
    line = ((np.arange(cells)[:, None] + 0.5 * (nodes + 1)) / cells).reshape(-1)
    weight = np.tile(0.5 * weights / cells, cells)
    u, v = np.meshgrid(line, line, indexing="ij")
    uv = np.stack([u.reshape(-1), v.reshape(-1)], axis=1)
    count = cage.summary["faces"]
    rows = cage.evaluate(np.repeat(np.arange(count), len(uv)), np.tile(uv, (count, 1)), order=1)
    integrand = (rows[:, 0] * np.cross(rows[:, 1], rows[:, 2])).sum(axis=1) / 3
    return (integrand * np.tile(np.outer(weight, weight).reshape(-1), count)).sum()


def main():
    folder, designs = pathlib.Path(sys.argv[1]), int(sys.argv[2]) if len(sys.argv) > 2 else 3
    folder.mkdir(parents=True, exist_ok=True)
    wing = patchwright.Cage.read(CAGE)
    span = np.argmax(np.ptp(wing.points, axis=0))
    print("dihedral  volume [mm^3]  of the limit surface  patches  verdict")
    for number, angle in enumerate(np.linspace(0, LARGEST_RAD, designs)):
        points = wing.points.copy()
        points[:, 2] += np.tan(angle) * abs(points[:, span])  # a shear: the volume stays
        design = wing.with_points(points)
        result = patchwright.export(design, folder / f"wing_{number}.step")
        print(f"{np.degrees(angle):6.1f}    {result.report['solid']['volume']:13.6g}  {enclosed_volume(design):20.6g}"
              f"  {result.report['patches']['count']:7}  {'met' if result.met else result.verdict.sentence}")


if __name__ == "__main__":
    main()
