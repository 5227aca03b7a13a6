"""Scenes: where they come from, how they change, what is wrong with them."""

from __future__ import annotations

import pickle
from pathlib import Path
from typing import Any, Callable

import numpy as np
import pytest
import tirtouch
from tirtouch import Scene, SceneError


def test_a_scene_comes_from_a_file_a_preset_a_text_and_a_dictionary(tmp_path: Path) -> None:
    preset = Scene.preset("contact-disc")
    file = tmp_path / "disc.toml"
    file.write_text(preset.to_toml())
    others = [Scene.open(file), Scene.open("preset:contact-disc"), Scene.parse(preset.to_toml())]
    assert all(other == preset for other in others)
    assert preset.name == "contact-disc" and "disc" in preset.description.lower()
    assert preset != Scene.preset("flat-bonded") and preset != 1


@pytest.mark.parametrize("name", Scene.presets())
def test_a_dictionary_gives_the_same_scene(name: str) -> None:
    scene = Scene.preset(name)
    again = Scene.from_dict(scene.to_dict())
    assert again == scene
    assert again.to_dict() == scene.to_dict()
    assert pickle.loads(pickle.dumps(again)) == scene


def test_a_dictionary_may_hold_numbers_of_numpy_and_none() -> None:
    scene = Scene.preset("contact-disc")
    values = scene.to_dict()
    values["camera"]["pixels"] = np.array([64, 48])
    values["stack"]["layer"][0]["n"] = np.float32(1.5)
    values["phantom"] = None
    made = Scene.from_dict(values).to_dict()
    assert made["camera"]["pixels"] == [64, 48]
    assert made["stack"]["layer"][0]["n"] == 1.5


def test_what_no_scene_can_hold_is_a_type_error_that_names_its_place() -> None:
    values = Scene.preset("contact-disc").to_dict()
    values["camera"]["pixels"][1] = object()
    with pytest.raises(TypeError, match=r"camera\.pixels\[1\]"):
        Scene.from_dict(values)
    endless: dict[str, object] = {}
    endless["stack"] = endless
    with pytest.raises(ValueError, match="deep"):
        Scene.from_dict(endless)


def test_set_changes_what_it_names_and_leaves_the_scene_alone() -> None:
    scene = Scene.preset("contact-disc")
    other = scene.set({"stack.layer[0].n": 1.42, 'stack.layer["PDMS 1.40"].n': 1.41, "name": "other"})
    layers = other.to_dict()["stack"]["layer"]
    assert [layer["n"] for layer in layers] == [1.42, 1.41, 1.39, 1.38]
    assert other.name == "other" and scene == Scene.preset("contact-disc")
    assert scene.set({}) == scene


def test_set_takes_lists_and_tables_too() -> None:
    scene = Scene.preset("contact-disc")
    values = scene.to_dict()
    assert scene.set({"camera.pixels": [64, 48]}).to_dict()["camera"]["pixels"] == [64, 48]
    # Whole numbers count, as they do by themselves.
    assert scene.set({"camera.pixels": np.array([64.0, 48.0])}).to_dict()["camera"]["pixels"] == [64, 48]
    led = values["led"][0] | {"radiance_w_per_m2_sr": 1.5}
    one = scene.set({"led": [led], "stack.layer[0].n": 1.42}).to_dict()
    assert len(values["led"]) > 1 and one["led"] == [led] and one["stack"]["layer"][0]["n"] == 1.42
    sensor = values["camera"]["sensor"] | {"exposure_ms": 3.5}
    assert scene.set({"camera.sensor": sensor}).to_dict()["camera"] == values["camera"] | {"sensor": sensor}
    elastic = {"law": "neo_hookean", "youngs_kpa": 9.0}
    layers = scene.set({"stack.layer[*].elastic": elastic}).to_dict()["stack"]["layer"]
    assert all(layer["elastic"].items() >= elastic.items() for layer in layers)
    assert [layer["n"] for layer in layers] == [layer["n"] for layer in values["stack"]["layer"]]


def test_lists_that_make_no_scene_say_why() -> None:
    scene = Scene.preset("contact-disc")
    for key, value, words in [
        ("camera.pixels", [64], "camera.pixels"),
        ("camera.pixels", [64, -1], "camera.pixels"),
        ("led", [{"radiance_w_per_m2_sr": 1.0, "color": "red"}], "color"),
        ("led", 3.0, "list of tables"),
        ("camera", [1.0], "table"),
    ]:
        with pytest.raises(SceneError, match=words) as raised:
            scene.set({key: value})
        assert raised.value.file == "contact-disc.toml" and raised.value.key is not None
    with pytest.raises(TypeError, match=r"camera\.pixels\[1\]"):
        scene.set({"camera.pixels": [64, object()]})


@pytest.mark.parametrize(
    ("key", "value", "words"),
    [
        ("stack.layer[0].n", -1, "n"),
        ("stack.layer[7].n", 1.4, "4 elements"),
        ("stack.layer[0].m", 1.4, "unknown key"),
        ("stack..n", 1.4, "stack.layer[0].n"),
    ],
)
def test_a_key_that_cannot_be_set_says_why(key: str, value: float, words: str) -> None:
    with pytest.raises(SceneError) as raised:
        Scene.preset("contact-disc").set({key: value})
    assert words in str(raised.value)
    assert raised.value.key == key
    assert raised.value.file == "contact-disc.toml"


def test_a_bad_key_has_file_line_and_key(tmp_path: Path) -> None:
    text = Scene.preset("contact-disc").to_toml().replace("thickness_mm = 3.0", "thicknes_mm = 3.0")
    line = 1 + text.splitlines().index("thicknes_mm = 3.0")
    file = tmp_path / "disc.toml"
    file.write_text(text)
    with pytest.raises(SceneError) as raised:
        Scene.open(file)
    error = raised.value
    assert (error.file, error.line, error.key) == (str(file), line, "stack.layer[1].thicknes_mm")
    assert isinstance(error, tirtouch.TirtouchError) and str(error).startswith(f"{file}:{line}: ")
    again = pickle.loads(pickle.dumps(error))
    assert (type(again), again.line, str(again)) == (SceneError, line, str(error))


def test_all_mistakes_of_a_file_are_told(command: Callable[..., dict[str, Any]], tmp_path: Path) -> None:
    text = Scene.preset("contact-disc").to_toml().replace("thickness_mm = 2.0", "thicknes_mm = 2.0")
    (tmp_path / "disc.toml").write_text(text)
    with pytest.raises(SceneError) as raised:
        Scene.parse(text, "disc.toml")
    said = command("inspect", "disc.toml")["errors"]
    assert [str(raised.value), *raised.value.others] == [error["message"] for error in said]
    first = said[0]
    assert (raised.value.file, raised.value.line, raised.value.key) == (first["file"], first["line"], first["key"])
    # Two layers are 2 mm thick.
    assert len(raised.value.others) == 1


def test_a_file_that_is_not_there_and_a_preset_that_is_none() -> None:
    with pytest.raises(SceneError, match="nowhere.toml"):
        Scene.open("nowhere.toml")
    with pytest.raises(SceneError, match="contact-disc"):
        Scene.preset("nothing")


def test_the_schema_knows_the_keys() -> None:
    assert "camera" in tirtouch.schema()["properties"]
    assert tirtouch.schema(sweep=True) != tirtouch.schema()
