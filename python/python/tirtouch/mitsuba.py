"""Scenes for Mitsuba 3, another renderer, so that whoever doubts an image can check it.

>>> import mitsuba, tirtouch
>>> mitsuba.set_variant("llvm_ad_mono")  # or "scalar_rgb", which needs no LLVM and is slow
>>> from tirtouch.mitsuba import radiance, to_mitsuba
>>> loaded = mitsuba.load_dict(to_mitsuba(tirtouch.Scene.preset("contact-disc")))
>>> theirs = radiance(mitsuba.render(loaded, spp=64, seed=1))

Only what both programs mean by the same words is translated: stacks of smooth, clear layers with black walls, flat or
dented; bonded Lambertian LEDs without a cut-off; a pinhole; one disc of full contact with index-matched tissue.
Everything else is refused with a line that names its key, so that a comparison never runs on two different scenes.
Lengths are mm; z points up from the camera.

Mitsuba is a package of its own: ``pip install mitsuba``. The LLVM variants need LLVM 19 or later, whose library the
variable ``DRJIT_LIBLLVM_PATH`` names where an older one is found first.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ._dents import Dent, Mesh, Stack, grid_face, smooth_face
from ._errors import SceneError

if TYPE_CHECKING:
    from ._tirtouch import Scene

__all__ = ["Mesh", "contact", "dent", "radiance", "to_mitsuba"]

#: Gap (mm) by which Mitsuba's LED discs and contact disc stand off the face they lie on: it has no rule for coincident
#: surfaces. 1 um in 30 mm moves nothing that a comparison can see.
_STAND_OFF_MM = 1e-3

#: Quarter turns from the wall at +x, with the extents across and along the wall.
_TURNS = {"+x": (0, 0, 1), "+y": (1, 1, 0), "-x": (2, 0, 1), "-y": (3, 1, 0)}

_FOV_AXIS = {"width": "x", "height": "y", "diagonal": "diagonal"}

_Values = Mapping[str, Any]


def to_mitsuba(
    scene: Scene | Mapping[str, Any],
    *,
    spp: int = 64,
    max_depth: int = 256,
    grid_cells: int | None = None,
    touched: Mesh | None = None,
    interfaces: Mapping[str, Any] | None = None,
) -> dict[str, Any]:
    """The scene as a dictionary for ``mitsuba.load_dict``, made for the variant that is set.

    ``spp`` are Mitsuba's paths per pixel, cut off after ``max_depth`` interactions. A dented face is a mesh: in fine
    rings about its axis, or of ``grid_cells`` squares a side. ``touched`` replaces the touched face of a dented scene.
    A pressed scene takes its ``interfaces``, shapes by name that replace every face and the tissue; without them it is
    refused, since results of a press hold the touched face alone.

    Raises SceneError, with its ``key``, for what Mitsuba would compute differently, ValueError where no variant is set
    or one that is polarised or spectral, and ImportError where Mitsuba is missing.
    """
    values: dict[str, Any] = dict(scene) if isinstance(scene, Mapping) else scene.to_dict()
    _check(values, interfaces is not None)
    cap, disc = dent(values), contact(values)
    mi = _mitsuba()
    stack = Stack(values)
    parts = _camera(mi, values["camera"], spp, max_depth)
    if interfaces is not None:
        parts |= interfaces
    else:
        inner_follows = values.get("touch", {}).get("inner", "follow") == "follow"
        for i, z in enumerate(stack.heights_mm):
            bsdf = {"type": "dielectric", "int_ior": stack.indices[i], "ext_ior": stack.indices[i + 1]}
            if cap and (z == stack.top_mm or (inner_follows and z > stack.rigid_mm)):
                mesh = grid_face(stack, z, cap, grid_cells) if grid_cells else smooth_face(stack, z, cap)
                parts[f"face{i}"] = _mesh(mi, bsdf, touched if touched and z == stack.top_mm else mesh)
            else:
                place = mi.ScalarTransform4f().translate([0, 0, z]).scale([*stack.half_mm, 1])
                parts[f"face{i}"] = {"type": "rectangle", "to_world": place, "bsdf": bsdf}
        if disc:
            parts["contact"] = _contact(mi, stack, *disc)
    parts |= _walls(mi, stack)
    for i, led in enumerate(values["led"]):
        parts[f"led{i}"] = _led(mi, led, stack)
    return parts


def radiance(rendered: Any) -> NDArray[np.float64]:
    """What ``mitsuba.render`` gives as radiance, W/(m^2 sr), (rows, columns), as ``Image.radiance`` has it.

    A camera that looks up sees +x on its left; the columns are turned round so that they run along +x. The frames of
    ``to_mitsuba`` have one channel, in colour variants too.
    """
    return np.array(rendered)[:, ::-1, 0].astype(np.float64)


def dent(values: Mapping[str, Any]) -> Dent | None:
    """The dent of a scene (as nested dictionaries), or None where the touched face is flat."""
    shape = values.get("touch", {}).get("shape", {"kind": "flat"})
    if shape["kind"] == "flat":
        return None
    if shape["kind"] in ("spherical_dent", "gaussian_dent"):
        return Dent(shape)
    raise _refused("touch.shape.kind", f"{shape['kind']!r} is not translated, only a spherical or Gaussian dent is")


def contact(values: Mapping[str, Any]) -> tuple[float, list[float], float] | None:
    """Radius (mm), centre (mm) and albedo of the disc in contact of a scene, or None where nothing touches."""
    touch = values.get("touch", {}).get("contact")
    if touch is None:
        return None
    pressure, tissue = touch["pressure"], touch["tissue"]
    if pressure["kind"] not in ("disc", "press"):
        raise _refused("touch.contact.pressure.kind", f"{pressure['kind']!r} is not translated, only a disc is")
    law = touch.get("law", {"kind": "full"})["kind"]
    if pressure["kind"] == "disc" and law != "full":
        raise _refused("touch.contact.law.kind", f"{law!r} is not translated, only full contact is")
    _only(tissue, "touch.contact.tissue", ("n", "diffuse_reflectance", "spread_mm"))
    if tissue["n"] != values["stack"]["layer"][0].get("n"):
        raise _refused("touch.contact.tissue.n", "must be that of the layer it touches")
    if tissue.get("spread_mm", 0.0) != 0.0:
        raise _refused("touch.contact.tissue.spread_mm", "must be 0, Mitsuba's face returns light where it fell")
    if "diffuse_reflectance" not in tissue:
        raise _refused("touch.contact.tissue.diffuse_reflectance", "must be given")
    radius = values["press"]["footprint"]["radius_mm"] if pressure["kind"] == "press" else pressure["radius_mm"]
    return radius, list(pressure.get("center_mm", [0.0, 0.0])), tissue["diffuse_reflectance"]


def _refused(key: str, why: str) -> SceneError:
    return SceneError(f"for Mitsuba: {key}: {why}", key=key)


def _only(table: _Values, where: str, known: Iterable[str]) -> None:
    """Refuses a table with any other key: what is not known here may change the light."""
    for key in table:
        if key not in known:
            place = f"{where}.{key}" if where else key
            raise _refused(place, "is not translated")


def _check(values: _Values, pressed: bool) -> None:
    """Refuses what is not translated, before anything is made."""
    # Neither the camera's electronics nor how tirtouch computes are of the light.
    known = ["name", "description", "light", "stack", "led", "camera", "touch", "render"]
    if pressed and "press" not in values:
        raise ValueError("interfaces: the scene presses nothing")
    if "press" in values and not pressed:
        raise _refused("press", "a pressed scene needs its faces, given as `interfaces`")
    _only(values, "", [*known, "press", "phantom"] if pressed else known)
    stack = values["stack"]
    _only(stack, "stack", ("footprint_mm", "layer", "lower_roughness", "surround_n", "walls"))
    _smooth(stack.get("lower_roughness"), "stack.lower_roughness")
    walls = stack.get("walls", {"kind": "black"})["kind"]
    if walls != "black":
        raise _refused("stack.walls.kind", f"must be 'black', is {walls!r}")
    for i, layer in enumerate(stack["layer"]):
        _check_layer(layer, f"stack.layer[{i}]")
    for i, led in enumerate(values["led"]):
        _check_led(led, f"led[{i}]")
    known = ["distance_mm", "lens", "pixel_pitch_um", "pixels", "sensor", "view_angle_deg", "view_axis"]
    _only(values["camera"], "camera", known)
    lens = values["camera"].get("lens", {"kind": "pinhole"})["kind"]
    if lens != "pinhole":
        raise _refused("camera.lens.kind", f"must be 'pinhole', is {lens!r}")
    touch = values.get("touch", {})
    _only(touch, "touch", ("contact", "inner", "shape"))
    if dent(values) and contact(values):
        raise _refused("touch.contact", "a contact on a dented face is not translated")


def _check_layer(layer: _Values, where: str) -> None:
    _only(layer, where, ("name", "thickness_mm", "n", "material", "absorption_per_mm", "upper_roughness", "elastic"))
    if "n" not in layer:
        raise _refused(f"{where}.material", "dispersion formulas are not translated, give n")
    if layer.get("absorption_per_mm", 0.0) != 0.0:
        raise _refused(f"{where}.absorption_per_mm", "must be 0, layers that absorb are not translated")
    _smooth(layer.get("upper_roughness"), f"{where}.upper_roughness")


def _smooth(roughness: _Values | None, key: str) -> None:
    if roughness is not None and roughness["kind"] != "none":
        raise _refused(f"{key}.kind", f"must be 'none', is {roughness['kind']!r}")


def _check_led(led: _Values, where: str) -> None:
    known = ["wall", "height_mm", "along_mm", "diameter_mm", "mount", "pattern", "radiance_w_per_m2_sr", "power_mw"]
    _only(led, where, known)
    if led["mount"]["kind"] != "bonded":
        raise _refused(f"{where}.mount.kind", f"must be 'bonded', is {led['mount']['kind']!r}")
    pattern = led.get("pattern", {"kind": "lambertian"})["kind"]
    if pattern != "lambertian":
        raise _refused(f"{where}.pattern.kind", f"must be 'lambertian', is {pattern!r}")
    if "radiance_w_per_m2_sr" not in led:
        raise _refused(f"{where}.power_mw", "is not translated, give radiance_w_per_m2_sr")


def _mitsuba() -> Any:
    """Mitsuba with a variant whose images can be compared."""
    try:
        import mitsuba
    except ImportError as missing:
        raise ImportError("Mitsuba is not installed: pip install mitsuba") from missing
    variant = mitsuba.variant()
    if variant is None:
        raise ValueError('set a variant of Mitsuba first, such as mitsuba.set_variant("llvm_ad_mono")')
    if "spectral" in variant or "polarized" in variant:
        raise ValueError(f"Mitsuba's variant is {variant}; the light here has one wavelength and no polarisation")
    return mitsuba


def _camera(mi: Any, camera: _Values, spp: int, max_depth: int) -> dict[str, Any]:
    width, height = camera["pixels"]
    place = mi.ScalarTransform4f().look_at(origin=[0, 0, -camera["distance_mm"]], target=[0, 0, 0], up=[0, 1, 0])
    film = {"type": "hdrfilm", "width": width, "height": height, "pixel_format": "luminance"}
    return {
        "type": "scene",
        "integrator": {"type": "path", "max_depth": max_depth, "rr_depth": 100_000},
        "sensor": {
            "type": "perspective",
            "fov": camera["view_angle_deg"],
            "fov_axis": _FOV_AXIS[camera.get("view_axis", "width")],
            "to_world": place,
            "film": film | {"rfilter": {"type": "box"}},
            "sampler": {"type": "independent", "sample_count": spp},
        },
    }


def _mesh(mi: Any, bsdf: dict[str, Any], mesh: Mesh) -> Any:
    props = mi.Properties()
    props["bsdf"] = mi.load_dict(bsdf)
    counts = len(mesh.vertices), len(mesh.triangles)
    made = mi.Mesh("face", *counts, props=props, has_vertex_normals=mesh.normals is not None)
    parameters = mi.traverse(made)
    if mesh.normals is not None:
        parameters["vertex_normals"] = mesh.normals.reshape(-1).astype(np.float32)
    parameters["vertex_positions"] = mesh.vertices.reshape(-1).astype(np.float32)
    parameters["faces"] = mesh.triangles.reshape(-1).astype(np.uint32)
    parameters.update()
    return made


def _contact(mi: Any, stack: Stack, radius_mm: float, center_mm: list[float], albedo: float) -> dict[str, Any]:
    place = mi.ScalarTransform4f().translate([*center_mm, stack.top_mm - _STAND_OFF_MM])
    place = place.rotate([1, 0, 0], 180).scale(radius_mm)
    return {"type": "disk", "to_world": place, "bsdf": {"type": "diffuse", "reflectance": albedo}}


def _on_wall(mi: Any, wall: str, stack: Stack, along_mm: float, height_mm: float, inset_mm: float) -> Any:
    """Transform of a shape in its own xy plane to one on the wall that faces inwards."""
    turns, across, _ = _TURNS[wall]
    # A quarter turn takes +y of the wall at +x to -x of the wall at +y: `along` runs along +x or +y on every wall.
    sign = 1 if wall in ("+x", "-y") else -1
    turn = mi.ScalarTransform4f().rotate([0, 0, 1], 90 * turns)
    place = mi.ScalarTransform4f().translate([stack.half_mm[across] - inset_mm, sign * along_mm, height_mm])
    return turn @ place.rotate([0, 1, 0], -90)


def _walls(mi: Any, stack: Stack) -> dict[str, Any]:
    parts = {}
    middle = stack.top_mm / 2
    for wall, (_, _, along) in _TURNS.items():
        place = _on_wall(mi, wall, stack, 0.0, middle, 0.0).scale([middle, stack.half_mm[along], 1])
        black = {"type": "diffuse", "reflectance": 0.0}
        parts[f"wall {wall}"] = {"type": "rectangle", "to_world": place, "bsdf": black}
    return parts


def _led(mi: Any, led: _Values, stack: Stack) -> dict[str, Any]:
    place = _on_wall(mi, led["wall"], stack, led.get("along_mm", 0.0), led["height_mm"], _STAND_OFF_MM)
    # Mitsuba's disc is black as a surface: light that meets an LED ends there.
    return {
        "type": "disk",
        "to_world": place.scale(led["diameter_mm"] / 2),
        "bsdf": {"type": "diffuse", "reflectance": 0.0},
        "emitter": {"type": "area", "radiance": led["radiance_w_per_m2_sr"]},
    }
