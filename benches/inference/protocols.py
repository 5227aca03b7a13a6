#!/usr/bin/env python3
"""What can a protocol of ten frames tell of size, depth and modulus at best?

    cargo build --release && python3 benches/inference/protocols.py [--phantom 8,5,120,5 ..] [--steps 1 0.5]
        [--errors 1e-3 1e-3:0.9 1e-4 ..] [--resolution 1] [--keep FOLDER] [--solid] [--program target/release/tirtouch]

An independent look at `tirtouch calibrate --bound`: no light is traced. A frame is the share of true contact by
Persson's law, erf(sqrt(2) p / E*), of the pressure p of a press, so that all slopes are central differences of presses,
free of light's noise. Frames of 348 x 261 pixels are read out to five sixths of the touched face's radius and exposed
until nine tenths of a pixel's well are full where most light is read; light spreads by about 1 mm in the tissue, which
takes the brightness of the rim away. Beside size, depth and modulus are unknown: the phantom's modulus, the depth of
the press (1 %), the contact law (10 %), the LEDs' power (3 %), with `--solid` the inclusion's place. Slopes are
polynomials of the place, eight even ones of the radius, 36 of the face: meshes change with the size, and leave 0.3 %
from ring to ring in its slope (1 % by steps of 3 %), which would pass for information; of the other slopes polynomials
leave 0.1 %. The logarithm of each load's light has an error of its own that is alike over 3 mm (a Gaussian process):
`--errors`, standard deviations, each with the correlation of the loads' errors after a colon. Prints Cramer-Rao bounds
in percent, a row a protocol, for each error and each step of the differences: what depends on the step is not known.
`--solid` presses in three dimensions, off the axis and tilted too. `--keep` keeps the presses. Needs numpy and scipy.
"""

import argparse
import json
import subprocess
import tempfile
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from scipy.interpolate import griddata
from scipy.linalg import block_diag
from scipy.special import erf

ROOT = Path(__file__).resolve().parents[2]
SCENE = ROOT / "scenes/calibrations/sensor.toml"
FIELD_MM = (29.9, 22.4)
PIXELS_PER_MM2 = 348 * 261 / (FIELD_MM[0] * FIELD_MM[1])
# The law of the scene: reduced modulus times slope, kPa.
CONTACT_KPA = 60.0
# Over which an error of the light is alike, mm.
ALIKE_MM = 3.0
READ_NOISE_E, WELL_E, LEVELS = 9.0, 15000.0, 255.0
FRAMES = 10
FORCE_ERROR = 0.01
INCLUSION = "phantom.inclusion[0]"
RADIUS = "press.footprint.radius_mm"
# Steps of the logarithms of size, depth, modulus, the phantom's modulus and the depth of the press; of the place, mm.
NAMES = ("size", "depth", "modulus", "phantom", "press", "x", "y")
STEPS = (0.12, 0.03, 0.25, 0.05, 0.01, 0.3, 0.3)
# What is known beforehand of these, the contact law and the power: standard deviations.
KNOWN = (9.0, 9.0, 9.0, 9.0, 0.01, 9.0, 9.0, 0.1, 0.03)


@dataclass(frozen=True)
class Setting:
    """How the sensor is pressed: changes to the scene."""

    name: str
    changes: tuple = ()


@dataclass(frozen=True)
class Protocol:
    """Frames, each a setting and a load; what is known besides, and whether forces are."""

    name: str
    frames: tuple
    known: dict = field(default_factory=dict)
    has_forces: bool = False


PLAIN = Setting("plain")
SMALL = Setting("face of 8 mm", ((RADIUS, 8.0),))
SOFT = Setting("layers half as stiff", tuple((f"stack.layer[{k}].elastic.youngs_kpa", e) for k, e in
                                             enumerate((30.0, 15.0, 7.5))))
STIFF = Setting("layers twice as stiff", tuple((f"stack.layer[{k}].elastic.youngs_kpa", e) for k, e in
                                               enumerate((120.0, 60.0, 30.0))))
