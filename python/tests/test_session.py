"""Sessions: what stops them, who may use them, what they keep."""

from __future__ import annotations

import os
import signal
import threading
from typing import Any

import numpy as np
import pytest
import tirtouch
from conftest import FEW, run_python
from tirtouch import Scene, Session

#: Longer than any test: what stops it is what is tested.
ENDLESS: dict[str, Any] = {"seconds": 1e6}


def test_a_callback_hears_of_the_work(session: Session, phantom: Scene) -> None:
    heard: list[tuple[str, float]] = []
    session.render(phantom, progress=lambda what, done: heard.append((what, done)), **FEW)
    assert heard and all(what and 0 <= done <= 1 for what, done in heard)


def test_a_callback_that_returns_false_stops_the_work(session: Session, disc: Scene) -> None:
    with pytest.raises(tirtouch.Stopped, match="stopped") as raised:
        session.render(disc, progress=lambda what, done: False, **ENDLESS)
    assert isinstance(raised.value, tirtouch.TirtouchError) and raised.value.file is None


def test_a_press_is_stopped_too(session: Session, phantom: Scene) -> None:
    other = phantom.set({"phantom.material.youngs_kpa": 5.5})
    with pytest.raises(tirtouch.Stopped):
        session.press(other, progress=lambda what, done: False)
    assert len(session.press(other).loads) == 2


def test_what_a_callback_raises_comes_out(session: Session, disc: Scene) -> None:
    def bad(what: str, done: float) -> None:
        raise LookupError(what)

    with pytest.raises(LookupError):
        session.render(disc, progress=bad, **ENDLESS)
    assert session.render(disc, **FEW).radiance.max() > 0


def test_progress_is_a_callable_or_a_flag(session: Session, disc: Scene, capfd: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(TypeError, match="progress"):
        session.render(disc, progress=3.5, **FEW)
    session.render(disc, progress=False, **FEW)
    assert capfd.readouterr() == ("", "")
    session.render(disc, progress=True, **FEW)


def test_a_callback_cannot_use_its_own_session(session: Session, disc: Scene) -> None:
    with pytest.raises(RuntimeError, match="at work"):
        session.render(disc, progress=lambda what, done: session.render(disc, **FEW), **ENDLESS)


def test_two_threads_use_a_session_one_after_the_other(session: Session, disc: Scene) -> None:
    wanted = {seed: session.render(disc, seed=seed, **FEW).radiance for seed in range(6)}
    found: dict[int, np.ndarray[Any, Any]] = {}

    def render(seeds: range) -> None:
        for seed in seeds:
            found[seed] = session.render(disc, seed=seed, **FEW).radiance

    threads = [threading.Thread(target=render, args=(range(first, 6, 2),)) for first in (0, 1)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert all(np.array_equal(found[seed], wanted[seed]) for seed in range(6))


def test_other_threads_run_while_an_image_is_traced(session: Session, disc: Scene) -> None:
    ran, stop = threading.Event(), threading.Event()
    other = threading.Thread(target=lambda: (stop.wait(), ran.set()))
    other.start()

    def progress(what: str, done: float) -> bool:
        stop.set()
        return not ran.is_set()

    with pytest.raises(tirtouch.Stopped):
        session.render(disc, progress=progress, **ENDLESS)
    other.join()


def test_a_kind_of_error_has_its_class(session: Session, disc: Scene, phantom: Scene) -> None:
    with pytest.raises(ValueError, match="backend"):
        Session(backend="tpu")
    with pytest.raises(ValueError, match="precision"):
        Session(precision="f16")
    with pytest.raises(tirtouch.TirtouchError, match="f64"):
        Session(backend="gpu", precision="f64")
    # Photons cannot be connected through a stack that is not flat: nobody's fault but the caller's.
    with pytest.raises(tirtouch.TirtouchError) as raised:
        session.render(phantom, integrator="splat", **FEW)
    assert not isinstance(raised.value, tirtouch.SceneError)
    with pytest.raises(tirtouch.SceneError):
        session.render(phantom.set({"press.depths_mm[1]": 200.0}), **FEW)


def test_without_an_adapter_a_gpu_is_a_device_error_and_auto_takes_the_cpu() -> None:
    code = """
import tirtouch
try:
    tirtouch.Session(backend="gpu")
except tirtouch.DeviceError as error:
    print("device:", error)
print(tirtouch.Session().adapter)
"""
    child = run_python(code, VK_DRIVER_FILES="/nonexistent", VK_ICD_FILENAMES="/nonexistent")
    out, err = child.communicate(timeout=60)
    assert (child.returncode, err) == (0, "")
    assert out.startswith("device: no Vulkan") and "built-in CPU tracer" in out


def test_the_cpu_gives_the_same_light_in_both_precisions(disc: Scene) -> None:
    means = []
    for precision in ("f32", "f64"):
        session = Session(backend="cpu", precision=precision)
        assert session.backend == "cpu"
        means.append(session.render(disc.set({"camera.pixels[0]": 16, "camera.pixels[1]": 12}), **FEW).radiance.mean())
    # The same random numbers: rounding alone differs, and may send single paths elsewhere.
    assert means[0] == pytest.approx(means[1], rel=1e-3)


def test_ctrl_c_stops_the_work_and_the_session_goes_on() -> None:
    # What a shell starts in the background ignores Ctrl-C, and so would its children.
    code = """
import signal, tirtouch
signal.signal(signal.SIGINT, signal.default_int_handler)
session = tirtouch.Session()
scene = tirtouch.Scene.preset("contact-disc").set({"camera.pixels[0]": 64, "camera.pixels[1]": 48})
try:
    session.render(scene, seconds=1e6, progress=lambda what, done: print("at work", flush=True))
except KeyboardInterrupt:
    print("interrupted", session.render(scene, spp=16, photons=1 << 14).radiance.shape)
"""
    child = run_python(code)
    assert child.stdout is not None and child.stdout.readline() == "at work\n"
    child.send_signal(signal.SIGINT)
    out, err = child.communicate(timeout=60)
    assert (child.returncode, err) == (0, "")
    assert out.endswith("interrupted (48, 64)\n")


@pytest.mark.skipif(not os.path.exists("/proc/self/statm"), reason="memory is read from /proc")
def test_many_images_take_no_more_memory_than_a_few(session: Session, disc: Scene) -> None:
    tiny = disc.set({"camera.pixels[0]": 16, "camera.pixels[1]": 12, "render.map_texel_mm": 1.0})

    def resident_mib() -> float:
        with open("/proc/self/statm") as file:
            return int(file.read().split()[1]) * os.sysconf("SC_PAGE_SIZE") / 2**20

    def render(images: int) -> None:
        for seed in range(images):
            assert session.render(tiny, seed=seed, **FEW).radiance.max() > 0

    # Allocators and the driver take what they need in the first.
    render(40)
    before = resident_mib()
    render(80)
    assert resident_mib() - before < 3


def test_nothing_is_said_by_itself(disc: Scene, capfd: pytest.CaptureFixture[str]) -> None:
    Session().render(disc, **FEW)
    assert capfd.readouterr() == ("", "")
