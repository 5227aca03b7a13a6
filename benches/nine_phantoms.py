#!/usr/bin/env python3
"""What the inclusions of the paper's nine phantoms add to the middle of the camera's image (docs/MEASURED.md).

    cargo build --release && python3 benches/nine_phantoms.py

Needs numpy and pillow. Runs each preset less its baseline, with 32 camera paths a pixel, and prints its force, the mean
of 24 x 24 pixels about the middle with the inclusion less that without, that without, the spread of its pixels, and
pixels at the top level.
"""

import json
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
from PIL import Image

ROOT = Path(__file__).resolve().parent.parent
SERIES = {
    "size": ["size-2mm", "size-8mm", "size-14mm"],
    "depth": ["depth-3mm", "depth-7mm", "depth-11.2mm"],
    "stiffness": ["stiffness-44.5kpa", "stiffness-63.5kpa", "stiffness-102.8kpa"],
}
HALF = 12


def middle(image):
    grey = np.asarray(Image.open(image), dtype=float)
    row, column = grey.shape[0] // 2, grey.shape[1] // 2
    return grey[row - HALF : row + HALF, column - HALF : column + HALF], int((grey == 255).sum())


def main():
    with tempfile.TemporaryDirectory() as work:
        for name in (name for names in SERIES.values() for name in names):
            command = [ROOT / "target/release/tirtouch", "run", f"preset:phantom-{name}", "--subtract-baseline"]
            command += ["--spp", "32", "--json", "--quiet", "-o", f"{work}/{name}"]
            done = subprocess.run(command, capture_output=True, text=True)
            if done.returncode:
                sys.exit(done.stderr)
            force = json.loads(done.stdout)["mechanics"]["force_n"]
            (pressed, full), (base, _) = middle(f"{work}/{name}/camera.png"), middle(f"{work}/{name}/baseline.png")
            added, spread = (pressed - base).mean(), base.std(ddof=1)
            print(f"{name}: {force:.3f} N, {added:.1f} added to {base.mean():.1f}, pixels {spread:.2f}, {full} full")


if __name__ == "__main__":
    main()
