"""Pressure frames: arrays, features, the tissue that they are of."""

from __future__ import annotations

import pickle
from pathlib import Path
from typing import Any, Callable

import numpy as np
import pytest
import tirtouch
from tirtouch import Frames, Scan

Command = Callable[..., dict[str, Any]]

#: Not the same in two runs.
APART = {"seconds", "error_seconds"}


@pytest.fixture(scope="module")
def scan() -> Scan:
    """Five positions on a coarse mesh."""
    return Scan.preset("frames-galea").set(
        {"scan.positions_mm": {"from": -10.0, "to": 10.0, "count": 5}, "scan.frame_points": 65, "scan.resolution": 0.5}
    )


@pytest.fixture(scope="module")
def frames(scan: Scan) -> Frames:
    heard: list[tuple[str, float]] = []
    computed = Frames.scan(scan, progress=lambda what, done: heard.append((what, done)))
    assert heard and all(what and 0 <= done <= 1 for what, done in heard)
    return computed


def test_a_scan_is_a_scene_of_its_own_kind(scan: Scan, tmp_path: Path) -> None:
    assert "frames-galea" in Scan.presets() and scan.name == "frames-galea" and scan.description
    (tmp_path / "scan.toml").write_text(scan.to_toml())
    others = [Scan.open(tmp_path / "scan.toml"), Scan.from_dict(scan.to_dict()), pickle.loads(pickle.dumps(scan))]
    assert all(other == scan for other in others) and scan != Scan.preset("frames-galea")
    with pytest.raises(tirtouch.SceneError) as raised:
        scan.set({"scan.depth_mm": -1.0})
    assert (raised.value.file, raised.value.key) == ("frames-galea.toml", "scan.depth_mm")
    with pytest.raises(tirtouch.SceneError, match="camera: unknown key"):
        Scan.parse(tirtouch.Scene.preset("contact-disc").to_toml())


def test_frames_are_those_of_the_command_line(scan: Scan, frames: Frames, command: Command, tmp_path: Path) -> None:
    assert frames.positions_mm.tolist() == [-10, -5, 0, 5, 10] and len(frames) == 5 and frames.scanned == scan
    assert frames.pressure_kpa.shape == frames.without_kpa.shape == (5, 65) and frames.x_mm.shape == (65,)
    # Over the stiff inclusion the pressure is higher.
    assert frames.pressure_kpa[2].max() > 1.1 * frames.without_kpa[2].max()
    (tmp_path / "scan.toml").write_text(scan.to_toml())
    said = command("frames", "scan.toml", "-o", "out")
    ours = frames.to_dict()
    mechanics = ours["mechanics"], said["mechanics"]
    assert all({**one, **dict.fromkeys(APART)} == {**mechanics[0], **dict.fromkeys(APART)} for one in mechanics)
    del ours["mechanics"]
    assert ours == {key: said[key] for key in ours}
    features = frames.features()
    for name in ("position_mm", "peak_kpa", "fwhm_mm", "eccentricity"):
        assert features[name].tolist() == [one[name] for one in said["features"]], name
    assert frames.force_n_per_mm.tolist() == mechanics[0]["force_n_per_mm"]
    assert not np.array_equal(frames.features(window_mm=5.0)["peak_kpa"], features["peak_kpa"])

    # The table that it writes is read as measured frames.
    read = Frames.read(tmp_path / "out" / "frames.csv")
    assert np.allclose(read.pressure_kpa, frames.pressure_kpa, rtol=1e-6, atol=1e-9)
    assert read.scanned is None and read.without_kpa is None and read.force_n_per_mm is None
    measured = Frames.measured(read.positions_mm, read.x_mm, read.pressure_kpa)
    assert all(np.array_equal(a, b) for a, b in zip(measured.features().values(), read.features().values()))


def test_the_tissue_is_found_as_the_command_line_finds_it(
    scan: Scan, frames: Frames, command: Command, tmp_path: Path
) -> None:
    noisy = frames.noisy(0.01, seed=3)
    shares = noisy.pressure_kpa[2, 20:45] / frames.pressure_kpa[2, 20:45] - 1
    assert 0.003 < shares.std() < 0.03
    tissue = noisy.invert(scan, seed=3)
    (tmp_path / "scan.toml").write_text(scan.to_toml())
    said = command("frames", "scan.toml", "-o", "out", "--invert", "--noise-share", "0.01", "--seed", "3")
    assert tissue.to_dict() == said["tissue"] == frames.to_dict(tissue=tissue)["tissue"]
    assert tissue.depth_mm is None and tissue.reduced_chi_square > 0
    for value, truth in [(tissue.thickness_mm, 25.0), (tissue.tissue_youngs_kpa, 12.8)]:
        assert value and value.low < truth < value.high, value


def test_frames_that_make_no_sense_are_refused(scan: Scan, frames: Frames, tmp_path: Path) -> None:
    positions, x, pressure = frames.positions_mm, frames.x_mm, frames.pressure_kpa
    with pytest.raises(ValueError, match=r"\(5, 65\)"):
        Frames.measured(positions, x, pressure.T)
    with pytest.raises(ValueError, match="ascend"):
        Frames.measured(positions[::-1].copy(), x, pressure)
    with pytest.raises(ValueError, match="window_mm"):
        frames.features(window_mm=-1.0)
    with pytest.raises(ValueError, match="share"):
        frames.noisy(float("nan"))
    with pytest.raises(tirtouch.TirtouchError, match="none.csv"):
        Frames.read(tmp_path / "none.csv")
    two = scan.set({"phantom.inclusion[0].center_mm": [1.0, 0.0]})
    with pytest.raises(tirtouch.SceneError, match="round inclusion") as raised:
        frames.invert(two)
    assert raised.value.key == "phantom.inclusion[0]" and raised.value.file == "frames-galea.toml"
    with pytest.raises(tirtouch.TirtouchError, match="window"):
        frames.invert(scan, window_mm=100.0)
    with pytest.raises(tirtouch.Stopped):
        frames.noisy(0.01).invert(scan, progress=lambda what, done: False)


def test_a_scan_is_stopped(scan: Scan) -> None:
    with pytest.raises(tirtouch.Stopped):
        Frames.scan(scan, progress=lambda what, done: False)

    def bad(what: str, done: float) -> None:
        raise LookupError(what)

    with pytest.raises(LookupError):
        Frames.scan(scan, progress=bad)
