"""Data sets: what a sweep keeps loads as Hugging Face's imagefolder, and by NumPy."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest
from datasets import load_dataset
from tirtouch import Scene, Session, Sweep, SweepResults

SIZE = "phantom.inclusion[0].shape.diameter_mm"


@pytest.fixture(scope="module")
def presses(phantom: Scene) -> Scene:
    return phantom.set({"render.spp": 16, "render.photons": 1 << 14})


def kept(scene: Scene, session: Session, folder: Path, images: dict[str, object]) -> SweepResults:
    """A data set of three phantoms at two loads."""
    return Sweep(scene, set={SIZE: [6.0, 9.0, 12.0]}, images=images).run(folder, session=session)


def test_a_data_set_loads_as_an_image_folder(presses: Scene, session: Session, tmp_path: Path) -> None:
    images = {"loads": "all", "baseline": True, "masks": True, "test_share": 0.4}
    swept = kept(presses, session, tmp_path / "set", images)
    data = load_dataset("imagefolder", data_dir=str(swept.folder), cache_dir=str(tmp_path / "cache"))
    assert sum(len(split) for split in data.values()) == 6
    seen = set()
    for name, split in data.items():
        for item in split:
            frame, mask = (np.asarray(item[key]) for key in ("image", "mask"))
            assert frame.shape == mask.shape == (87, 116)
            assert item["split"] == name and item[SIZE] == item["true_size_mm"]
            # The mask is a disc of the inclusion's size, by the scale on the axis.
            found = 2 * np.sqrt(np.count_nonzero(mask) / np.pi) * item["mm_per_pixel"]
            assert found == pytest.approx(item["true_size_mm"], rel=0.05)
            assert np.asarray(item["baseline"]).shape == frame.shape
            seen.add((item["true_size_mm"], item["load"], item["press_depth_mm"]))
    assert seen == {(size, load, depth) for size in (6.0, 9.0, 12.0) for load, depth in ((0, 0.5), (1, 0.9))}
    # Harder presses give more light, and every frame is another one.
    sums = [int(np.asarray(item["image"], dtype=np.int64).sum()) for split in data.values() for item in split]
    assert len(set(sums)) == 6 and min(sums) > 0


def test_arrays_load_by_numpy(presses: Scene, session: Session, tmp_path: Path) -> None:
    swept = kept(presses, session, tmp_path / "set", {"format": "npy", "loads": "all", "pressures": True})
    with open(swept.folder / "train" / "metadata.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == 6
    for row in rows:
        light, pressure = (np.load(swept.folder / "train" / row[key]) for key in ("file_name", "pressure_npy"))
        assert light.shape == pressure.shape == (87, 116) and light.dtype == np.float32
        assert np.isfinite(light).all() and light.max() > 0
        # The phantom presses most where the lump is.
        middle = pressure[38:49, 52:64].mean()
        assert middle > 0 and 0.2 * middle < np.median(pressure) < 1.1 * middle
