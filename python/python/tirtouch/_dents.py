"""Faces of a stack of layers, flat or dented, as triangles. Lengths are mm; z points up from the lowest face."""

# Not from __future__ import annotations: the constructor of a named tuple would have texts for types.

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray


class Mesh(NamedTuple):
    """Triangles of one face: vertices (mm, n x 3), their numbers (m x 3), unit normals at the vertices or None."""

    vertices: NDArray[np.float64]
    """Places, mm, of shape (vertices, 3)."""
    triangles: NDArray[np.int64]
    """Numbers of the vertices of each triangle, of shape (triangles, 3)."""
    normals: NDArray[np.float64] | None = None
    """Unit normals at the vertices, of their shape, or None."""


class Stack:
    """Heights of the faces (mm, from the lowest upwards) and indices from below the stack to above it."""

    def __init__(self, scene: dict[str, Any]) -> None:
        stack = scene["stack"]
        layers = list(reversed(stack["layer"]))
        self.half_mm: list[float] = [extent / 2 for extent in stack["footprint_mm"]]
        self.heights_mm: list[float] = [0.0]
        for layer in layers:
            self.heights_mm.append(self.heights_mm[-1] + layer["thickness_mm"])
        surround = stack.get("surround_n", 1.0)
        self.indices: list[float] = [surround] + [layer["n"] for layer in layers] + [surround]
        self.top_mm = self.heights_mm[-1]
        self.rigid_mm = self.heights_mm[1]


class Dent:
    """A dent in the touched face: a spherical cap of a rim radius, or a Gaussian of a standard deviation (mm)."""

    def __init__(self, shape: dict[str, Any]) -> None:
        self.depth: float = shape["depth_mm"]
        self.center: list[float] = shape.get("center_mm", [0.0, 0.0])
        self.rim: float | None = shape.get("radius_mm")
        self.sigma: float | None = shape.get("sigma_mm")
        # Where the face is flat: slopes of a Gaussian are below 2e-6 of its depth over its width there.
        self.reach_mm: float = self.rim or 5.5 * (self.sigma or 0.0)

    def down(self, r2: Any) -> NDArray[np.float64]:
        """How far (mm) the touched face sinks at squared distance r2 (mm^2) from the axis."""
        if self.sigma is not None:
            return np.asarray(self.depth * np.exp(-0.5 * r2 / self.sigma**2))
        assert self.rim is not None
        ball = (self.rim**2 + self.depth**2) / (2 * self.depth)
        return np.where(r2 < self.rim**2, self.depth - ball + np.sqrt(np.maximum(ball**2 - r2, 0.0)), 0.0)


def _sink(stack: Stack, height_mm: float, dent: Dent, r2: Any) -> NDArray[np.float64]:
    """How far (mm) a face sinks at squared distance r2 (mm^2) from the dent's axis.

    A face below the touched one moves by the dent times its height above the lowest, rigid layer over that of the
    touched face.
    """
    share = (height_mm - stack.rigid_mm) / (stack.top_mm - stack.rigid_mm)
    return np.asarray(dent.down(r2) * share)


def grid_face(stack: Stack, height_mm: float, dent: Dent, cells: int, beyond: float = math.inf) -> Mesh:
    """A dented face over a grid of ``cells`` squares a side.

    Lines further than ``beyond`` (mm) from the dent's centre are left out, but for the borders.
    """

    def lines(axis: int) -> NDArray[np.float64]:
        half = stack.half_mm[axis]
        every = np.linspace(-half, half, cells + 1)
        kept: NDArray[np.float64] = every[(abs(every - dent.center[axis]) < beyond) | (abs(every) == half)]
        return kept

    x, y = np.meshgrid(lines(0), lines(1))
    center = dent.center
    z = height_mm - _sink(stack, height_mm, dent, (x - center[0]) ** 2 + (y - center[1]) ** 2)
    i = np.arange(x.size).reshape(x.shape)
    return Mesh(np.stack([x, y, z], -1).reshape(-1, 3), _two_triangles_each(i))


def smooth_face(stack: Stack, height_mm: float, dent: Dent, rings: int = 512) -> Mesh:
    """A dented face in rings about its axis.

    Fine where the face is curved, one ring of long triangles where it is flat. The rim has its vertices twice, one for
    each side, so that no normal is a mean over the crease: a grid smears the rim over its cells.
    """
    radius, center = dent.reach_mm, dent.center
    corners = [
        math.atan2(y - center[1], x - center[0])
        for x in (-stack.half_mm[0], stack.half_mm[0])
        for y in (-stack.half_mm[1], stack.half_mm[1])
    ]
    angle = np.unique(np.concatenate([np.linspace(-math.pi, math.pi, 2 * rings, endpoint=False), corners]))
    across, along = np.cos(angle), np.sin(angle)
    with np.errstate(divide="ignore"):
        border = np.minimum(
            (np.copysign(stack.half_mm[0], across) - center[0]) / across,
            (np.copysign(stack.half_mm[1], along) - center[1]) / along,
        )
    inside = np.outer(np.linspace(0.0, radius, rings + 1), np.ones_like(angle))
    r = np.concatenate([inside, inside[-1:], border[None, :]])
    x, y = center[0] + r * across, center[1] + r * along
    z = height_mm - _sink(stack, height_mm, dent, r**2)
    i = np.arange(r.size).reshape(r.shape)
    i = np.concatenate([i, i[:, :1]], axis=1)
    faces = _two_triangles_each(i.T)
    # The first ring is a point: of its squares only one triangle is left. Between the two rims there is nothing.
    ring = np.sort(faces // len(angle), axis=1)
    point, crease = ring[:, 1] == 0, (ring[:, 0] == rings) & (ring[:, 2] == rings + 1)
    return Mesh(np.stack([x, y, z], -1).reshape(-1, 3), faces[~(point | crease)])


def _two_triangles_each(i: NDArray[np.int64]) -> NDArray[np.int64]:
    """Two triangles for each square of a lattice of vertex numbers."""
    a, b, c, d = i[:-1, :-1].ravel(), i[:-1, 1:].ravel(), i[1:, 1:].ravel(), i[1:, :-1].ravel()
    return np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])
