"""The sweeps that programs of this folder stop, send and time, and what their folders end with."""

import subprocess
import time
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent.parent
PROGRAM = ROOT / "target/release/tirtouch"


def changed(name, changes):
    """The text of a scene of the program with lines in place of others."""
    text = (ROOT / f"scenes/{name}.toml").read_text()
    for old, new in changes.items():
        assert old in text, f"{old} is not in {name}"
        text = text.replace(old, new)
    return text


# The paper's field of view in more pixels.
CAMERA = {"pixels = [348, 261]": "pixels = [384, 288]", "pixel_pitch_um = 18.6": "pixel_pitch_um = 16.86"}
FEW = {
    "pixels = [384, 288]": "pixels = [64, 48]",
}
COARSE = {
    "pixels = [348, 261]": "pixels = [32, 24]",
    "depths_mm = [1.0, 2.0, 4.0]": "depths_mm = [0.5, 1.0]\nresolution = 0.5\nestimate_error = false",
}
INDEX = "stack.layer[0].n"
DISC_SWEEP = f"""[sweep]
scene = "scene.toml"
design = {{ kind = "grid" }}
[[vary]]
key = "{INDEX}"
linear = {{ from = 1.40, to = 1.43, points = 12 }}
[[vary]]
key = "touch.contact.pressure.radius_mm"
values = [3, 4]
[[measure]]
kind = "mean_radiance"
[[measure]]
kind = "contrast"
"""
# Eight points share each press.
SET_SWEEP = f"""[sweep]
scene = "scene.toml"
design = {{ kind = "grid" }}
images = {{ loads = "all", baseline = true, masks = true, pressures = true, test_share = 0.3 }}
[[vary]]
key = "phantom.inclusion[0].shape.diameter_mm"
values = [6, 8, 10]
[[vary]]
key = "{INDEX}"
linear = {{ from = 1.40, to = 1.43, points = 8 }}
[[measure]]
kind = "force"
[[measure]]
kind = "snr"
"""
INDEX_SWEEP = f"""[sweep]
scene = "scene.toml"
design = {{ kind = "grid" }}
target_error = 0.01
[[vary]]
key = "{INDEX}"
linear = {{ from = 1.40, to = 1.44, points = POINTS }}
[[measure]]
kind = "contrast"
"""


@dataclass(frozen=True)
class Case:
    """A sweep of a scene, of so many points, and what traces it."""

    scene: str
    sweep: str
    points: int
    backend: str = "cpu"

    def write(self, work):
        (work / "scene.toml").write_text(self.scene)
        (work / "sweep.toml").write_text(self.sweep)

    def command(self, out, *more):
        return [PROGRAM, "sweep", "run", "sweep.toml", "-o", out, "--backend", self.backend, "--quiet", *more]

    def whole(self, work):
        """Writes the sweep to a folder and runs it there: what it ends with, and the seconds that it took."""
        self.write(work)
        start = time.monotonic()
        subprocess.run(self.command("whole"), cwd=work, check=True, stdout=subprocess.DEVNULL)
        return ends(work / "whole"), time.monotonic() - start


def ends(folder):
    """Table, labels and images of a folder, byte by byte."""
    files = [folder / "points.csv", *folder.glob("train/*"), *folder.glob("test/*")]
    return {str(path.relative_to(folder)): path.read_bytes() for path in sorted(files)}


def index(points):
    """The index of the touched layer of a pressed phantom, 384 x 288 pixels to 1 %."""
    return Case(changed("phantom-size-8mm", CAMERA), INDEX_SWEEP.replace("POINTS", str(points)), points, "auto")


RENDER = "\n[render]\nphotons = 131072\nspp = 32\nmap_texel_mm = 0.5\n"
CASES = {
    "disc": Case(changed("contact-disc", FEW) + RENDER, DISC_SWEEP, 24),
    "set": Case(changed("phantom-size-8mm", COARSE) + RENDER, SET_SWEEP, 24),
    "index": index(200),
}
