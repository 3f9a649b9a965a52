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
SHOWN = 0.4  # mm, largest deviation with a colour of its own


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

    figure, axes = plt.subplots(2, 2, figsize=(9, 5.2), width_ratios=(2.2, 1), layout="constrained")
    titles = ("as built", f"shank_d = {shank['value']:g} in place of {part.value('shank_d'):g}")
    for row, title, verdict in zip(axes, titles, (part.verdict, thick)):
        deviations = verdict["part.scad"].deviations
        drawn = draw_map(row[0], scan.points, deviations)
        row[0].set_title(f"{title}: {verdict.verdict.replace('_', ' ')}")
        draw_histogram(row[1], deviations)
    axes[1, 0].set_xlabel("mm")
    axes[1, 1].set_xlabel("scan minus script, mm")
    axes[0, 1].legend(loc="upper right", fontsize="small")
    figure.colorbar(drawn, ax=axes[:, 0], label="scan minus script, mm", aspect=40, pad=0.02)
    figure.savefig(sys.argv[2], dpi=100)
    print(f"wrote {sys.argv[2]}")
    return 0


def draw_map(axes, points, deviations):
    """The points seen from the side, coloured by their deviations; what is nearest to the eye is drawn last."""
    middle = points.mean(axis=0)
    _, _, directions = np.linalg.svd(points - middle, full_matrices=False)  # the part's longest one first
    along, across, depth = directions @ (points - middle).T
    order = np.argsort(depth)
    axes.set(aspect="equal", ylabel="mm")
    return axes.scatter(
        along[order], across[order], c=deviations[order], s=5, linewidths=0, cmap="coolwarm",
        vmin=-SHOWN, vmax=SHOWN, plotnonfinite=False,
    )  # fmt: skip


def draw_histogram(axes, deviations):
    axes.hist(deviations, bins=80, range=(-SHOWN, SHOWN), color="0.3")
    axes.axvspan(-TOLERANCE, TOLERANCE, color="tab:green", alpha=0.2, linewidth=0, label="tolerance")
    axes.set(ylabel="points", yscale="log", ylim=(0.7, None))


if __name__ == "__main__":
    sys.exit(main())
