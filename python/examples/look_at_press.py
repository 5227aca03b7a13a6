#!/usr/bin/env python3
"""The bodies of `tirtouch press` in PyVista: every load deformed, in colours of pressure, as a picture.

    tirtouch press preset:phantom-size-8mm -o out/press
    python python/examples/look_at_press.py out/press -o press.png

Needs pyvista (`pip install pyvista`), whose VTK draws off screen, without a desktop. What it printed:

| load | base, mm | highest pressure, kPa, of the undeformed place, mm | farthest, mm | least Jacobian |
|---|---|---|---|---|
| 1 | 1.000 | 1.08 at x = 14.9, z = 12.1 | 1.00 | 0.80 |
| 2 | 2.000 | 2.11 at x = 14.9, z = 11.9 | 2.01 | 0.59 |
| 3 | 4.000 | 5.42 at x = 14.9, z = 11.9 | 4.04 | 0.47 |

The highest pressure sits at the rim of the tied face, where it is singular: it grows with a finer mesh.

Fields have their units in their names: `displacement_mm`, `contact_pressure_kpa` and `contact_shear_kpa` at points,
`pressure_kpa`, `stress_kpa`, `least_jacobian`, `body` (0 phantom, 1 sensor) and `region` of elements.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np
import pyvista


def loads(folder: Path) -> list[pyvista.UnstructuredGrid]:
    """The undeformed mesh with the fields of each load, from `deformed.pvd`."""
    reader = pyvista.get_reader(folder / "deformed.pvd")
    found = []
    for time in reader.time_values:
        reader.set_active_time_value(time)
        found.append(reader.read()[0])
    return found


def depth_mm(mesh: pyvista.UnstructuredGrid) -> float:
    """How far the phantom's base, which is moved as a whole, is pressed in, mm."""
    height = mesh.points[:, 2]
    return float(-mesh["displacement_mm"][height == height.max(), 2].mean())


def said(number: int, mesh: pyvista.UnstructuredGrid) -> str:
    """A row of the table: what a load's fields hold."""
    place = mesh.cell_centers().points[mesh["pressure_kpa"].argmax()]
    where = f"x = {abs(place[0]):.1f}, z = {place[2]:.1f}"
    return (
        f"| {number} | {depth_mm(mesh):.3f} | {mesh['pressure_kpa'].max():.2f} at {where}"
        f" | {np.linalg.norm(mesh['displacement_mm'], axis=1).max():.2f} | {mesh['least_jacobian'].min():.2f} |"
    )


def picture(meshes: list[pyvista.UnstructuredGrid], file: Path) -> None:
    """All loads side by side: bodies as deformed, in colours of pressure, with outlines of layers and inclusions."""
    # One scale; the rim, where the pressure is singular, is beyond it.
    top = float(np.quantile(meshes[-1]["pressure_kpa"], 0.995))
    plotter = pyvista.Plotter(off_screen=True, shape=(1, len(meshes)), window_size=(520 * len(meshes), 420))
    for column, mesh in enumerate(meshes):
        plotter.subplot(0, column)
        bent = mesh.warp_by_vector("displacement_mm")
        bar = {"title": "pressure_kpa", "vertical": False, "height": 0.08, "position_y": 0.03}
        plotter.add_mesh(bent, scalars="pressure_kpa", clim=(0.0, top), cmap="viridis", scalar_bar_args=bar)
        for body, region in sorted({(int(b), int(r)) for b, r in zip(mesh["body"], mesh["region"], strict=True)}):
            part = bent.extract_cells((mesh["body"] == body) & (mesh["region"] == region))
            edges = part.extract_feature_edges(feature_edges=False, manifold_edges=False, non_manifold_edges=False)
            plotter.add_mesh(edges, color="white", line_width=1)
        plotter.add_text(f"load {column + 1}: {depth_mm(mesh):.3g} mm", font_size=10)
        plotter.view_xz()
        plotter.camera.zoom(1.3)
    plotter.screenshot(file)
    plotter.close()


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path, help="folder that `tirtouch press` wrote")
    parser.add_argument("-o", "--out", type=Path, default=Path("press.png"))
    arguments = parser.parse_args()
    meshes = loads(arguments.folder)
    print("| load | base, mm | highest pressure, kPa, of the undeformed place, mm | farthest, mm | least Jacobian |")
    print("|---|---|---|---|---|")
    for number, mesh in enumerate(meshes, 1):
        print(said(number, mesh))
    picture(meshes, arguments.out)
    print(arguments.out)


if __name__ == "__main__":
    main()
