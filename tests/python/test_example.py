"""The example with matplotlib draws its picture."""

import subprocess
import sys

import pytest


def test_the_example_draws_a_verified_and_a_refused_script(root, pin, tmp_path):
    pytest.importorskip("matplotlib", reason="skipped: matplotlib is not installed")
    picture = tmp_path / "deviations.png"
    run = [sys.executable, root / "examples/python/deviations.py", pin, picture]
    said = subprocess.run(run, check=True, capture_output=True, text=True).stdout
    assert "NOT VERIFIED: shank" in said
    assert picture.read_bytes().startswith(b"\x89PNG") and picture.stat().st_size > 20000
