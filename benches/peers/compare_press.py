#!/usr/bin/env python3
"""tirtouch against CalculiX: the same presses, their forces and pressures, and the seconds they take.

    benches/peers/mechanics.sh                  # builds the release binary, then all parts
    python compare_press.py forces hertz        # some parts; the figures of the others are kept

forces   a tied press on ladders of meshes: the mesh of ours in both programs, and CalculiX's own even grid
speed    the same press by both, alternating, the order turning from round to round
hertz    a ball on a block of the same mesh: the pressures against Hertz's
layers   soft layers of several moduli tied to the phantom, with faults that must show (other_presses.py)
skin     a layer of the phantom of another modulus, likewise
off-axis a ball beside the axis in three dimensions, likewise

Writes mechanics.json (every figure) and mechanics.md (the tables).
"""

import argparse
import json
import os
import resource
import statistics
import subprocess
import sys
import tempfile
import textwrap
from pathlib import Path

import calculix_deck as ccx
import calculix_hertz
import calculix_press
import other_presses

HERE = Path(__file__).resolve().parent
PRESSES = {
    "linear, 1 mm": ("linear", 1.0),
    "neo-Hookean, 1 mm": ("neo-hookean", 1.0),
    "neo-Hookean, 4 mm": ("neo-hookean", 4.0),
}
# Rungs of each ladder: subdivisions of our mesh in ours, in CalculiX; columns and rows of CalculiX's own grid.
RUNGS = {
    "linear, 1 mm": ([1, 2, 4], [1, 2, 4], [(48, 34), (96, 68), (192, 136)]),
    "neo-Hookean, 1 mm": ([1, 2, 4], [1, 2, 4], [(24, 17), (48, 34), (96, 68)]),
    "neo-Hookean, 4 mm": ([1, 2, 4], [1, 2], [(24, 17), (48, 34)]),
}


class Programs:
    """Both programs and a folder for their files."""

    def __init__(self, binary, work):
        self.binary, self.work = Path(binary).resolve(), Path(work)

    def ours(self, *arguments, threads=None):
        """One run of press_peer: its figures, and the processor's seconds of the whole program."""
        environment = dict(os.environ)
        if threads:
            environment["RAYON_NUM_THREADS"] = str(threads)
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        command = [self.binary, *map(str, arguments)]
        done = subprocess.run(command, check=True, capture_output=True, text=True, env=environment)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        cpu = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
        return {**json.loads(done.stdout), "cpu_seconds": cpu}

    def tied(self, law, press, subdivision, *more, threads=None):
        arguments = ["tied", "--law", law, "--press", press, "--subdivision", subdivision]
        return self.ours(*arguments, *more, threads=threads)

    def mesh(self, kind, *arguments):
        path = self.work / f"{kind}-{'-'.join(map(str, arguments))}.json".replace("--", "")
        if not path.exists():
            self.ours(kind, *arguments, "--mesh", path)
        return path

    def theirs(self, law, press, subdivision=None, grid=None):
        """One run of CalculiX, on our mesh or on its own grid."""
        if grid:
            mesh = calculix_press.grid(*grid)
        else:
            mesh = ccx.Mesh.of_lattice(self.mesh("tied", "--law", "linear", "--subdivision", subdivision))
        return calculix_press.solve(mesh, law, press, self.work / "press")


def brief(run):
    """The figures of a run without its points."""
    return {key: value for key, value in run.items() if key != "touched"}


def extrapolated(values):
    """Aitken's limit of a ladder of halved sizes; of two rungs that of order 1, the tied edge being singular; the
    last where the steps do not shrink one way."""
    if len(values) < 3:
        return 2 * values[-1] - values[-2]
    a, b, c = values[-3:]
    if abs(c - b) >= abs(b - a) or (c - b) * (b - a) <= 0:
        return c
    return c - (c - b) ** 2 / ((c - b) - (b - a))


def forces(programs, found, keep):
    """The ladders of the tied press."""
    for name, (law, press) in PRESSES.items():
        mine, matched, grids = RUNGS[name]
        runs = [("tirtouch", f"x{s}", lambda s=s: programs.tied(law, press, s, "--estimate")) for s in mine]
        for s in matched:
            runs.append(("CalculiX, our mesh", f"x{s}", lambda s=s: programs.theirs(law, press, subdivision=s)))
        for a, b in grids:
            runs.append(("CalculiX, own grid", f"{a} x {b}", lambda g=(a, b): programs.theirs(law, press, grid=g)))
        for program, rung, run in runs:
            known = found.setdefault(name, {}).setdefault(program, {})
            if rung not in known:
                try:
                    known[rung] = brief(run())
                except RuntimeError as error:
                    known[rung] = {"failed": str(error)}
                print(name, program, rung, known[rung], flush=True)
                keep()


