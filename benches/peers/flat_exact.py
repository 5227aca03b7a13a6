#!/usr/bin/env python3
"""The image of a flat stack with bonded LEDs and black walls, without random numbers.

    python3 flat_exact.py ../../scenes/flat-bonded.toml --fine 32

In a flat stack all that a camera ray can do is known: in each layer it runs at an angle that the pinhole fixes, and at
each interface it splits in two. The tree of these pieces is followed for a lattice of camera rays at once and cut where
less than 1e-9 of the light is left; a piece that meets a black wall ends there, on an LED or not. Every pixel gets 2 x
2 rays, those near light get fine x fine. The only error is the lattice's: compare two sizes. Needs numpy alone. Prints
one JSON object; `--out` writes the image as a NumPy file.
"""

import argparse
import json
import math
import tomllib

import numpy as np

SMALLEST_SHARE = 1e-9


class FlatScene:
    """What the tree needs of a scene file; refuses what is not flat, bonded, Lambertian and black."""

    def __init__(self, path):
        with open(path, "rb") as file:
            scene = tomllib.load(file)
        if "touch" in scene:
            raise SystemExit(f"{path} has a [touch]: this is for flat stacks that nothing touches")
        if scene["camera"].get("view_axis", "width") != "width":
            raise SystemExit("view_axis other than width")
        if scene["stack"].get("walls", {"kind": "black"})["kind"] != "black":
            raise SystemExit("walls other than black")
        layers = list(reversed(scene["stack"]["layer"]))
        surround = scene["stack"].get("surround_n", 1.0)
        self.name, self.leds = scene["name"], scene["led"]
        if any(led["mount"]["kind"] != "bonded" or "cutoff_half_angle_deg" in led for led in self.leds):
            raise SystemExit("an LED that is not bonded or has a cut-off")
        self.n = [surround] + [layer["n"] for layer in layers] + [surround]
        self.thickness = [layer["thickness_mm"] for layer in layers]
        self.floor = np.concatenate([[0.0], np.cumsum(self.thickness)])
        self.half_x, self.half_y = (extent / 2 for extent in scene["stack"]["footprint_mm"])
        self.width, self.height = scene["camera"]["pixels"]
        self.distance = scene["camera"]["distance_mm"]
        self.pixel_tangent = 2 * math.tan(math.radians(scene["camera"]["view_angle_deg"] / 2)) / self.width


def radiance(scene, tangent_x, tangent_y):
    """Radiance at the pinhole from the directions with the given tangents, the whole tree."""
    n = scene.n
    tangent = np.hypot(tangent_x, tangent_y)
    s = n[0] * tangent / np.hypot(1.0, tangent)
    cosine = [np.sqrt(1 - (s / index) ** 2) for index in n]
    # Lateral way per mm of height in each layer, as a multiple of the tangents outside.
    slope = [cosine[0] * n[0] / (index * c) for index, c in zip(n, cosine)]
    reflected = [fresnel(n[k], cosine[k], n[k + 1], cosine[k + 1]) for k in range(len(n) - 1)]
    x, y = scene.distance * tangent_x, scene.distance * tangent_y
    inside = (np.abs(x) < scene.half_x) & (np.abs(y) < scene.half_y)
    pieces = [(1, True, (1 - reflected[0]) * inside, x, y)]
    total = np.zeros_like(s)
    while pieces:
        medium, upward, share, x, y = pieces.pop()
        if share.max() < SMALLEST_SHARE:
            continue
        way = scene.thickness[medium - 1] * slope[medium]
        step_x, step_y = way * tangent_x, way * tangent_y
        emitted, meets_wall = end_of_piece(scene, medium, upward, x, y, step_x, step_y)
        # What crosses the interfaces is radiance over the square of the index.
        total += share * emitted * (n[0] / n[medium]) ** 2
        share = np.where(meets_wall, 0.0, share)
        face, beyond = (medium, medium + 1) if upward else (medium - 1, medium - 1)
        pieces.append((medium, not upward, share * reflected[face], x + step_x, y + step_y))
        if 0 < beyond < len(n) - 1:
            pieces.append((beyond, upward, share * (1 - reflected[face]), x + step_x, y + step_y))
    return total


