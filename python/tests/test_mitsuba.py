"""Scenes as Mitsuba's: what the dictionary holds, and what is refused. ``against_mitsuba.py`` compares the light."""

from __future__ import annotations

import subprocess
import sys
from typing import Any

import numpy as np
import pytest
import tirtouch
from tirtouch._dents import Stack, grid_face, smooth_face
from tirtouch.mitsuba import dent, to_mitsuba

CAP = {"shape": {"kind": "spherical_dent", "depth_mm": 1.0, "radius_mm": 4.0}, "inner": "follow"}


@pytest.fixture
def mitsuba() -> Any:
    module = pytest.importorskip("mitsuba")
    module.set_variant("scalar_rgb")
    return module


def test_importing_the_translation_does_not_import_mitsuba() -> None:
    code = "import sys, tirtouch.mitsuba; sys.exit('mitsuba' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


@pytest.mark.parametrize(
    ("values", "key"),
    [
        ({"stack.layer[1].absorption_per_mm": 0.01}, "stack.layer[1].absorption_per_mm"),
        ({"led[2].cutoff_half_angle_deg": 60.0}, "led[2].cutoff_half_angle_deg"),
        ({"touch.contact.tissue.n": 1.40}, "touch.contact.tissue.n"),
        ({"touch.contact.tissue.spread_mm": 0.5}, "touch.contact.tissue.spread_mm"),
    ],
)
def test_what_mitsuba_would_compute_otherwise_is_refused_by_its_key(values: dict[str, Any], key: str) -> None:
    with pytest.raises(tirtouch.SceneError, match="for Mitsuba: ") as raised:
        to_mitsuba(tirtouch.Scene.preset("contact-disc").set(values))
    assert raised.value.key == key and key in str(raised.value) and "\n" not in str(raised.value)


@pytest.mark.parametrize(
    ("table", "values", "key"),
    [
        ("stack", {"walls": {"kind": "clear"}}, "stack.walls.kind"),
        ("stack", {"lower_roughness": {"kind": "microfacet", "alpha": 0.1}}, "stack.lower_roughness.kind"),
        ("camera", {"lens": {"kind": "thin_lens", "focus_mm": 25.0}}, "camera.lens.kind"),
        ("touch", {"shape": CAP["shape"]}, "touch.contact"),
        ("touch", {"shape": {"kind": "mesh", "file": "face.obj", "normals": "flat"}}, "touch.shape.kind"),
    ],
)
def test_tables_that_mitsuba_has_not_are_refused_by_their_key(table: str, values: dict[str, Any], key: str) -> None:
    scene = tirtouch.Scene.preset("contact-disc").to_dict()
    scene[table] |= values
    with pytest.raises(tirtouch.SceneError) as raised:
        to_mitsuba(scene)
    assert raised.value.key == key


def test_presses_and_keys_that_are_not_known_are_refused() -> None:
    with pytest.raises(tirtouch.SceneError) as raised:
        to_mitsuba(tirtouch.Scene.preset("phantom-size-8mm"))
    assert raised.value.key == "press"
    scene = tirtouch.Scene.preset("contact-disc").to_dict()
    scene["stack"]["layer"][3]["birefringence"] = 0.1
    with pytest.raises(tirtouch.SceneError, match=r"stack\.layer\[3\]\.birefringence"):
        to_mitsuba(scene)
    with pytest.raises(ValueError, match="presses nothing"):
        to_mitsuba(tirtouch.Scene.preset("contact-disc"), interfaces={})


def test_a_dented_face_reaches_its_depth_and_the_border_in_both_meshes() -> None:
    values = tirtouch.Scene.preset("contact-disc").to_dict() | {"touch": CAP}
    stack, cap = Stack(values), dent(values)
    assert cap is not None
    for mesh in (grid_face(stack, stack.top_mm, cap, 64), smooth_face(stack, stack.top_mm, cap, 64)):
        x, y, z = mesh.vertices.T
        assert abs(z.min() - 11.0) < 1e-12 and z.max() == 12.0
        a, b, c = (mesh.vertices[mesh.triangles[:, k]] for k in range(3))
        area = np.cross(b - a, c - a)[:, 2] / 2
        # Every triangle looks up, and seen from above they fill the footprint once.
        assert area.min() > 0 and abs(area.sum() - 900.0) < 1e-9
    glass = grid_face(stack, stack.rigid_mm, cap, 64).vertices
    assert np.all(glass[:, 2] == stack.rigid_mm)


def test_the_dictionary_has_every_face_wall_led_and_contact(mitsuba: Any) -> None:
    parts = to_mitsuba(tirtouch.Scene.preset("contact-disc"), spp=7)
    faces = [(parts[f"face{i}"]["bsdf"]["int_ior"], parts[f"face{i}"]["bsdf"]["ext_ior"]) for i in range(5)]
    assert faces == [(1.0, 1.38), (1.38, 1.39), (1.39, 1.40), (1.40, 1.41), (1.41, 1.0)]
    assert parts["contact"]["bsdf"] == {"type": "diffuse", "reflectance": 0.5}
    assert [parts[f"led{i}"]["emitter"]["radiance"] for i in range(4)] == [1.0] * 4
    assert parts["sensor"]["film"]["width"] == 384 and parts["sensor"]["sampler"]["sample_count"] == 7
    # 5 faces, a contact, 4 walls and 4 LEDs, within the footprint and the height of the stack.
    assert len(parts) == 14 + len(["type", "integrator", "sensor"])
    loaded = mitsuba.load_dict(parts)
    assert len(loaded.emitters()) == 4
    box = loaded.bbox()
    assert np.allclose([*box.min, *box.max], [-15, -15, 0, 15, 15, 12], atol=1e-4)
    leds = sorted(tuple(np.round(led.bbox().center(), 3)) for led in loaded.shapes() if led.is_emitter())
    assert leds == [(-14.999, 0, 6), (0, -14.999, 6), (0, 14.999, 6), (14.999, 0, 6)]


def test_leds_beside_the_middle_of_a_wall_lie_where_the_scene_says(mitsuba: Any) -> None:
    loaded = mitsuba.load_dict(to_mitsuba(tirtouch.Scene.preset("contact-disc").set({"led[*].along_mm": 4.0})))
    leds = sorted(tuple(np.round(led.bbox().center(), 3)) for led in loaded.shapes() if led.is_emitter())
    assert leds == [(-14.999, 4, 6), (4, -14.999, 6), (4, 14.999, 6), (14.999, 4, 6)]


def test_a_dent_is_a_mesh_and_inner_faces_follow(mitsuba: Any) -> None:
    values = tirtouch.Scene.preset("contact-disc").to_dict() | {"touch": CAP}
    parts = to_mitsuba(values, grid_cells=32)
    depths = [12.0, 10.0, 7.0]
    for i, height in zip((4, 3, 2), depths, strict=True):
        assert abs(parts[f"face{i}"].bbox().min[2] - (height - (height - 2.0) / 10.0)) < 1e-5
    assert parts["face1"]["type"] == "rectangle"
    flat = to_mitsuba(values | {"touch": CAP | {"inner": "flat"}}, grid_cells=32)
    assert flat["face3"]["type"] == "rectangle"


def test_a_variant_must_suit_the_light(mitsuba: Any) -> None:
    mitsuba.set_variant("scalar_spectral")
    with pytest.raises(ValueError, match="scalar_spectral"):
        to_mitsuba(tirtouch.Scene.preset("contact-disc"))
