#!/usr/bin/env python3
"""A reference image of a scene by Mitsuba 3: mean.exr, variance.exr (of the mean) and its figures as one JSON object.

    peer-venv/bin/python reference.py ../../scenes/contact-disc.toml --spp 400 --runs 16 --out contact-disc

`--cells` makes a dented face a grid of that many squares a side instead of a smooth mesh.
"""

import argparse
import json
import time

import mitsuba as mi
import numpy as np

mi.set_variant("llvm_ad_mono")

import mitsuba_scene as peer  # noqa: E402 (needs the variant)

parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
parser.add_argument("scene")
parser.add_argument("--spp", type=int, default=128)
parser.add_argument("--runs", type=int, default=16)
parser.add_argument("--cells", type=int)
parser.add_argument("--seed", type=int, default=1)
parser.add_argument("--out", required=True, help="folder for mean.exr and variance.exr")
arguments = parser.parse_args()

scene = peer.load(arguments.scene)
loaded = peer.build(scene, arguments.spp, grid_cells=arguments.cells)
peer.render(loaded, 4, 1_000_000)  # compiles the kernel
images, seconds = [], []
for run in range(arguments.runs):
    start = time.perf_counter()
    images.append(peer.render(loaded, arguments.spp, arguments.seed + run))
    seconds.append(time.perf_counter() - start)
stack = np.stack(images)
mean, variance = stack.mean(0), stack.var(0, ddof=1) / arguments.runs


def figures(mask):
    """Mean over a patch with two standard errors: from the pixels' variances and from the spread of the runs."""
    runs = stack[:, mask].mean(1)
    return {
        "pixels": int(mask.sum()),
        "mean": float(mean[mask].mean()),
        "standard_error": float(np.sqrt(variance[mask].sum()) / mask.sum()),
        "standard_error_of_runs": float(runs.std(ddof=1) / np.sqrt(arguments.runs)),
    }


report = {"scene": scene["name"], "mitsuba": mi.__version__, "spp": arguments.spp, "runs": arguments.runs,
          "grid_cells": arguments.cells, "seconds_per_run": float(np.median(seconds)),
          "paths_per_second": mean.size * arguments.spp / float(np.median(seconds)),
          "image": figures(np.ones_like(mean, dtype=bool))}
patch = peer.contact_pixels(scene)
if patch is not None:
    report["patch"] = figures(patch)
peer.write_estimate(arguments.out, mean, variance)
print(json.dumps(report))
