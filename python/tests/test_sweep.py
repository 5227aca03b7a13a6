"""Sweeps: the same records and bits as the command line's, stopped and gone on with."""

from __future__ import annotations

import json
import pickle
import signal
from pathlib import Path
from typing import Any, Callable

import numpy as np
import pytest
import tirtouch
from conftest import run_python, smaller
from tirtouch import Scene, SceneError, Session, Sweep, SweepResults

SET = {"stack.layer[0].n": [1.40, 1.41], "led[*].radiance_w_per_m2_sr": [1.0, 2.0, 3.0]}
MEASURES = ["mean_radiance", "contrast radius_mm=4"]


@pytest.fixture(scope="module")
def few() -> Scene:
    """A disc of contact of few pixels and few samples."""
    scene = smaller(Scene.preset("contact-disc"), (48, 36))
    return scene.set({"render.spp": 16, "render.photons": 1 << 14, "render.map_texel_mm": 0.5})


@pytest.fixture(scope="module")
def swept(session: Session, few: Scene, tmp_path_factory: pytest.TempPathFactory) -> SweepResults:
    folder = tmp_path_factory.mktemp("sweep") / "out"
    return Sweep(few, set=SET, measures=MEASURES).run(folder, session=session)


def test_a_sweep_is_that_of_the_command_line(
    swept: SweepResults, few: Scene, command: Callable[..., dict[str, Any]], tmp_path: Path
) -> None:
    (tmp_path / "scene.toml").write_text(few.to_toml())
    keys = [f"--set={key}={','.join(str(value) for value in values)}" for key, values in SET.items()]
    measures = [f"--measure={measure}" for measure in MEASURES]
    said = command("sweep", "scene.toml", *keys, *measures, "-o", "theirs")
    ours = swept.to_dict()
    assert {key: value for key, value in said.items() if key in ours}.keys() == ours.keys()
    apart = {"seconds", "points_per_minute"}
    assert all(said[key] == ours[key] for key in ours.keys() - apart) and ours["done"] == 6
    assert (swept.folder / "points.csv").read_bytes() == (tmp_path / "theirs" / "points.csv").read_bytes()
    # Each reads the other's folder.
    assert command("sweep", "status", str(swept.folder))["done"] == 6
    theirs = SweepResults.open(tmp_path / "theirs")
    for name, column in theirs.points().items():
        assert np.array_equal(column, swept.points()[name], equal_nan=not isinstance(column, list)), name
    assert (theirs.seconds, theirs.sweep.name) == (None, "contact-disc-sweep")
    result = json.loads((swept.folder / "result.json").read_text())
    assert result["command"] == ["tirtouch for Python"] and result["points_per_minute"] == ours["points_per_minute"]


def test_points_are_columns(swept: SweepResults) -> None:
    points = swept.points()
    assert len(swept.sweep) == 6 and all(len(column) == 6 for column in points.values())
    assert points["row"].dtype == np.int64 and points["status"] == ["done"] * 6
    assert points["led[*].radiance_w_per_m2_sr"].tolist() == [1, 2, 3, 1, 2, 3]
    light = points["mean_radiance_w_m2_sr"]
    assert np.all((points["mean_radiance_w_m2_sr_low"] < light) & (light < points["mean_radiance_w_m2_sr_high"]))
    # The same random numbers: twice the power is twice the light.
    assert np.allclose(light[1] / light[0], 2, rtol=1e-5)
    assert points["note"] == [None] * 6
    assert swept.to_pandas().shape == (6, len(points))
    assert swept.sweep.variables == list(SET) and swept.sweep.figures == ["mean_radiance_w_m2_sr", "contrast"]


def test_a_row_has_its_scene(swept: SweepResults, session: Session, few: Scene) -> None:
    scene = swept.scene(4)
    assert scene == few.set({"stack.layer[0].n": 1.41, "led[*].radiance_w_per_m2_sr": 2.0}) == swept.sweep.scene(4)
    with pytest.raises(IndexError, match="no row 6"):
        swept.scene(6)
    # A point draws what the sweep's scene draws.
    assert swept.sweep.base == few
    first = few.set({"stack.layer[0].n": 1.40, "led[*].radiance_w_per_m2_sr": 1.0})
    light = session.render(first).to_dict()["mean_radiance"]
    assert light == pytest.approx(swept.points()["mean_radiance_w_m2_sr"][0], rel=0.1)


