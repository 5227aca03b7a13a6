"""A tirtouch scene file as a Mitsuba 3 scene, and Mitsuba's images of it.

The conversion is the Python package's, `tirtouch.mitsuba`, read from its folder here: it needs no build. It refuses,
with a line that names the key, what Mitsuba would not compute the same way, so that a comparison never runs on two
different scenes. Lengths are mm; z points up from the camera; image columns run along +x, row 0 lies at +y.
"""

import math
import sys
import tomllib
import types
from pathlib import Path

import mitsuba as mi
import numpy as np

# The package's folder without its compiled part, which this file needs none of.
_package = types.ModuleType("tirtouch")
_package.__path__ = [str(Path(__file__).resolve().parents[2] / "python/python/tirtouch")]
sys.modules.setdefault("tirtouch", _package)

from tirtouch._dents import Mesh, Stack, grid_face, smooth_face  # noqa: E402,F401 (others take the faces here)
from tirtouch._errors import SceneError  # noqa: E402
from tirtouch.mitsuba import contact, dent, radiance, to_mitsuba  # noqa: E402


def load(path):
    """The scene file as nested dictionaries."""
    with open(path, "rb") as file:
        return tomllib.load(file)


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
    interfaces = pressed and pressed.parts(Stack(scene).indices, contact(scene)[2])
    return mi.load_dict(to_mitsuba(scene, spp=spp, max_depth=max_depth, grid_cells=grid_cells,
                                   touched=touched and Mesh(*touched), interfaces=interfaces))


def contact_pixels(scene):
    """Mask of the pixels inside 0.9 of the contact disc's apparent radius, for a disc on the axis, or None."""
    disc = contact(scene)
    if disc is None:
        return None
    radius, center, _ = disc
    if center != [0.0, 0.0]:
        raise SceneError("a contact disc off the axis", key="touch.contact.pressure.center_mm")
    stack, view = Stack(scene), scene["camera"]
    width, height = view["pixels"]
    half = {"width": width, "height": height, "diagonal": math.hypot(width, height)}[view.get("view_axis", "width")] / 2
    depths = np.diff(stack.heights_mm)
    apparent_mm = view["distance_mm"] + sum(d / n for d, n in zip(depths, stack.indices[1:-1]))
    radius_px = radius / apparent_mm / math.tan(math.radians(view["view_angle_deg"] / 2)) * half
    v, u = np.mgrid[:height, :width]
    return np.hypot(u + 0.5 - width / 2, v + 0.5 - height / 2) < 0.9 * radius_px


def render(loaded, spp, seed):
    """One image as (height, width) doubles, columns along +x."""
    return radiance(mi.render(loaded, spp=spp, seed=seed))


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
