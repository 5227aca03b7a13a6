#!/usr/bin/env python3
"""tirtouch against Mitsuba 3 on the same scenes, alternating in one run: is the light the same, and at what cost?

    benches/peers/run.sh                       # builds the release binary, then calls this
    peer-venv/bin/python compare.py --rounds 4 --case contact-disc

Every round renders the scene once with each program, each round with a new seed, the order turning round from round to
round, so that a machine that grows slow slows both. Nothing is taken from either program's own error estimate: errors
are the spread of the rounds. Writes comparison.json (everything) and comparison.md (the table).
"""

import argparse
import json
import os
import subprocess
import tempfile
import time
from pathlib import Path

import mitsuba as mi
import numpy as np

mi.set_variant("llvm_ad_mono")

import mitsuba_scene as peer  # noqa: E402 (needs the variant)
import pressed_scene  # noqa: E402

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent
GRID_CELLS = 256
PRESSED_PEER = ROOT / "target/release/examples/pressed_peer"


class Case:
    """One comparison: the files both programs read, and the pixels over which the light is compared."""

    def __init__(self, name, scene_file, scene, grid_cells, same_surface):
        self.name, self.scene_file, self.scene, self.grid_cells = name, scene_file, scene, grid_cells
        # False where Mitsuba's facets only approximate the surface: the block test would find the facets.
        self.same_surface = same_surface


def cases(scenes, work):
    """The comparisons by name."""
    found = {}
    for name in ("flat-bonded", "contact-disc", "dent-cap"):
        path = scenes / f"{name}.toml"
        found[name] = Case(name, path, peer.load(path), None, name != "dent-cap")
    found["dent-cap-mesh"] = _mesh_case(found["dent-cap"].scene, work)
    found["dent-smooth"] = _smooth_case(found["dent-cap"].scene, work)
    found["pressed"] = Case("pressed", HERE / "pressed.toml", peer.load(HERE / "pressed.toml"), None, True)
    return found


def _pressed(case):
    """Interfaces and contact of a press, or None where nothing is pressed."""
    if "press" not in case.scene:
        return None
    half_mm, contact = peer.Stack(case.scene).half_mm, peer.contact(case.scene)[0]
    return pressed_scene.Faces(PRESSED_PEER, case.scene_file, half_mm, contact)


def _smooth_case(scene, work):
    """A Gaussian dent 1 mm deep: a height field in tirtouch, a mesh in Mitsuba."""
    shape = {"kind": "gaussian_dent", "depth_mm": 1.0, "sigma_mm": 2.0}
    smooth = {**scene, "name": "dent-smooth", "touch": {"shape": shape, "inner": "flat"}}
    return Case("dent-smooth", _write_scene(smooth, work), smooth, GRID_CELLS, False)


def _write_scene(scene, work):
    path = work / f"{scene['name']}.toml"
    path.write_text("".join(f"{key} = {_toml(value)}\n" for key, value in scene.items()))
    return path


def _mesh_case(scene, work):
    """The dent as the same triangles for both programs; the interfaces below stay flat in both."""
    scene = {**scene, "touch": {**scene["touch"], "inner": "flat"}}
    stack = peer.Stack(scene)
    vertices, faces, _ = peer.grid_face(stack, stack.top_mm, peer.dent(scene), GRID_CELLS)
    peer.write_obj(work / "dent.obj", vertices, faces)
    shape = {"kind": "mesh", "file": "dent.obj", "normals": "flat"}
    meshed = {**scene, "name": "dent-cap-mesh", "touch": {**scene["touch"], "shape": shape}}
    return Case("dent-cap-mesh", _write_scene(meshed, work), scene, GRID_CELLS, True)


def _toml(value):
    """A TOML value, tables inline."""
    if isinstance(value, dict):
        return "{ " + ", ".join(f'"{key}" = {_toml(item)}' for key, item in value.items()) + " }"
    if isinstance(value, list):
        return "[" + ", ".join(_toml(item) for item in value) + "]"
    return json.dumps(value)


