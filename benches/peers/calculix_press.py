#!/usr/bin/env python3
"""A rigid plate tied to a soft phantom with a stiff ball in it, pressed down, by CalculiX. Prints one line of JSON.

    python calculix_press.py --nx 48 --nz 34 --law neo-hookean --press 1
    python calculix_press.py --mesh mesh.json          # the mesh that `press_peer tied --mesh mesh.json` wrote
    python calculix_press.py --mesh mesh.json --layers 5,5,5    # of `press_peer tied --layers 5,5,5`

Axisymmetric, or the half y >= 0 of a mesh of bricks; mm and kPa, hence mN. Phantom radius 30, height 25, bonded to a
rigid base, free side; plate radius 15 tied to its face; a ball of 8 mm whose top lies 5 deep; 5 kPa and 120 kPa; nu
0.499, as CAX8R and C3D20R have no exact limit. On the own grid (--nx, --nz) the ball's outline is stair-stepped by
element centroids; the given mesh follows it.
"""

import argparse
import json

import numpy as np

import calculix_deck as ccx

RADIUS, HEIGHT, PLATE, BALL, TOP_DEPTH = 30.0, 25.0, 15.0, 4.0, 5.0
YOUNG_KPA = {"TISSUE": 5.0, "BALL": 120.0}
NU = 0.499
# Reach of the weight 1 - (r / reach)^2 under which the pressure in the middle is averaged. Nodal forces times a weight
# of the elements' own functions are the work of the pressure on it, so the mean is as good as the force.
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


def solve(mesh, law, press, folder, increment=None, threads=1, layers=None, skin=None):
    """Presses; figures with the total force (N), and the tied face's nodes: their places across, forces (mN), areas.

    Axisymmetric or, of bricks, the half y >= 0. `layers`: moduli of a soft sensor's (kPa, the one on the glass first),
    whose nodes on the face lie on the phantom's and are tied to them one by one.
    """
    young = {**YOUNG_KPA, **({"SKIN": skin} if skin else {})}
    of_phantom = len(young)
    young |= {f"LAYER{k}": value for k, value in enumerate(layers or [])}
    up, across, height = mesh.dim, np.linalg.norm(mesh.nodes[:, :-1], axis=1), mesh.nodes[:, -1]
    of_sensor = np.zeros(len(mesh.nodes), bool)
    of_sensor[mesh.elements[mesh.region >= of_phantom]] = True
    on_face = (np.abs(height) < 1e-9) & (across <= PLATE + 1e-7)
    face = np.flatnonzero(on_face & ~of_sensor)
    # The axis (axisymmetric) keeps r, the plane of symmetry y.
    kept, keeps = np.abs(mesh.nodes[:, up - 2]) < 1e-9, up - 1
    deck = mesh.deck(young)
    deck += mesh.numbered_set("BASE", np.flatnonzero(np.abs(height - HEIGHT) < 1e-7))
    deck += mesh.numbered_set("KEPT", np.flatnonzero(kept))
    deck += mesh.numbered_set("FACE", face)
    deck += "".join(ccx.material(region, law, value, NU) for region, value in young.items())
    if layers:
        deck += mesh.numbered_set("GLASS", np.flatnonzero(np.abs(height - height.min()) < 1e-7))
        deck += _ties(mesh.nodes, face, np.flatnonzero(on_face & of_sensor), kept, keeps)
    deck += f"*BOUNDARY\n{'GLASS' if layers else 'FACE'},1,{up}\nKEPT,{keeps},{keeps}\nBASE,1,{up - 1}\n"
    if law == "linear":
        deck += "*STEP\n*STATIC\n"
    else:
        deck += f"*STEP,NLGEOM,INC=1000\n*STATIC\n{increment or (0.25 if press > 1.5 else 1.0)},1.\n"
    deck += f"*BOUNDARY\nBASE,{up},{up},{-press}\n*NODE PRINT,NSET=FACE\nRF\n*END STEP\n"
    figures, printed = ccx.run("press", deck, folder, threads)
    text = printed.split("forces")[-1].splitlines()[1:]
    rows = np.array([[float(x) for x in line.split()] for line in text if line.strip()])
    face = rows[:, 0].astype(int) - 1
    places, copies = mesh.nodes[face, :-1], ccx.SLICES if up == 2 else 2
    force = rows[:, up] * (copies if up == 2 else 1)
    area = areas(places[:, 0]) if up == 2 else mesh.face_areas(face)
    return {
        "dofs": up * len(mesh.nodes),
        "elements": len(mesh.elements),
        **figures,
        "force_n": float(np.sum(rows[:, up])) * copies / 1000,
        "middle_kpa": float(mean_pressure(places, force, area, np.zeros(up - 1), MIDDLE)),
        "touched": [[list(place), *pair] for place, *pair in zip(places, force, area)],
    }


def _ties(nodes, face, other, kept, keeps):
    """*EQUATION of equal displacements of the nodes of two faces that lie on each other."""
    near = np.linalg.norm(nodes[face][:, None] - nodes[other][None], axis=2).argmin(axis=1)
    assert np.allclose(nodes[face], nodes[other[near]], atol=1e-9) and len(face) == len(other)
    axes = range(1, nodes.shape[1] + 1)
    pairs = ((a, b, axis) for a, b in zip(face, other[near]) for axis in axes if not (kept[a] and axis == keeps))
    return "*EQUATION\n" + "".join(f"2\n{a + 1},{axis},1.,{b + 1},{axis},-1.\n" for a, b, axis in pairs)


def mean_pressure(places, force, area, center, reach):
    """Mean pressure (kPa) under the weight 1 - (d / reach)^2, d the distance from a centre: a disc, or a ring of r."""
    weight = np.maximum(0.0, 1 - (np.linalg.norm(places - center, axis=1) / reach) ** 2)
    return np.sum(force * weight) / np.sum(area * weight)


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
    p.add_argument("--layers", help="Young's moduli of a soft sensor, kPa, from the glass up; with --mesh")
    p.add_argument("--law", choices=["linear", "neo-hookean"], default="neo-hookean")
    p.add_argument("--press", type=float, default=1.0, help="plate displacement, mm")
    p.add_argument("--increment", type=float, help="first increment, a share of the press")
    p.add_argument("--out", default="calculix-press")
    a = p.parse_args()
    mesh = ccx.Mesh.of_lattice(a.mesh) if a.mesh else grid(a.nx, a.nz)
    layers = [float(young) for young in a.layers.split(",")] if a.layers else None
    print(json.dumps(solve(mesh, a.law, a.press, a.out, a.increment, layers=layers)))


if __name__ == "__main__":
    main()