def fresnel(n_i, cos_i, n_t, cos_t):
    """Unpolarised reflectance; the camera sees no ray beyond a critical angle."""
    s_part = (n_i * cos_i - n_t * cos_t) / (n_i * cos_i + n_t * cos_t)
    p_part = (n_t * cos_i - n_i * cos_t) / (n_t * cos_i + n_i * cos_t)
    return (s_part**2 + p_part**2) / 2


def end_of_piece(scene, medium, upward, x, y, step_x, step_y):
    """Radiance of the LED that the piece meets (0: none), and whether it meets a wall at all."""
    with np.errstate(divide="ignore", invalid="ignore"):
        to_x = np.where(step_x == 0, np.inf, (np.copysign(scene.half_x, step_x) - x) / step_x)
        to_y = np.where(step_y == 0, np.inf, (np.copysign(scene.half_y, step_y) - y) / step_y)
    end = np.minimum(to_x, to_y)
    meets_wall = end <= 1.0
    z = scene.floor[medium - 1] + scene.thickness[medium - 1] * (end if upward else 1 - end)
    emitted = np.zeros_like(z)
    with np.errstate(invalid="ignore"):
        for led in scene.leds:
            if led["wall"][1] == "x":
                here, step, along = to_x <= to_y, step_x, y + end * step_y
            else:
                here, step, along = to_y < to_x, step_y, x + end * step_x
            here = here & meets_wall & (np.sign(step) == (1.0 if led["wall"][0] == "+" else -1.0))
            off_axis = np.hypot(along - led.get("along_mm", 0.0), z - led["height_mm"])
            emitted += led["radiance_w_per_m2_sr"] * (here & (off_axis < led["diameter_mm"] / 2))
    return emitted, meets_wall


def pixel_means(scene, rows, columns, lattice):
    """Mean radiance of the given pixels from lattice x lattice rays each."""
    offsets = (np.arange(lattice) + 0.5) / lattice
    means = np.zeros(len(rows))
    # Some ten thousand rays at a time keep the tree's arrays in the cache.
    for part in np.array_split(np.arange(len(rows)), max(1, len(rows) * lattice**2 // 50_000)):
        u = columns[part, None, None] + offsets[None, :, None] - scene.width / 2
        v = scene.height / 2 - rows[part, None, None] - offsets[None, None, :]
        u, v = np.broadcast_arrays(u * scene.pixel_tangent, v * scene.pixel_tangent)
        means[part] = radiance(scene, u.ravel(), v.ravel()).reshape(len(part), -1).mean(1)
    return means


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scene")
    parser.add_argument("--fine", type=int, default=32, help="rays along each side of a pixel near light")
    parser.add_argument("--out", help="NumPy file for the image")
    arguments = parser.parse_args()
    scene = FlatScene(arguments.scene)
    rows, columns = (axis.ravel() for axis in np.mgrid[: scene.height, : scene.width])
    image = pixel_means(scene, rows, columns, 2).reshape(scene.height, scene.width)
    # Dim pixels (light of three and more reflections) may keep 2 x 2 rays: together they weigh little.
    bright = np.pad(image > 1e-4 * image.max(), 2)
    near = np.zeros_like(image, dtype=bool)
    for row in range(5):
        for column in range(5):
            near |= bright[row : row + scene.height, column : column + scene.width]
    image[near] = pixel_means(scene, *np.nonzero(near), arguments.fine)
    if arguments.out:
        np.save(arguments.out, image)
    share = float(image[near].sum() / image.sum())
    print(json.dumps({"scene": scene.name, "fine": arguments.fine, "fine_pixels": int(near.sum()),
                      "mean_radiance": float(image.mean()), "share_of_fine_pixels": share}))


if __name__ == "__main__":
    main()
