#!/usr/bin/env python3
"""Is the image of a press smooth in its depth (docs/ERROR.md, "The mesh of the press")?

    cargo build --release && python3 benches/press_smooth.py [--resolution 1] [--spp 32]

Needs numpy. Runs `phantom-size-8mm` at 20 depths from 0.25 to 5 mm, 16 bits deep, and prints how far the sum of grey
values, the force and the peak pressure are off polynomials of 7th degree in the depth, in per cent.
"""

import argparse
import json
import re
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parent.parent
DEPTHS_MM = 0.25 * np.arange(1, 21)
DEGREE = 7


def run(resolution, spp):
    text = (ROOT / "scenes/phantom-size-8mm.toml").read_text()
    depths = ", ".join(str(depth) for depth in DEPTHS_MM)
    keys = f"depths_mm = [{depths}]\nresolution = {resolution}\nestimate_error = false"
    text = re.sub(r"^depths_mm.*$", keys, text, count=1, flags=re.M)
    text = re.sub(r"bit_depth *= *\d+", "bit_depth = 16", text, count=1)
    with tempfile.TemporaryDirectory() as work:
        scene = Path(work) / "scene.toml"
        scene.write_text(text)
        command = [ROOT / "target/release/tirtouch", "run", scene, "-o", Path(work) / "out", "--json", "--quiet"]
        done = subprocess.run(command + ["--seed", "1", "--spp", str(spp)], capture_output=True, text=True)
        if done.returncode:
            sys.exit(done.stderr)
        return json.loads(done.stdout)


def off(values):
    """Departure from the polynomial that fits best, each value weighted by its own size, per cent."""
    values = np.array(values)
    powers = np.vander(DEPTHS_MM / DEPTHS_MM[-1], DEGREE + 1) / values[:, None]
    return 100.0 * (powers @ np.linalg.lstsq(powers, np.ones(len(values)), rcond=None)[0] - 1.0)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--resolution", type=float, default=1.0)
    parser.add_argument("--spp", type=int, default=32)
    wanted = parser.parse_args()
    result = run(wanted.resolution, wanted.spp)
    frames = result["earlier_frames"] + [result]
    steps = result["mechanics"]["steps"]
    rows = {
        "sum of grey values": [frame["camera"]["sum_grey"] for frame in frames],
        "force": [step["force_n"] for step in steps],
        "peak pressure": [step["peak_pressure_kpa"] for step in steps],
    }
    for name, values in rows.items():
        departure = off(values)
        print(f"{name}: {np.sqrt((departure**2).mean()):.4f} % rms, {abs(departure).max():.4f} % at most")


if __name__ == "__main__":
    main()
