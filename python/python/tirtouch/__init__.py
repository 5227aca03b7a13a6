"""Simulator of the multilayer total-internal-reflection tactile sensor.

>>> import tirtouch
>>> session = tirtouch.Session()
>>> image = session.render(tirtouch.Scene.preset("contact-disc"), spp=16)
>>> image.radiance.shape
(288, 384)
"""

import os as _os

from ._errors import DeviceError, SceneError, Stopped, TirtouchError
from ._tirtouch import (
    Comparison,
    Estimates,
    Image,
    Load,
    Press,
    Radiance,
    Reading,
    Run,
    Scene,
    Session,
    Value,
    __version__,
    _drivers_environment,
    compare,
    estimate,
    read_radiance,
    schema,
)

# Read when a driver is loaded: software Vulkan then uses all of the CPU's width and does not complain of a missing
# compositor. What is set already stays.
_os.environ.update(_drivers_environment())

__all__ = [
    "Comparison",
    "DeviceError",
    "Estimates",
    "Image",
    "Load",
    "Press",
    "Radiance",
    "Reading",
    "Run",
    "Scene",
    "SceneError",
    "Session",
    "Stopped",
    "TirtouchError",
    "Value",
    "__version__",
    "compare",
    "estimate",
    "read_radiance",
    "schema",
]
