"""Where a converted wing deviates from its input, as a picture. deviation_plot.py OUT.png [INPUT]"""
import pathlib
import sys
import tempfile

import matplotlib.pyplot as plt
import numpy as np
import patchwright

WING = pathlib.Path(__file__).resolve().parents[1] / "wing" / "wing.igs"


def main():
    picture, given = sys.argv[1], sys.argv[2] if len(sys.argv) > 2 else WING
    model = patchwright.read(given)
    with tempfile.TemporaryDirectory() as folder:
        result = patchwright.convert(model, pathlib.Path(folder) / "output.step", tolerance="1e-4rel")
        output = patchwright.read(result.output)
    field = output.field(model)
    long_axis, other_axis, up = np.argsort(np.ptp(field.points, axis=0))[::-1]
    upper = field.triangles[field.normals[field.triangles, up].sum(axis=1) > 0]  # the side that is seen

    figure, (above, below) = plt.subplots(2, 1, figsize=(10, 7), height_ratios=[2, 1])
    image = above.tripcolor(field.points[:, long_axis], field.points[:, other_axis], upper,
                            1000 * field.deviation, shading="gouraud", cmap="turbo")
    above.set_aspect("equal")
    above.set_xlabel(f"{'xyz'[long_axis]} [mm]")
    above.set_ylabel(f"{'xyz'[other_axis]} [mm]")
    above.set_title(result.verdict.sentence, fontsize=9)
    figure.colorbar(image, ax=above, label="deviation [µm]")
    below.hist(1000 * field.deviation, bins=60)
    below.set_xlabel("deviation [µm]")
    below.set_ylabel("points")
    figure.savefig(picture, dpi=120)
    print(f"largest {field.deviation.max():.4g} mm at {field.points[field.deviation.argmax()].round(3).tolist()}")


if __name__ == "__main__":
    main()
