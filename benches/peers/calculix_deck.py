"""Input decks of CalculiX: meshes, node sets, materials, and one timed run of `ccx` (Debian: calculix-ccx)."""

import json
import os
import re
import shutil
import subprocess
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np

# CalculiX makes a slice of this angle of an axisymmetric body and prints forces on the slice.
SLICES = 180


@dataclass
class Mesh:
    """Axisymmetric quadrilaterals of 8 nodes: nodes (r, z) in mm, elements (from 0), region of each element."""

    nodes: np.ndarray
    elements: np.ndarray
    region: np.ndarray

    @staticmethod
    def of_lattice(path):
        """The mesh of 9-node quadrilaterals that `press_peer --mesh` writes, without the middle nodes."""
        read = json.loads(Path(path).read_text())
        # Corners anticlockwise, then the middles of the edges.
        elements = np.array(read["elements"])[:, [0, 2, 8, 6, 1, 5, 7, 3]]
        used, elements = np.unique(elements, return_inverse=True)
        return Mesh(np.array(read["nodes"])[used], elements.reshape(-1, 8), np.array(read["region"]))

    def deck(self, regions):
        """*NODE and one *ELEMENT block per named region."""
        text = "*NODE,NSET=NALL\n" + "".join(f"{k + 1},{r:.12g},{z:.12g},0.\n" for k, (r, z) in enumerate(self.nodes))
        for number, name in enumerate(regions):
            text += f"*ELEMENT,TYPE=CAX8R,ELSET={name}\n"
            chosen = np.flatnonzero(self.region == number)
            text += "".join(f"{k + 1}," + ",".join(str(a + 1) for a in self.elements[k]) + "\n" for k in chosen)
        return text

    def node_set(self, name, keep):
        """*NSET of the nodes where keep(r, z)."""
        chosen = np.flatnonzero(keep(self.nodes[:, 0], self.nodes[:, 1])) + 1
        lines = (",".join(map(str, chosen[k : k + 10])) for k in range(0, len(chosen), 10))
        return f"*NSET,NSET={name}\n" + "".join(line + ",\n" for line in lines)


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
