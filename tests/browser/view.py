"""`tirtouch view` in a headless Chromium, with real events: `python3 tests/browser/view.py PROGRAM [FOLDER]`.

A slider is dragged and the image changes to that of the new number; the probe says what the program says of a pixel; a
number that makes no scene is refused in words; at 390 px nothing is wider than the screen; the console has no error;
Ctrl-C ends the program with exit code 0. Pictures go to FOLDER.
"""

from __future__ import annotations

import json
import re
import signal
import struct
import subprocess
import sys
import urllib.request
from pathlib import Path

from chromium import Chromium

SCENE = ["preset:contact-disc", "--set", "camera.pixels[0]=96", "--set", "camera.pixels[1]=72"]
SLIDER = "touch.contact.tissue.n=1.33:1.45"
KEY = "touch.contact.tissue.n"
DONE = "document.body.dataset.busy === 'false'"


def pixels(url: str) -> tuple[int, int, tuple[float, ...]]:
    """Width, height and radiances of what the program shows."""
    data = urllib.request.urlopen(url.replace("/?", "/pixels?")).read()
    width, height, _ = struct.unpack_from("<3I", data)
    count = width * height
    return width, height, struct.unpack_from(f"<{count}f", data, 12 + 4 * ((count + 1) // 2))


def check(browser: Chromium, url: str, folder: Path | None) -> None:
    """All that the page promises."""
    browser.wait(f"document.body.dataset.shown && {DONE}")
    before = pixels(url)[2]

    left, top, wide, high = browser.place(f"[data-key='{KEY}'] input[type=range]")
    middle = top + high / 2
    browser.mouse("mousePressed", left + wide / 2, middle)
    for share in (0.6, 0.8, 0.95):
        browser.mouse("mouseMoved", left + share * wide, middle, pressed=True)
    browser.mouse("mouseReleased", left + 0.95 * wide, middle)
    number = browser.value(f"document.querySelector(\"[data-key='{KEY}'] input[type=number]\").valueAsNumber")
    assert 1.43 < number <= 1.45, number
    browser.wait("document.body.dataset.wished > 1 && document.body.dataset.wish === document.body.dataset.wished"
                 f" && {DONE} && document.body.dataset.shown.startsWith(document.body.dataset.wish + '/')")
    scene = urllib.request.urlopen(url.replace("/?", "/scene.toml?")).read().decode()
    assert f"n = {number}" in scene, scene
    width, height, after = pixels(url)
    brighter = sum(after) / sum(before)
    assert abs(brighter - 1) > 0.02, f"tissue of index {number} sends {brighter} of the light back"

    left, top, wide, high = browser.place("#image")
    column, row = 40, 30
    browser.mouse("mouseMoved", left + (column + 0.5) * wide / width, top + (row + 0.5) * high / height)
    for _ in range(3):
        said = browser.value("document.getElementById('probe').textContent")
        found = re.search(r"column (\d+), row (\d+) .* radiance (\S+) ±", said)
        assert found, said
        assert (int(found[1]), int(found[2])) == (column, row), said
        real = after[row * width + column]
        assert abs(float(found[3]) - real) <= 5.1e-4 * real, (said, real)
        if column == 40:
            browser.value("document.getElementById('image').focus()")
        browser.key("ArrowRight")
        column += 1
    if folder:
        browser.picture(folder / "view.png")

    browser.call("Page.reload")
    browser.wait(f"document.readyState === 'complete' && document.body.dataset.shown && {DONE}")
    kept = browser.value(f"document.querySelector(\"[data-key='{KEY}'] input[type=number]\").valueAsNumber")
    assert kept == number, f"loaded again, the slider stands at {kept}, the image is of {number}"

    field = f"document.querySelector(\"[data-key='{KEY}'] input[type=number]\")"
    browser.value(f"{field}.value = '-1'; {field}.dispatchEvent(new Event('change'))")
    browser.wait(f"document.getElementById('refused').textContent.includes('{KEY}')")
    errors = [error for error in browser.errors if "422" not in error]
    assert not errors, errors
    browser.value("document.getElementById('reset').click()")
    browser.wait("!document.getElementById('refused').textContent")

    browser.size(390, 844)
    wide = browser.value("document.documentElement.scrollWidth")
    assert wide <= 390, wide
    if folder:
        browser.picture(folder / "view-phone.png")


def main() -> None:
    """Runs the check."""
    folder = Path(sys.argv[2]) if len(sys.argv) > 2 else None
    command = [sys.argv[1], "view", *SCENE, "--slider", SLIDER, "--json"]
    # A shell that starts it in the background would have it ignore Ctrl-C.
    def listen() -> None:
        signal.signal(signal.SIGINT, signal.default_int_handler)
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True, preexec_fn=listen) as program:
        assert program.stdout
        try:
            url = json.loads(program.stdout.readline())["url"]
            with Chromium(url) as browser:
                check(browser, url, folder)
            program.send_signal(signal.SIGINT)
            code = program.wait(30)
            assert code == 0, code
        finally:
            program.kill()
    print("view: all checks passed")


if __name__ == "__main__":
    main()
