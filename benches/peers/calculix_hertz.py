#!/usr/bin/env python3
"""A rigid ball on an elastic block by the penalty contact of CalculiX: how far is its pressure from Hertz's?

    python calculix_hertz.py --mesh mesh.json --rung 2

The mesh is that which `press_peer hertz --rung 2 --mesh mesh.json` wrote. The same block, mesh and depth as ours; the
ball is a cap of elements all of whose nodes are held. Frictionless, surface to surface, pressure = stiffness times
overlap. Prints one line of JSON with nodal pressures (kPa at E = 1 kPa).
"""

import argparse
import json
from pathlib import Path

import numpy as np

import calculix_deck as ccx

BALL, FAR, REACH = 400.0, 1200.0, 1.4
# A modulus of 1 MPa instead of 1 kPa keeps CalculiX's printed digits; pressures are divided by it.
YOUNG = 1000.0


def cap(size):
    """The ball's lower part as a mesh: three rows below its surface, edges that do not match the block's."""
    columns = int(np.ceil(1.25 * REACH / size)) + 1
    r = np.linspace(0, 1.25 * REACH, 2 * columns + 1)
    depth = np.linspace(-0.5, 0, 7)
    i, j = np.meshgrid(2 * np.arange(columns), 2 * np.arange(3))
    around = [(0, 0), (2, 0), (2, 2), (0, 2), (1, 0), (2, 1), (1, 2), (0, 1)]
    lattice = np.stack([(i + a) + (2 * columns + 1) * (j + b) for a, b in around], axis=-1).reshape(-1, 8)
    used, elements = np.unique(lattice, return_inverse=True)
    x = r[used % (2 * columns + 1)]
    z = depth[used // (2 * columns + 1)] - (BALL - np.sqrt(BALL**2 - x**2))
    return ccx.Mesh(np.stack([x, z], axis=1), elements.reshape(-1, 8), np.ones(len(elements.reshape(-1, 8)), int))


def deck_of(block, size, nu, stiffness, mortar, increment, core):
    """The input deck; the block's nodes and elements come first."""
    ball = cap(size)
    count = len(block.nodes)
    for body in (block, ball):
        body.nodes[:, 0] = np.maximum(body.nodes[:, 0], core * size)
    both = ccx.Mesh(
        np.concatenate([block.nodes, ball.nodes]),
        np.concatenate([block.elements, ball.elements + count]),
        np.concatenate([block.region, ball.region]),
    )
    deck = both.deck(["BLOCK", "CAP"])
    on_face = np.all(np.abs(block.nodes[block.elements[:, :2], 1]) < 1e-9, axis=1)
    touched = np.flatnonzero(on_face & np.all(block.nodes[block.elements[:, :2], 0] <= REACH * (1 + 1e-9), axis=1)) + 1
    top = np.arange(len(ball.elements) * 2 // 3, len(ball.elements)) + len(block.elements) + 1
    deck += "*SURFACE,NAME=FACE,TYPE=ELEMENT\n" + "".join(f"{e},S1\n" for e in touched)
    deck += "*SURFACE,NAME=TIP,TYPE=ELEMENT\n" + "".join(f"{e},S3\n" for e in top)
    numbers = np.arange(len(both.nodes))
    deck += both.node_set("HELD", lambda r, z: numbers >= count)
    deck += both.node_set("AXIS", lambda r, z: (np.abs(r) < (core + 1e-6) * size) & (numbers < count))
    deck += both.node_set("BASE", lambda r, z: (np.abs(z - FAR) < 1e-6) & (numbers < count))
    deck += ccx.material("BLOCK", "linear", YOUNG, nu) + ccx.material("CAP", "linear", 1000 * YOUNG, 0.3)
    deck += "*SURFACE INTERACTION,NAME=TOUCH\n*SURFACE BEHAVIOR,PRESSURE-OVERCLOSURE=LINEAR\n"
    deck += f"{stiffness * YOUNG}\n"
    kind = mortar or "SURFACE TO SURFACE"
    deck += f"*CONTACT PAIR,INTERACTION=TOUCH,TYPE={kind}\nFACE,TIP\n"
    deck += "*BOUNDARY\nHELD,1,2\nAXIS,1,1\nBASE,1,1\n"
    deck += f"*STEP,INC=1000\n*STATIC\n{increment},1.\n*BOUNDARY\nBASE,2,2,{-1 / BALL}\n"
    deck += "*NODE PRINT,NSET=BASE,TOTALS=ONLY\nRF\n*CONTACT PRINT\nCSTR\n*CONTACT FILE\nCDIS,CSTR\n*END STEP\n"
    return deck


def pressures(folder):
    """Rows (r, pressure in kPa at E = 1 kPa) of the block's touched nodes, outwards, from the result file."""
    at, found, block = {}, {}, None
    for line in (folder / "hertz.frd").read_text().splitlines():
        if line[:5] in ("    2", "    3", " -4  "):
            block = {"    2": "NODES", "    3": "ELEMENTS"}.get(line[:5]) or line.split()[1]
        if line[:3] == " -1" and block in ("NODES", "CONTACT"):
            values = [float(line[13 + 12 * k : 25 + 12 * k]) for k in range((len(line) - 13) // 12)]
            if block == "NODES":
                at[int(line[3:13])] = values
            else:
                found[int(line[3:13])] = values[3]
    # An axisymmetric body is written as its slice: x and z across, y along the axis. The cap's nodes bear no pressure.
    rows = {}
    for number, pressure in found.items():
        x, y, z = at[number]
        if abs(y) < 1e-9 and np.hypot(x, z) < REACH:
            rows.setdefault(round(np.hypot(x, z), 4), []).append(pressure / YOUNG)
    return sorted((r, max(several, key=abs)) for r, several in rows.items())


def scatter(rows, rung, nu=0.3):
    """Difference to p0 sqrt(1 - r^2) for r < 0.8 (the contact's radius is 1 mm) as shares of p0: rms over the area with
    and without the element at the axis, where the slice ends in a wedge, and the largest without."""
    r, pressure = np.array([row for row in rows if row[0] < 0.8 - 1e-6]).T
    off = pressure / (2 / (1 - nu * nu) / (np.pi * BALL)) - np.sqrt(1 - r * r)
    beyond = r > 0.2 / rung + 1e-6

    def rms(chosen):
        return float(np.sqrt(np.sum(r[chosen] * off[chosen] ** 2) / np.sum(r[chosen])))

    return {"rms": rms(r >= 0), "rms_off_axis": rms(beyond), "largest_off_axis": float(np.max(np.abs(off[beyond])))}


def solve(mesh, rung, folder, nu=0.3, stiffness=100.0, mortar=None, increment=1.0, core=0.01):
    """Presses the ball in; figures with force (mN), pressures (kPa) and their scatter, for E = 1 kPa."""
    block = ccx.Mesh.of_lattice(mesh)
    deck = deck_of(block, 0.2 / rung, nu, stiffness, mortar, increment, core)
    figures, printed = ccx.run("hertz", deck, folder)
    total = printed.split("total force")[1].splitlines()[1:]
    force = -float(next(line for line in total if line.strip()).split()[1]) * ccx.SLICES / YOUNG
    rows = pressures(Path(folder))
    return {
        "dofs": 2 * len(block.nodes),
        **figures,
        "stiffness_per_mm": stiffness,
        "force_mn": force,
        "hertz_force_mn": 4 / 3 / (1 - nu * nu) / BALL,
        **scatter(rows, rung, nu),
        "pressures": rows,
    }


def main():
    p = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    p.add_argument("--mesh", required=True)
    p.add_argument("--rung", type=int, default=2)
    p.add_argument("--nu", type=float, default=0.3)
    p.add_argument("--stiffness", type=float, default=100.0, help="penalty over Young's modulus, per mm")
    p.add_argument("--mortar", help="MORTAR, LINMORTAR or PGLINMORTAR instead of the penalty")
    p.add_argument("--core", type=float, default=0.01, help="radius of the hole on the axis, in elements; 0: none")
    p.add_argument("--increment", type=float, default=1.0)
    p.add_argument("--out", default="calculix-hertz")
    a = p.parse_args()
    print(json.dumps(solve(a.mesh, a.rung, a.out, a.nu, a.stiffness, a.mortar, a.increment, a.core)))


if __name__ == "__main__":
    main()
