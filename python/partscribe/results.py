"""What the functions of partscribe answer: the JSON that the program writes, as objects, and arrays beside it."""

from __future__ import annotations

import json
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Any, TypeVar

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from . import _native

T = TypeVar("T")
_UNITS = {"length": "mm", "angle": "rad", "count": "", "ratio": ""}


def _filled(kind: type[T], row: dict[str, Any], **more: object) -> T:
    """A dataclass from the keys of the same names."""
    names = [field.name for field in fields(kind) if field.name not in more]  # type: ignore[arg-type]
    return kind(**{name: row.get(name) for name in names}, **more)


@dataclass(frozen=True)
class Parameter:
    """A named number of a model.

    `value` is what the scripts say, `fitted` what the data said, `sigma` its standard deviation (0: not fitted), all in
    `unit`: "mm", "rad" or "". `nominal` says why a nominal value was taken or not, `formula` how the value follows from
    other parameters; None where there is no such thing.
    """

    name: str
    quantity: str
    value: float
    unit: str
    fitted: float
    sigma: float
    points: int | None
    nominal: dict[str, Any] | None
    formula: Any
    note: str | None


def parameters_of(model: dict[str, Any]) -> list[Parameter]:
    return [
        _filled(Parameter, row, unit=_UNITS[row.get("quantity", "length")]) for row in model.get("parameters", [])
    ]


@dataclass(frozen=True)
class Dimension:
    """One number of a feature: as the artifact says (`nominal`) and as fitted to its points (`measured`); mm or rad."""

    name: str
    quantity: str
    nominal: float
    measured: float
    sigma: float
    deviation: float
    within: bool


@dataclass(frozen=True)
class Feature:
    """A row of the verdict: a face, hole or round of the artifact, with its deviations in mm.

    `max` is the largest local mean, `covered` the share of its surface with data.
    """

    name: str
    kind: str
    verdict: str
    points: int
    rms: float
    max: float
    covered: float
    dimensions: list[Dimension]


@dataclass(frozen=True)
class Finding:
    """A place where artifact and scan disagree, or that was not scanned (`kind`).

    `deviation` is mm along `direction`, the unit vector towards the scan (zero: none); `place` is on the surface;
    `area` is mm^2, `extent` mm. `text` says all of it in one line.
    """

    kind: str
    feature: str
    place: list[float]
    direction: list[float]
    deviation: float
    area: float
    extent: float
    points: int
    reason: str
    text: str


class ArtifactVerdict:
    """What one file amounts to. The verdict is "verified", "out_of_tolerance", "cannot_decide" or "not_run"."""

    def __init__(self, judged: _native.Judged, index: int, row: dict[str, Any]) -> None:
        self._judged, self._index = judged, index
        self.json = row
        self.file: str = row["file"]
        self.backend: str = row["backend"]
        self.program: str = row["program"]
        self.verdict: str = row["verdict"]
        self.ok: bool = self.verdict == "verified"
        self.reasons: list[str] = row["reasons"]
        self.findings = [_filled(Finding, finding) for finding in row.get("findings", [])]
        self.features = [
            _filled(Feature, feature, dimensions=[_filled(Dimension, d) for d in feature.get("dimensions", [])])
            for feature in row["objects"]
        ]

    @property
    def deviations(self) -> NDArray[np.float32] | None:
        """(N,) mm, one for each point of the scan: its local signed deviation from the artifact, positive outside.

        NaN for points that were set aside; None if nothing was compared. Read-only, without a copy.
        """
        return self._judged.deviations(self._index)

    @property
    def vertices(self) -> NDArray[np.float64] | None:
        """(V, 3) mm, of the geometry that the program made of the file. Read-only, without a copy."""
        return self._judged.vertices(self._index)

    @property
    def triangles(self) -> NDArray[np.uint32] | None:
        """(M, 3) indices of `vertices`. Read-only, without a copy."""
        return self._judged.triangles(self._index)

    def __repr__(self) -> str:
        return f"<partscribe.ArtifactVerdict {self.file}: {self.verdict}>"


