"""What is raised, with the codes of the command line."""

import subprocess

import partscribe
import pytest


def test_an_unreadable_scan_is_an_input_error(tmp_path, program):
    file = tmp_path / "broken.ply"
    file.write_text("ply\nformat ascii 1.0\nelement vertex 3\n")
    with pytest.raises(partscribe.InputError) as caught:
        partscribe.read(file)
    said = subprocess.run([program, "measure", file], capture_output=True, text=True)
    assert said.returncode == caught.value.exit_code == 3
    assert said.stderr.splitlines()[-1] == "partscribe: " + caught.value.message == "partscribe: " + str(caught.value)
    assert "broken.ply" in caught.value.message
    assert caught.value.meaning == "input cannot be used"
    assert isinstance(caught.value, partscribe.Error)


def test_file_names_may_hold_any_bytes(tmp_path):
    name = tmp_path / b"no \xff utf-8.ply".decode(errors="surrogateescape")
    with pytest.raises(partscribe.InputError) as caught:
        partscribe.read(name)
    assert "no \udcff utf-8.ply" in caught.value.message


def test_every_kind_has_a_code_and_a_meaning():
    kinds = partscribe.Error.__subclasses__()
    assert sorted(kind.exit_code for kind in kinds) == [2, 3, 4, 5]
    assert len({kind.meaning for kind in kinds}) == 4
    for kind in kinds:
        assert partscribe.errors.of_kind(kind.exit_code) is kind


def test_a_bad_model_says_where(tmp_path):
    (tmp_path / "model.json").write_text("{}")
    with pytest.raises(partscribe.InputError, match="model.json"):
        partscribe.explain(tmp_path)
    with pytest.raises(partscribe.InputError, match="the model"):
        partscribe.explain({"format": "partscribe-model"})
    with pytest.raises(partscribe.InputError, match="nowhere"):
        partscribe.parameters(tmp_path / "nowhere.json")


def test_wrong_types_are_type_errors(box):
    with pytest.raises(TypeError):
        partscribe.read(3)
    with pytest.raises(TypeError):
        partscribe.build(box, "0.1")
