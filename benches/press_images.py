#!/usr/bin/env python3
"""How far does the image of a press depend on its mesh (docs/ERROR.md, "The mesh of the press")?

    cargo build --release && python3 benches/press_images.py [--depths 2 4] [--edges 0 0.5] [--solid]

Needs numpy and OpenEXR. Renders `phantom-size-8mm` on four meshes by the same random numbers, prints the mean radiance
of each and the largest difference of two meshes in rings of 0.5 mm about the axis, as a share of the finest one's. With
`--solid`, the default mesh in two dimensions against two in three dimensions, ring by ring.
"""

import argparse
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
import OpenEXR

ROOT = Path(__file__).resolve().parent.parent
SCENE = ROOT / "scenes/phantom-size-8mm.toml"
WORK = ["--spp", "32", "--photons", "16000000", "--seed", "1", "--common-random-numbers"]
# Half the view's width over the distance of the pinhole; the distance; thickness and index of glass and layers.
HALF_VIEW, DISTANCE_MM = np.tan(np.radians(30.0)), 17.32
LAYERS = [(2.0, 1.38), (5.0, 1.39), (3.0, 1.40), (2.0, 1.41)]
RING_MM = 0.5
REACHES_MM = (7.5, 14.0)


def render(work, depth, edge, resolution, dimensions):
    text = SCENE.read_text()
    loads = next(line for line in text.splitlines() if line.startswith("depths_mm"))
    keys = [f"depths_mm = [{depth}]", f"edge_radius_mm = {edge}", f"resolution = {resolution}"]
    keys += [f'dimensions = "{dimensions}"', "estimate_error = false"]
    scene = Path(work) / "scene.toml"
    scene.write_text(text.replace(loads, "\n".join(keys), 1))
    folder = Path(work) / "image"
    command = [ROOT / "target/release/tirtouch", "render", scene, *WORK, "--quiet", "--force", "-o", folder]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode:
        sys.exit(done.stderr)
    with OpenEXR.File(str(folder / "radiance.exr")) as image:
        return image.channels()["mean"].pixels.astype(float)


def rings(image):
    """Mean radiance in rings about the axis of the flat touched face, as the camera sees it by refraction."""
    rows, columns = image.shape
    x, y = ((np.arange(count) - 0.5 * (count - 1)) * 2.0 * HALF_VIEW / columns for count in (columns, rows))
    slope = np.hypot(*np.meshgrid(x, y))
    sine = slope / np.hypot(1.0, slope)
    radius = slope * DISTANCE_MM + sum(h * np.tan(np.arcsin(sine / n)) for h, n in LAYERS)
    ring = (radius / RING_MM).astype(int)
    return np.bincount(ring.ravel(), image.ravel()) / np.bincount(ring.ravel())


def largest(images, reach):
    count = int(reach / RING_MM)
    all_rings = np.array([rings(image)[:count] for image in images])
    return 100.0 * (np.ptp(all_rings, axis=0) / all_rings[-1]).max()


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--depths", type=float, nargs="+", default=[2.0, 4.0])
    parser.add_argument("--edges", type=float, nargs="+", default=[0.0, 0.5])
    parser.add_argument("--solid", action="store_true")
    wanted = parser.parse_args()
    meshes = [(1, "two"), (1, "three"), (1.5, "three")] if wanted.solid else [(r, "two") for r in (0.5, 1, 1.5, 2)]
    with tempfile.TemporaryDirectory() as work:
        for depth in wanted.depths:
            for edge in wanted.edges:
                images = [render(work, depth, edge, *mesh) for mesh in meshes]
                means = " ".join(f"{image.mean():.5f}" for image in images)
                within = ", ".join(f"{largest(images, reach):.2f} % within {reach} mm" for reach in REACHES_MM)
                print(f"{depth} mm, edge {edge} mm: {means}; {within}", flush=True)
                if wanted.solid:
                    plane = rings(images[0])
                    for k in range(int(15.0 / RING_MM)):
                        off = [100.0 * (rings(image)[k] / plane[k] - 1.0) for image in images[1:]]
                        print(f"  {k * RING_MM:4.1f} mm, {plane[k]:.4f}: " + " ".join(f"{o:+.2f} %" for o in off))


if __name__ == "__main__":
    main()