ASIDE = Setting("3 mm aside", (("press.offset_mm", "[3.0, 0.0]"),))
TILTED = Setting("tilted by 2 degrees", (("press.tilt_deg", "[0.0, 2.0]"),))


def at(*loads, setting=PLAIN):
    return tuple((setting, load) for load in loads)


PROTOCOLS = [
    Protocol("4", at(4.0)),
    Protocol("5.5", at(5.5)),
    Protocol("1 2 4", at(1.0, 2.0, 4.0)),
    Protocol("1 2 3 4 5", at(1.0, 2.0, 3.0, 4.0, 5.0)),
    Protocol("2 4 5", at(2.0, 4.0, 5.0)),
    Protocol("2 4 5.5", at(2.0, 4.0, 5.5)),
    Protocol("1 2 4 5.5", at(1.0, 2.0, 4.0, 5.5)),
    Protocol("1 2 3 4 5 5.5", at(1.0, 2.0, 3.0, 4.0, 5.0, 5.5)),
    Protocol("1 2 4, forces", at(1.0, 2.0, 4.0), has_forces=True),
    Protocol("2 4 5.5, forces", at(2.0, 4.0, 5.5), has_forces=True),
    Protocol("2 4 5.5, phantom's modulus to 1 %", at(2.0, 4.0, 5.5), {"phantom": 0.01}),
    Protocol("2 4 5.5, size to 1 %", at(2.0, 4.0, 5.5), {"size": 0.01}),
    Protocol("2 4 5.5, depth to 1 %", at(2.0, 4.0, 5.5), {"depth": 0.01}),
    Protocol("2 4, and 4 by a face of 8 mm", at(2.0, 4.0) + at(4.0, setting=SMALL)),
    Protocol("2 5.5, and 4 by a face of 8 mm", at(2.0, 5.5) + at(4.0, setting=SMALL)),
    Protocol("2 4, and 4 by layers twice as stiff", at(2.0, 4.0) + at(4.0, setting=STIFF)),
    Protocol("2 4, and 4 by layers half as stiff", at(2.0, 4.0) + at(4.0, setting=SOFT)),
]
SOLID = [
    Protocol("1 2 4", at(1.0, 2.0, 4.0)),
    Protocol("2 4, and 4 at 3 mm aside", at(2.0, 4.0) + at(4.0, setting=ASIDE)),
    Protocol("2 4, and 4 tilted by 2 degrees", at(2.0, 4.0) + at(4.0, setting=TILTED)),
]


class Face:
    """Where a frame is read: rings, or cells of 1 mm, out to five sixths of the touched face's radius."""

    def __init__(self, is_solid, radius_mm):
        self.is_solid, reach = is_solid, radius_mm * 12.5 / 15.0
        if is_solid:
            x, y = (grid.ravel() for grid in np.meshgrid(*(np.arange(-e / 2 + 0.5, e / 2, 1.0) for e in FIELD_MM)))
            inside = np.hypot(x, y) < reach
            self.x, self.y, self.areas = x[inside], y[inside], np.ones(inside.sum())
            places = np.column_stack([self.x, self.y])
            smooth = [(self.x / reach) ** i * (self.y / reach) ** j for i in range(8) for j in range(8 - i)]
        else:
            self.radii = reach * (np.arange(50) + 0.5) / 50
            x, y = (np.linspace(-extent / 2, extent / 2, 801) for extent in FIELD_MM)
            radius, cell = np.hypot(*np.meshgrid(x, y)), (x[1] - x[0]) * (y[1] - y[0])
            self.areas = np.array([(abs(radius - ring) < reach / 100).sum() * cell for ring in self.radii])
            places = self.radii[:, None]
            smooth = [(self.radii / reach) ** (2 * k) for k in range(8)]
        weights = np.sqrt(self.areas)
        self.smooth = np.linalg.qr(np.array(smooth).T * weights[:, None])[0].T / weights
        apart = ((places[:, None] - places[None]) ** 2).sum(axis=2)
        self.alike = np.exp(-0.5 * apart / ALIKE_MM**2)

    def smoothed(self, of):
        """The polynomial next to what rows say of each place."""
        return of * self.areas @ self.smooth.T @ self.smooth

    def read(self, table):
        """Pressure of each place, kPa."""
        if self.is_solid:
            places = np.column_stack([table["x_mm"], table["y_mm"]])
            return griddata(places, table["pressure_kpa"], (self.x, self.y), method="linear")
        return np.interp(self.radii, table["r_mm"], table["pressure_kpa"])


