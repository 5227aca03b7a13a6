#!/usr/bin/env python3
"""Do the intervals of a sweep's figures hold?

    cargo build --release && python3 benches/sweeps/coverage.py [--seeds 200]
        [--cases disc phantom null less press effects indices] [--program target/release/tirtouch]

Renders one scene with many seeds, as a sweep over `render.seed`, and prints for each figure how many intervals hold the
mean over all seeds, with the interval of Clopper and Pearson, and the claimed over the true spread. `disc` is
`contact-disc`, `bright` the same exposed until pixels saturate, `noisy` the few camera paths of `dent-cap`, exposed
alike: of what saturates in both the truth is that of 256 times the samples. `phantom` is the pressed
`phantom-size-8mm`, `null` the same with an inclusion of the tissue's own material, where the signal of the inclusion is
to hold 0; `less` has the paper's figures of what the inclusion adds.
`press` draws as many phantoms at random instead: do intervals of force and peak pressure hold what a mesh of three
times the resolution gives? `effects` and `effects-own` make as many Morris designs of the disc's mean radiance, points
of a trajectory with random numbers in common or not: do intervals hold the mean over all of them, and the exposure's
effect, which is none? `indices` and `indices-own` do so with Saltelli designs: do intervals hold what Sobol's indices
are by a quadrature of converged renders? And where nothing is varied that the radiance feels, how many designs tell of
an index above 0? Needs numpy and scipy.
"""

import argparse
import csv
import statistics
import subprocess
import tempfile
from pathlib import Path

import numpy as np
from cases import PROGRAM, changed
from scipy.stats import beta

# Pixels of eight times the pitch gather 64 times the light: exposures are as much shorter, so that nothing saturates.
SMALL_DISC = {
    "pixels = [384, 288]": "pixels = [48, 36]",
    "pixel_pitch_um = 16.86": "pixel_pitch_um = 134.88",
    "exposure_ms = 60.0": "exposure_ms = 0.94",
}
SMALL_PHANTOM = {
    "pixels = [348, 261]": "pixels = [48, 36]",
    "pixel_pitch_um = 18.6": "pixel_pitch_um = 134.85",
    "exposure_ms = 0.7": "exposure_ms = 0.0133",
    "depths_mm = [1.0, 2.0, 4.0]": "depths_mm = [2.0]\nresolution = 0.5\nestimate_error = false",
}
LUMP = 'material = { law = "neo_hookean", youngs_kpa = 120.0 }'
SAME = {LUMP: LUMP.replace("120.0", "5.0")}
BRIGHT = {**SMALL_DISC, "exposure_ms = 60.0": "exposure_ms = 2.0"}
SMALL_DENT = {key: value for key, value in SMALL_DISC.items() if "exposure" not in key}
SMALL_DENT["[touch]"] = "[camera.sensor]\nexposure_ms = 20.0\n\n[touch]"
LIGHT = ["mean_radiance", "contrast", "unevenness", "trapped", "escaped", "absorbed", "paper"]
CASES = {
    "disc": ("contact-disc", SMALL_DISC, LIGHT, 65_536),
    "bright": ("contact-disc", BRIGHT, ["saturated", "mean_grey"], 65_536),
    "noisy": ("dent-cap", SMALL_DENT, ["mean_radiance", "saturated", "mean_grey"], 65_536),
    "phantom": ("phantom-size-8mm", SMALL_PHANTOM, [*LIGHT, "snr"], 131_072),
    "null": ("phantom-size-8mm", {**SMALL_PHANTOM, **SAME}, ["snr", "contrast"], 131_072),
    "less": ("phantom-size-8mm", {**SMALL_PHANTOM, "[2.0]": "[4.0]"}, ["paper"], 131_072),
}
OTHERS = ["press", "effects", "effects-own", "indices", "indices-own"]
SEEDS = '[[vary]]\nkey = "render.seed"\nlinear = { from = 1, to = POINTS, points = POINTS }\n'
PHANTOMS = """
[[vary]]
key = "phantom.inclusion[0].shape.diameter_mm"
uniform = [4, 14]
[[vary]]
key = "phantom.inclusion[0].depth_mm"
uniform = [2, 10]
[[vary]]
key = "phantom.inclusion[0].material.youngs_kpa"
log_uniform = [20, 150]
[[vary]]
key = "phantom.material.youngs_kpa"
uniform = [3, 10]
[[vary]]
key = "press.depths_mm[0]"
uniform = [0.5, 4]
"""
EFFECTS = """
[[vary]]
key = "stack.layer[0].n"
name = "n_top"
uniform = [1.405, 1.415]
[[vary]]
key = "led[0].height_mm"
name = "height"
uniform = [5.95, 6.05]
[[vary]]
key = "camera.sensor.exposure_ms"
name = "exposure"
uniform = [0.9, 1.0]
"""
EXPOSURE = EFFECTS[EFFECTS.rindex("[[vary]]") :]
INDICES = f"""
[[vary]]
key = "stack.layer[0].n"
name = "n_top"
uniform = [1.38, 1.42]
[[vary]]
key = "led[*].radiance_w_per_m2_sr"
name = "power"
uniform = [0.9, 1.1]
{EXPOSURE}"""


