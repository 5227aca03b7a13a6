"""Scenes that take a moment, a warm session, and the command line to compare with."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any, Callable

import pytest
import tirtouch

ROOT = Path(__file__).resolve().parents[2]
BINARY = Path(os.environ.get("TIRTOUCH_BINARY", ROOT / "target" / "ci" / "tirtouch"))

#: Samples of small images: as few as there may be.
FEW: dict[str, Any] = {"spp": 16, "photons": 1 << 14}


def smaller(scene: tirtouch.Scene, pixels: tuple[int, int]) -> tirtouch.Scene:
    """The same view in fewer pixels, each of which collects as much more light."""
    camera = scene.to_dict()["camera"]
    factor = camera["pixels"][0] / pixels[0]
    changes = {
        "camera.pixels[0]": pixels[0],
        "camera.pixels[1]": pixels[1],
        "camera.pixel_pitch_um": camera["pixel_pitch_um"] * factor,
        "camera.sensor.exposure_ms": camera["sensor"]["exposure_ms"] / factor**2,
    }
    return scene.set(changes)


def run_python(code: str, **environment: str) -> subprocess.Popen[str]:
    """Starts a program of its own."""
    return subprocess.Popen(
        [sys.executable, "-c", code],
        env=os.environ | environment,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


@pytest.fixture(scope="session")
def session() -> tirtouch.Session:
    opened = tirtouch.Session()
    if os.environ.get("TIRTOUCH_REQUIRE_GPU"):
        assert opened.backend == "gpu", opened.adapter
    return opened


@pytest.fixture(scope="session")
def disc() -> tirtouch.Scene:
    """A disc of contact on a flat stack."""
    return smaller(tirtouch.Scene.preset("contact-disc"), (64, 48))


@pytest.fixture(scope="session")
def phantom() -> tirtouch.Scene:
    """A phantom pressed to two loads, on a coarse map of the light."""
    values = smaller(tirtouch.Scene.preset("phantom-size-8mm"), (116, 87)).to_dict()
    values["press"] |= {"depths_mm": [0.5, 0.9], "estimate_error": False}
    values["render"]["map_texel_mm"] = 0.75
    return tirtouch.Scene.from_dict(values)


@pytest.fixture
def command(tmp_path: Path) -> Callable[..., dict[str, Any]]:
    """Runs the command line in a folder of the test's own; gives its JSON."""

    def run(*arguments: str) -> dict[str, Any]:
        done = subprocess.run(
            [BINARY, *arguments, "--json"], cwd=tmp_path, capture_output=True, text=True, timeout=300, check=False
        )
        assert done.stdout, done.stderr
        said: dict[str, Any] = json.loads(done.stdout)
        return said

    return run