class Presses:
    """Presses of one phantom, kept in a folder."""

    def __init__(self, asked, folder, phantom):
        self.asked, self.folder, self.phantom = asked, folder, phantom

    def face(self, setting):
        return Face(self.asked.solid, dict(setting.changes).get(RADIUS, 15.0))

    def press(self, setting, loads, moved):
        """Pressure of each load, kPa, by rings or cells, and forces, N; `moved` are steps of the unknowns by name."""
        size, depth, youngs, phantom = (
            value * np.exp(moved.get(name, 0.0)) for name, value in zip(NAMES, self.phantom))
        scale = np.exp(moved.get("press", 0.0))
        values = {
            f"{INCLUSION}.shape.diameter_mm": size,
            f"{INCLUSION}.depth_mm": depth,
            f"{INCLUSION}.material.youngs_kpa": youngs,
            "phantom.material.youngs_kpa": phantom,
            "press.resolution": self.asked.resolution,
            "press.depths_mm": "[" + ", ".join(f"{load * scale:.6f}" for load in loads) + "]",
            **dict(setting.changes),
        }
        if self.asked.solid:
            place = [moved.get(axis, 0.0) for axis in ("x", "y")]
            values |= {"press.dimensions": "three", f"{INCLUSION}.center_mm": str(place)}
        words = [word for key, value in values.items() for word in ("--set", f"{key}={value}")]
        parts = [setting.name, *(f"{value:.4g}" for value in self.phantom), "solid" * self.asked.solid,
                 f"{self.asked.resolution:g}", *(f"{key}{step:+.5f}" for key, step in moved.items())]
        name = "_".join(parts).replace(" ", "-")
        out = self.folder / name
        if not (out / "result.json").exists():
            command = [self.asked.program, "press", SCENE, "-o", out, "--force", "--quiet", "--json", *words]
            done = subprocess.run([*map(str, command)], capture_output=True, text=True)
            if done.returncode:
                raise SystemExit(f"protocols.py: {' '.join(map(str, command))}\n{done.stderr}")
        table = np.genfromtxt(out / "contact.csv", delimiter=",", names=True)
        face, steps = self.face(setting), json.loads((out / "result.json").read_text())["mechanics"]["steps"]
        pressures = [face.read(table[table["depth_mm"] == load]) for load in np.unique(table["depth_mm"])]
        return np.array(pressures), np.array([step["force_n"] for step in steps])


def slopes(presses, setting, loads, steps, pool):
    """Logarithms of the light of each load, their slopes by all unknowns, those of the forces, and the face."""
    names, face = NAMES if presses.asked.solid else NAMES[:5], presses.face(setting)
    jobs = [{}] + [{name: sign * steps * step} for name, step in zip(names, STEPS) for sign in (1, -1)]
    middle, *moved = pool.map(lambda job: presses.press(setting, loads, job), jobs)
    share = lambda pressure: np.log(erf(np.sqrt(2.0) * pressure / CONTACT_KPA))
    pairs = [(moved[2 * k], moved[2 * k + 1], 2 * steps * STEPS[k]) for k in range(len(names))]
    light = [face.smoothed(share(high[0]) - share(low[0])) / step for high, low, step in pairs]
    force = [(np.log(high[1]) - np.log(low[1])) / step for high, low, step in pairs]
    # The contact law's modulus, and the power.
    off = 1e-4
    light.append((share(middle[0] * (1.0 - off)) - share(middle[0] * (1.0 + off))) / (2.0 * off))
    light.append(np.ones_like(light[0]))
    force += [np.zeros_like(force[0])] * 2
    return share(middle[0]), np.array(light), np.array(force), face


