#!/usr/bin/python3
"""Builds the bundled pin, makes its shank too thick, and draws how far the scan lies from the changed script.

    PYTHONPATH=build/release/python examples/python/deviations.py corpus/pin/scan/scan.json deviations.png
"""

import sys
import tempfile

import matplotlib
import numpy as np

matplotlib.use("agg")
import matplotlib.pyplot as plt  # noqa: E402
import partscribe  # noqa: E402

TOLERANCE = 0.1  # mm


def main() -> int:
    if len(sys.argv) != 3:
        print("usage: deviations.py SCAN.json PICTURE.png", file=sys.stderr)
        return 2
    scan = partscribe.read(sys.argv[1])
    part = partscribe.build(scan, TOLERANCE, name="pin", to=["openscad"])
    model = part.model
    shank = next(p for p in model["parameters"] if p["name"] == "shank_d")
    shank["value"] += 0.6
    with tempfile.TemporaryDirectory() as folder:
        partscribe.emit(model, folder, to=["openscad"])
        thick = partscribe.verify(f"{folder}/part.scad", scan, TOLERANCE, model=model)
    print(thick)

    figure, axes = plt.subplots(2, 2, figsize=(9, 6.4), width_ratios=(2, 1), layout="constrained")
    titles = ("as built", f"shank_d = {shank['value']:g} mm in place of {part.value('shank_d'):g} mm")
    for row, title, verdict in zip(axes, titles, (part.verdict, thick)):
        drawn = draw(*row, part.scan, verdict["part.scad"].deviations, f"{title}: {verdict.verdict.replace('_', ' ')}")
    figure.colorbar(drawn, ax=axes[:, 0], location="left", label="scan minus script, mm")
    figure.savefig(sys.argv[2], dpi=110)
    print(f"wrote {sys.argv[2]}")
    return 0


def draw(map_axes, histogram_axes, scan, deviations, title):
    """The points seen from the side, coloured by their deviation, and how often each deviation occurs."""
    largest = 4 * TOLERANCE
    # Along the part's longest direction, and across it; what is nearest to the eye is drawn last.
    middle = scan.points.mean(axis=0)
    _, _, axes = np.linalg.svd(scan.points - middle, full_matrices=False)
    along, across, depth = axes @ (scan.points - middle).T
    order = np.argsort(depth)
    drawn = map_axes.scatter(
        along[order], across[order], c=deviations[order], s=1.5, linewidths=0, cmap="coolwarm",
        vmin=-largest, vmax=largest, plotnonfinite=False, rasterized=True,
    )  # fmt: skip
    map_axes.set(title=title, xlabel="mm", ylabel="mm", aspect="equal")
    histogram_axes.hist(deviations, bins=80, range=(-largest, largest), color="0.4")
    for bound in (-TOLERANCE, TOLERANCE):
        histogram_axes.axvline(bound, color="tab:red", linewidth=1, linestyle="--")
    histogram_axes.set(xlabel="mm", ylabel="points", yscale="log")
    return drawn


if __name__ == "__main__":
    sys.exit(main())