class Rounds:
    """What one program did: an image, a time and a number of paths each round."""

    def __init__(self):
        self.images, self.seconds, self.paths, self.claimed_variance, self.reports = [], [], [], [], []

    def mean(self):
        return np.mean(self.images, axis=0)

    def variance_of_mean(self):
        return np.var(self.images, axis=0, ddof=1) / len(self.images)

    def paths_per_second(self):
        return float(np.median(np.array(self.paths) / np.array(self.seconds)))

    def patch(self, mask):
        """Mean over the mask and its standard error, from the spread of the rounds."""
        means = np.stack(self.images)[:, mask].mean(1)
        return float(means.mean()), float(means.std(ddof=1) / np.sqrt(len(means)))

    def efficiency(self, mask):
        """1 / (relative pixel variance x seconds)."""
        relative = self.variance_of_mean()[mask].mean() / self.mean()[mask].mean() ** 2
        return float(1 / (relative * np.median(self.seconds) * len(self.seconds)))


def run_mitsuba(rounds, case, loaded, seed, spp):
    start = time.perf_counter()
    rounds.images.append(peer.render(loaded, spp, seed))
    rounds.seconds.append(time.perf_counter() - start)
    rounds.paths.append(rounds.images[-1].size * spp)


def run_tirtouch(rounds, case, seed, arguments, out):
    command = [arguments.tirtouch, "render", case.scene_file, "--json", "--quiet", "--seed", seed,
               "--spp", arguments.tirtouch_spp, "--integrator", arguments.integrator, "--backend", arguments.backend,
               "--out", out, "--force"]
    report = json.loads(_tirtouch(command).stdout)
    channels = peer.read_exr(out / "radiance.exr")
    rounds.images.append(channels["mean"])
    rounds.claimed_variance.append(channels["variance"])
    rounds.seconds.append(report["seconds"])
    rounds.paths.append(report["paths"])
    rounds.reports.append(report)


def _tirtouch(command, allowed=(0,)):
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True)
    if done.returncode not in allowed:
        raise SystemExit(f"{' '.join(map(str, command))}\nexit code {done.returncode}\n{done.stdout}{done.stderr}")
    return done


def t_quantile_975(freedom):
    """Student's t at 97.5 %, by the expansion about the normal quantile (Abramowitz and Stegun 26.7.5)."""
    z = 1.959964
    return (z + (z**3 + z) / (4 * freedom) + (5 * z**5 + 16 * z**3 + 3 * z) / (96 * freedom**2)
            + (3 * z**7 + 19 * z**5 + 17 * z**3 - 15 * z) / (384 * freedom**3))


def ratio_of_means(ours, theirs, rounds):
    """Ratio, its relative standard error and the half-width of its 95 % interval (Welch)."""
    ratio = ours[0] / theirs[0]
    a, b = (ours[1] / ours[0]) ** 2, (theirs[1] / theirs[0]) ** 2
    error = np.sqrt(a + b)
    freedom = (a + b) ** 2 / ((a**2 + b**2) / (rounds - 1))
    return {"ratio": ratio, "standard_error": ratio * error, "half_width_95": ratio * error * t_quantile_975(freedom)}


def lit(scene, image):
    """The pixels over which light and efficiency are compared."""
    patch = peer.contact_pixels(scene)
    if patch is not None:
        return patch
    return image > 0.3 * np.percentile(image, 99)


def compare(case, arguments, work):
    """All figures of one case."""
    loaded = peer.build(case.scene, arguments.spp, grid_cells=case.grid_cells, pressed=_pressed(case))
    peer.render(loaded, 4, 1_000_000)  # compiles the kernel
    out = work / case.name
    theirs, ours = Rounds(), Rounds()
    for seed in range(1, arguments.rounds + 1):
        if seed % 2:
            run_mitsuba(theirs, case, loaded, seed, arguments.spp)
        run_tirtouch(ours, case, seed, arguments, out / "render")
        if not seed % 2:
            run_mitsuba(theirs, case, loaded, seed, arguments.spp)
    mask = lit(case.scene, (ours.mean() + theirs.mean()) / 2)
    whole = np.ones_like(mask)
    compared = mask if peer.contact(case.scene) else whole
    ours_mean, theirs_mean = ours.patch(compared), theirs.patch(compared)
    found = ours.variance_of_mean()[mask].mean() * arguments.rounds
    result = {
        "case": case.name,
        "rounds": arguments.rounds,
        "scene": case.scene["name"],
        "grid_cells": case.grid_cells,
        "integrator": ours.reports[0]["integrator"],
        "backend": ours.reports[0]["backend"],
        "adapter": ours.reports[0]["adapter"],
        "compared_pixels": int(compared.sum()),
        "lit_pixels": int(mask.sum()),
        "tirtouch_mean": ours_mean,
        "mitsuba_mean": theirs_mean,
        "mean_ratio": ratio_of_means(ours_mean, theirs_mean, arguments.rounds),
        "tirtouch_paths_per_second": ours.paths_per_second(),
        "mitsuba_paths_per_second": theirs.paths_per_second(),
        "tirtouch_seconds": ours.seconds,
        "mitsuba_seconds": theirs.seconds,
        "tirtouch_efficiency": ours.efficiency(mask),
        "mitsuba_efficiency": theirs.efficiency(mask),
        # 1 where tirtouch's own variance is honest, up to the spread of so few rounds.
        "claimed_over_found_variance": float(np.mean([v[mask].mean() for v in ours.claimed_variance]) / found),
    }
    result["paths_per_second_ratio"] = result["tirtouch_paths_per_second"] / result["mitsuba_paths_per_second"]
    result["efficiency_ratio"] = result["tirtouch_efficiency"] / result["mitsuba_efficiency"]
    if case.same_surface:
        folders = out / "ours", out / "theirs"
        for folder, rounds in zip(folders, (ours, theirs)):
            peer.write_estimate(folder, rounds.mean(), rounds.variance_of_mean())
        tested = _tirtouch([arguments.tirtouch, "compare", *folders, "--json"], allowed=(0, 1))
        result |= {"block_test": json.loads(tested.stdout), "block_test_agrees": tested.returncode == 0}
    return result