def bound(protocol, known_slopes, loads, error, alike):
    """Cramer-Rao bound of each unknown, percent; of a place in mm times 100."""
    taken = [(known_slopes[setting], loads[setting].index(load)) for setting, load in protocol.frames]
    gain = 0.9 * WELL_E / max(np.exp(light[k]).max() for (light, *_), k in taken)
    unknowns = taken[0][0][1].shape[0]
    known = [*KNOWN[:5], *(KNOWN[5:7] if unknowns == 9 else ()), *KNOWN[7:]]
    for name, deviation in protocol.known.items():
        known[NAMES.index(name)] = deviation
    noise = READ_NOISE_E**2 + (WELL_E / LEVELS) ** 2 / 12.0
    own, shared, rows = [], [], []
    for (light, by, _, face), k in taken:
        electrons = gain * np.exp(light[k])
        pixels = np.maximum(face.areas * PIXELS_PER_MM2, 1e-9) * FRAMES / len(taken)
        own.append(np.diag((1.0 / electrons + noise / electrons**2) / pixels) + (1.0 - alike) * error**2 * face.alike)
        # A root of what places have in common, by which loads of one face go together.
        values, vectors = np.linalg.eigh(face.alike)
        shared.append(np.sqrt(alike) * error * vectors * np.sqrt(np.maximum(values, 0.0)))
        rows.append(by[:, k])
    shared = np.concatenate(shared)
    slopes = np.concatenate(rows, axis=1)
    information = np.diag(np.array(known) ** -2.0)
    information += slopes @ np.linalg.solve(block_diag(*own) + shared @ shared.T, slopes.T)
    for (_, _, force, _), k in taken if protocol.has_forces else ():
        information += np.outer(force[:, k], force[:, k]) / FORCE_ERROR**2
    return 100.0 * np.sqrt(np.diag(np.linalg.inv(information)))


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--phantom", nargs="+", default=["8,5,120,5"])
    parser.add_argument("--steps", nargs="+", type=float, default=[1.0])
    parser.add_argument("--errors", nargs="+", default=["1e-3", "1e-3:0.9", "1e-4"])
    parser.add_argument("--resolution", type=float, default=1.0)
    parser.add_argument("--keep", type=Path)
    parser.add_argument("--solid", action="store_true")
    parser.add_argument("--program", type=Path, default=ROOT / "target/release/tirtouch")
    asked = parser.parse_args()
    errors = [[float(part) for part in f"{error}:0".split(":")[:2]] for error in asked.errors]
    protocols = SOLID if asked.solid else PROTOCOLS
    loads = {}
    for setting, load in (frame for protocol in protocols for frame in protocol.frames):
        loads[setting] = sorted({*loads.get(setting, []), load})
    with tempfile.TemporaryDirectory() as place, ThreadPoolExecutor(2) as pool:
        folder = asked.keep or Path(place)
        folder.mkdir(parents=True, exist_ok=True)
        for text in asked.phantom:
            phantom = [float(word) for word in text.split(",")]
            presses = Presses(asked, folder, phantom)
            found = {}
            for steps in asked.steps:
                of = {setting: slopes(presses, setting, loads[setting], steps, pool) for setting in loads}
                for protocol in protocols:
                    bounds = [bound(protocol, of, loads, *error) for error in errors]
                    found.setdefault(protocol.name, []).extend(bounds)
            size, depth, youngs, own = phantom
            print(f"\n{size:g} mm, {depth:g} mm deep, {youngs:g} in {own:g} kPa; bounds in % for steps of "
                  f"{asked.steps} times each error of {asked.errors}")
            print("| frames at | size | depth | modulus |\n|---|---|---|---|")
            for name, bounds in found.items():
                written = lambda value: f"{value:.0f}" if value > 99.0 else f"{value:.2g}"
                cells = [", ".join(written(one[k]) for one in bounds) for k in range(3)]
                print(f"| {name} | {' | '.join(cells)} |", flush=True)


if __name__ == "__main__":
    main()