def swept(folder, scene, measures, vary, design, program, more="", numbers="own", table="points.csv"):
    folder.mkdir()
    (folder / "scene.toml").write_text(scene)
    measured = "".join(f'[[measure]]\nkind = "{kind}"\n' for kind in measures)
    head = f'[sweep]\nscene = "scene.toml"\ndesign = {design}\nrandom_numbers = "{numbers}"\n{more}'
    (folder / "sweep.toml").write_text(head + vary + measured)
    command = [program, "sweep", "run", folder / "sweep.toml", "-o", folder / "out", "--quiet"]
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    with open(folder / "out" / table, newline="") as file:
        return list(csv.DictReader(file))


def sweep(case, seeds, work, program, times=1):
    """Rows of so many seeds, with so many times the samples."""
    name, changes, measures, photons = CASES[case]
    scene = f"{changed(name, changes)}\n[render]\nspp = {16 * times}\nphotons = {photons * times}\n"
    if case == "less":
        measures = [f'{kind}"\nless_baseline = true\n# "' for kind in measures]
    vary = SEEDS.replace("POINTS", str(seeds))
    return swept(Path(work) / f"{case}-{times}", scene, measures, vary, '{ kind = "grid" }', program)


def press(points, work, program):
    """Rows at resolution 1 with their intervals, and the same on a mesh of three times the resolution."""
    scene = changed("phantom-size-8mm", {"depths_mm = [1.0, 2.0, 4.0]": "depths_mm = [4.0]\nresolution = RESOLUTION"})
    design = f'{{ kind = "random", points = {points}, seed = 11 }}'
    both = []
    for name, resolution in (("coarse", "1.0"), ("fine", "3.0\nestimate_error = false")):
        text = scene.replace("RESOLUTION", resolution)
        both.append(swept(Path(work) / name, text, ["force", "peak_pressure"], PHANTOMS, design, program))
    rows, fine = both
    done = [(row, true) for row, true in zip(rows, fine) if (row["status"], true["status"]) == ("done", "done")]
    print(f"\npress: {points} points, {len(done)} done at both resolutions")
    print("| figure | hold it | share, % | half width, median % | off, median % |\n|---|---|---|---|---|")
    for name in ("force_n", "peak_pressure_kpa"):
        numbers = [[float(row[name]), float(row[f"{name}_low"]), float(row[f"{name}_high"]), float(true[name])]
                   for row, true in done]
        held = sum(low <= true <= high for _, low, high, true in numbers)
        wide = statistics.median(50 * (high - low) / value for value, low, high, _ in numbers)
        off = statistics.median(100 * abs(value / true - 1) for value, _, _, true in numbers)
        ends = share(held, len(numbers))
        print(f"| {name} | {held} of {len(numbers)} | {ends} | {wide:.2f} | {off:.2f} |", flush=True)


def tiny(spp, photons):
    """The disc in few pixels by few paths, whose noise is as large as effects are."""
    fewer = {"pixels = [384, 288]": "pixels = [16, 12]", "pixel_pitch_um = 16.86": "pixel_pitch_um = 404.64"}
    small = {**SMALL_DISC, **fewer}
    return f"{changed('contact-disc', small)}\n[render]\nspp = {spp}\nphotons = {photons}\nmap_texel_mm = 1.0\n"


def sensitivities(name, design, vary, designs, work, program, numbers):
    """What so many designs tell of each variable and quantity, with both ends; how many of them refuse to."""
    all_found, refused = {}, 0
    for seed in range(designs):
        seeded = f"{{ {design}, seed = {seed} }}"
        folder = Path(work) / f"{name}-{numbers}-{seed}"
        found = swept(folder, tiny(4, 4096), ["mean_radiance"], vary, seeded, program, f"seed = {seed}\n", numbers,
                      "sensitivity.csv")
        refused += not found[0]["variable"]
        for row in found:
            if row["low"]:
                told = [float(row[key]) for key in ("value", "low", "high")]
                all_found.setdefault((row["variable"], row["quantity"]), []).append(told)
    return all_found, refused


def print_held(all_found, truths):
    """A row a variable and quantity."""
    print("| variable | quantity | truth | mean | hold it | share, % |\n|---|---|---|---|---|---|")
    for what, told in all_found.items():
        truth = truths[what]
        held = sum(low <= truth <= high for _, low, high in told)
        mean = statistics.fmean(value for value, _, _ in told)
        counts = f"{held} of {len(told)} | {share(held, len(told))}"
        print(f"| {what[0]} | {what[1]} | {truth:.3g} | {mean:.3g} | {counts} |", flush=True)


