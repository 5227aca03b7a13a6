#!/usr/bin/env python3
"""Is an image that was traced to an asked error as good as it says?

    cargo build --release && python3 benches/sweeps/asked.py [--seeds 200] [--errors 0.02 0.01]
        [--program target/release/tirtouch]

Renders small scenes with many seeds to an asked error, where a lucky estimate stops too early, and with samples given.
An image's true error is its root mean square distance from the mean of all over the lit pixels, as a share of their
mean: that of `relative_error`. Prints the claimed over the true one, both rms over the seeds, how far single images are
off their claim, and how many are as good as asked. Needs numpy and OpenEXR.
"""

import argparse
import sys
import tempfile
from pathlib import Path

import numpy as np
import OpenEXR
from cases import ROOT, changed
from coverage import SAME, SEEDS, SMALL_DISC, SMALL_PHANTOM, swept

# Scene, changes to it, whether it has an inclusion.
CASES = {
    "phantom": ("phantom-size-8mm", SMALL_PHANTOM),
    "no inclusion": ("phantom-size-8mm", {**SMALL_PHANTOM, **SAME}),
    "disc": ("contact-disc", SMALL_DISC),
}
IMAGES = 'images = { format = "exr" }\n'


def images(folder, rows):
    """Their means by row of the table, images x pixels."""
    out = folder / "out"
    files = sorted(path for path in out.rglob("*.exr"))
    if len(files) != len(rows):
        sys.exit(f"{out}: {len(rows)} points have {len(files)} images")
    stack = []
    for path in files:
        with OpenEXR.File(str(path)) as image:
            stack.append(image.channels()["mean"].pixels.astype(float).ravel())
    return np.array(stack)


def judge(case, asked, seeds, work, program):
    name, changes = CASES[case]
    given = "" if asked else "spp = 16\nphotons = 131072\n"
    scene = f"{changed(name, changes)}\n[render]\n{given}"
    folder = Path(work) / f"{case.replace(' ', '-')}-{asked}"
    head = IMAGES + (f"target_error = {asked}\n" if asked else "")
    vary = SEEDS.replace("POINTS", str(seeds))
    rows = swept(folder, scene, ["mean_radiance"], vary, '{ kind = "grid" }', program, head)
    stack = images(folder, rows)
    truth = stack.mean(axis=0)
    lit = truth > 0.3 * np.quantile(truth, 0.99)
    off = (stack - truth)[:, lit] * np.sqrt(seeds / (seeds - 1.0))
    true = np.sqrt((off**2).mean(axis=1)) / truth[lit].mean()
    claimed = np.array([float(row["relative_error"]) for row in rows])
    root = [np.sqrt((values**2).mean()) for values in (claimed, true)]
    low, high = np.quantile(true / claimed, [0.025, 0.975])
    good = f"{int((true <= asked).sum())} of {seeds}" if asked else "-"
    print(f"| {case} | {asked or 'none'} | {root[0]:.4f} | {root[1]:.4f} | {root[0] / root[1]:.3f} "
          f"| {low:.2f} to {high:.2f} | {good} |", flush=True)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--seeds", type=int, default=200)
    parser.add_argument("--errors", type=float, nargs="+", default=[0.02, 0.01])
    parser.add_argument("--program", type=Path, default=ROOT / "target/release/tirtouch")
    wanted = parser.parse_args()
    print("| scene | asked | claimed | true | claimed over true | true over claimed, 95 % of images ", end="")
    print("| as good as asked |")
    print("|---|---|---|---|---|---|---|")
    with tempfile.TemporaryDirectory() as work:
        for case in CASES:
            for asked in [None, *wanted.errors]:
                judge(case, asked, wanted.seeds, work, wanted.program)


if __name__ == "__main__":
    main()
