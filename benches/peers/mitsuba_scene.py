"""A tirtouch scene file as a Mitsuba 3 scene.

Only what both programs mean by the same words is translated; everything else is refused with a line that names it, so
that a comparison never runs on two different scenes. What is translated: flat or dented stacks of smooth, clear layers
with black walls, bonded Lambertian LEDs without a cut-off, a pinhole, one disc of full contact with index-matched
tissue, and pressed phantoms on such tissue. Lengths are mm; z points up from the camera; image columns run along +x, row 0 lies at +y.
"""

import math
import tomllib
from pathlib import Path

import mitsuba as mi
import numpy as np

# Gap by which Mitsuba's LED discs and contact disc stand off the face they lie on: it has no rule for coincident
# surfaces. 1 um in 30 mm moves nothing that these comparisons can see.
STAND_OFF_MM = 1e-3


class Unsupported(Exception):
    """The scene holds something that Mitsuba would not compute the same way."""


def load(path):
    """The scene file as nested dictionaries."""
    with open(path, "rb") as file:
        return tomllib.load(file)


class Stack:
    """Heights (from the lowest face upwards) and indices of the layers."""

    def __init__(self, scene):
        stack = scene["stack"]
        layers = list(reversed(stack["layer"]))
        self.half_mm = [extent / 2 for extent in stack["footprint_mm"]]
        self.heights_mm = [0.0]
        for layer in layers:
            self.heights_mm.append(self.heights_mm[-1] + layer["thickness_mm"])
        surround = stack.get("surround_n", 1.0)
        self.indices = [surround] + [_index(layer) for layer in layers] + [surround]
        self.top_mm = self.heights_mm[-1]
        self.rigid_mm = self.heights_mm[1]


def _index(layer):
    if "n" not in layer:
        raise Unsupported(f"layer {layer['name']!r}: give n, dispersion formulas are not translated")
    if layer.get("absorption_per_mm", 0.0) != 0.0:
        raise Unsupported(f"layer {layer['name']!r}: absorption")
    _smooth(layer.get("upper_roughness"))
    return layer["n"]


def _smooth(roughness):
    if roughness is not None and roughness["kind"] != "none":
        raise Unsupported(f"roughness {roughness['kind']!r}")


class Dent:
    """A dent pressed into the touched face: a spherical cap of a rim radius, or a Gaussian of a standard deviation (mm)."""

    def __init__(self, shape):
        self.depth, self.center = shape["depth_mm"], shape.get("center_mm", [0.0, 0.0])
        self.rim, self.sigma = shape.get("radius_mm"), shape.get("sigma_mm")
        # Where the face is flat: slopes of a Gaussian are below 2e-6 of its depth over its width there.
        self.reach_mm = self.rim or 5.5 * self.sigma

    def down(self, r2):
        """How far (mm) the touched face sinks at squared distance r2 (mm^2) from the axis."""
        if self.sigma is not None:
            return self.depth * np.exp(-0.5 * r2 / self.sigma**2)
        ball = (self.rim**2 + self.depth**2) / (2 * self.depth)
        return np.where(r2 < self.rim**2, self.depth - ball + np.sqrt(np.maximum(ball**2 - r2, 0.0)), 0.0)


def dent(scene):
    """The dent, or None where the touched face is flat."""
    shape = scene.get("touch", {}).get("shape", {"kind": "flat"})
    if shape["kind"] == "flat":
        return None
    if shape["kind"] in ("spherical_dent", "gaussian_dent"):
        return Dent(shape)
    raise Unsupported(f"touch.shape {shape['kind']!r}")


