"""Presses, runs and estimates."""

from __future__ import annotations

import csv
import pickle
from pathlib import Path
from typing import Any, Callable

import numpy as np
import pytest
import tirtouch
from conftest import FEW
from tirtouch import Scene, Session

Command = Callable[..., dict[str, Any]]

#: Keys of results that differ from run to run or are about files and the command.
NOT_COMPARED = {"command", "out", "version", "files"}


def without_times(said: Any) -> Any:
    """What is said, less how long it took."""
    if isinstance(said, dict):
        return {key: without_times(value) for key, value in said.items() if "second" not in key}
    return [without_times(value) for value in said] if isinstance(said, list) else said


def test_a_press_says_what_the_command_line_says(
    session: Session, phantom: Scene, command: Command, tmp_path: Path
) -> None:
    press = session.press(phantom)
    (tmp_path / "phantom.toml").write_text(phantom.to_toml())
    said = command("press", "phantom.toml", "-o", "out")
    ours = press.to_dict()
    assert without_times(ours) == without_times({key: said[key] for key in ours})
    assert said.keys() - ours.keys() <= NOT_COMPARED

    first, last = press.loads
    assert (first.depth_mm, last.depth_mm, last.slide_mm, last.hold_s) == (0.5, 0.9, (0, 0), 0)
    assert 0 < first.force_n < last.force_n and 0 < first.peak_pressure_kpa < last.peak_pressure_kpa
    assert last.peak_at_mm == (0, 0), "over the inclusion"
    for error in (last.force_error, last.pressure_error, last.peak_error):
        assert not error and "estimate_error" in str(error.reason)
    assert ours["mechanics"]["steps"] == [load.to_dict() for load in press.loads]

    with (tmp_path / "out" / "contact.csv").open() as file:
        rows = list(csv.DictReader(file))
    for load in press.loads:
        of_load = [row for row in rows if float(row["depth_mm"]) == load.depth_mm]
        assert ["depth_mm", *load.contact] == list(rows[0])
        for name, values in load.contact.items():
            assert values.dtype == np.float64
            # Ten digits are written.
            assert np.allclose(values, [float(row[name]) for row in of_load], rtol=1e-9, atol=0), name


def test_a_table_of_pandas(session: Session, phantom: Scene) -> None:
    pytest.importorskip("pandas")
    press = session.press(phantom)
    table = press.to_pandas()
    assert len(table) == sum(len(load.contact["r_mm"]) for load in press.loads)
    assert list(table.groupby("load")["depth_mm"].first()) == [0.5, 0.9]


def test_a_scene_that_presses_nothing_has_no_press(session: Session, disc: Scene) -> None:
    with pytest.raises(tirtouch.SceneError, match="no .press.") as raised:
        session.press(disc)
    assert raised.value.key == "press"
    with pytest.raises(tirtouch.TirtouchError, match="presses nothing"):
        session.render(disc, baseline=True, **FEW)


def test_a_press_that_stops_early_gives_what_it_reached(session: Session) -> None:
    values = Scene.preset("phantom-size-8mm").to_dict()
    # A flat phantom against a rigid face: elements of a coarse mesh are squeezed flat before the second depth.
    values["phantom"] |= {"shape": {"kind": "cylinder", "radius_mm": 30.0, "height_mm": 6.0}, "inclusion": []}
    values["press"] |= {"sensor": "rigid", "depths_mm": [1.0, 5.9], "estimate_error": False, "resolution": 0.25}
    with pytest.raises(tirtouch.PressError, match="stops at") as raised:
        session.press(Scene.from_dict(values, "flat.toml"))
    error = raised.value
    assert isinstance(error, tirtouch.TirtouchError) and error.file == "flat.toml"
    assert error.reached is not None
    [load] = error.reached.loads
    assert load.depth_mm == 1.0 and load.force_n > 0 and load.contact["pressure_kpa"].max() > 0
    again = pickle.loads(pickle.dumps(error))
    assert (type(again), str(again), again.file, again.reached) == (type(error), str(error), "flat.toml", None)


def test_a_run_says_what_the_command_line_says(
    session: Session, phantom: Scene, command: Command, tmp_path: Path
) -> None:
    run = session.run(phantom, seed=3, subtract_baseline=True, **FEW)
    (tmp_path / "phantom.toml").write_text(phantom.to_toml())
    flags = ["--seed", "3", "--spp", "16", "--photons", str(FEW["photons"]), "--subtract-baseline"]
    said = command("run", "phantom.toml", "-o", "out", *flags)
    ours = run.to_dict()
    assert without_times(ours) == without_times({key: said[key] for key in ours})
    assert said.keys() - ours.keys() <= NOT_COMPARED

    theirs = tirtouch.read_radiance(tmp_path / "out" / "radiance.exr")
    assert run.image is not None and np.array_equal(theirs.radiance, run.image.radiance)
    assert [image.depth_mm.value for image in run.images] == [0.5, 0.9]
    assert run.press is not None and len(run.press.loads) == 2
    assert run.reading.to_dict() == ours["paper"] and run.reading.to_dict()["reference"] == "baseline.png"
    assert run.image.baseline is not None and run.image.baseline.radiance.sum() < run.image.radiance.sum()
    # The calibration that comes with the program knows other loads.
    assert run.estimates.detected is None and "mm deep" in str(run.estimates.reason)
    assert run.estimates.to_dict()["estimates"] == ours["estimates"]


