"""How well size, depth and modulus could be known, by presses alone.

    python3 press_bound.py PROGRAM SCENE SIZE DEPTH YOUNGS PHANTOM LOAD,LOAD.. [SMOOTH_ERROR]

An independent look at `tirtouch calibrate --bound`: no light is traced. The image of a press is taken as the share of
true contact, which goes with the pressure while it is small, so that all derivatives are those of the logarithm of the
pressure in rings: central differences of presses, free of noise. Each ring has the noise of its pixels, 348 x 261 over
the face with 6000 electrons at 2 kPa, as in the phantom scenes. Beside size, depth and modulus the phantom's modulus,
the depth of the press (1 %), the contact law and the LEDs' power are unknown, and each load has a smooth error of its
own (SMOOTH_ERROR, a share; default 0.001). Prints the Cramer-Rao bound as shares. Needs numpy; a minute on two cores.
"""

import os
import re
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor

import numpy as np

RADII_MM = np.arange(0.125, 12.5, 0.25)
FIELD_MM = (29.9, 22.4)
PIXELS_PER_MM2 = 135.0
ELECTRONS_PER_KPA = 3000.0
READ_NOISE_E, WELL_E, LEVELS = 9.0, 15000.0, 255.0
# Steps of the logarithms of size, depth, modulus, the phantom's modulus and the depth of the press.
STEPS = (0.03, 0.03, 0.25, 0.05, 0.01)
# What is known beforehand of these, the contact law and the power: standard deviations of logarithms.
KNOWN = (9.0, 9.0, 9.0, 9.0, 0.01, 0.1, 0.03)


def areas():
    """Area of each ring within the field of view, mm^2."""
    x, y = (np.linspace(-extent / 2, extent / 2, 801) for extent in FIELD_MM)
    radius = np.hypot(*np.meshgrid(x, y))
    cell = (x[1] - x[0]) * (y[1] - y[0])
    return np.array([(abs(radius - ring) < 0.125).sum() * cell for ring in RADII_MM])


def log_pressure(program, scene, folder, name, unknowns, scale, loads):
    """Logarithm of the pressure, loads x rings."""
    size, depth, youngs, phantom = unknowns
    path = os.path.join(folder, f"{name}.toml")
    depths = ", ".join(f"{load * scale:.6f}" for load in loads)
    with open(path, "w") as file:
        file.write(re.sub(r"depths_mm = .*", f"depths_mm = [{depths}]", open(scene).read()))
    inclusion = "phantom.inclusion[0]"
    values = {
        f"{inclusion}.shape.diameter_mm": size,
        f"{inclusion}.depth_mm": depth,
        f"{inclusion}.material.youngs_kpa": youngs,
        "phantom.material.youngs_kpa": phantom,
    }
    sets = [word for key, value in values.items() for word in ("--set", f"{key}={value}")]
    out = os.path.join(folder, name)
    environment = {**os.environ, "RAYON_NUM_THREADS": "1"}
    subprocess.run([program, "press", path, "-o", out, "--quiet", "--json", *sets], check=True, env=environment,
                   stdout=subprocess.DEVNULL)
    table = np.genfromtxt(os.path.join(out, "contact.csv"), delimiter=",", names=True)
    loads = np.unique(table["depth_mm"])
    of = [table[table["depth_mm"] == load] for load in loads]
    return np.log([np.interp(RADII_MM, one["r_mm"], one["pressure_kpa"]) for one in of])


def main():
    program, scene = sys.argv[1:3]
    unknowns = [float(word) for word in sys.argv[3:7]]
    loads = [float(word) for word in sys.argv[7].split(",")]
    smooth = float(sys.argv[8]) if len(sys.argv) > 8 else 1e-3
    with tempfile.TemporaryDirectory() as folder, ThreadPoolExecutor(2) as pool:

        def press(job):
            k, sign = job
            moved, scale = list(unknowns), 1.0
            if k is not None and k < 4:
                moved[k] *= np.exp(sign * STEPS[k])
            elif k == 4:
                scale = np.exp(sign * STEPS[k])
            return log_pressure(program, scene, folder, f"press{k}{sign}", moved, scale, loads)

        jobs = [(None, 0)] + [(k, sign) for k in range(5) for sign in (1, -1)]
        middle, *moved = pool.map(press, jobs)
    slopes = [(moved[2 * k] - moved[2 * k + 1]) / (2 * STEPS[k]) for k in range(5)]
    slopes += [np.ones_like(middle)] * 2
    electrons = ELECTRONS_PER_KPA * np.exp(middle)
    if electrons.max() > WELL_E:
        print("the exposure would have to be shorter: some rings have more electrons than a pixel holds")
    noise = READ_NOISE_E**2 + (WELL_E / LEVELS) ** 2 / 12
    variance = (1 / electrons + noise / electrons**2) / np.maximum(areas() * PIXELS_PER_MM2, 1e-9)
    waves = []
    for load in range(len(loads)):
        for k in range(6):
            wave = np.zeros_like(middle)
            wave[load] = smooth / np.sqrt(3.5) * np.cos(np.pi * k * RADII_MM / 12.5)
            waves.append(wave.ravel())
    covariance = np.diag(variance.ravel()) + np.array(waves).T @ np.array(waves)
    slopes = np.array([slope.ravel() for slope in slopes]).T
    information = slopes.T @ np.linalg.solve(covariance, slopes) + np.diag([known**-2 for known in KNOWN])
    size, depth, youngs, phantom = 100 * np.sqrt(np.diag(np.linalg.inv(information)))[:4]
    print(f"size {size:.2f} %, depth {depth:.2f} %, modulus {youngs:.1f} %, the phantom's modulus {phantom:.1f} %")


main()