def test_a_sweep_that_was_stopped_goes_on(session: Session, few: Scene, swept: SweepResults, tmp_path: Path) -> None:
    sweep = Sweep(few, set=SET, measures=MEASURES)
    with pytest.raises(tirtouch.TirtouchError, match="no records"):
        sweep.status(tmp_path / "out")
    heard: list[float] = []

    def until_two(what: str, done: float) -> bool:
        heard.append(done)
        return done < 2 / 6

    with pytest.raises(tirtouch.Stopped, match="what was done is in .*out"):
        sweep.run(tmp_path / "out", session=session, progress=until_two)
    with pytest.raises(tirtouch.Stopped, match="^stopped on request$"):
        session.render(few, progress=lambda what, done: False)
    before = sweep.status(tmp_path / "out")
    assert 0 < before.done < 6 == before.points and heard[-1] >= 2 / 6
    kept = {file: file.read_bytes() for file in (tmp_path / "out" / "items").glob("0*.json")}
    with pytest.raises(tirtouch.TirtouchError, match="resume=True") as raised:
        sweep.run(tmp_path / "out", session=session)
    assert raised.value.file == str(tmp_path / "out") and "--" not in str(raised.value)
    again = sweep.run(tmp_path / "out", session=session, resume=True)
    assert again.status().done == 6 and again.status().workers == 0
    assert all(file.read_bytes() == text for file, text in kept.items()) and kept
    assert (again.folder / "points.csv").read_bytes() == (swept.folder / "points.csv").read_bytes()


def test_ctrl_c_stops_a_sweep_and_it_goes_on(few: Scene, session: Session, tmp_path: Path) -> None:
    # What a shell starts in the background ignores Ctrl-C, and so would its children. The last point takes for ever: at
    # more than two thirds it is under way, at two thirds the second may be traced and not yet written down.
    (tmp_path / "scene.toml").write_text(few.to_toml())
    code = f"""
import signal, tirtouch
signal.signal(signal.SIGINT, signal.default_int_handler)
scene = tirtouch.Scene.open({str(tmp_path / "scene.toml")!r})
sweep = tirtouch.Sweep(scene, set={{"render.photons": [1 << 14, 1 << 15, 10**12]}}, measures=["mean_radiance"])
told = lambda what, done: print("last" if done > 2 / 3 else "first", flush=True)
try:
    sweep.run({str(tmp_path / "out")!r}, progress=told)
except KeyboardInterrupt:
    print("interrupted", sweep.status({str(tmp_path / "out")!r}).done)
"""
    child = run_python(code)
    assert child.stdout is not None
    while child.stdout.readline() == "first\n":
        pass
    child.send_signal(signal.SIGINT)
    out, err = child.communicate(timeout=60)
    assert (child.returncode, err) == (0, "") and out.endswith("interrupted 2\n")
    results = SweepResults.open(tmp_path / "out")
    assert results.points()["status"] == ["done", "done", "missing"] and results.status().workers == 0
    again = results.sweep.run(tmp_path / "out", session=session, resume=True, shard=(1, 3))
    assert again.status().done == 2


def test_shards_make_the_whole(session: Session, few: Scene, swept: SweepResults, tmp_path: Path) -> None:
    sweep = Sweep(few, set=SET, measures=MEASURES)
    for k in (1, 2):
        part = sweep.run(tmp_path / "out", session=session, resume=True, shard=(k, 2), workers=1)
        assert part.status().done == 3 * k
    assert (part.folder / "points.csv").read_bytes() == (swept.folder / "points.csv").read_bytes()
    with pytest.raises(ValueError, match="shard"):
        sweep.run(tmp_path / "out", session=session, resume=True, shard=(3, 2))
    with pytest.raises(ValueError, match="workers"):
        sweep.run(tmp_path / "out", session=session, resume=True, workers=0)
    (part.folder / "points.csv").unlink()
    assert part.collect().done == 6
    assert (part.folder / "points.csv").read_bytes() == (swept.folder / "points.csv").read_bytes()
    other = Sweep(few, set=SET, measures=MEASURES, seed=7)
    with pytest.raises(tirtouch.TirtouchError, match="another"):
        other.status(tmp_path / "out")


