"""The compiled part: tests/python/test_stubs.py holds it against the module."""

import os
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

_File = str | os.PathLike[str]
_Progress = Callable[[str, float], object]

version: str

class Scan:
    """All files of one part in one frame, in mm; arrays are read-only views, None for what a scan does not have."""

    @property
    def points(self) -> NDArray[np.float64] | None: ...
    @property
    def normals(self) -> NDArray[np.float64] | None: ...
    @property
    def rays(self) -> NDArray[np.float64] | None: ...
    @property
    def sigma(self) -> NDArray[np.float32] | None: ...
    @property
    def view(self) -> NDArray[np.int32] | None: ...
    @property
    def rejected(self) -> NDArray[np.bool_] | None: ...
    @property
    def vertices(self) -> NDArray[np.float64] | None: ...
    @property
    def triangles(self) -> NDArray[np.uint32] | None: ...
    @property
    def views(self) -> list[str]: ...
    @property
    def files(self) -> list[Path]: ...
    @property
    def warnings(self) -> list[str]: ...
    @property
    def unit_scale(self) -> float: ...
    def __len__(self) -> int: ...
    def __repr__(self) -> str: ...

class Measured:
    @property
    def json(self) -> str: ...
    @property
    def face_of(self) -> NDArray[np.uint32] | None: ...

class Judged:
    @property
    def json(self) -> str: ...
    @property
    def table(self) -> str: ...
    @property
    def exit_code(self) -> int: ...
    def deviations(self, artifact: int) -> NDArray[np.float32] | None: ...
    def vertices(self, artifact: int) -> NDArray[np.float64] | None: ...
    def triangles(self, artifact: int) -> NDArray[np.uint32] | None: ...

class Built:
    @property
    def json(self) -> str: ...
    @property
    def model(self) -> str: ...
    @property
    def artifacts(self) -> dict[str, bytes]: ...
    @property
    def scan(self) -> Scan: ...
    @property
    def judged(self) -> Judged: ...

class Model:
    @staticmethod
    def read(file: _File) -> Model: ...
    @staticmethod
    def parse(json: str) -> Model: ...
    @property
    def json(self) -> str: ...
    def explain(self) -> str: ...

def read(
    files: Sequence[_File],
    units: str,
    poses: str,
    registration: str,
    fiducials: _File,
    correct_depth: bool,
    filter: str,
    threads: int,
    progress: _Progress | None,
) -> Scan: ...
def measure(scan: Scan, tolerance: float | None, threads: int, progress: _Progress | None) -> Measured: ...
def build(
    scan: Scan,
    tolerance: float | None,
    out: _File,
    name: str,
    to: Sequence[str],
    nominal: bool,
    procedure: str,
    templates: _File,
    force: bool,
    threads: int,
    progress: _Progress | None,
) -> Built: ...
def verify(
    artifacts: Sequence[_File],
    scan: Scan,
    tolerance: float | None,
    model: Model | None,
    rule: str,
    strict: bool,
    align: str,
    outliers: float | None,
    time_limit: float,
    second_opinion: bool,
    threads: int,
    progress: _Progress | None,
) -> Judged: ...
def emit(model: Model, to: Sequence[str], out: _File, templates: _File, force: bool) -> dict[str, bytes]: ...