def contact(scene):
    """Radius (mm), centre (mm) and albedo of the disc in contact, or None where nothing touches."""
    touch = scene.get("touch", {}).get("contact")
    if touch is None:
        return None
    pressure, tissue = touch["pressure"], touch["tissue"]
    if pressure["kind"] not in ("disc", "press"):
        raise Unsupported(f"touch.contact.pressure {pressure['kind']!r}")
    if pressure["kind"] == "disc" and touch.get("law", {"kind": "full"})["kind"] != "full":
        raise Unsupported("a contact law other than full")
    if tissue["n"] != scene["stack"]["layer"][0]["n"]:
        raise Unsupported("tissue whose index differs from that of the layer it touches")
    if "diffuse_reflectance" not in tissue or tissue.get("spread_mm", 0.0) != 0.0:
        raise Unsupported("tissue given by coefficients or with a sideways spread")
    radius = scene["press"]["footprint"]["radius_mm"] if pressure["kind"] == "press" else pressure["radius_mm"]
    return radius, pressure.get("center_mm", [0.0, 0.0]), tissue["diffuse_reflectance"]


def _sink(stack, height_mm, cap, r2):
    """How far (mm) a face sinks at squared distance r2 (mm^2) from the dent's axis.

    A face below the touched one moves by the dent times its height above the lowest, rigid layer over that of the
    touched face.
    """
    down = cap.down(r2)
    return down * (height_mm - stack.rigid_mm) / (stack.top_mm - stack.rigid_mm)


def grid_face(stack, height_mm, cap, cells, beyond=math.inf):
    """Vertices (mm) and triangles of a dented face over a grid of `cells` squares a side.

    Lines further than `beyond` (mm) from the dent's centre are left out, but for the borders.
    """
    def lines(axis):
        half = stack.half_mm[axis]
        every = np.linspace(-half, half, cells + 1)
        return every[(abs(every - cap.center[axis]) < beyond) | (abs(every) == half)]

    x, y = np.meshgrid(lines(0), lines(1))
    center = cap.center
    z = height_mm - _sink(stack, height_mm, cap, (x - center[0]) ** 2 + (y - center[1]) ** 2)
    i = np.arange(x.size).reshape(x.shape)
    return np.stack([x, y, z], -1).reshape(-1, 3), _two_triangles_each(i)


def smooth_face(stack, height_mm, cap, rings=512):
    """Vertices (mm) and triangles of a dented face in rings about its axis.

    Fine where the face is curved, one ring of long triangles where it is flat. The rim has its vertices twice, one for
    each side, so that no normal is a mean over the crease: a grid smears the rim over its cells (meshes.py).
    """
    radius, center = cap.reach_mm, cap.center
    corners = [math.atan2(y - center[1], x - center[0]) for x in (-stack.half_mm[0], stack.half_mm[0])
               for y in (-stack.half_mm[1], stack.half_mm[1])]
    angle = np.unique(np.concatenate([np.linspace(-math.pi, math.pi, 2 * rings, endpoint=False), corners]))
    across, along = np.cos(angle), np.sin(angle)
    with np.errstate(divide="ignore"):
        border = np.minimum((np.copysign(stack.half_mm[0], across) - center[0]) / across,
                            (np.copysign(stack.half_mm[1], along) - center[1]) / along)
    inside = np.outer(np.linspace(0.0, radius, rings + 1), np.ones_like(angle))
    r = np.concatenate([inside, inside[-1:], border[None, :]])
    x, y = center[0] + r * across, center[1] + r * along
    z = height_mm - _sink(stack, height_mm, cap, r**2)
    i = np.arange(r.size).reshape(r.shape)
    i = np.concatenate([i, i[:, :1]], axis=1)
    faces = _two_triangles_each(i.T)
    # The first ring is a point: of its squares only one triangle is left. Between the two rims there is nothing.
    ring = np.sort(faces // len(angle), axis=1)
    point, crease = ring[:, 1] == 0, (ring[:, 0] == rings) & (ring[:, 2] == rings + 1)
    return np.stack([x, y, z], -1).reshape(-1, 3), faces[~(point | crease)]


def _two_triangles_each(i):
    """Two triangles for each square of a lattice of vertex numbers."""
    a, b, c, d = i[:-1, :-1].ravel(), i[:-1, 1:].ravel(), i[1:, 1:].ravel(), i[1:, :-1].ravel()
    return np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])


