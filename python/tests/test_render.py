"""Images: arrays, bits, figures, files."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Callable

import numpy as np
import pytest
import tirtouch
from conftest import FEW
from tirtouch import Scene, Session

Command = Callable[..., dict[str, Any]]


@pytest.fixture(scope="module")
def image(session: Session, disc: Scene) -> tirtouch.Image:
    return session.render(disc, seed=7, **FEW)


def test_arrays_have_the_promised_types_and_shapes(session: Session, disc: Scene, image: tirtouch.Image) -> None:
    for array, kind in [(image.radiance, np.float32), (image.variance, np.float32), (image.frame, np.uint8)]:
        assert (array.dtype, array.shape) == (kind, (48, 64))
        assert not array.flags.writeable and array.flags.c_contiguous
    assert image.radiance is image.radiance
    assert image.radiance.max() > 0 and image.frame.max() > 0
    # The disc lies in the middle.
    assert image.radiance[20:28, 28:36].mean() > 2 * image.radiance[:8].mean()
    of_12_bits = session.render(disc.set({"camera.sensor.bit_depth": 12}), seed=7, **FEW)
    assert of_12_bits.frame.dtype == np.uint16 and of_12_bits.frame.max() > 255


def test_figures_of_an_image(session: Session, disc: Scene, image: tirtouch.Image) -> None:
    assert abs(image.ledger["residual"]) < 1e-6 and image.ledger["emitted"] == 1
    error = image.relative_error
    assert error and error.value is not None and 0 < error.value < 1 and error.reason is None
    assert (image.seed, image.scene, image.baseline) == (7, disc, None)
    assert image.adapter == session.adapter and image.mm_per_pixel > 0
    assert not image.depth_mm and "presses nothing" in str(image.depth_mm.reason)
    said = image.to_dict()
    assert said["ledger"] == image.ledger and said["relative_error"] == error.value
    assert "undefined" in said["truth"]["size_mm"]


def test_the_same_seed_gives_the_same_bits_as_the_command_line(
    image: tirtouch.Image, disc: Scene, command: Command, tmp_path: Path
) -> None:
    (tmp_path / "disc.toml").write_text(disc.to_toml())
    said = command("render", "disc.toml", "-o", "out", "--seed", "7", "--spp", "16", "--photons", str(FEW["photons"]))
    theirs = tirtouch.read_radiance(tmp_path / "out" / "radiance.exr")
    assert np.array_equal(theirs.radiance, image.radiance)
    assert np.array_equal(theirs.variance, image.variance)
    ours = image.to_dict()
    for key in ["mean_radiance", "relative_error", "block_errors", "ledger", "camera", "adapter", "stream", "truth"]:
        assert ours[key] == said[key], key
    assert said.keys() - ours.keys() <= {"command", "out", "version", "files"}, said.keys() - ours.keys()
    assert ours.keys() <= said.keys()


def test_another_seed_gives_other_bits(session: Session, disc: Scene, image: tirtouch.Image) -> None:
    again, other = (session.render(disc, seed=seed, **FEW) for seed in (7, 8))
    assert np.array_equal(again.radiance, image.radiance) and np.array_equal(again.frame, image.frame)
    assert not np.array_equal(other.radiance, image.radiance)


def test_light_that_is_traced_is_exposed_anew(
    image: tirtouch.Image, disc: Scene, command: Command, tmp_path: Path
) -> None:
    again = image.expose()
    assert np.array_equal(again.frame, image.frame) and again.frame.dtype == np.uint8
    assert not again.frame.flags.writeable and again.frame is again.frame
    other = image.expose(seed=5)
    assert other.seed == 5 and not np.array_equal(other.frame, image.frame)
    dim, brighter = (image.expose(exposure_ms=again.exposure_ms / k, bit_depth=12) for k in (16, 8))
    assert brighter.frame.dtype == np.uint16 and (brighter.bit_depth, brighter.seed) == (12, again.seed)
    assert brighter.saturated_pixels == 0 and brighter.frame.mean() == pytest.approx(2 * dim.frame.mean(), rel=0.05)
    assert again.suggested_ms and image.expose(exposure_ms=1e3 * again.exposure_ms).saturated_pixels > 0
    for bad in [{"exposure_ms": -1.0}, {"bit_depth": 7}, {"bit_depth": 17}]:
        with pytest.raises(ValueError, match="camera.sensor"):
            image.expose(**bad)

    image.write(tmp_path / "radiance.exr")
    (tmp_path / "disc.toml").write_text(disc.to_toml())
    said = command("expose", "radiance.exr", "--scene", "disc.toml", "--exposure-ms", "2.5", "-o", "out")
    of_file = tirtouch.read_radiance(tmp_path / "radiance.exr").expose(disc, exposure_ms=2.5)
    ours = image.expose(exposure_ms=2.5)
    assert ours.to_dict() == of_file.to_dict() == {key: said[key] for key in ours.to_dict()}
    assert np.array_equal(ours.frame, of_file.frame)
    ours.write(tmp_path / "camera.png")
    assert (tmp_path / "camera.png").read_bytes() == (tmp_path / "out" / "camera.png").read_bytes()
    with pytest.raises(ValueError, match="png"):
        ours.write(tmp_path / "camera.exr")
    with pytest.raises(tirtouch.SceneError, match="64"):
        tirtouch.read_radiance(tmp_path / "radiance.exr").expose(disc.set({"camera.pixels": [32, 24]}))


def test_what_is_understood_of_a_scene_is_what_the_command_line_says(
    session: Session, disc: Scene, phantom: Scene, command: Command, tmp_path: Path
) -> None:
    (tmp_path / "disc.toml").write_text(disc.to_toml())
    (tmp_path / "phantom.toml").write_text(phantom.to_toml())
    for name, scene in [("disc", disc), ("phantom", phantom)]:
        seen, said = session.inspect(scene), command("inspect", f"{name}.toml")
        ours = seen.to_dict()
        for press in [ours["press"], said["press"]]:
            # What the system has free changes.
            assert press is None or press.pop("memory_limit_gib") > 0
        assert ours == {key: said[key] for key in ours}
        assert said.keys() - seen.to_dict().keys() <= {"command", "out", "version"}
        assert seen.integrator and seen.why and seen.regimes and seen.gains is None
        assert str(seen).startswith(f"{scene.name}: ")
    assert session.inspect(disc).press is None and session.inspect(phantom).press["dofs"] > 0
    assert 0 < session.inspect(disc).launch_cone_deg <= 180
    assert session.inspect(disc).to_dict()["adapter"] == session.adapter
    with pytest.raises(ValueError, match="rounds"):
        session.inspect(disc, gains=True, rounds=1)
    small = disc.set({"camera.pixels": [16, 12]})
    gains = session.inspect(small, gains=True, rounds=2).gains
    assert gains and all(gain["same_image"] for gain in gains)


def test_what_is_written_is_read_again(image: tirtouch.Image, tmp_path: Path) -> None:
    image.write(tmp_path / "radiance.exr")
    read = tirtouch.read_radiance(tmp_path / "radiance.exr")
    assert np.array_equal(read.radiance, image.radiance) and np.array_equal(read.variance, image.variance)
    assert read.provenance is not None and read.provenance["seed"] == 7
    image.write(tmp_path / "camera.png")
    assert (tmp_path / "camera.png").read_bytes().startswith(b"\x89PNG")
    with pytest.raises(ValueError, match="jpg"):
        image.write(tmp_path / "camera.jpg")
    with pytest.raises(tirtouch.TirtouchError) as raised:
        image.write(tmp_path / "nowhere" / "radiance.exr")
    assert raised.value.file == str(tmp_path / "nowhere" / "radiance.exr")
    with pytest.raises(tirtouch.TirtouchError):
        tirtouch.read_radiance(tmp_path / "camera.png")


def test_images_of_two_seeds_are_the_same_light_and_brighter_ones_are_not(
    session: Session, disc: Scene, command: Command, tmp_path: Path
) -> None:
    brighter = disc.set({"led[*].radiance_w_per_m2_sr": 1.3})
    for name, scene, seed in [("a", disc, 1), ("b", disc, 2), ("c", brighter, 3)]:
        session.render(scene, seed=seed, **FEW).write(tmp_path / f"{name}.exr")
    same = tirtouch.compare(tmp_path / "a.exr", tmp_path / "b.exr")
    assert same and same.passed and abs(same.ratio.value - 1) < 0.1
    different = tirtouch.compare(tmp_path / "a.exr", tmp_path / "c.exr")
    assert not different and abs(different.ratio.value - 1.3) < 0.1
    for name, found in [("b", same), ("c", different)]:
        said = command("compare", "a.exr", f"{name}.exr")
        ours = found.to_dict()
        assert ours == {key: said[key] for key in ours}
        assert said.keys() - ours.keys() <= {"a", "b", "command", "version", "out"}
    with pytest.raises(tirtouch.TirtouchError, match="none.exr"):
        tirtouch.compare(tmp_path / "a.exr", tmp_path / "none.exr")


def test_a_reading_has_the_papers_figures(image: tirtouch.Image) -> None:
    reading = image.read()
    assert reading.lit_pixels == int((image.frame > 5).sum()) and reading.threshold_grey == 5
    assert reading.diameter_mm.low < reading.diameter_mm.value < reading.diameter_mm.high
    column, row = reading.centroid_px
    assert abs(column.value - 32) < 4 and abs(row.value - 24) < 4
    assert reading.to_dict()["lit_pixels"] == reading.lit_pixels
    higher = image.read(threshold="50%")
    assert higher.threshold_grey == 127.5 and higher.lit_pixels < reading.lit_pixels
    nothing = image.read(reference=image)
    assert nothing.lit_pixels == 0 and nothing.sum_grey.value == 0
    for bad in ["", "200%", -1.0, float("nan")]:
        with pytest.raises(ValueError, match="threshold"):
            image.read(threshold=bad)
    with pytest.raises(TypeError):
        image.read(threshold=[])


def test_a_reference_of_another_size_is_refused(session: Session, disc: Scene, image: tirtouch.Image) -> None:
    small = session.render(disc.set({"camera.pixels[1]": 32}), **FEW)
    with pytest.raises(tirtouch.SceneError, match="64 x 32"):
        image.read(reference=small)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"spp": 0}, "spp"),
        ({"photons": 0}, "photons"),
        ({"seconds": float("inf")}, "seconds"),
        ({"target_error": -0.1}, "target_error"),
        ({"seconds": 1, "spp": 16}, "one of"),
        ({"seconds": 1, "target_error": 0.1}, "one of"),
        ({"integrator": "bdpt"}, "auto, path, splat or map"),
        ({"without_inclusions": True}, "press"),
    ],
)
def test_arguments_that_make_no_sense(session: Session, disc: Scene, options: dict[str, Any], words: str) -> None:
    with pytest.raises(ValueError, match=words):
        session.render(disc, **options)


def test_a_table_of_xarray(image: tirtouch.Image) -> None:
    pytest.importorskip("xarray")
    table = image.to_xarray()
    assert table["radiance"].shape == (48, 64) and table.attrs["scene"] == "contact-disc"
    assert np.array_equal(table["frame"].values, image.frame)
    assert table["y_mm"][0] > table["y_mm"][-1] and table["x_mm"][0] == -table["x_mm"][-1]
