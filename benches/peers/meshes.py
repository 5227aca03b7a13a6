#!/usr/bin/env python3
"""Dents as closed forms and as meshes of 256 to 1,024 cells, by tirtouch and by Mitsuba 3: does it all meet?

    DRJIT_LIBLLVM_PATH=... peer-venv/bin/python meshes.py --rounds 8 --mitsuba-rounds 8

Each dent of `DENTS` lies in the touched face of `dent-cap`, inner interfaces flat; the camera's view is narrowed to the dent, beyond
which a mesh changes little. tirtouch traces the closed form (a height field for a Gaussian) and meshes with flat and with
interpolated normals, round by round by the same random numbers, so that a mesh's difference to the closed form is known better than
either (1,024 cells need a buffer of 201 MB, more than a device allows by default: the twin in f32 traces them); Mitsuba traces the flat meshes, the same triangles. Errors are the spread of the rounds. Writes meshes.json and meshes.md.
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
# Two triangles of 96 bytes a cell, in the 128 MiB that a binding holds by default.
MOST_CELLS_ON_GPU = 836
DENTS = {
    "cap": {"kind": "spherical_dent", "depth_mm": 1.5, "radius_mm": 6.0},
    "gaussian-narrow": {"kind": "gaussian_dent", "depth_mm": 1.0, "sigma_mm": 1.25},
    "gaussian-wide": {"kind": "gaussian_dent", "depth_mm": 1.5, "sigma_mm": 2.0},
}


def scene_of(name, scenes):
    """`dent-cap` with this dent, seen by a square image that just holds it."""
    scene = peer.load(scenes / "dent-cap.toml")
    shape = DENTS[name]
    reach = shape.get("radius_mm", 3.0 * shape.get("sigma_mm", 0.0))
    stack, camera = peer.Stack(scene), scene["camera"]
    depths = np.diff(stack.heights_mm)
    away = camera["distance_mm"] + sum(d / n for d, n in zip(depths, stack.indices[1:-1]))
    camera |= {"pixels": [PIXELS, PIXELS], "view_angle_deg": 2 * math.degrees(math.atan(1.1 * reach / away))}
    return {**scene, "name": name, "touch": {"shape": shape, "inner": "flat"}}


def meshed(scene, cells, normals, work):
    """The same scene with the dent as triangles."""
    stack, file = peer.Stack(scene), f"{scene['name']}-{cells}.obj"
    if not (work / file).exists():
        peer.write_obj(work / file, *peer.grid_face(stack, stack.top_mm, peer.dent(scene), cells))
    shape = {"kind": "mesh", "file": file, "normals": normals}
    return {**scene, "name": f"{scene['name']}-{cells}-{normals}", "touch": {"shape": shape, "inner": "flat"}}


def ours(scene, rounds, arguments, work, backend=None):
    """Mean of each round's image."""
    path, means = compare._write_scene(scene, work), []
    for seed in range(1, rounds + 1):
        command = [arguments.tirtouch, "render", path, "--json", "--quiet", "--seed", seed, "--spp", arguments.spp,
                   "--integrator", "path", "--backend", backend or arguments.backend, "--out", work / "out", "--force"]
        means.append(json.loads(compare._tirtouch(command).stdout)["mean_radiance"])
        print(scene["name"], seed, means[-1], flush=True)
    return np.array(means)


def theirs(scene, cells, rounds, spp):
    loaded, means = peer.build(scene, spp, grid_cells=cells), []
    for seed in range(1, rounds + 1):
        means.append(peer.render(loaded, spp, seed).mean())
        print("mitsuba", scene["name"], cells, seed, means[-1], flush=True)
    return np.array(means)


def mean_error(values):
    return float(values.mean()), float(values.std(ddof=1) / math.sqrt(len(values)))


def study(name, arguments, work):
    """All rows of one dent: what, mean, its error, difference to the closed form in per cent, its error."""
    scene = scene_of(name, arguments.scenes)
    exact = ours(scene, arguments.rounds, arguments, work)
    rows, middle = [("closed form", *mean_error(exact), 0.0, 0.0)], exact.mean()
    for normals in ("flat", "smooth"):
        for cells in arguments.cells:
            backend = "cpu" if cells > MOST_CELLS_ON_GPU else None
            found = ours(meshed(scene, cells, normals, work), arguments.rounds, arguments, work, backend)
            off, error = mean_error(found - exact)
            rows.append((f"{cells} cells, {normals}", *mean_error(found), 100 * off / middle, 100 * error / middle))
    for cells in arguments.mitsuba_cells:
        found = mean_error(theirs(scene, cells, arguments.mitsuba_rounds, arguments.mitsuba_spp))
        error = math.hypot(found[1], rows[0][2]) / middle
        rows.append((f"{cells} cells, flat, Mitsuba", *found, 100 * (found[0] / middle - 1), 100 * error))
    return rows


def table(name, rows):
    lines = [f"{name}: {json.dumps(DENTS[name])}", "", "| surface | mean radiance | off the closed form |", "|---|---|---|"]
    for what, mean, error, off, off_error in rows:
        share = "-" if what == "closed form" else f"{off:+.2f} ± {off_error:.2f} %"
        lines.append(f"| {what} | {mean:.4e} ± {error:.1e} | {share} |")
    return "\n".join(lines) + "\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--tirtouch", type=Path, default=compare.ROOT / "target/release/tirtouch")
    parser.add_argument("--scenes", type=Path, default=compare.ROOT / "scenes")
    parser.add_argument("--dent", action="append", choices=DENTS, help="only this dent; may be repeated")
    parser.add_argument("--cells", type=int, nargs="+", default=[256, 512, 1024])
    parser.add_argument("--mitsuba-cells", type=int, nargs="*", default=[256, 1024])
    parser.add_argument("--rounds", type=int, default=8)
    parser.add_argument("--mitsuba-rounds", type=int, default=8)
    parser.add_argument("--spp", type=int, default=512)
    parser.add_argument("--mitsuba-spp", type=int, default=2048)
    parser.add_argument("--backend", default="auto")
    parser.add_argument("--out", type=Path, default=compare.HERE / "results")
    arguments = parser.parse_args()
    if min(arguments.rounds, arguments.mitsuba_rounds) < 4:
        parser.error("--rounds and --mitsuba-rounds: at least 4, errors are the spread of the rounds")
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