def write_obj(path, vertices, faces):
    """The mesh as an OBJ file. Coordinates as 32-bit floats, which is what both programs trace."""
    with open(path, "w") as file:
        for x, y, z in vertices.astype(np.float32):
            file.write(f"v {x:.9g} {y:.9g} {z:.9g}\n")
        for a, b, c in faces + 1:
            file.write(f"f {a} {b} {c}\n")


def build(scene, spp, grid_cells=None, max_depth=256, pressed=None, touched=None):
    """The loaded Mitsuba scene. A dented face is a grid of that many squares a side, or smooth (see `smooth_face`); the
    touched one may be given as vertices, triangles and, to be interpolated, normals; the interfaces of a press are
    `pressed` (see pressed_scene.py)."""
    transform = mi.ScalarTransform4f
    stack = Stack(scene)
    view = _view(scene)
    width, height = view["pixels"]
    cap, disc = dent(scene), contact(scene)
    if cap and disc:
        raise Unsupported("a dent and a contact in one scene")
    _smooth(scene["stack"].get("lower_roughness"))
    if scene["stack"].get("walls", {"kind": "black"})["kind"] != "black":
        raise Unsupported("walls other than black")
    camera = transform().look_at(origin=[0, 0, -view["distance_mm"]], target=[0, 0, 0], up=[0, 1, 0])
    parts = {
        "type": "scene",
        "integrator": {"type": "path", "max_depth": max_depth, "rr_depth": 100_000},
        "sensor": {
            "type": "perspective",
            "fov": view["view_angle_deg"],
            "fov_axis": {"width": "x", "height": "y", "diagonal": "diagonal"}[view.get("view_axis", "width")],
            "to_world": camera,
            "film": {"type": "hdrfilm", "width": width, "height": height, "pixel_format": "luminance",
                     "rfilter": {"type": "box"}},
            "sampler": {"type": "independent", "sample_count": spp},
        },
    }
    inner_follows = scene.get("touch", {}).get("inner", "follow") == "follow"
    if ("press" in scene) != (pressed is not None):
        raise Unsupported("a press without its interfaces")
    if pressed is not None:
        parts |= pressed.parts(stack.indices, disc[2])
    for i, z in enumerate([] if pressed else stack.heights_mm):
        bsdf = {"type": "dielectric", "int_ior": stack.indices[i], "ext_ior": stack.indices[i + 1]}
        moves = z == stack.top_mm or (inner_follows and z > stack.rigid_mm)
        if cap and moves:
            mesh = grid_face(stack, z, cap, grid_cells) if grid_cells else smooth_face(stack, z, cap)
            parts[f"face{i}"] = _mesh(bsdf, *(touched if touched and z == stack.top_mm else mesh))
        else:
            scale = transform().translate([0, 0, z]).scale([*stack.half_mm, 1])
            parts[f"face{i}"] = {"type": "rectangle", "to_world": scale, "bsdf": bsdf}
    if disc and pressed is None:
        radius, center, albedo = disc
        place = transform().translate([*center, stack.top_mm - STAND_OFF_MM]).rotate([1, 0, 0], 180).scale(radius)
        parts["contact"] = {"type": "disk", "to_world": place, "bsdf": {"type": "diffuse", "reflectance": albedo}}
    _walls(parts, stack, transform)
    for i, led in enumerate(scene["led"]):
        parts[f"led{i}"] = _led(led, stack, transform)
    return mi.load_dict(parts)


def _view(scene):
    camera = scene["camera"]
    if camera.get("lens", {"kind": "pinhole"})["kind"] != "pinhole":
        raise Unsupported("a lens other than a pinhole")
    return camera


def _mesh(bsdf, vertices, faces, normals=None):
    props = mi.Properties()
    props["bsdf"] = mi.load_dict(bsdf)
    mesh = mi.Mesh("face", len(vertices), len(faces), props=props, has_vertex_normals=normals is not None)
    parameters = mi.traverse(mesh)
    if normals is not None:
        parameters["vertex_normals"] = normals.reshape(-1).astype(np.float32)
    parameters["vertex_positions"] = vertices.reshape(-1).astype(np.float32)
    parameters["faces"] = faces.reshape(-1).astype(np.uint32)
    parameters.update()
    return mesh