def table(results, arguments):
    """The figures as Markdown."""
    lines = [
        f"Medians of alternating rounds; Mitsuba {mi.__version__} `llvm_ad_mono`, {arguments.spp} paths"
        f" per pixel, {os.cpu_count()} cores;",
        f"tirtouch on {results[0]['adapter']}.",
        "Intervals are 95 %. Ratios are tirtouch over Mitsuba; efficiency is 1 / (relative pixel variance x seconds).",
        "",
        "| scene | rounds | integrator | mean radiance, ratio | blocks agree"
        " | paths/s | Mitsuba paths/s | ratio | efficiency ratio |",
        "|---|---|---|---|---|---|---|---|---|",
    ]
    for r in results:
        mean = r["mean_ratio"]
        agrees = {True: "yes", False: "no", None: "not tested"}[r.get("block_test_agrees")]
        lines.append(
            f"| {r['case']} | {r['rounds']} | {r['integrator']} | {mean['ratio']:.4f} ± {mean['half_width_95']:.4f}"
            f" | {agrees} | {r['tirtouch_paths_per_second']:.2e} | {r['mitsuba_paths_per_second']:.2e}"
            f" | {r['paths_per_second_ratio']:.2f} | {r['efficiency_ratio']:.2f} |")
    return "\n".join(lines) + "\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--tirtouch", type=Path, default=ROOT / "target/release/tirtouch")
    parser.add_argument("--scenes", type=Path, default=ROOT / "scenes")
    parser.add_argument("--case", action="append", help="only this case; may be repeated")
    parser.add_argument("--rounds", type=int, default=16)
    parser.add_argument("--spp", type=int, default=64, help="Mitsuba's paths per pixel and round")
    parser.add_argument("--tirtouch-spp", type=int, default=64)
    parser.add_argument("--integrator", default="auto")
    parser.add_argument("--backend", default="auto")
    parser.add_argument("--out", type=Path, default=HERE / "results")
    arguments = parser.parse_args()
    if arguments.rounds < 4:
        parser.error("--rounds: at least 4, errors are the spread of the rounds")
    results = []
    with tempfile.TemporaryDirectory() as work:
        available = cases(arguments.scenes, Path(work))
        for name in arguments.case or available:
            if name not in available:
                parser.error(f"--case {name}: one of {', '.join(available)}")
            results.append(compare(available[name], arguments, Path(work)))
            print(json.dumps({key: results[-1][key] for key in ("case", "mean_ratio", "efficiency_ratio")}), flush=True)
    arguments.out.mkdir(parents=True, exist_ok=True)
    written = {key: getattr(arguments, key) for key in ("rounds", "spp", "tirtouch_spp", "integrator", "backend")}
    written |= {"mitsuba": mi.__version__, "cores": os.cpu_count(), "cases": results}
    (arguments.out / "comparison.json").write_text(json.dumps(written, indent=1) + "\n")
    (arguments.out / "comparison.md").write_text(table(results, arguments))


if __name__ == "__main__":
    main()