def test_a_sweep_comes_from_a_file_a_dictionary_and_by_hand(few: Scene, tmp_path: Path) -> None:
    (tmp_path / "scene.toml").write_text(few.to_toml())
    values = {
        "sweep": {"scene": "scene.toml", "design": {"kind": "sobol", "points": 8}, "random_numbers": "common"},
        "vary": [{"key": "stack.layer[0].n", "uniform": [1.40, 1.44]}],
        "require": [{"expression": "1 > 0"}],
        "measure": [{"kind": "mean_radiance"}],
    }
    made = Sweep.from_dict(values, tmp_path / "top.toml")
    (tmp_path / "top.toml").write_text(made.to_toml())
    opened = Sweep.open(tmp_path / "top.toml")
    by_hand = Sweep(
        few,
        set={"stack.layer[0].n": {"uniform": [1.40, 1.44]}},
        measures=[{"kind": "mean_radiance"}],
        design={"kind": "sobol", "points": 8},
        require=["1 > 0"],
    )
    again = pickle.loads(pickle.dumps(by_hand))
    assert [len(one) for one in (made, opened, by_hand, again)] == [8] * 4 and made.name == "top"
    assert made.to_dict() == opened.to_dict() == by_hand.to_dict() == again.to_dict()
    assert Sweep(few, set=SET).figures == ["mean_radiance_w_m2_sr"]
    assert Sweep(few, set=SET, images={"format": "png", "loads": "last"}).figures == []
    assert all(one.scene(3) == made.scene(3) != made.scene(4) for one in (opened, by_hand, again))


def test_what_makes_no_sweep_says_why(few: Scene, tmp_path: Path) -> None:
    def by_hand(**changes: Any) -> Sweep:
        return Sweep(few, **({"set": SET, "measures": MEASURES} | changes))

    for changes, words in [
        ({"set": {"stack.layer[9].n": [1.4]}}, "4 elements"),
        ({"set": {"stack.layer[0].n": {"uniform": [1.5, 1.4]}}}, "width"),
        ({"measures": []}, "measure"),
        ({"measures": None, "set": {"stack.layer[0].n": [1.4, 1.4]}, "target_error": -1.0}, "target_error"),
        ({"measures": ["force"]}, "press"),
        ({"design": {"kind": "sobel"}}, "sobel"),
    ]:
        with pytest.raises(SceneError, match=words):
            by_hand(**changes)
    with pytest.raises(ValueError, match=r"measures\[0\]"):
        by_hand(measures=["contrats"])
    with pytest.raises(TypeError, match=r"measures\[1\]"):
        by_hand(measures=["contrast", 3])
    text = 'sweep = { scene = "preset:contact-disc", design = { kind = "grid" } }\nvry = []\n'
    with pytest.raises(SceneError) as raised:
        Sweep.parse(text, tmp_path / "bad.toml")
    assert (raised.value.file, raised.value.line, raised.value.key) == (str(tmp_path / "bad.toml"), 2, "vry")
    with pytest.raises(tirtouch.TirtouchError, match="records"):
        SweepResults.open(tmp_path)


def test_points_that_make_no_scene_stop_nothing(session: Session, few: Scene, tmp_path: Path) -> None:
    sweep = Sweep(few, set={"stack.layer[0].n": [1.40, -1.0]}, measures=["mean_radiance"])
    results = sweep.run(tmp_path / "out", session=session)
    assert (results.status().done, results.status().rejected) == (1, 1)
    points = results.points()
    assert points["status"] == ["done", "rejected"] and np.isnan(points["mean_radiance_w_m2_sr"][1])
    assert points["note"][0] is None and "stack.layer[0].n" in points["note"][1]
    with pytest.raises(SceneError, match="stack.layer"):
        results.scene(1)
