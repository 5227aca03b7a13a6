"""Calibrations: learnt from small sweeps, read, and used."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import tirtouch
from tirtouch import Calibration, Scene, Session, Sweep

CONTACT = "touch.contact.law.reduced_modulus_kpa"


@pytest.fixture(scope="module")
def sensor() -> Scene:
    """The paper's sensor with a phantom, pressed to two depths on a coarse mesh and seen in few pixels."""
    scene = Scene.preset("phantom-size-8mm")
    camera = scene.to_dict()["camera"]
    factor = camera["pixels"][0] / 48
    return scene.set(
        {
            "camera.pixels": [48, 36],
            "camera.pixel_pitch_um": camera["pixel_pitch_um"] * factor,
            "camera.sensor.exposure_ms": camera["sensor"]["exposure_ms"] / factor**2,
            "press.depths_mm": [1.0, 2.0],
            "press.estimate_error": False,
            "press.resolution": 0.5,
            "render.spp": 16,
            "render.photons": 1 << 16,
            "render.map_texel_mm": 0.75,
        }
    )


@pytest.fixture(scope="module")
def learnt(session: Session, sensor: Scene, tmp_path_factory: pytest.TempPathFactory) -> tuple[Calibration, Path]:
    """A calibration of one unknown, the contact law's modulus: eight points of one press."""
    folder = tmp_path_factory.mktemp("calibration")
    sweep = Sweep(
        sensor,
        set={CONTACT: {"name": "contact", "log_uniform": [60.0, 240.0]}},
        measures=["force"],
        design={"kind": "sobol", "points": 8},
        images={"format": "exr", "loads": "all"},
        random_numbers="own",
        name="design",
    )
    (folder / "design.toml").write_text(sweep.to_toml())
    (folder / "scene.toml").write_text(sensor.to_toml())
    heard: list[str] = []
    calibration = tirtouch.calibrate(
        {"design": folder / "design.toml"},
        folder / "out",
        session=session,
        progress=lambda what, done: heard.append(what),
    )
    assert heard
    return calibration, folder


def test_a_calibration_says_what_it_is_valid_for(
    learnt: tuple[Calibration, Path], sensor: Scene, command: Any
) -> None:
    calibration, folder = learnt
    assert calibration.depths_mm == [1.0, 2.0] and calibration.scores > 0 and not calibration.knows_empty
    [contact] = calibration.unknowns
    assert (contact.name, contact.keys) == ("contact", [CONTACT])
    assert contact.low == pytest.approx(60) and contact.high == pytest.approx(240)
    assert calibration.to_dict()["unknowns"] == [contact.to_dict()]
    assert calibration.scene == sensor and calibration.unsuited(sensor) is None
    assert "another stack.layer[0].n" in str(calibration.unsuited(sensor.set({"stack.layer[0].n": 1.42})))
    assert "from 60.0 to 240" in str(calibration.unsuited(sensor.set({CONTACT: 300.0})))
    # The command line goes on with the folder, and learns the same.
    (folder / "cal.toml").write_text('[calibrate]\ndesign = "out/design"\n')
    said = command("calibrate", str(folder / "cal.toml"), "-o", str(folder / "theirs"))
    assert (said["phantoms"], said["scores"]) == (8, calibration.scores)
    assert (folder / "theirs" / "calibration.json").read_bytes() == (folder / "out" / "calibration.json").read_bytes()


def test_frames_are_read_by_it(
    session: Session, learnt: tuple[Calibration, Path], sensor: Scene, tmp_path: Path
) -> None:
    calibration, folder = learnt
    images = session.render_loads(sensor.set({CONTACT: 150.0}), spp=16, photons=1 << 18)
    frames = [image.frame for image in images]
    found = tirtouch.estimate(frames, [1.0, 2.0], calibration=calibration, scene=sensor)
    contact = found.unknowns["contact"]
    assert contact and contact.low < 150 < contact.high and contact.high - contact.low < 120, contact
    of_file = tirtouch.estimate(frames, [1.0, 2.0], calibration=folder / "out" / "calibration.json", scene=sensor)
    assert of_file.unknowns == found.unknowns
    run = session.run(sensor, calibration=calibration, spp=16, photons=1 << 16)
    assert "no" in str(run.estimates.reason) and "mm deep" not in str(run.estimates.reason)
    calibration.write(tmp_path / "again.json")
    again = Calibration.open(tmp_path / "again.json")
    assert again.to_dict() == calibration.to_dict()
    other = tirtouch.estimate(frames, [1.0, 2.0], calibration=Calibration.ready(), scene=sensor)
    assert not other.unknowns and "equal blocks" in str(other.reason)


def test_what_cannot_be_learnt_says_why(session: Session, learnt: tuple[Calibration, Path], tmp_path: Path) -> None:
    _, folder = learnt
    with pytest.raises(TypeError, match="calibration file"):
        tirtouch.calibrate(3, tmp_path / "out")  # type: ignore[arg-type]
    with pytest.raises(tirtouch.SceneError, match="desing"):
        tirtouch.calibrate({"desing": "a.toml"}, tmp_path / "out", session=session)
    with pytest.raises(tirtouch.SceneError, match="none.toml"):
        tirtouch.calibrate(tmp_path / "none.toml", tmp_path / "out", session=session)
    with pytest.raises(tirtouch.TirtouchError, match="is no calibration"):
        Calibration.open(folder / "design.toml")
    with pytest.raises(tirtouch.Stopped):
        tirtouch.calibrate(
            {"design": folder / "out" / "design"}, tmp_path / "out", session=session, progress=lambda what, done: False
        )
    assert not (tmp_path / "out").exists()


def test_the_ready_calibration_is_there(learnt: tuple[Calibration, Path]) -> None:
    ready = Calibration.ready()
    assert {one.name for one in ready.unknowns} >= {"size", "depth", "youngs"} and ready.knows_empty
    assert ready.unsuited(Scene.preset("phantom-size-8mm")) is None
    assert np.isclose(next(one.low for one in ready.unknowns if one.name == "size"), 3.8)
