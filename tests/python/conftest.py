"""Scans that the tests share."""

import struct
from pathlib import Path

import partscribe
import pytest

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture(scope="session")
def root() -> Path:
    return ROOT


@pytest.fixture(scope="session")
def pin() -> Path:
    """Six range images of a turned pin."""
    return ROOT / "corpus/pin/scan/scan.json"


@pytest.fixture(scope="session")
def program() -> Path:
    """The command line of this build."""
    return Path(partscribe.__file__).parent / "partscribe"


@pytest.fixture(scope="session")
def built(pin) -> partscribe.Build:
    return partscribe.build(pin, 0.1, name="pin")


def box_stl(x: float, y: float, z: float) -> bytes:
    """A box with one corner at the origin, as binary STL."""
    corners = [(a * x, b * y, c * z) for a in (0, 1) for b in (0, 1) for c in (0, 1)]
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    triangles = [t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))]
    facets = b"".join(
        struct.pack("<12fH", 0, 0, 0, *(v for corner in t for v in corners[corner]), 0) for t in triangles
    )
    return bytes(80) + struct.pack("<I", len(triangles)) + facets


@pytest.fixture(scope="session")
def box(tmp_path_factory) -> Path:
    """A mesh of 20 x 30 x 10 mm."""
    file = tmp_path_factory.mktemp("mesh") / "box.stl"
    file.write_bytes(box_stl(20, 30, 10))
    return file


