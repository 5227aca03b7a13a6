#!/usr/bin/env python3
"""Do the intervals of a sweep's figures hold?

    cargo build --release && python3 benches/sweeps/coverage.py [--seeds 200] [--cases disc phantom null]

Renders one scene with many seeds, as a sweep over `render.seed`, and prints for each figure how many intervals hold the
mean over all seeds, with the interval of Clopper and Pearson, and the claimed over the true spread. `disc` is
`contact-disc`, `phantom` the pressed `phantom-size-8mm`, `null` the same with an inclusion of the tissue's own
material, where the signal of the inclusion is to hold 0. Needs scipy.
"""

import argparse
import csv
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

from scipy.stats import beta

ROOT = Path(__file__).resolve().parent.parent.parent
PROGRAM = ROOT / "target/release/tirtouch"
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
LIGHT = ["mean_radiance", "contrast", "unevenness", "trapped", "escaped", "absorbed", "paper"]
CASES = {
    "disc": ("contact-disc", SMALL_DISC, LIGHT, 65_536),
    "phantom": ("phantom-size-8mm", SMALL_PHANTOM, [*LIGHT, "snr"], 131_072),
    "null": ("phantom-size-8mm", {**SMALL_PHANTOM, **SAME}, ["snr", "contrast"], 131_072),
}


def sweep(case, seeds, work):
    name, changes, measures, photons = CASES[case]
    text = (ROOT / f"scenes/{name}.toml").read_text()
    for old, new in changes.items():
        if old not in text:
            sys.exit(f"{name}: has no '{old}'")
        text = text.replace(old, new)
    folder = Path(work) / case
    folder.mkdir()
    (folder / "scene.toml").write_text(f"{text}\n[render]\nspp = 16\nphotons = {photons}\n")
    measured = "".join(f'[[measure]]\nkind = "{kind}"\n' for kind in measures)
    vary = f'[[vary]]\nkey = "render.seed"\nlinear = {{ from = 1, to = {seeds}, points = {seeds} }}\n'
    head = '[sweep]\nscene = "scene.toml"\ndesign = { kind = "grid" }\nrandom_numbers = "own"\n'
    (folder / "sweep.toml").write_text(head + vary + measured)
    command = [PROGRAM, "sweep", "run", folder / "sweep.toml", "-o", folder / "out", "--quiet"]
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    with open(folder / "out/points.csv", newline="") as file:
        return list(csv.DictReader(file))


def judge(case, rows):
    print(f"\n{case}: {len(rows)} seeds, {sum(row['status'] == 'done' for row in rows)} done")
    print("| figure | mean | hold it | share, % | claimed over true spread |\n|---|---|---|---|---|")
    names = [name[: -len("_low")] for name in rows[0] if name.endswith("_low")]
    for name in names:
        told = [row for row in rows if row[name] and row[f"{name}_low"]]
        if len(told) < 2:
            print(f"| {name} | - | without an interval in all but {len(told)} | | |")
            continue
        value, low, high = ([float(row[key]) for row in told] for key in (name, f"{name}_low", f"{name}_high"))
        # What the inclusion adds is 0 where there is none.
        truth = 0.0 if case == "null" and name.startswith("snr") else statistics.fmean(value)
        held = sum(a <= truth <= b for a, b in zip(low, high))
        ends = [beta.ppf(0.025, held, len(told) - held + 1), beta.ppf(0.975, held + 1, len(told) - held)]
        ends = [100.0 * (end if end == end else float(side)) for end, side in zip(ends, (0, 1))]
        spread = statistics.stdev(value)
        claimed = statistics.fmean((b - a) / 3.92 for a, b in zip(low, high))
        ratio = f"{claimed / spread:.2f}" if spread > 0.0 else "-"
        share = f"{ends[0]:.1f} to {ends[1]:.1f}"
        print(f"| {name} | {statistics.fmean(value):.5g} | {held} of {len(told)} | {share} | {ratio} |", flush=True)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--seeds", type=int, default=200)
    parser.add_argument("--cases", nargs="+", choices=CASES, default=list(CASES))
    wanted = parser.parse_args()
    with tempfile.TemporaryDirectory() as work:
        for case in wanted.cases:
            judge(case, sweep(case, wanted.seeds, work))


if __name__ == "__main__":
    main()
