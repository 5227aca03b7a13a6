#!/usr/bin/env python3
"""Does a sweep through Slurm end like one on this machine, though workers are killed?

    cargo build --release && benches/sweeps/slurm.sh FOLDER 2 && SLURM_CONF=FOLDER/slurm.conf \\
        python3 benches/sweeps/slurm.py [--rounds 10] [--seed 1] [--case disc]

Runs a sweep of cases.py on this machine, then in each round as a job array of four tasks. At random times one task's
program is killed (`kill -9`), another's job is sent back to the queue (`scontrol requeue`, as where it is preempted),
and the array is sent anew until all points are there. Table, labels and images after `sweep collect` are to be those of
this machine, byte by byte, and no record that was there after a kill is to be written again. `index` is the sweep of
200 points of index.py.
"""

import argparse
import json
import os
import random
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from cases import CASES, PROGRAM, ends
from kills import items


def said(*words, cwd=None):
    return subprocess.run(words, cwd=cwd, check=True, capture_output=True, text=True).stdout


def tasks(state):
    """Jobs of the queue in a state, as squeue knows them."""
    return said("squeue", "-h", "-r", "-t", state, "-o", "%A %a").split("\n")[:-1]


def programs(folder):
    """Processes that compute points of a folder."""
    found = []
    for place in Path("/proc").glob("[0-9]*/cmdline"):
        try:
            words = place.read_bytes().split(b"\0")
        except OSError:
            continue
        if b"--shard" in words and str(folder).encode() in words:
            found.append(int(place.parent.name))
    return found


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--rounds", type=int, default=10)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--case", choices=list(CASES), default="disc")
    arguments = parser.parse_args()
    case = CASES[arguments.case]
    draw = random.Random(arguments.seed)
    work = Path(tempfile.mkdtemp(prefix="tirtouch-slurm-"))
    expected, seconds = case.whole(work)
    equal = killed = requeued = sent = twice = 0
    for number in range(arguments.rounds):
        folder = work / f"sent-{number}"
        subprocess.run(
            case.command(folder.name, "--engine", "slurm", "--tasks", "4", "--submit"), cwd=work, check=True,
            stdout=subprocess.DEVNULL,
        )
        sent += 1
        kept, faults = {}, ["kill", "requeue"]
        while True:
            time.sleep(draw.uniform(0.2, seconds / 4))
            running = programs(folder)
            if faults and running:
                fault = faults.pop(0)
                if fault == "kill":
                    os.kill(draw.choice(running), signal.SIGKILL)
                    killed += 1
                elif jobs := tasks("R"):
                    said("scontrol", "requeue", draw.choice(jobs).split()[0])
                    requeued += 1
                now = items(folder)
                twice += sum(now.get(name) != mark for name, mark in kept.items())
                kept = now
            if not said("squeue", "-h", "-r"):
                status = json.loads(said(PROGRAM, "sweep", "status", folder, "--json"))
                if status["done"] == case.points:
                    break
                said("sbatch", "job.sh", cwd=folder)
                sent += 1
        now = items(folder)
        twice += sum(now.get(name) != mark for name, mark in kept.items())
        subprocess.run([PROGRAM, "sweep", "collect", folder], check=True, stdout=subprocess.DEVNULL)
        equal += ends(folder) == expected
    print(f"{arguments.rounds} sweeps by Slurm, {sent} arrays sent, {killed} programs killed, {requeued} jobs requeued")
    print(f"{equal} folders end as that of one machine, byte by byte; {twice} records written twice")
    sys.exit(equal != arguments.rounds or twice > 0)


if __name__ == "__main__":
    main()
