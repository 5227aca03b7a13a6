"""What becomes of estimates where the truth is not as the calibration assumes.

    python3 mismatch.py PROGRAM OUT [POINTS] [KIND ..]

Phantoms of `scenes/studies/phantoms.toml`, all drawn alike, pressed and traced with another contact law, Poisson's
ratio, interface, index or hyperelastic law than the calibration that comes with the program was learnt with, and once
as it was. `tirtouch study` inverts them. Prints for each kind how many numbers are told, how many intervals of 95 %
hold, the median error, and why the others are undefined. OUT keeps the sweeps: a second call goes on where the first
was stopped. A phantom takes half a minute of a core.
"""

import collections
import csv
import json
import pathlib
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
PERSSON = 'law = { kind = "persson", reduced_modulus_kpa = 120.0, rms_slope = 0.5 }'
PHANTOM = 'material = { law = "neo_hookean", youngs_kpa = 5.0 }'
INCLUSION = 'material = { law = "neo_hookean", youngs_kpa = 120.0 }'
CONTACT = "touch.contact.law.reduced_modulus_kpa"

# What is replaced in the scene, and in the sweep.
KINDS = {
    "as calibrated": ([], []),
    # Greenwood and Williamson: 1 - exp(-p / p0), of the same slope at small pressures.
    "contact law": (
        [(PERSSON, 'law = { kind = "greenwood_williamson", pressure_scale_kpa = 37.6 }')],
        [(CONTACT, "touch.contact.law.pressure_scale_kpa"), ("log_uniform = [107, 134]", "log_uniform = [33.5, 42.0]")],
    ),
    "Poisson's ratio 0.49": ([(PHANTOM, PHANTOM.replace("5.0", "5.0, poisson = 0.49"))], []),
    "friction 0.5": ([('interface = { kind = "tied" }', 'interface = { kind = "coulomb", friction = 0.5 }')], []),
    "index of the top layer + 0.005": ([("n = 1.41\n", "n = 1.415\n")], []),
    # c1 = E / 6; c2 = 0.2 c1 stiffens by a tenth at a stretch of 1.5.
    "Yeoh phantom": (
        [(PHANTOM, 'material = { law = "yeoh", c_kpa = [0.8333, 0.1667, 0.0] }')],
        [
            ('key = "phantom.material.youngs_kpa"\n', ""),
            ("[[require]]", '[[vary]]\nname = "c1"\nkey = "phantom.material.c_kpa[0]"\nexpression = "phantom / 6"\n'
             '[[vary]]\nname = "c2"\nkey = "phantom.material.c_kpa[1]"\nexpression = "phantom / 30"\n[[require]]'),
        ],
    ),
}


def replaced(text, changes):
    """The text with all changes, each of which must be there to be made."""
    for old, new in changes:
        if old not in text:
            raise SystemExit(f"mismatch.py: {old!r} is not there to be replaced")
        text = text.replace(old, new)
    return text


def study(program, out, name, points):
    """Sweeps and inverts the phantoms of a kind."""
    in_scene, in_sweep = KINDS[name]
    folder = out / name.replace(" ", "_").replace("'", "")
    folder.mkdir(parents=True, exist_ok=True)
    scene = (ROOT / "scenes/calibrations/sensor.toml").read_text()
    (folder / "sensor.toml").write_text(replaced(scene, in_scene))
    sweep = (ROOT / "scenes/studies/phantoms.toml").read_text()
    of_all = [("../calibrations/sensor.toml", "sensor.toml"), ("points = 400", f"points = {points}")]
    sweep = replaced(sweep, of_all + in_sweep)
    (folder / "phantoms.toml").write_text(sweep)
    calibration = ROOT / "scenes/calibrations/phantoms.json"
    (folder / "study.toml").write_text(
        f'[study]\ncalibration = "{calibration}"\nphantoms = "phantoms.toml"\nexposure_ms = 0.0778\nexposures = 1\n'
    )
    call = [program, "study", folder / "study.toml", "-o", folder / "study", "--quiet", "--json", "--workers", "1"]
    if (folder / "study").is_dir():
        call.append("--resume")
    return json.loads(subprocess.run(call, check=True, capture_output=True, text=True).stdout), folder / "study"


def main():
    program, out = sys.argv[1], pathlib.Path(sys.argv[2])
    points = int(sys.argv[3]) if len(sys.argv) > 3 else 20
    for name in sys.argv[4:] or KINDS:
        summary, folder = study(program, out, name, points)
        print(f"{name}: {summary['phantoms']} phantoms, found {summary['found'].get('value')}")
        for quantity in summary["quantities"]:
            whole = quantity["coverage"][0] if quantity["coverage"] else {"held": 0}
            error = quantity["median_error"].get("value")
            bias = quantity["relative_bias"].get("value")
            share = lambda value: "-" if value is None else f"{100 * value:.1f} %"
            print(f"  {quantity['name']}: held {whole['held']} of {quantity['known']}, median error {share(error)}, "
                  f"bias {share(bias)}")
        with open(folder / "estimates.csv", newline="") as table:
            whys = collections.Counter(row["size_mm_undefined"].split(";")[0] for row in csv.DictReader(table))
        for why, count in whys.most_common(3):
            if why:
                print(f"  {count}: {why}")
        sys.stdout.flush()


if __name__ == "__main__":
    main()
