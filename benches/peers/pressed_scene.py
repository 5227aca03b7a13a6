"""A pressed sensor for Mitsuba: interfaces as meshes, contact as a blend, from `benches/pressed_peer.rs`.

Faces are rings about the axis with the spline's own normals at the vertices. The touched face is split at the tissue's
rim. Inside, it is a film of air in the top layer's index (`thindielectric`) where there is no true contact, and nothing
where there is: a `mask` by the share of contact. The tissue is a Lambertian face above it.
"""

import math
import subprocess

import mitsuba as mi
import numpy as np

# Rings within the tissue's rim, from there to the border, and vertices on each.
RINGS, OUTER_RINGS, TURNS = 384, 64, 768
# The tissue's height above the touched face: more than Mitsuba moves a ray's start off the face it left (1.5 um here).
TISSUE_MM = 0.01


class Faces:
    """Vertices of all interfaces, and which of the triangles lie inside the tissue's rim."""

    def __init__(self, program, scene_file, half_mm, rim_mm):
        corners = [math.atan2(y, x) for x in (-half_mm[0], half_mm[0]) for y in (-half_mm[1], half_mm[1])]
        angle = np.unique(np.concatenate([np.linspace(-math.pi, math.pi, TURNS, endpoint=False), corners]))
        with np.errstate(divide="ignore"):
            border = np.minimum(half_mm[0] / np.abs(np.cos(angle)), half_mm[1] / np.abs(np.sin(angle)))
        rings = [np.outer(np.linspace(0.0, rim_mm, RINGS + 1)[1:], np.ones_like(angle))]
        # The faces level off within a millimetre or two beyond the rim, so rings are closer there. Where the rim
        # touches the border, what lies between are slivers thinner than a micrometre.
        beyond = np.maximum(border - rim_mm, 1e-6)
        rings.append(rim_mm + np.outer((np.arange(1, OUTER_RINGS + 1) / OUTER_RINGS) ** 1.5, beyond))
        r = np.concatenate(rings)
        x, y = np.minimum(r, border + 1e-6) * np.cos(angle), np.minimum(r, border + 1e-6) * np.sin(angle)
        self.points = np.concatenate([[[0.0, 0.0]], np.stack([x, y], -1).reshape(-1, 2)])
        i = np.arange(r.size).reshape(r.shape) + 1
        i = np.concatenate([i, i[:, :1]], axis=1)
        center = np.stack([np.zeros(len(angle), int), i[0, :-1], i[0, 1:]], 1)
        self.inner = np.concatenate([center, _squares(i[:RINGS])])
        self.outer = _squares(i[RINGS - 1:])
        found = subprocess.run([program, scene_file], input=self.points.astype(np.float64).tobytes(), check=True,
                               capture_output=True).stdout
        numbers, count = np.frombuffer(found), len(self.points)
        self.share = numbers[-count:]
        self.faces = numbers[:-count].reshape(-1, count, 3)

    def mesh(self, face, triangles, bsdf, lift_mm=0.0, downwards=False):
        """The mesh of one interface's triangles."""
        height, along, across = self.faces[face].T
        sign = -1.0 if downwards else 1.0
        normal = sign * np.stack([-along, -across, np.ones_like(along)], 1)
        normal /= np.linalg.norm(normal, axis=1)[:, None]
        props = mi.Properties()
        props["bsdf"] = mi.load_dict(bsdf)
        mesh = mi.Mesh("face", len(self.points), len(triangles), has_vertex_normals=True, props=props)
        mesh.add_attribute("vertex_clear", 1, (1.0 - self.share).astype(np.float32))
        values = mi.traverse(mesh)
        place = np.concatenate([self.points, (height + lift_mm)[:, None]], 1)
        values["vertex_positions"] = place.reshape(-1).astype(np.float32)
        values["vertex_normals"] = normal.reshape(-1).astype(np.float32)
        values["faces"] = (triangles[:, ::-1] if downwards else triangles).reshape(-1).astype(np.uint32)
        values.update()
        return mesh

    def parts(self, indices, albedo):
        """All interfaces and the tissue, for a scene's dictionary."""
        top = len(self.faces) - 1
        both = np.concatenate([self.inner, self.outer])
        parts = {}
        for face in range(top):
            bsdf = {"type": "dielectric", "int_ior": indices[face], "ext_ior": indices[face + 1]}
            parts[f"face{face}"] = self.mesh(face, both, bsdf)
        open_face = {"type": "dielectric", "int_ior": indices[top], "ext_ior": indices[top + 1]}
        parts["open"] = self.mesh(top, self.outer, open_face)
        gap = {"type": "thindielectric", "int_ior": 1.0, "ext_ior": indices[top]}
        clear = {"type": "mesh_attribute", "name": "vertex_clear"}
        parts["touched"] = self.mesh(top, self.inner, {"type": "mask", "opacity": clear, "bsdf": gap})
        tissue = {"type": "diffuse", "reflectance": albedo}
        parts["tissue"] = self.mesh(top, self.inner, tissue, TISSUE_MM, downwards=True)
        return parts


def _squares(i):
    a, after, out, beyond = i[:-1, :-1].ravel(), i[:-1, 1:].ravel(), i[1:, :-1].ravel(), i[1:, 1:].ravel()
    # Counter-clockwise from above: outwards along the radius, then along the turn.
    return np.concatenate([np.stack([a, out, beyond], 1), np.stack([a, beyond, after], 1)])