SPEED = {
    "tirtouch x1": lambda p: p.tied("neo-hookean", 1.0, 1),
    "tirtouch x1, one thread": lambda p: p.tied("neo-hookean", 1.0, 1, threads=1),
    "tirtouch x2 (default)": lambda p: p.tied("neo-hookean", 1.0, 2),
    "tirtouch x2, one thread": lambda p: p.tied("neo-hookean", 1.0, 2, threads=1),
    "CalculiX, own grid 48 x 34": lambda p: p.theirs("neo-hookean", 1.0, grid=(48, 34)),
    "CalculiX, our mesh x2": lambda p: p.theirs("neo-hookean", 1.0, subdivision=2),
}


def speed(programs, found, keep, rounds):
    """Every contender once a round, the order turning."""
    found.clear()
    found["load_before"] = os.getloadavg()
    found["rounds"] = {name: [] for name in SPEED}
    for number in range(rounds):
        for name in list(SPEED)[:: 1 if number % 2 == 0 else -1]:
            found["rounds"][name].append(brief(SPEED[name](programs)))
            print(number, name, found["rounds"][name][-1], flush=True)
    found["load_after"] = os.getloadavg()
    keep()


# CalculiX's penalty in Young's moduli per mm, and the radius of the hole about the axis in elements.
PENALTIES = {
    "100 E/mm, elements on the axis": (100, 0.0),
    "30 E/mm": (30, 0.01),
    "100 E/mm": (100, 0.01),
    "1000 E/mm": (1000, 0.01),
}


def hertz(programs, found, keep):
    """The ball on meshes of 0.2, 0.1 and 0.05 mm, with CalculiX's penalty weak to stiff, its mortar contact once."""
    for nu, rung in [(nu, rung) for nu in (0.3, 0.499) for rung in (1, 2, 4)]:
        known = found.setdefault(f"{nu} | {0.2 / rung}", {})
        mine = programs.ours("hertz", "--rung", rung, "--nu", nu)
        known["tirtouch"] = {**mine, **calculix_hertz.scatter(mine["pressures"], rung, nu)}
        mesh = programs.mesh("hertz", "--rung", rung)
        for name, (stiffness, core) in PENALTIES.items():
            try:
                run = calculix_hertz.solve(mesh, rung, programs.work / "hertz", nu, stiffness, core=core)
            except (RuntimeError, subprocess.TimeoutExpired) as error:
                run = {"failed": str(error)}
            known[f"CalculiX, {name}"] = run
        keep()
    try:
        calculix_hertz.solve(programs.mesh("hertz", "--rung", 1), 1, programs.work / "hertz", mortar="MORTAR")
        found["mortar"] = "works"
    except RuntimeError:
        log = (programs.work / "hertz" / "log").read_text()
        found["mortar"] = next((" ".join(line.split()) for line in log.splitlines() if "*ERROR" in line), "fails")
    keep()


TITLES = {
    "layers": "Tied press of soft layers, 1 mm; moduli from the glass up",
    "skin": "Tied press of a layered phantom, 1 mm",
    "off-axis": "Tied press in three dimensions, 1 mm",
}


def row(*cells):
    """One of a table."""
    return "|" + "|".join(f" {cell} " if cell != "" else " " for cell in cells) + "|"


def head(*columns):
    """The rows above a table's."""
    return [row(*columns), "|" + "---|" * len(columns)]


def tables(found):
    """The figures as Markdown."""
    text = [found["machine"], ""]
    if "forces" in found:
        text += ["## Tied press: force", ""]
        text += head("press", "program", "mesh", "unknowns", "iterations", "force, N", "off the limit", "middle, kPa",
                     "processor seconds")
        for name, programs in found["forces"].items():
            limit = extrapolated([run["force_n"] for run in programs["tirtouch"].values()])
            for program, runs in programs.items():
                good = {rung: run for rung, run in runs.items() if "failed" not in run}
                for rung, run in good.items():
                    off = 100 * (run["force_n"] / limit - 1)
                    text.append(row(name, program, rung, run["dofs"], run["iterations"] or "-", f"{run['force_n']:.5f}",
                                    f"{off:+.2f} %", f"{run['middle_kpa']:.4f}", f"{run['cpu_seconds']:.2f}"))
                if len(good) > 1:
                    forces, middles = ([run[key] for run in good.values()] for key in ("force_n", "middle_kpa"))
                    force, middle = extrapolated(forces), extrapolated(middles)
                    text.append(row(name, program, "limit", "", "", f"**{force:.5f}**",
                                    f"{100 * (force / limit - 1):+.2f} %", f"{middle:.4f}", ""))
                text += [f"| {name} | {program} | {rung} | failed | | | | | |" for rung in runs if rung not in good]
        estimates = "Estimates of our own error of the force: " + "; ".join(_estimates(found["forces"])) + "."
        text += ["", textwrap.fill(estimates, 120), ""]
    if "speed" in found and "forces" in found:
        text += _speed_table(found)
    if "hertz" in found:
        text += ["## Hertz: pressure of a ball, r < 0.8 a", ""]
        text += head("nu", "element, mm", "program", "unknowns", "rms", "without the axis", "largest", "force / Hertz",
                     "seconds")
        for size, programs in found["hertz"].items():
            if size == "mortar":
                continue
            for program, run in programs.items():
                if "failed" in run:
                    text.append(f"| {size} | {program} | failed | | | | | |")
                    continue
                ratio = run["force_mn"] / run["hertz_force_mn"]
                shares = (f"{100 * run[key]:.2f} %" for key in ("rms", "rms_off_axis", "largest_off_axis"))
                text.append(row(size, program, run["dofs"], *shares, f"{ratio:.4f}", f"{run['seconds']:.2f}"))
        text += ["", f"CalculiX's mortar contact, axisymmetric: `{found['hertz']['mortar']}`.", ""]
    for part in other_presses.PARTS:
        if part in found:
            text += [f"## {TITLES[part]}", "", *other_presses.table(part, found[part])]
    return "\n".join(text)


