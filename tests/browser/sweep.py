"""The page of a sweep in a headless Chromium, with real events: `python3 tests/browser/sweep.py PROGRAM [FOLDER]`.

A small sweep of two variables with images is run. Its page goes through the points in the order of a figure, with the
numbers of `points.csv` and the images beside it; alone in another folder it says which are not there. At 390 px nothing
is wider than the screen; the console has no error. Pictures go to FOLDER.
"""

from __future__ import annotations

import csv
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from chromium import Chromium

SWEEP = """
[sweep]
scene = "preset:contact-disc"
design = { kind = "grid" }
images = { format = "png" }
[[vary]]
name = "tissue_n"
key = "touch.contact.tissue.n"
values = [1.34, 1.37, 1.40]
[[vary]]
name = "power"
key = "led[0].radiance_w_per_m2_sr"
values = [2, 1]
[[vary]]
name = "columns"
key = "camera.pixels[0]"
fixed = 96
[[vary]]
name = "rows"
key = "camera.pixels[1]"
fixed = 72
[[measure]]
kind = "mean_radiance"
"""
# Many variables with long keys: dots against each, bars and tables of effects.
EFFECTS = SWEEP.replace('{ kind = "grid" }', '{ kind = "morris", trajectories = 6 }').replace(
    'name = "tissue_n"\n', "").replace('name = "power"\n', "") + """
[[vary]]
key = "stack.layer[\\"PDMS 1.41\\"].n"
uniform = [1.405, 1.415]
[[vary]]
key = "render.photons"
fixed = 4096
"""
FIGURES = "[...document.querySelectorAll('figure img')].map((image) => image.complete && image.naturalWidth)"
CELLS = """[...document.querySelectorAll('#points-table tbody tr')]
    .map((line) => [...line.cells].map((cell) => cell.textContent))"""
IMAGES = "[...document.querySelectorAll('.points-images img')].map((image) => [image.naturalWidth, image.src])"


def check(browser: Chromium, rows: list[dict[str, str]], folder: Path | None) -> None:
    """All that the page promises."""
    figure = next(name for name in rows[0] if name.startswith("mean_radiance") and "low" not in name)
    browser.value(f"""(() => {{ const by = document.getElementById('points-by');
        by.value = [...by.options].find((option) => option.textContent === '{figure}').value;
        by.dispatchEvent(new Event('input')); }})()""")
    dimmest, *_, brightest = sorted(rows, key=lambda row: float(row[figure]))
    browser.value("document.getElementById('points-A').focus()")
    for key, row in (("Home", dimmest), ("End", brightest)):
        browser.key(key)
        cells = browser.value(CELLS)
        shown = {name: value for name, value, _ in cells}
        for name in ("tissue_n", "power", figure):
            value = float(shown[name].split(" ")[0])
            assert abs(value - float(row[name])) <= 6e-3 * abs(value), (key, name, shown, row)
        said = browser.value("document.querySelector('label[for=points-A] ~ output').textContent")
        assert said == f"row {row['row']}", said
        browser.wait(f"{IMAGES}.every(([width]) => width === 96)")
        assert f"{int(row['row']):07}.png" in browser.value(IMAGES)[0][1]
    head = f"[...document.querySelectorAll('.scroll th')].find((cell) => cell.textContent === '{figure}')"
    first = f"{head}.closest('table').tBodies[0].rows[0].cells[0].textContent"
    for row in (dimmest, brightest):
        browser.value(f"{head}.querySelector('button').click()")
        assert browser.value(first) == row["row"], row
    if folder:
        browser.picture(folder / "sweep.png")
    looks(browser, "sweep", folder)


def looks(browser: Chromium, name: str, folder: Path | None) -> None:
    """Figures are there, nothing is wider than a phone's screen, and the console is empty."""
    browser.wait(f"{FIGURES}.length > 0 && {FIGURES}.every((width) => width > 0)")
    browser.size(390, 844)
    wide = browser.value("document.documentElement.scrollWidth")
    assert wide <= 390, wide
    if folder:
        browser.picture(folder / f"{name}-phone.png")
    assert not browser.errors, browser.errors


def main() -> None:
    """Runs the check."""
    folder = Path(sys.argv[2]) if len(sys.argv) > 2 else None
    with tempfile.TemporaryDirectory() as place:
        (Path(place) / "sweep.toml").write_text(SWEEP)
        out = Path(place) / "out"
        subprocess.run([sys.argv[1], "sweep", "run", Path(place) / "sweep.toml", "-o", out], check=True,
                       stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        with (out / "points.csv").open(newline="") as file:
            rows = list(csv.DictReader(file))
        assert len(rows) == 6, rows
        with Chromium((out / "report.html").as_uri()) as browser:
            check(browser, rows, folder)
        (Path(place) / "effects.toml").write_text(EFFECTS)
        effects = Path(place) / "effects"
        subprocess.run([sys.argv[1], "sweep", "run", Path(place) / "effects.toml", "-o", effects], check=True,
                       stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        with Chromium((effects / "report.html").as_uri()) as browser:
            assert "Sensitivity" in browser.value("document.body.innerText")
            looks(browser, "effects", folder)
        alone = Path(place) / "alone"
        alone.mkdir()
        shutil.copy(out / "report.html", alone)
        with Chromium((alone / "report.html").as_uri()) as browser:
            images = "[...document.querySelectorAll('.points-images')]"
            browser.wait(f"{images}.every((one) => one.innerText.includes('not beside'))")
    print("sweep: all checks passed")


if __name__ == "__main__":
    main()
