"""Simulator of the multilayer total-internal-reflection tactile sensor.

>>> import tirtouch
>>> session = tirtouch.Session()
>>> image = session.render(tirtouch.Scene.preset("contact-disc"), spp=16)
>>> image.radiance.shape
(288, 384)
"""

import os as _os

from ._errors import DeviceError, PressError, SceneError, Stopped, TirtouchError
from ._tirtouch import (
    Calibration,
    Comparison,
    Estimates,
    Exposure,
    Frames,
    Image,
    Inspection,
    Load,
    Press,
    Radiance,
    Reading,
    Run,
    Scan,
    Scene,
    Session,
    Sweep,
    SweepResults,
    SweepStatus,
    Tissue,
    Unknown,
    Value,
    __version__,
    _drivers_environment,
    calibrate,
    compare,
    estimate,
    read_radiance,
    schema,
)

# Read when a driver is loaded: software Vulkan then uses all of the CPU's width and does not complain of a missing
# compositor. What is set already stays.
_os.environ.update(_drivers_environment())

__all__ = [
    "Calibration",
    "Comparison",
    "DeviceError",
    "Estimates",
    "Exposure",
    "Frames",
    "Image",
    "Inspection",
    "Load",
    "Press",
    "PressError",
    "Radiance",
    "Reading",
    "Run",
    "Scan",
    "Scene",
    "SceneError",
    "Session",
    "Stopped",
    "Sweep",
    "SweepResults",
    "SweepStatus",
    "TirtouchError",
    "Tissue",
    "Unknown",
    "Value",
    "__version__",
    "calibrate",
    "compare",
    "estimate",
    "read_radiance",
    "schema",
]
