"""Verdicts: what is refused, where, by how much; deviations as arrays."""

import json
import subprocess

import numpy as np
import partscribe
import pytest


@pytest.fixture(scope="module")
def files(built, tmp_path_factory):
    """The pin as it was built, and with a shank that is 0.6 mm too thick."""
    folder = tmp_path_factory.mktemp("pin")
    for name, data in built.artifacts.items():
        (folder / name).write_bytes(data)
    (folder / "model.json").write_text(built.model_json)
    (folder / "thick").mkdir()
    script = built.artifacts["part.scad"].replace(b"shank_d = 12;", b"shank_d = 12.6;")
    assert script != built.artifacts["part.scad"]
    (folder / "thick/part.scad").write_bytes(script)
    return folder


@pytest.fixture(scope="module")
def refused(files, pin):
    return partscribe.verify(files / "thick/part.scad", pin, 0.1, model=files / "model.json")


def test_two_files_are_verified(files, pin):
    verdict = partscribe.verify([files / "part.scad", files / "part.step"], pin, 0.1)
    assert verdict.ok and verdict.findings == [f for f in verdict.findings if f.kind == "not_scanned"]
    assert verdict["part.step"].program == "OpenCASCADE"
    assert {row.name for row in verdict["part.scad"].features} >= {"shank", "head", "chamfer"}
    with pytest.raises(KeyError):
        verdict["part.igs"]


def test_a_thick_shank_is_refused(refused):
    assert not refused.ok and refused.verdict == "out_of_tolerance" and refused.exit_code == 1
    worst = refused.findings[0]
    assert worst.feature == "shank" and worst.kind == "displaced"
    assert "shank" in worst.text and len(worst.place) == 3
    shank = next(row for row in refused["part.scad"].features if row.name == "shank")
    diameter = next(d for d in shank.dimensions if d.name == "diameter")
    assert diameter.nominal == pytest.approx(12.6, abs=0.01) and diameter.measured == pytest.approx(12, abs=0.01)
    assert diameter.deviation == pytest.approx(-0.6, abs=0.01) and not diameter.within


def test_deviations_are_a_view_with_a_number_for_each_point(refused, pin):
    scan = partscribe.read(pin)
    deviations = refused["part.scad"].deviations
    assert deviations.shape == (len(scan),) and deviations.dtype == np.float32
    again = refused["part.scad"].deviations
    assert deviations.__array_interface__["data"] == again.__array_interface__["data"]
    assert not deviations.flags.owndata and not deviations.flags.writeable
    # The scanned shank lies 0.3 mm inside the thick one; the head is where it was.
    judged = deviations[np.isfinite(deviations)]
    assert np.mean(judged < -0.25) > 0.4 and np.mean(np.abs(judged) < 0.05) > 0.2


def test_geometry_of_an_artifact(refused):
    artifact = refused["part.scad"]
    assert artifact.vertices.shape[1] == artifact.triangles.shape[1] == 3
    assert artifact.triangles.max() < len(artifact.vertices)
    a, b, c = artifact.vertices[artifact.triangles].swapaxes(0, 1)
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2
    assert area == pytest.approx(artifact.json["model_to_data"]["area"])


def test_the_answer_is_that_of_the_command(files, pin, program, tmp_path):
    out = tmp_path / "verdict.json"
    subprocess.run([program, "verify", files / "part.scl", pin, "--tolerance", "0.1", "--json", out], check=True)
    ours, told = partscribe.verify(files / "part.scl", pin, 0.1).json, json.loads(out.read_text())
    for verdict in (ours, told):
        verdict["artifacts"][0].pop("seconds")  # a run takes the time that it takes
    assert ours == told


def test_a_mesh_is_judged_in_a_frame_of_its_own(box, tmp_path):
    scan = partscribe.read(box)
    moved = tmp_path / "moved.obj"
    moved.write_text(
        "".join(f"v {x + 5} {y - 2} {z}\n" for x, y, z in scan.vertices)
        + "".join(f"f {a + 1} {b + 1} {c + 1}\n" for a, b, c in scan.triangles)
    )
    assert not partscribe.verify(moved, scan, 0.1).ok
    aligned = partscribe.verify(moved, scan, 0.1, align="best-fit")
    assert aligned.ok and np.allclose(aligned.json["artifacts"][0]["alignment"]["translation"], [5, -2, 0], atol=1e-3)


def test_a_missing_program_is_an_outcome(files, pin, monkeypatch, tmp_path):
    monkeypatch.setenv("PATH", str(tmp_path))
    verdict = partscribe.verify(files / "part.scad", pin, 0.1)
    assert verdict.verdict == "not_run" and verdict.exit_code == 4
    assert verdict["part.scad"].deviations is None and "openscad" in verdict["part.scad"].reasons[0]


def test_bad_arguments_name_what_is_expected(files, pin):
    with pytest.raises(partscribe.UsageError, match="align: expected one of none, best-fit, datums, found 'icp'"):
        partscribe.verify(files / "part.scad", pin, align="icp")
    with pytest.raises(partscribe.UsageError, match="outliers: expected a number from 0 to 1, found 2"):
        partscribe.verify(files / "part.scad", pin, outliers=2)
    with pytest.raises(partscribe.InputError, match="missing.scad"):
        partscribe.verify(files / "missing.scad", pin)