def test_images_of_all_loads_are_those_of_a_run(session: Session, phantom: Scene) -> None:
    images = session.render_loads(phantom, seed=3, **FEW)
    run = session.run(phantom, seed=3, **FEW)
    assert len(images) == 2
    assert all(np.array_equal(a.radiance, b.radiance) for a, b in zip(images, run.images))
    last = session.render(phantom, seed=3, baseline=True, **FEW)
    assert np.array_equal(last.radiance, images[-1].radiance)
    assert last.baseline is not None
    assert last.read(reference=last.baseline).sum_grey.value < last.read().sum_grey.value
    alone = session.render(phantom, seed=3, without_inclusions=True, **FEW)
    assert "no inclusion" in alone.to_dict()["truth"]["size_mm"]["undefined"]


@pytest.fixture(scope="module")
def known(session: Session) -> list[tirtouch.Image]:
    """Images of a phantom that the ready calibration knows."""
    values = Scene.preset("phantom-size-8mm").to_dict()
    values["camera"] |= {"pixels": [116, 87], "pixel_pitch_um": 3 * values["camera"]["pixel_pitch_um"]}
    values["camera"]["sensor"]["exposure_ms"] /= 9
    values["press"]["estimate_error"] = False
    values["render"]["map_texel_mm"] = 0.375
    return session.render_loads(Scene.from_dict(values), spp=16, photons=1 << 18)


def test_a_known_phantom_is_estimated_from_its_frames(session: Session, known: list[tirtouch.Image]) -> None:
    depths_mm = [image.depth_mm.value for image in known]
    frames = [image.frame for image in known]
    assert depths_mm == [1.0, 2.0, 4.0]
    found = tirtouch.estimate(frames, depths_mm, scene=known[0].scene)
    assert found.detected is True and found.reason is None
    for value, truth in [(found.size_mm, 8.0), (found.depth_mm, 5.0)]:
        assert value and value.low < truth < value.high, value
    assert found.unknowns["size"] == found.size_mm
    assert found.to_dict()["inferred"]["scores"] > 0
    # Forces of the same press tell more of the tissue, and twice as large ones are of none that is known.
    steps = session.press(known[0].scene).loads
    forces_n = np.array([load.force_n for load in steps])
    more = tirtouch.estimate(frames, depths_mm, forces_n=list(forces_n), scene=known[0].scene)
    width = [one.unknowns["phantom"].high - one.unknowns["phantom"].low for one in (found, more)]
    assert width[1] < 0.8 * width[0] and more.unknowns["phantom"].low < 5.0 < more.unknowns["phantom"].high
    wrong = tirtouch.estimate(frames, depths_mm, forces_n=list(2 * forces_n), scene=known[0].scene)
    assert wrong.detected is None and "forces" in wrong.reason
    # The calibration's own camera, read with so many pixels, has another exposure: these frames are not as bright.
    other = tirtouch.estimate(frames, depths_mm)
    assert other.detected is None and not other.size_mm and other.reason and not other.unknowns
    # Frames of the wrong loads say something else, or nothing.
    swapped = tirtouch.estimate(frames[::-1], depths_mm, scene=known[0].scene)
    assert swapped.detected is None


def test_frames_that_make_no_sense_are_refused(known: list[tirtouch.Image], tmp_path: Path) -> None:
    frames, scene = [image.frame for image in known], known[0].scene
    with pytest.raises(ValueError, match="2 depths for 3 frames"):
        tirtouch.estimate(frames, [1.0, 2.0])
    with pytest.raises(ValueError, match="twice"):
        tirtouch.estimate(frames, [1.0, 2.0, 2.0])
    with pytest.raises(ValueError, match="2 forces for 3 frames"):
        tirtouch.estimate(frames, [1.0, 2.0, 4.0], forces_n=[0.1, 0.2])
    with pytest.raises(ValueError, match="above 0"):
        tirtouch.estimate(frames, [1.0, 2.0, 4.0], forces_n=[0.1, -0.2, 0.3])
    with pytest.raises(TypeError, match=r"frames\[1\]"):
        tirtouch.estimate([frames[0], frames[1].astype(float)], [1.0, 2.0], scene=scene)
    with pytest.raises(ValueError, match="255"):
        tirtouch.estimate([frames[0].astype(np.uint16) + 256], [1.0], scene=scene)
    with pytest.raises(ValueError, match=r"frames\[0\]"):
        tirtouch.estimate([np.zeros((0, 0), np.uint8)], [1.0], scene=scene)
    assert not tirtouch.estimate([frames[0][:, :50]], [1.0], scene=scene).size_mm
    with pytest.raises(tirtouch.TirtouchError, match="none.json"):
        tirtouch.estimate(frames, [1.0, 2.0, 4.0], calibration=tmp_path / "none.json")