# Quarter turns from the wall at +x, with the extents across and along the wall.
_TURNS = {"+x": (0, 0, 1), "+y": (1, 1, 0), "-x": (2, 0, 1), "-y": (3, 1, 0)}


def _on_wall(wall, stack, transform, along_mm, height_mm, inset_mm):
    """Transform of a shape in its own xy plane to one on the wall that faces inwards."""
    turns, across, _ = _TURNS[wall]
    # A quarter turn takes +y of the wall at +x to -x of the wall at +y: `along` runs along +x or +y on every wall.
    sign = 1 if wall in ("+x", "-y") else -1
    turn = transform().rotate([0, 0, 1], 90 * turns)
    return turn @ transform().translate([stack.half_mm[across] - inset_mm, sign * along_mm, height_mm]).rotate([0, 1, 0], -90)


def _walls(parts, stack, transform):
    for wall, (_, _, along) in _TURNS.items():
        middle = stack.top_mm / 2
        place = _on_wall(wall, stack, transform, 0.0, middle, 0.0).scale([middle, stack.half_mm[along], 1])
        parts[f"wall {wall}"] = {"type": "rectangle", "to_world": place, "bsdf": {"type": "diffuse", "reflectance": 0.0}}


def _led(led, stack, transform):
    if led["mount"]["kind"] != "bonded":
        raise Unsupported("an LED that is not bonded")
    if led.get("pattern", {"kind": "lambertian"})["kind"] != "lambertian" or "cutoff_half_angle_deg" in led:
        raise Unsupported("an LED that is not plainly Lambertian")
    if "radiance_w_per_m2_sr" not in led:
        raise Unsupported("an LED without radiance_w_per_m2_sr")
    place = _on_wall(led["wall"], stack, transform, led.get("along_mm", 0.0), led["height_mm"], STAND_OFF_MM)
    # Mitsuba's disc is black as a surface: light that meets an LED ends there.
    return {"type": "disk", "to_world": place.scale(led["diameter_mm"] / 2),
            "bsdf": {"type": "diffuse", "reflectance": 0.0},
            "emitter": {"type": "area", "radiance": led["radiance_w_per_m2_sr"]}}


def contact_pixels(scene):
    """Mask of the pixels inside 0.9 of the contact disc's apparent radius, for a disc on the axis, or None."""
    disc = contact(scene)
    if disc is None:
        return None
    radius, center, _ = disc
    if center != [0.0, 0.0]:
        raise Unsupported("a contact disc off the axis")
    stack, view = Stack(scene), _view(scene)
    width, height = view["pixels"]
    half = {"width": width, "height": height, "diagonal": math.hypot(width, height)}[view.get("view_axis", "width")] / 2
    depths = np.diff(stack.heights_mm)
    apparent_mm = view["distance_mm"] + sum(d / n for d, n in zip(depths, stack.indices[1:-1]))
    radius_px = radius / apparent_mm / math.tan(math.radians(view["view_angle_deg"] / 2)) * half
    v, u = np.mgrid[:height, :width]
    return np.hypot(u + 0.5 - width / 2, v + 0.5 - height / 2) < 0.9 * radius_px


def render(loaded, spp, seed):
    """One image as (height, width) doubles.

    A camera that looks up sees +x on its left; the columns are turned round so that they run along +x.
    """
    return np.array(mi.render(loaded, spp=spp, seed=seed))[:, ::-1, 0].astype(np.float64)


def read_exr(path):
    """The channels of an EXR file by name."""
    bitmap = mi.Bitmap(str(path))
    pixels, names = np.array(bitmap), [field.name for field in bitmap.struct_()]
    return {name: pixels[..., i].astype(np.float64) for i, name in enumerate(names)}


def write_estimate(folder, mean, variance_of_mean):
    """mean.exr and variance.exr (variance of the mean), as `tirtouch compare` reads them."""
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    for name, image in (("mean", mean), ("variance", variance_of_mean)):
        mi.Bitmap(image.astype(np.float32)[..., None]).write(str(folder / f"{name}.exr"))