def _estimates(forces):
    for name, programs in forces.items():
        limit = extrapolated([run["force_n"] for run in programs["tirtouch"].values()])
        for rung, run in programs["tirtouch"].items():
            if run["estimated_force_error"] is not None:
                estimated, true = 100 * run["estimated_force_error"], 100 * abs(run["force_n"] / limit - 1)
                yield f"{name} {rung} {estimated:.3f} % (true {true:.3f} %)"


def _speed_table(found):
    runs = found["speed"]["rounds"]
    ladder = found["forces"]["neo-Hookean, 1 mm"]["tirtouch"].values()
    limits = [extrapolated([run[key] for run in ladder]) for key in ("force_n", "middle_kpa")]
    times = ("seconds", "cpu_seconds")
    median = {name: [statistics.median(run[key] for run in rounds) for key in times] for name, rounds in runs.items()}
    peers = [name for name in runs if name.startswith("CalculiX")]
    before, after = (found["speed"][key][0] for key in ("load_before", "load_after"))
    count = len(runs[peers[0]])
    loads = f"load average {before:.1f} before, {after:.1f} after"
    text = ["## Speed: tied press, neo-Hookean, 1 mm", "", f"Medians of {count} alternating rounds; {loads}.", ""]
    text += head("program", "unknowns", "force off", "middle off", "seconds", "of processor",
                 *(f"faster than {p}" for p in peers))
    for name, rounds in runs.items():
        off = [abs(rounds[0][key] / limit - 1) for key, limit in zip(("force_n", "middle_kpa"), limits)]
        pairs = ([b["seconds"] / a["seconds"] for a, b in zip(rounds, runs[peer])] for peer in peers)
        ratios = [f"{statistics.median(pair):.0f}" if name not in peers else "" for pair in pairs]
        shares, seconds = (f"{100 * o:.2f} %" for o in off), (f"{s:.2f}" for s in median[name])
        text.append(row(name, rounds[0]["dofs"], *shares, *seconds, *ratios))
    return text + [""]


def main():
    p = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    p.add_argument("parts", nargs="*", help="forces, speed, hertz, layers, skin, off-axis; all where none is named")
    p.add_argument("--binary", default=HERE.parent.parent / "target/release/examples/press_peer")
    p.add_argument("--build", default="release", help="what the tables say of the binary")
    p.add_argument("--rounds", type=int, default=5)
    p.add_argument("--out", default=HERE / "results")
    a = p.parse_args()
    out = Path(a.out)
    out.mkdir(parents=True, exist_ok=True)
    path = out / "mechanics.json"
    found = json.loads(path.read_text()) if path.exists() else {}
    version = subprocess.run(["ccx", "-v"], capture_output=True, text=True).stdout.split()[-1]
    cores = os.cpu_count()
    found["machine"] = f"CalculiX {version} with one thread; tirtouch built as `{a.build}`; {cores} processors."

    def keep():
        path.write_text(json.dumps(found))

    with tempfile.TemporaryDirectory() as work:
        programs = Programs(a.binary, work)
        for part in a.parts or ["forces", "speed", "hertz", *other_presses.PARTS]:
            section = found.setdefault(part, {})
            if part == "speed":
                speed(programs, section, keep, a.rounds)
            elif part in other_presses.PARTS:
                other_presses.run(programs, part, section, keep)
            else:
                {"forces": forces, "hertz": hertz}[part](programs, section, keep)
    keep()
    (out / "mechanics.md").write_text(tables(found))
    print(tables(found))
    failures = [line for part in other_presses.PARTS for line in other_presses.failures(part, found.get(part, {}))]
    if failures:
        sys.exit("Presses that differ, or faults that do not show:\n" + "\n".join(failures))


if __name__ == "__main__":
    main()
