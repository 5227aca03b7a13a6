#!/usr/bin/env python3
"""A rigid plate tied to a soft phantom with a stiff ball in it, pressed down, by CalculiX. Prints one line of JSON.

    python calculix_press.py --nx 48 --nz 34 --law neo-hookean --press 1
    python calculix_press.py --mesh mesh.json          # the mesh that `press_peer tied --mesh mesh.json` wrote

Axisymmetric, mm and kPa, hence mN. Phantom radius 30, height 25, bonded to a rigid base, free side; plate radius 15 tied to
its face; a ball of 8 mm whose top lies 5 deep; 5 kPa and 120 kPa; nu 0.499, as CAX8R has no exact limit. On the own grid
(--nx, --nz) the ball's outline is stair-stepped by element centroids; the given mesh follows it.
"""

import argparse
import json

import numpy as np

import calculix_deck as ccx

RADIUS, HEIGHT, PLATE, BALL, TOP_DEPTH = 30.0, 25.0, 15.0, 4.0, 5.0
YOUNG_KPA = {"TISSUE": 5.0, "BALL": 120.0}
NU = 0.499
# Reach of the weight 1 - (r / reach)^2 under which the pressure in the middle is averaged. Nodal forces times a weight of the
# elements' own functions are the work of the pressure on it, so the mean is as good as the force.
MIDDLE = 2.5


def grid(nx, nz):
    """The peer's own mesh: even out to the plate's edge, then growing; finer towards the touched face."""
    inner = nx * 3 // 4
    outside = PLATE + (RADIUS - PLATE) * np.linspace(0, 1, nx - inner + 1)[1:] ** 1.3
    x = _with_midpoints(np.concatenate([np.linspace(0, PLATE, inner + 1), outside]))
    z = _with_midpoints(HEIGHT * np.linspace(0, 1, nz + 1) ** 1.25)
    i, j = np.meshgrid(2 * np.arange(nx), 2 * np.arange(nz))
    around = [(0, 0), (2, 0), (2, 2), (0, 2), (1, 0), (2, 1), (1, 2), (0, 1)]
    lattice = np.stack([(i + a) + (2 * nx + 1) * (j + b) for a, b in around], axis=-1).reshape(-1, 8)
    used, elements = np.unique(lattice, return_inverse=True)
    nodes = np.stack([x[used % (2 * nx + 1)], z[used // (2 * nx + 1)]], axis=1)
    middle = np.stack([x[i + 1], z[j + 1]], axis=-1).reshape(-1, 2)
    in_ball = middle[:, 0] ** 2 + (middle[:, 1] - TOP_DEPTH - BALL) ** 2 < BALL**2
    return ccx.Mesh(nodes, elements.reshape(-1, 8), in_ball.astype(int))


def _with_midpoints(breaks):
    out = np.empty(2 * len(breaks) - 1)
    out[::2], out[1::2] = breaks, (breaks[1:] + breaks[:-1]) / 2
    return out


def solve(mesh, law, press, folder, increment=None, threads=1):
    """Presses; figures with the total force (N) and the pressure in the middle (kPa)."""
    deck = mesh.deck(YOUNG_KPA)
    deck += mesh.node_set("BASE", lambda r, z: np.abs(z - HEIGHT) < 1e-7)
    deck += mesh.node_set("AXIS", lambda r, z: np.abs(r) < 1e-9)
    deck += mesh.node_set("FACE", lambda r, z: (np.abs(z) < 1e-9) & (r <= PLATE + 1e-7))
    deck += "".join(ccx.material(region, law, young, NU) for region, young in YOUNG_KPA.items())
    deck += "*BOUNDARY\nFACE,1,2\nAXIS,1,1\nBASE,1,1\n"
    if law == "linear":
        deck += "*STEP\n*STATIC\n"
    else:
        deck += f"*STEP,NLGEOM,INC=1000\n*STATIC\n{increment or (0.25 if press > 1.5 else 1.0)},1.\n"
    deck += f"*BOUNDARY\nBASE,2,2,{-press}\n*NODE PRINT,NSET=FACE\nRF\n*END STEP\n"
    figures, printed = ccx.run("press", deck, folder, threads)
    rows = np.array([[float(x) for x in line.split()] for line in printed.split("forces")[-1].splitlines()[1:] if line.strip()])
    r = mesh.nodes[rows[:, 0].astype(int) - 1, 0]
    force = rows[:, 2] * ccx.SLICES
    weight, area = np.maximum(0.0, 1 - (r / MIDDLE) ** 2), areas(r)
    return {
        "dofs": 2 * len(mesh.nodes),
        "elements": len(mesh.elements),
        **figures,
        "force_n": float(np.sum(force)) / 1000,
        "middle_kpa": float(np.sum(force * weight) / np.sum(area * weight)),
    }


def areas(r):
    """Integrals of the quadratic functions of the nodes at r over the face, mm^2: nodal forces of a unit pressure."""
    order = np.argsort(r)
    ends = r[order]
    found = np.zeros(len(r))
    points, weights = np.polynomial.legendre.leggauss(3)
    shapes = np.stack([points * (points - 1) / 2, 1 - points**2, points * (points + 1) / 2])
    for k in range(0, len(r) - 2, 2):
        a, b = ends[k], ends[k + 2]
        found[order[k : k + 3]] += shapes @ (weights * np.pi * (a + b + points * (b - a)) * (b - a) / 2)
    return found


def main():
    p = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    p.add_argument("--nx", type=int, default=48)
    p.add_argument("--nz", type=int, default=34)
    p.add_argument("--mesh", help="a mesh from press_peer instead of the own grid")
    p.add_argument("--law", choices=["linear", "neo-hookean"], default="neo-hookean")
    p.add_argument("--press", type=float, default=1.0, help="plate displacement, mm")
    p.add_argument("--increment", type=float, help="first increment, a share of the press")
    p.add_argument("--out", default="calculix-press")
    a = p.parse_args()
    mesh = ccx.Mesh.of_lattice(a.mesh) if a.mesh else grid(a.nx, a.nz)
    print(json.dumps(solve(mesh, a.law, a.press, a.out, a.increment)))


if __name__ == "__main__":
    main()
