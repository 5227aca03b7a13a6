#!/usr/bin/env python3
"""Looks at a data set of `tirtouch sweep run`: 24 of its phantoms with what is true of them.

    tirtouch sweep run scenes/sweeps/phantoms.toml -o out/phantoms      # 1,024 phantoms: hours on 2 cores, 130 MB
    python python/examples/look_at_dataset.py out/phantoms sheet.png

Needs matplotlib and Hugging Face's `datasets` (`pip install datasets matplotlib pillow`), which takes such a folder as
an `imagefolder`: an item has the frame, the frame without the inclusion and the mask of its outline, if they were kept,
what varied, and the truth.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from datasets import load_dataset

#: Rows and columns of the sheet.
SHAPE = (4, 6)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path, help="data set that `tirtouch sweep run` wrote, with images in png")
    parser.add_argument("sheet", type=Path, help="picture to write")
    arguments = parser.parse_args()
    data = load_dataset("imagefolder", data_dir=str(arguments.folder), split="train")
    loads = np.array(data["load"])
    deepest = np.flatnonzero(loads == loads.max())
    sizes = np.array(data["true_size_mm"])[deepest]
    ordered = deepest[np.argsort(sizes)]
    chosen = ordered[np.linspace(0, len(ordered) - 1, min(SHAPE[0] * SHAPE[1], len(ordered))).round().astype(int)]
    print(f"{len(data)} frames of {len(deepest)} phantoms, {', '.join(data.column_names)}")
    items = [data[int(k)] for k in chosen]
    # What the inclusion adds, where the frame without it was kept: the frames alone are alike.
    frames = [np.asarray(item["image"], dtype=float) for item in items]
    if "baseline" in data.column_names:
        frames = [frame - np.asarray(item["baseline"], dtype=float) for frame, item in zip(frames, items)]
    brightest = max(np.percentile(frame, 99.9) for frame in frames)
    figure, axes = plt.subplots(*SHAPE, figsize=(13, 7.6), squeeze=False, layout="constrained")
    for axis in axes.flat:
        axis.set_axis_off()
    for axis, item, frame in zip(axes.flat, items, frames):
        axis.imshow(frame, cmap="inferno", vmin=0, vmax=brightest)
        size, depth, youngs = (item[f"true_{name}"] for name in ("size_mm", "depth_mm", "youngs_kpa"))
        axis.set_title(f"{size:.1f} mm, {depth:.1f} mm deep, {youngs:.0f} kPa", fontsize=8)
        if "mask" in item:
            axis.contour(np.asarray(item["mask"]) > 127, levels=[0.5], colors="white", linewidths=0.6)
    figure.suptitle(f"{data.num_rows} frames of {arguments.folder.name}: what the inclusion adds, its outline in white")
    figure.savefig(arguments.sheet, dpi=110)


if __name__ == "__main__":
    main()
