#!/usr/bin/env python3
"""What does an index sweep of a pressed phantom cost beside a shell loop?

    cargo build --release && python3 benches/sweeps/index.py [--points 200] [--rounds 3]
        [--program target/release/tirtouch]

Sweeps the index of the touched layer of `phantom-size-8mm` in 384 x 288 pixels from 1.40 to 1.44, 1 % a pixel, then
starts `run` and `render` for single points of it in turn. Prints points a minute, the share of the time at which the
tracer is at work, and how many times as long the commands take for a point.
"""

import argparse
import csv
import json
import statistics
import subprocess
import tempfile
import time
from pathlib import Path

from cases import INDEX, PROGRAM, index


def alone(program, words, value, folder):
    """Seconds of a command for one point."""
    start = time.monotonic()
    words = [program, *words, folder / "scene.toml", "--set", f"{INDEX}={value}", "--target-error", "0.01", "--quiet"]
    subprocess.run([*map(str, words), "-o", str(folder / f"{words[1]}-{value}")], check=True, stdout=subprocess.DEVNULL)
    return time.monotonic() - start


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--points", type=int, default=200)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--program", type=Path, default=PROGRAM)
    asked = parser.parse_args()
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        index(asked.points).write(folder)
        command = [asked.program, "sweep", "run", folder / "sweep.toml", "-o", folder / "out", "--json", "--quiet"]
        said = json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)
        with open(folder / "out/times.csv", newline="") as file:
            traced = sum(float(row["light_s"]) for row in csv.DictReader(file))
        rate = said["points_per_minute"]
        # One thread traces: its seconds do not overlap. Presses are beside it, so at most the rest is outside both.
        print(f"sweep: {said['done']} of {said['points']} points, {rate:.1f} a minute; the tracer is at work for "
              f"{100 * traced / said['seconds']:.1f} % of the time, at most the rest is outside tracer and press",
              flush=True)
        times = {"run": [], "render": []}
        for number in range(asked.rounds):
            value = 1.40 + 0.04 * (number + 0.5) / asked.rounds
            for name, seconds in times.items():
                seconds.append(alone(asked.program, [name], f"{value:.4f}", folder))
        for name, seconds in times.items():
            middle = statistics.median(seconds)
            print(f"{name}: {', '.join(f'{s:.1f}' for s in seconds)} s a point; {middle * rate / 60:.1f} times as long")


if __name__ == "__main__":
    main()