def effects(designs, work, program, numbers):
    """Morris designs of few pixels and paths."""
    design = 'kind = "morris", trajectories = 6'
    all_found, _ = sensitivities("effects", design, EFFECTS, designs, work, program, numbers)
    print(f"\neffects, {numbers}: {designs} designs of 6 trajectories")
    truths = {}
    for variable, quantity in all_found:
        # Over so small ranges no effect changes its sign: the absolute one is that of the mean, which has no bias.
        mean = statistics.fmean(value for value, _, _ in all_found[variable, "mean_effect"])
        mean = 0.0 if variable == "exposure" else mean
        truths[variable, quantity] = abs(mean) if quantity == "mean_absolute_effect" else mean
    print_held(all_found, truths)


def quadrature(work, program):
    """Sobol's indices of index and power from converged renders at Gauss' nodes."""
    nodes, weights = np.polynomial.legendre.leggauss(4)
    vary = INDICES[: INDICES.index(EXPOSURE)]
    for low, high in ((1.38, 1.42), (0.9, 1.1)):
        values = (low + (high - low) * (1.0 + nodes) / 2.0).tolist()
        vary = vary.replace(f"uniform = [{low}, {high}]", f"values = {values}")
    rows = swept(Path(work) / "truth", tiny(4096, 1 << 22), ["mean_radiance"], vary, '{ kind = "grid" }', program)
    figures = np.array([float(row["mean_radiance_w_m2_sr"]) for row in rows]).reshape(4, 4)
    weights = weights / 2.0
    mean = weights @ figures @ weights
    whole = weights @ (figures - mean) ** 2 @ weights
    index, power = (weights @ (means - mean) ** 2 / whole for means in (figures @ weights, weights @ figures))
    return {("n_top", "first_index"): index, ("n_top", "total_index"): 1.0 - power,
            ("power", "first_index"): power, ("power", "total_index"): 1.0 - index,
            ("exposure", "first_index"): 0.0, ("exposure", "total_index"): 0.0}


def indices(designs, work, program, numbers):
    """Saltelli designs of few pixels and paths; and such where nothing is varied that the radiance feels."""
    design = 'kind = "saltelli", points = 64'
    all_found, refused = sensitivities("indices", design, INDICES, designs, work, program, numbers)
    print(f"\nindices, {numbers}: {designs} designs of 64 base points, {refused} refused")
    print_held(all_found, quadrature(work, program))
    all_found, refused = sensitivities("nothing", design, EXPOSURE, designs, work, program, numbers)
    false = sum(low > 0.0 for told in all_found.values() for _, low, _ in told)
    print(f"nothing varied that is felt: {refused} of {designs} refused, {false} intervals above 0")


def share(held, of):
    """Interval of Clopper and Pearson, percent."""
    ends = [beta.ppf(0.025, held, of - held + 1), beta.ppf(0.975, held + 1, of - held)]
    low, high = (100.0 * (end if end == end else float(side)) for end, side in zip(ends, (0, 1)))
    return f"{low:.1f} to {high:.1f}"


def judge(case, rows, known):
    """Prints a row a figure; its truth is the mean over all rows where it is not known."""
    print(f"\n{case}: {len(rows)} seeds, {sum(row['status'] == 'done' for row in rows)} done")
    print("| figure | mean | hold it | share, % | claimed over true spread |\n|---|---|---|---|---|")
    names = [name[: -len("_low")] for name in rows[0] if name.endswith("_low")]
    for name in names:
        told = [row for row in rows if row[name] and row[f"{name}_low"]]
        if len(told) < 2:
            print(f"| {name} | - | without an interval in all but {len(told)} | | |")
            continue
        value, low, high = ([float(row[key]) for row in told] for key in (name, f"{name}_low", f"{name}_high"))
        truth = known.get(name, statistics.fmean(value))
        held = sum(a <= truth <= b for a, b in zip(low, high))
        spread = statistics.stdev(value)
        claimed = statistics.fmean((b - a) / 3.92 for a, b in zip(low, high))
        ratio = f"{claimed / spread:.2f}" if spread > 0.0 else "-"
        ends = share(held, len(told))
        print(f"| {name} | {statistics.fmean(value):.5g} | {held} of {len(told)} | {ends} | {ratio} |", flush=True)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--seeds", type=int, default=200)
    parser.add_argument("--cases", nargs="+", choices=[*CASES, *OTHERS], default=[*CASES, *OTHERS])
    parser.add_argument("--program", type=Path, default=PROGRAM)
    wanted = parser.parse_args()
    with tempfile.TemporaryDirectory() as work:
        for case in wanted.cases:
            if case == "press":
                press(wanted.seeds, work, wanted.program)
            elif case in OTHERS:
                judged = effects if case.startswith("effects") else indices
                judged(wanted.seeds, work, wanted.program, "own" if case.endswith("-own") else "common")
            else:
                # What the inclusion adds is 0 where there is none.
                known = {"snr": 0.0} if case == "null" else {}
                if case in ("bright", "noisy"):
                    known = {"saturated": float(sweep(case, 1, work, wanted.program, 256)[0]["saturated"])}
                judge(case, sweep(case, wanted.seeds, work, wanted.program), known)


if __name__ == "__main__":
    main()
