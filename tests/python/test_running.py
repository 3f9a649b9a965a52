"""While C++ works: progress, exceptions, Ctrl-C, other threads."""

import os
import signal
import threading
import time

import partscribe
import pytest


def test_progress_is_told(pin):
    told = []
    partscribe.build(pin, 0.1, to=["openscad"], progress=lambda stage, share: told.append((stage, share)))
    stages = [stage.split(":")[0] for stage, _ in told]
    assert [s for s in ("read", "fit", "write", "verify") if s in stages] == ["read", "fit", "write", "verify"]
    assert stages.index("read") < stages.index("fit") < stages.index("verify")
    assert all(0 <= share <= 1 for _, share in told)


def test_an_exception_in_progress_stops_the_work(pin, tmp_path):
    class Enough(Exception):
        pass

    def progress(stage, share):
        if stage.startswith("fit"):
            raise Enough(stage)

    begin = time.monotonic()
    with pytest.raises(Enough, match="fit"):
        partscribe.build(pin, 0.1, tmp_path / "pin", progress=progress)
    assert time.monotonic() - begin < 10
    assert not (tmp_path / "pin/part.scad").exists()


def test_ctrl_c_stops_the_work(pin):
    fitting = threading.Event()

    def interrupt():
        fitting.wait(60)
        os.kill(os.getpid(), signal.SIGINT)

    def progress(stage, share):
        if stage.startswith("fit"):
            fitting.set()

    thread = threading.Thread(target=interrupt)
    thread.start()
    begin = time.monotonic()
    with pytest.raises(KeyboardInterrupt):
        partscribe.build(pin, 0.1, progress=progress)
    thread.join()
    assert time.monotonic() - begin < 20


def test_other_threads_run_meanwhile(pin):
    running, ticks = True, 0

    def tick():
        nonlocal ticks
        while running:
            ticks += 1
            time.sleep(0.002)

    thread = threading.Thread(target=tick)
    thread.start()
    begin, before = time.monotonic(), ticks
    partscribe.measure(pin, 0.1)
    seconds, during = time.monotonic() - begin, ticks - before
    running = False
    thread.join()
    # With the interpreter's lock held there would be none at all, but for the moments before and after.
    assert seconds > 0.1 and during > 20 * seconds


def test_two_builds_at_a_time(box):
    parts = []
    threads = [
        threading.Thread(target=lambda: parts.append(partscribe.build(box, 0.05, to=["alpha1"]))) for _ in range(2)
    ]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert parts[0].artifacts == parts[1].artifacts and parts[0].ok
