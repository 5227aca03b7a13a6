"""Labelled images from Python: how many a minute beside the same loop in the library?

    python benches/labelled_images.py --library target/release/examples/labelled_images [--images 8] [--rounds 3]

Runs the loop of labelled_images.rs (`--alone`) and the same from Python in turn, each in a process of its own: a
session opens, and each scene is loaded, pressed and traced to the error. Prints both rates of each round and their
ratio, and fails where the sum of an image's grey levels differs.
"""

import argparse
import os
import re
import subprocess
import sys
import tempfile
from pathlib import Path


def loop(folder: Path, images: int, error: float) -> None:
    """The loop in this process: prints the sums of grey levels, and images a minute."""
    import time

    start = time.perf_counter()
    import tirtouch

    session = tirtouch.Session()
    for number in range(images):
        image = session.render(tirtouch.Scene.open(folder / f"{number}.toml"), seed=number, target_error=error)
        print(f"grey {image.frame.sum(dtype='uint64')},")
    print(f"loop: {60 * images / (time.perf_counter() - start):.2f} images a minute")


def run(command: list) -> tuple[float, list[str]]:
    said = subprocess.run([str(word) for word in command], check=True, capture_output=True, text=True).stdout
    return float(re.findall(r"loop: ([\d.]+) images", said)[0]), re.findall(r"grey (\d+),", said)


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("--library", type=Path, required=True)
    parser.add_argument("--images", type=int, default=8)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--error", type=float, default=0.01)
    parser.add_argument("--loop", type=Path, help="the folder of scenes to loop over")
    asked = parser.parse_args()
    if asked.loop:
        loop(asked.loop, asked.images, asked.error)
        return
    # As the program and the package set it for themselves, where it is not set.
    os.environ.setdefault("LP_NATIVE_VECTOR_WIDTH", "512")
    number = ["--images", asked.images, "--error", asked.error]
    ratios = []
    with tempfile.TemporaryDirectory() as folder:
        for _ in range(asked.rounds):
            library, theirs = run([asked.library, "--alone", folder, *number])
            python, ours = run([sys.executable, __file__, "--library", asked.library, "--loop", folder, *number])
            if not theirs or ours != theirs:
                sys.exit(f"the images differ: {theirs} and {ours}")
            ratios.append(python / library)
            print(f"library {library:.1f}, Python {python:.1f} images a minute: {ratios[-1]:.3f}", flush=True)
    print(f"median {sorted(ratios)[len(ratios) // 2]:.3f}")


if __name__ == "__main__":
    main()
