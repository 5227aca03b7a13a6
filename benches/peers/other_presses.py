"""Presses of other sensors and places, by both programs: soft layers, and a ball beside the axis in three dimensions.

Each case runs on a ladder of meshes that both programs share. Asked is that the limits of the force agree within
FORCE, and on the finest shared mesh the pressures over 0.8 of the plate's radius within PRESSURE, rms. A case's faults
change the press in ours alone: what they must show is that the same test turns red.
"""

from dataclasses import dataclass, field

import numpy as np

import calculix_deck as ccx
import calculix_press

FORCE, PRESSURE = 0.005, 0.01
JUDGED = 0.8 * calculix_press.PLATE
# Pressures are means under the weight 1 - (d / REACH)^2 about centres STEP apart, mm: single nodes' values are noisy.
REACH, STEP = 2.0, 1.0


@dataclass
class Case:
    """A press of 1 mm: options of `press_peer tied`, subdivisions in both programs; faults are ours alone."""

    law: str
    options: list
    rungs: tuple
    layers: list = None
    skin: float = None
    faults: dict = field(default_factory=dict)


def _layered(law, rungs, young, **faults):
    moduli = [f"--layers={','.join(map(str, layers))}" for layers in (young, *faults.values())]
    named = {name.replace("_", " "): [option] for name, option in zip(faults, moduli[1:])}
    return Case(law, moduli[:1], rungs, layers=young, faults=named)


PARTS = {
    # Moduli from the glass up.
    "layers": {
        "5 / 5 / 5 kPa, linear": _layered("linear", (1, 2, 4), [5, 5, 5], lowest_layer_5_percent_stiffer=[5.25, 5, 5]),
        "4 / 8 / 120 kPa, linear": _layered(
            "linear",
            (1, 2, 4),
            [4, 8, 120],
            lowest_layer_5_percent_stiffer=[4.2, 8, 120],
            layers_upside_down=[120, 8, 4],
        ),
        "100 / 20 / 200 kPa, linear": _layered(
            "linear", (1, 2, 4), [100, 20, 200], middle_layer_half_as_stiff=[100, 10, 200]
        ),
        "5 / 5 / 5 kPa, neo-Hookean": _layered(
            "neo-hookean", (1, 2), [5, 5, 5], lowest_layer_5_percent_stiffer=[5.25, 5, 5]
        ),
        "4 / 8 / 120 kPa, neo-Hookean": _layered(
            "neo-hookean", (1, 2), [4, 8, 120], lowest_layer_5_percent_stiffer=[4.2, 8, 120]
        ),
    },
    # A layer of the phantom: thickness, mm, and modulus, kPa.
    "skin": {
        f"2 mm of 60 kPa, {law}": Case(
            law,
            ["--skin=2,60"],
            rungs,
            skin=60.0,
            faults={"skin a tenth stiffer": ["--skin=2,66"], "skin a tenth thicker": ["--skin=2.2,60"]},
        )
        for law, rungs in (("linear", (1, 2, 4)), ("neo-hookean", (1, 2)))
    },
    "off-axis": {
        "ball 5 mm beside the axis, linear": Case(
            "linear", ["--off-axis=5"], (1, 2, 3), faults={"ball 0.5 mm further out": ["--off-axis=5.5"]}
        ),
    },
}


def run(programs, part, found, keep):
    """Every rung of every case of a part: ours, ours with each fault, CalculiX. What is known is kept."""
    for name, case in PARTS[part].items():
        runs = {"tirtouch": case.options, **case.faults}
        for rung in case.rungs:
            known = found.setdefault(name, {}).setdefault(str(rung), {})
            for program, options in runs.items():
                if program not in known:
                    known[program] = programs.tied(case.law, 1.0, rung, *options)
            if "CalculiX" not in known:
                path = programs.mesh("tied", "--law", "linear", "--subdivision", rung, *case.options)
                mesh = ccx.Mesh.of_lattice(path)
                folder = programs.work / "press"
                known["CalculiX"] = calculix_press.solve(
                    mesh, case.law, 1.0, folder, layers=case.layers, skin=case.skin
                )
            for program, figures in known.items():
                if "touched" in figures:
                    figures["pressures_kpa"] = _pressures(figures.pop("touched"))
            print(name, rung, {program: figures["force_n"] for program, figures in known.items()}, flush=True)
            keep()


