#!/usr/bin/env python3
"""Dents as closed forms and as meshes, by tirtouch and by Mitsuba 3: does it all meet?

    DRJIT_LIBLLVM_PATH=... peer-venv/bin/python meshes.py

Each dent of `DENTS` lies in the touched face of `dent-cap`, inner interfaces flat. The view is narrowed to the dent and
the LEDs are widened to 10 mm: of 3 mm they light 2 % of the pixels, and their images are a few facets wide.

- grid: squares of the footprint over `--cells`, two triangles each. Beyond the dent one cell reaches to the border. No
  line follows the rim of the cap, so that a ring a cell wide (two with interpolated normals) has slopes that the cap
  has nowhere: an error of the first order. A Gaussian has no rim: the second.
- rings: `--rings` of them about the axis, twice as many sectors, with the rim's vertices twice (see `smooth_face`).

tirtouch traces closed forms (height fields for Gaussians), in four times the rounds, and meshes, on the CPU, where
trees are searched faster; equal seeds would gain nothing, as a mesh's facets scatter its error. Mitsuba traces the same
triangles of the coarsest grid (without grids: of the fewest rings), with the same normals. Errors are the spread of the
rounds. The grids' limit, the finest rings and Mitsuba meet if they are off by at most 0.3 % with an error below 0.1 %.
Writes meshes.json and meshes.md.
"""

import argparse
import json
import math
import tempfile
from pathlib import Path

import mitsuba as mi
import numpy as np

mi.set_variant("llvm_ad_mono")

import compare  # noqa: E402 (needs the variant)
import mitsuba_scene as peer  # noqa: E402

PIXELS = 96
MOST_OFF, MOST_ERROR = 0.3, 0.1  # per cent
DENTS = {
    "cap": {"kind": "spherical_dent", "depth_mm": 1.5, "radius_mm": 6.0},
    "gaussian-narrow": {"kind": "gaussian_dent", "depth_mm": 1.5, "sigma_mm": 1.25},
    "gaussian-wide": {"kind": "gaussian_dent", "depth_mm": 1.9, "sigma_mm": 2.0},
}


def scene_of(name, arguments):
    """`dent-cap` with this dent, seen by a square image that just holds it."""
    scene = peer.load(arguments.scenes / "dent-cap.toml")
    shape = DENTS[name]
    reach = shape.get("radius_mm", 3.0 * shape.get("sigma_mm", 0.0))
    stack, camera = peer.Stack(scene), scene["camera"]
    depths = np.diff(stack.heights_mm)
    away = camera["distance_mm"] + sum(d / n for d, n in zip(depths, stack.indices[1:-1]))
    camera |= {"pixels": [PIXELS, PIXELS], "view_angle_deg": 2 * math.degrees(math.atan(1.1 * reach / away))}
    leds = [{**led, "diameter_mm": arguments.led_mm} for led in scene["led"]]
    return {**scene, "name": name, "led": leds, "touch": {"shape": shape, "inner": "flat"}}


def triangles(scene, kind, count):
    """Vertices and triangles of the dented face."""
    stack, dent = peer.Stack(scene), peer.dent(scene)
    if kind == "rings":
        return peer.smooth_face(stack, stack.top_mm, dent, count)[:2]
    return peer.grid_face(stack, stack.top_mm, dent, count, 1.1 * dent.reach_mm)[:2]


def vertex_normals(vertices, faces):
    """Upward unit normals at the vertices: means over the facets, weighted by area."""
    vertices = vertices.astype(np.float32).astype(float)
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    facets, sums = np.cross(b - a, c - a), np.zeros_like(vertices)
    for k in range(3):
        np.add.at(sums, faces[:, k], facets)
    return sums / np.maximum(np.linalg.norm(sums, axis=1, keepdims=True), 1e-30)


def meshed(scene, kind, count, normals, work):
    """The same scene with the dent as triangles."""
    file = f"{scene['name']}-{kind}-{count}.obj"
    if not (work / file).exists():
        peer.write_obj(work / file, *triangles(scene, kind, count))
    shape = {"kind": "mesh", "file": file, "normals": normals}
    return {**scene, "name": f"{scene['name']}-{kind}-{count}-{normals}", "touch": {"shape": shape, "inner": "flat"}}


def ours(scene, rounds, arguments, work, *how):
    """Mean of each round's image."""
    path, means = compare._write_scene(scene, work), []
    for seed in range(1, rounds + 1):
        command = [arguments.tirtouch, "render", path, "--json", "--quiet", "--seed", seed, "--spp", arguments.spp,
                   "--integrator", "path", "--out", work / "out", "--force", *how]
        means.append(json.loads(compare._tirtouch(command).stdout)["mean_radiance"])
    print(scene["name"], *how, means, flush=True)
    return np.array(means)


def theirs(scene, mesh, arguments):
    """Mean of each of Mitsuba's images of this mesh."""
    loaded, means = peer.build(scene, arguments.mitsuba_spp, touched=mesh), []
    for seed in range(1, arguments.mitsuba_rounds + 1):
        means.append(peer.render(loaded, arguments.mitsuba_spp, seed).mean())
    print("mitsuba", scene["name"], means, flush=True)
    return np.array(means)


def mean_error(values):
    return float(values.mean()), float(values.std(ddof=1) / math.sqrt(len(values)))


