"""Input decks of CalculiX: meshes, node sets, materials, and one timed run of `ccx` (Debian: calculix-ccx)."""

import itertools
import json
import os
import re
import shutil
import subprocess
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np

# Nodes of CAX8R and C3D20R in the lattices of 9 and 27: corners anticlockwise, below and above, then middles of edges.
LATTICE = {
    9: [0, 2, 8, 6, 1, 5, 7, 3],
    27: [0, 2, 8, 6, 18, 20, 26, 24, 1, 5, 7, 3, 19, 23, 25, 21, 9, 11, 17, 15],
}
# Places in C3D20R of each face's nodes, as LATTICE[9] has them.
FACES = [
    [0, 1, 2, 3, 8, 9, 10, 11],
    [4, 5, 6, 7, 12, 13, 14, 15],
    [0, 1, 5, 4, 8, 17, 12, 16],
    [1, 2, 6, 5, 9, 18, 13, 17],
    [2, 3, 7, 6, 10, 19, 14, 18],
    [3, 0, 4, 7, 11, 16, 15, 19],
]
# CalculiX makes a slice of this angle of an axisymmetric body and prints forces on the slice.
SLICES = 180


@dataclass
class Mesh:
    """Axisymmetric quadrilaterals of 8 nodes or bricks of 20: nodes (r, z) or (x, y, z) in mm, elements (from 0), their
    regions."""

    nodes: np.ndarray
    elements: np.ndarray
    region: np.ndarray

    @staticmethod
    def of_lattice(path):
        """The mesh of 9- or 27-node elements that `press_peer --mesh` writes, without the middle nodes."""
        read = json.loads(Path(path).read_text())
        lattice = np.array(read["elements"])
        elements = lattice[:, LATTICE[lattice.shape[1]]]
        used, places = np.unique(elements, return_inverse=True)
        return Mesh(np.array(read["nodes"])[used], places.reshape(elements.shape), np.array(read["region"]))

    @property
    def dim(self):
        return self.nodes.shape[1]

    def deck(self, regions):
        """*NODE and one *ELEMENT block per named region."""
        text = "*NODE,NSET=NALL\n"
        for k, place in enumerate(self.nodes):
            text += f"{k + 1}," + ",".join(f"{x:.12g}" for x in place) + (",0.\n" if self.dim == 2 else "\n")
        for number, name in enumerate(regions):
            text += f"*ELEMENT,TYPE={'CAX8R' if self.dim == 2 else 'C3D20R'},ELSET={name}\n"
            for k in np.flatnonzero(self.region == number):
                # A line holds at most 16 numbers.
                numbers = [str(n + 1) for n in (k, *self.elements[k])]
                text += ",\n".join(",".join(numbers[i : i + 16]) for i in range(0, len(numbers), 16)) + "\n"
        return text

    def node_set(self, name, keep):
        """*NSET of the nodes where keep(r, z), or keep(x, y, z)."""
        return self.numbered_set(name, np.flatnonzero(keep(*self.nodes.T)))

    @staticmethod
    def numbered_set(name, chosen):
        """*NSET of nodes by their numbers from 0."""
        lines = (",".join(str(n + 1) for n in chosen[k : k + 10]) for k in range(0, len(chosen), 10))
        return f"*NSET,NSET={name}\n" + "".join(line + ",\n" for line in lines)

    def face_areas(self, chosen):
        """Of bricks: integrals of the nodes' functions over a face in a plane z, mm^2: forces of a unit pressure."""
        inside = np.zeros(len(self.nodes), bool)
        inside[chosen] = True
        faces = np.concatenate([self.elements[:, face] for face in FACES])
        faces = faces[inside[faces].all(axis=1)]
        points, weights = np.polynomial.legendre.leggauss(3)
        areas = np.zeros(len(self.nodes))
        for (u, wu), (v, wv) in itertools.product(zip(points, weights), repeat=2):
            shape, along = _serendipity(u, v)
            tangents = np.einsum("dk,fkc->fdc", along, self.nodes[faces, :2])
            area = wu * wv * np.abs(np.linalg.det(tangents))
            np.add.at(areas, faces, area[:, None] * shape)
        return areas[chosen]


def _serendipity(u, v):
    """Functions of the 8-node square, corners first, and their derivatives by u and v."""
    shape, along = np.empty(8), np.empty((2, 8))
    for k, (a, b) in enumerate([(-1, -1), (1, -1), (1, 1), (-1, 1)]):
        shape[k] = (1 + a * u) * (1 + b * v) * (a * u + b * v - 1) / 4
        along[:, k] = a * (1 + b * v) * (2 * a * u + b * v) / 4, b * (1 + a * u) * (a * u + 2 * b * v) / 4
    for k, (a, b) in enumerate([(0, -1), (1, 0), (0, 1), (-1, 0)], start=4):
        if a == 0:
            shape[k], along[:, k] = (1 - u * u) * (1 + b * v) / 2, (-u * (1 + b * v), b * (1 - u * u) / 2)
        else:
            shape[k], along[:, k] = (1 - v * v) * (1 + a * u) / 2, (a * (1 - v * v) / 2, -v * (1 + a * u))
    return shape, along


def material(region, law, young_kpa, nu):
    """*MATERIAL and *SOLID SECTION of a region. Neo-Hookean: W = C10 (I1bar - 3) + (J - 1)^2 / D1, D1 = 2 / K."""
    text = f"*MATERIAL,NAME=M{region}\n"
    if law == "linear":
        text += f"*ELASTIC\n{young_kpa},{nu}\n"
    else:
        mu, bulk = young_kpa / (2 * (1 + nu)), young_kpa / (3 * (1 - 2 * nu))
        text += f"*HYPERELASTIC,NEO HOOKE\n{mu / 2:.12g},{2 / bulk:.12g}\n"
    return text + f"*SOLID SECTION,ELSET={region},MATERIAL=M{region}\n"


def run(name, deck, folder, threads=1):
    """Runs a deck; its figures and the printed results. Raises RuntimeError where CalculiX did not reach the end."""
    folder = Path(folder)
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    (folder / f"{name}.inp").write_text(deck)
    environment = {**os.environ, "OMP_NUM_THREADS": str(threads)}
    log_path = folder / "log"
    start = time.perf_counter()
    with open(log_path, "w") as log:
        process = subprocess.Popen(["ccx", name], cwd=folder, stdout=log, stderr=subprocess.STDOUT, env=environment)
        _, status, usage = os.wait4(process.pid, 0)
    seconds = time.perf_counter() - start
    process.returncode = os.waitstatus_to_exitcode(status)
    log = log_path.read_text()
    if process.returncode != 0 or "Job finished" not in log or "*ERROR" in log:
        raise RuntimeError(f"ccx failed: {' / '.join(log.splitlines()[-6:])}")
    figures = {
        "seconds": seconds,
        "cpu_seconds": usage.ru_utime + usage.ru_stime,
        "iterations": len(re.findall(r"^ *iteration +\d+", log, re.M)),
        "peak_mib": usage.ru_maxrss / 1024,
    }
    return figures, (folder / f"{name}.dat").read_text()