def _pressures(touched):
    """Mean pressures about the centres, whose discs or rings lie within the judged part."""
    places, force, area = (np.array(column) for column in zip(*touched))
    at = np.arange(0, JUDGED - REACH + 1e-9, STEP)
    centers = at[:, None]
    if places.shape[1] == 2:
        x, y = np.meshgrid(np.concatenate([-at[:0:-1], at]), at)
        centers = np.stack([x.ravel(), y.ravel()], axis=1)
        centers = centers[np.linalg.norm(centers, axis=1) <= JUDGED - REACH + 1e-9]
    return [calculix_press.mean_pressure(places, force, area, center, REACH) for center in centers]


def order(rungs, values):
    """Order p of the last three values, which fit limit + constant / rung^p; 1 where there are fewer, the tied edge
    being singular, or where they fit none from 0.3 to 4."""
    if len(values) < 3:
        return 1.0
    (s, t, u), (a, b, c) = rungs[-3:], values[-3:]
    orders = np.linspace(0.3, 4, 3701)
    ratios = (s**-orders - t**-orders) / (t**-orders - u**-orders)
    asked = (a - b) / (b - c)
    return float(orders[np.abs(ratios - asked).argmin()]) if ratios[0] <= asked <= ratios[-1] else 1.0


def limit(rungs, values, p):
    """The value on elements of no size."""
    (t, u), (b, c) = rungs[-2:], values[-2:]
    return c + (c - b) / ((u / t) ** p - 1)


def judged(part, found):
    """Rows of a part: press, program, forces on each mesh, order, limit; of ours also how far force and pressure are
    off CalculiX's (rms, and the largest over the highest pressure), and whether that is as little as asked."""
    for name, case in PARTS[part].items():
        runs = [(rung, found[name][str(rung)]) for rung in case.rungs if str(rung) in found.get(name, {})]
        runs = [(rung, known) for rung, known in runs if "CalculiX" in known]
        if not runs:
            continue
        rungs, finest = [rung for rung, _ in runs], runs[-1][1]
        peer, ends = np.array(finest["CalculiX"]["pressures_kpa"]), {}
        for program in ["CalculiX", "tirtouch", *case.faults]:
            forces = [known[program]["force_n"] for _, known in runs]
            p = order(rungs, forces)
            ends[program] = limit(rungs, forces, p)
            row = {"press": name, "program": program, "forces": forces, "order": p, "limit": ends[program]}
            if program != "CalculiX":
                apart = np.array(finest[program]["pressures_kpa"]) - peer
                row["force_off"] = ends[program] / ends["CalculiX"] - 1
                row["rms"] = np.sqrt(np.mean(apart**2) / np.mean(peer**2))
                row["largest"] = np.max(np.abs(apart)) / np.max(peer)
                row["agrees"] = bool(abs(row["force_off"]) < FORCE and row["rms"] < PRESSURE)
            yield row


def table(part, found):
    """The figures of a part as Markdown."""
    text = ["| press | program | force on each mesh, N | order | limit, N | force off | pressure, rms | largest | |"]
    text += ["|" + "---|" * 9]
    for row in judged(part, found):
        program = row["program"] if row["program"] in ("CalculiX", "tirtouch") else f"tirtouch, {row['program']}"
        forces = ", ".join(f"{force:.5f}" for force in row["forces"])
        line = f"| {row['press']} | {program} | {forces} | {row['order']:.2f} | {row['limit']:.5f} |"
        if "agrees" in row:
            line += f" {100 * row['force_off']:+.2f} % | {100 * row['rms']:.2f} % | {100 * row['largest']:.2f} % |"
            line += " agrees |" if row["agrees"] else " **differs** |"
        else:
            line += " | | | |"
        text.append(line)
    return text + [""]


def failures(part, found):
    """Presses that differ, and faults that do not show."""
    rows = [row for row in judged(part, found) if "agrees" in row]
    return [f"{row['press']}: {row['program']}" for row in rows if row["agrees"] != (row["program"] == "tirtouch")]