def row(what, found, reference, judged=True):
    """Mean radiance and its error; difference to a reference and its error in per cent; whether that meets."""
    off = 100 * (found[0] / reference[0] - 1)
    error = 100 * math.hypot(found[1] / found[0], reference[1] / reference[0])
    meets = abs(off) <= MOST_OFF and error < MOST_ERROR if judged else None
    return {"surface": what, "mean": found, "off_%": off, "error_%": error, "meets": meets}


def extrapolated(cells, found, order):
    """Mean at no width with its error, and chi square, of a + b / cells^order (three grids: one degree of freedom)."""
    means, errors = np.array(found).T
    design = np.stack([np.ones(len(cells)), np.array(cells, float) ** -order], 1) / errors[:, None]
    inverse = np.linalg.inv(design.T @ design)
    fit = inverse @ design.T @ (means / errors)
    chi_square = float(((design @ fit - means / errors) ** 2).sum())
    return (float(fit[0]), float(math.sqrt(inverse[0, 0]))), chi_square


def study(name, arguments, work):
    """All rows of one dent."""
    scene = scene_of(name, arguments)
    exact = mean_error(ours(scene, 4 * arguments.rounds, arguments, work))
    rows = [{"surface": "closed form", "mean": exact}]
    counts = [("grid", n) for n in arguments.cells] + [("rings", n) for n in arguments.rings]
    coarse = counts[0]
    for normals in ("flat", "smooth"):
        grids = []
        for kind, count in counts:
            mesh = meshed(scene, kind, count, normals, work)
            means = ours(mesh, arguments.rounds, arguments, work, "--backend", "cpu")
            finest = (kind, count) == ("rings", arguments.rings[-1])
            rows.append(row(f"{kind} {count}, {normals}", mean_error(means), exact, finest))
            if kind == "grid":
                grids.append(mean_error(means))
            if (kind, count) == coarse:
                first, same = means[0], mean_error(means)
        order = 1 if "radius_mm" in DENTS[name] else 2
        if grids:
            limit, chi_square = extrapolated(arguments.cells, grids, order)
            rows.append(row(f"grid, {normals}, to no width", limit, exact) | {"order": order, "chi_square": chi_square})
        if normals in arguments.mitsuba_normals:
            vertices, faces = triangles(scene, *coarse)
            given = (vertices, faces, vertex_normals(vertices, faces) if normals == "smooth" else None)
            peers = mean_error(theirs(scene, given, arguments))
            rows.append(row("{} {}, {}: Mitsuba over tirtouch".format(*coarse, normals), peers, same))
    mesh = meshed(scene, *coarse, "smooth", work)
    for what, how in (("f64", ("--backend", "cpu", "--precision", "f64")), ("GPU", ("--backend", "gpu"))):
        off = 100 * (float(ours(mesh, 1, arguments, work, *how)[0] / first) - 1)
        rows.append({"surface": "{} {}, smooth: {} over f32, same paths".format(*coarse, what), "off_%": off})
    return rows


def table(name, rows):
    lines = [f"{name}: {json.dumps(DENTS[name])}", ""]
    lines += ["| surface | mean radiance | off by | meets |", "|---|---|---|---|"]
    for r in rows:
        mean = "{:.4e} ± {:.1e}".format(*r["mean"]) if "mean" in r else ""
        off = f"{r['off_%']:+.0e} %" if "off_%" in r else ""
        if "error_%" in r:
            off = f"{r['off_%']:+.2f} ± {r['error_%']:.2f} %"
        verdict = {None: "", True: "yes", False: "**no**"}[r.get("meets")]
        lines.append(f"| {r['surface']} | {mean} | {off} | {verdict} |")
    return "\n".join(lines) + "\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--tirtouch", type=Path, default=compare.ROOT / "target/release/tirtouch")
    parser.add_argument("--scenes", type=Path, default=compare.ROOT / "scenes")
    parser.add_argument("--dent", action="append", choices=DENTS, help="only this dent; may be repeated")
    parser.add_argument("--led-mm", type=float, default=10.0, help="diameter of the LEDs")
    parser.add_argument("--cells", type=int, nargs="*", default=[256, 512, 1024])
    parser.add_argument("--rings", type=int, nargs="+", default=[128, 256])
    parser.add_argument("--rounds", type=int, default=8)
    parser.add_argument("--spp", type=int, default=32)
    parser.add_argument("--mitsuba-rounds", type=int, default=20)
    parser.add_argument("--mitsuba-spp", type=int, default=2048)
    parser.add_argument("--mitsuba-normals", nargs="*", default=["flat", "smooth"], choices=["flat", "smooth"])
    parser.add_argument("--out", type=Path, default=compare.HERE / "results")
    arguments = parser.parse_args()
    if min(arguments.rounds, arguments.mitsuba_rounds) < 8:
        parser.error("--rounds and --mitsuba-rounds: at least 8, errors are the spread of the rounds")
    if len(arguments.cells) in (1, 2):
        parser.error("--cells: none or at least 3, the fit has two unknowns")
    arguments.out.mkdir(parents=True, exist_ok=True)
    results, text = {}, ""
    with tempfile.TemporaryDirectory() as work:
        for name in arguments.dent or DENTS:
            results[name] = study(name, arguments, Path(work))
            text += table(name, results[name]) + "\n"
            (arguments.out / "meshes.md").write_text(text)
            (arguments.out / "meshes.json").write_text(json.dumps(results, indent=1) + "\n")


if __name__ == "__main__":
    main()
