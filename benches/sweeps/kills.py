#!/usr/bin/env python3
"""Does a sweep survive `kill -9` at any moment?

    cargo build --release && python3 benches/sweeps/kills.py [--kills 100] [--seed 1] [--case disc]

Runs a sweep of 24 points on the built-in tracer in one folder after the other, kills it after random times until it
comes to its end, and compares: the final table is that of a sweep that was never stopped, byte by byte, and so are
labels and images; no record that was there after a kill was written again. Every third run has a second worker beside
it. `disc` is `contact-disc`, `set` a data set of pressed phantoms, of which eight share each press.
"""

import argparse
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from cases import CASES, ends


def items(folder):
    """Inode and time of each record: one that is written again has others."""
    found = {}
    for path in sorted((folder / "items").glob("0*.json")):
        status = path.stat()
        found[path.name] = (status.st_ino, status.st_mtime_ns)
    return found


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--kills", type=int, default=100)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--case", choices=["disc", "set"], default="disc")
    arguments = parser.parse_args()
    case = CASES[arguments.case]
    draw = random.Random(arguments.seed)
    work = Path(tempfile.mkdtemp(prefix="tirtouch-kills-"))
    expected, whole_seconds = case.whole(work)

    kills, folders, twice, wrong, done_at_kill = 0, 0, 0, 0, []
    while kills < arguments.kills:
        out = work / f"killed-{folders}"
        folders += 1
        kept = {}
        runs = 0
        while True:
            more = ["--resume"] if (out / "items/order.json").exists() else []
            workers = [subprocess.Popen(case.command(out.name, *more), cwd=work)]
            if runs % 3 == 2 and more:
                workers.append(subprocess.Popen(case.command(out.name, "--resume"), cwd=work))
            runs += 1
            try:
                workers[0].wait(timeout=draw.uniform(0.02, 0.7 * whole_seconds))
            except subprocess.TimeoutExpired:
                os.kill(workers[0].pid, signal.SIGKILL)
                kills += 1
            codes = [worker.wait() for worker in workers]
            now = items(out) if out.exists() else {}
            twice += sum(1 for name, mark in kept.items() if now.get(name) != mark)
            kept = now
            done_at_kill.append(len(now))
            if codes[-1] == 0 and codes[0] == 0:
                break
            if any(code not in (0, -signal.SIGKILL) for code in codes):
                print(f"a run ended with {codes}", file=sys.stderr)
                wrong += 1
                break
        if ends(out) != expected:
            wrong += 1
    print(f"{kills} kills in {folders} folders; records written again: {twice}; folders that end otherwise: {wrong}")
    print(f"points there at the kills: {min(done_at_kill)} to {max(done_at_kill)} of {case.points}")
    shutil.rmtree(work)
    sys.exit(1 if twice or wrong else 0)


if __name__ == "__main__":
    main()
