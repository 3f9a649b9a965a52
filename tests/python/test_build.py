"""From a scan to a verified model, the same as on the command line."""

import json
import subprocess

import partscribe
import pytest


@pytest.fixture(scope="module")
def folder(program, pin, tmp_path_factory):
    """What the command makes of the pin."""
    out = tmp_path_factory.mktemp("command") / "pin"
    run = [program, "build", pin, "--tolerance", "0.1", "--name", "pin", "--out", out, "--quiet"]
    subprocess.run(run, check=True)
    return out


def test_the_pin_is_verified(built):
    assert built.ok and built.verdict.verdict == "verified" and built.verdict.exit_code == 0
    assert built.procedure == "revolve" and not built.fallback
    assert built.files == []
    assert [a.file for a in built.verdict.artifacts] == ["part.scad", "part.scl", "part.igs", "part.step"]


def test_parameters_are_named_numbers(built):
    head = next(p for p in built.parameters if p.name == "head_d")
    assert head.value == built.value("head_d") == 20 and head.unit == "mm"
    assert abs(head.fitted - 20) < 4 * head.sigma < 0.01
    assert head.nominal["kept"] is True
    with pytest.raises(KeyError):
        built.value("bore_d")


def test_the_files_are_those_of_the_command(built, folder):
    assert sorted(built.artifacts) == sorted(["part.scad", "part.scl", "prelude.scl", "part.igs", "part.step"])
    for name, data in built.artifacts.items():
        assert data == (folder / name).read_bytes(), name
    assert built.model_json == (folder / "model.json").read_text()


def test_a_folder_gets_all_that_the_command_writes(pin, folder, tmp_path):
    out = tmp_path / "pin"
    part = partscribe.build(partscribe.read(pin), 0.1, out, name="pin")
    assert sorted(f.name for f in out.iterdir()) == sorted(f.name for f in folder.iterdir())
    assert sorted(part.files) == sorted(str(f) for f in out.iterdir())
    for name in ("cloud.ply", "model.json", "part.scad", "part.step"):
        assert (out / name).read_bytes() == (folder / name).read_bytes(), name
    with pytest.raises(partscribe.UsageError, match="exists already; give --force"):
        partscribe.build(pin, 0.1, out, name="pin")


def test_a_chosen_backend_alone(box, tmp_path):
    part = partscribe.build(box, 0.05, to=["openscad"], name="Box 1")
    assert list(part.artifacts) == ["part.scad"] and part.model["name"] == "box_1"
    assert sorted(p.value for p in part.parameters) == [10, 20, 30]


def test_the_scan_of_a_build_has_what_the_fit_learnt(box):
    scan = partscribe.read(box)
    part = partscribe.build(scan, 0.05, to=["openscad"])
    assert scan.sigma is None and part.scan.sigma.shape == (len(scan),)


def test_a_changed_model_is_emitted(built, tmp_path):
    model = built.model
    next(p for p in model["parameters"] if p["name"] == "head_d")["value"] = 22
    files = partscribe.emit(model, tmp_path / "larger", ["openscad"])
    assert b"head_d = as_designed ? 22 : 19.9999;" in files["part.scad"]
    assert (tmp_path / "larger/part.scad").read_bytes() == files["part.scad"]
    assert partscribe.emit(built, to=["openscad"])["part.scad"] == built.artifacts["part.scad"]


def test_models_are_explained_and_listed(built, folder, program):
    said = subprocess.run([program, "explain", folder], check=True, capture_output=True, text=True).stdout
    assert partscribe.explain(folder) == partscribe.explain(built) == said
    assert partscribe.parameters(folder / "model.json") == built.parameters
    assert partscribe.parameters(json.loads((folder / "model.json").read_text())) == built.parameters


def test_bad_requests_are_refused_before_the_work(box):
    with pytest.raises(partscribe.UsageError, match="procedure: .* 'bore'"):
        partscribe.build(box, procedure="bore")
    with pytest.raises(partscribe.UsageError, match="expected some of openscad, .* found 'catia'"):
        partscribe.build(box, to=["catia"])
    with pytest.raises(partscribe.UsageError, match="expected a list of words"):
        partscribe.build(box, to="openscad")
    for tolerance in (0, -1, float("nan"), float("inf")):
        with pytest.raises(partscribe.UsageError, match="tolerance: expected"):
            partscribe.build(box, tolerance)
