"""Results as tables of other packages, which are imported when they are asked for."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    import xarray

    from ._tirtouch import Image, Press, SweepResults


def press_to_pandas(press: Press) -> Any:
    """The contact of all loads, below one another, as a pandas.DataFrame."""
    import pandas

    frames = []
    for number, load in enumerate(press.loads):
        slide_x_mm, slide_y_mm = load.slide_mm
        own = {
            "load": number,
            "depth_mm": load.depth_mm,
            "slide_x_mm": slide_x_mm,
            "slide_y_mm": slide_y_mm,
            "hold_s": load.hold_s,
        }
        columns = load.contact
        length = len(columns["pressure_kpa"])
        frames.append(pandas.DataFrame({name: np.full(length, value) for name, value in own.items()} | columns))
    return pandas.concat(frames, ignore_index=True)


def points_to_pandas(results: SweepResults) -> Any:
    """The points of a sweep as a pandas.DataFrame."""
    import pandas

    return pandas.DataFrame(results.points())


def image_to_xarray(image: Image) -> xarray.Dataset:
    """Radiance, variance and grey levels over the touched face."""
    import xarray

    height, width = image.radiance.shape
    scale = image.mm_per_pixel
    coordinates = {
        "y_mm": ("y_mm", (height / 2 - 0.5 - np.arange(height)) * scale, {"units": "mm"}),
        "x_mm": ("x_mm", (np.arange(width) + 0.5 - width / 2) * scale, {"units": "mm"}),
    }
    dims = ("y_mm", "x_mm")
    return xarray.Dataset(
        {
            "radiance": (dims, image.radiance, {"units": "W/(m^2 sr)"}),
            "variance": (dims, image.variance, {"units": "(W/(m^2 sr))^2"}),
            "frame": (dims, image.frame, {"units": "grey levels"}),
        },
        coords=coordinates,
        attrs={"scene": image.scene.name, "seed": image.seed, "adapter": image.adapter},
    )
