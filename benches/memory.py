"""Does a session's memory grow from image to image?

    python benches/memory.py [--phantoms 200] [--images 5]

With the wheel installed, on Linux. Presses phantoms drawn at random on one session, renders each by so many seeds, and
prints the resident memory after every tenth phantom.
"""

import argparse
import random
import re
import time
from pathlib import Path

import tirtouch


def resident_mib() -> float:
    """Resident memory of this process, MiB."""
    status = Path("/proc/self/status").read_text()
    return int(re.search(r"VmRSS:\s+(\d+)", status).group(1)) / 1024


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--phantoms", type=int, default=200)
    parser.add_argument("--images", type=int, default=5, help="images of each")
    wanted = parser.parse_args()
    session, base, draw = tirtouch.Session(), tirtouch.Scene.preset("phantom-size-8mm"), random.Random(3)
    start = time.perf_counter()
    for number in range(1, wanted.phantoms + 1):
        diameter = draw.uniform(4, 14)
        depth = draw.uniform(3, min(10, 25 - 1.05 * diameter))
        scene = base.set(
            {
                "phantom.inclusion[0].shape.diameter_mm": diameter,
                "phantom.inclusion[0].depth_mm": depth,
                "phantom.inclusion[0].material.youngs_kpa": draw.uniform(20, 150),
                "press.estimate_error": False,
            }
        )
        for image in range(wanted.images):
            shot = session.render(scene, seed=number * wanted.images + image, spp=4, photons=1 << 16)
            assert shot.frame.any() and shot.radiance.any()
        if number % 10 == 0:
            seconds = time.perf_counter() - start
            print(f"{number * wanted.images} images: {resident_mib():.0f} MiB, {seconds:.0f} s", flush=True)


if __name__ == "__main__":
    main()