class Verdict:
    """Do artifacts agree with a scan? `verdict` is the worst of all, `json` all of verdict.json; `print` shows a table.

    `tolerance`, `noise` and `smallest_honest_tolerance`, below which the scan cannot decide, are mm; `exit_code` is the
    command line's. An artifact is found by its file's name: `verdict["part.scad"].deviations`.
    """

    def __init__(self, judged: _native.Judged) -> None:
        self._judged = judged
        self.json: dict[str, Any] = json.loads(judged.json)
        self.verdict: str = self.json["verdict"]
        self.ok: bool = self.verdict == "verified"
        self.exit_code: int = judged.exit_code
        self.tolerance: float = self.json["tolerance"]
        self.noise: float = self.json["noise"]
        self.smallest_honest_tolerance: float = self.json["smallest_honest_tolerance"]
        self.artifacts = [ArtifactVerdict(judged, i, row) for i, row in enumerate(self.json["artifacts"])]

    @property
    def findings(self) -> list[Finding]:
        """Of all artifacts; of each the worst first."""
        return [finding for artifact in self.artifacts for finding in artifact.findings]

    def __getitem__(self, file: str) -> ArtifactVerdict:
        for artifact in self.artifacts:
            if artifact.file == file:
                return artifact
        raise KeyError(file)

    def __str__(self) -> str:
        return self._judged.table

    def __repr__(self) -> str:
        return f"<partscribe.Verdict {self.verdict} within {self.tolerance} mm>"


class Measurement:
    """Faces, features and relations as faces.json has them (docs/faces.schema.json), mm and degrees.

    `faces`, `features`, `relations` and `unclassified` are lists of dicts, `json` is all of it. `source` says whether
    faces are made of a mesh's triangles ("mesh") or of points ("points").
    """

    def __init__(self, measured: _native.Measured) -> None:
        self._measured = measured
        self.json: dict[str, Any] = json.loads(measured.json)
        self.tolerance: float = self.json["tolerance"]
        self.source: str = self.json["source"]
        self.faces: list[dict[str, Any]] = self.json["faces"]
        self.features: list[dict[str, Any]] = self.json["features"]
        self.relations: list[dict[str, Any]] = self.json["relations"]
        self.unclassified: list[dict[str, Any]] = self.json["unclassified"]

    @property
    def face_of(self) -> NDArray[np.uint32] | None:
        """For each triangle or point of the scan an index into `faces`; 2**32 - 1: none. Read-only, without a copy."""
        return self._measured.face_of

    def __repr__(self) -> str:
        return f"<partscribe.Measurement of {len(self.faces)} faces and {len(self.features)} features>"


class Build:
    """The procedure of a part, and how it fared.

    Attributes
    ----------
    verdict : Verdict
    ok : bool
        Every file is verified.
    procedure, description : str
        One word, and the procedure in words. `fallback` tells that it is a triangulation, because none was found.
    parameters : list of Parameter
    model : dict
        model.json; changed, it can be given to `emit`. `model_json` is its text.
    artifacts : dict
        The files by name, as bytes: {"part.scad": ..., "part.step": ...}.
    files : list of str
        What was written into `out`.
    scan : Scan
        As the fit saw it: with normals, sigma and outlier flags.
    json : dict
        What `build --json` prints.
    """

    def __init__(self, built: _native.Built) -> None:
        self.json: dict[str, Any] = json.loads(built.json)
        self.verdict = Verdict(built.judged)
        self.ok: bool = self.verdict.ok
        self.procedure: str = self.json["procedure"]
        self.description: str = self.json["description"]
        self.fallback: bool = self.json["fallback"]
        self.files: list[str] = self.json["files"]
        self.model_json: str = built.model
        self.model: dict[str, Any] = json.loads(built.model)
        self.parameters = parameters_of(self.model)
        self.artifacts: dict[str, bytes] = built.artifacts
        self.scan: _native.Scan = built.scan

    def value(self, name: str) -> float:
        """Of the parameter of this name, in mm or rad."""
        for parameter in self.parameters:
            if parameter.name == name:
                return parameter.value
        raise KeyError(name)

    def __repr__(self) -> str:
        return f"<partscribe.Build of {self.description}: {self.verdict.verdict}>"
