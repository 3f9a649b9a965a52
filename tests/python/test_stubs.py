"""Type hints that are true: the stub of the compiled module, the annotations and the docstrings."""

import ast
import inspect
import re
from pathlib import Path

import partscribe
import pytest
from partscribe import _native

STUB = ast.parse((Path(partscribe.__file__).parent / "_native.pyi").read_text())
SHARED = {"threads", "progress"}  # described once, for all functions


def arguments(function):
    """As the compiled module states them in the first line of each docstring."""
    line = function.__doc__.splitlines()[0]
    return [a.arg for a in ast.parse(f"def {line}: ...").body[0].args.args]


def stated(node):
    return [a.arg for a in node.args.args]


def test_the_stub_has_the_functions_of_the_module():
    functions = {node.name: node for node in STUB.body if isinstance(node, ast.FunctionDef)}
    compiled = {name: f for name, f in vars(_native).items() if inspect.isbuiltin(f)}
    assert set(functions) == set(compiled)
    for name, node in functions.items():
        assert stated(node) == arguments(compiled[name]), name
    assert isinstance(_native.version, str)


def test_the_stub_has_the_classes_of_the_module():
    classes = {node.name: node for node in STUB.body if isinstance(node, ast.ClassDef)}
    compiled = {name: c for name, c in vars(_native).items() if inspect.isclass(c)}
    assert set(classes) == set(compiled)
    for name, node in classes.items():
        members = {m.name: m for m in node.body if isinstance(m, ast.FunctionDef)}
        there = {n for n in vars(compiled[name]) if not n.startswith("_")} | (
            {"__len__", "__repr__"} & set(vars(compiled[name]))
        )
        assert set(members) == there, name
        for member, stub in members.items():
            is_property = any(isinstance(d, ast.Name) and d.id == "property" for d in stub.decorator_list)
            assert is_property == isinstance(vars(compiled[name])[member], property), (name, member)
            if not is_property and not member.startswith("_"):
                assert stated(stub) == arguments(getattr(compiled[name], member)), (name, member)


def test_a_stub_that_lags_behind_is_noticed():
    node = next(n for n in STUB.body if isinstance(n, ast.FunctionDef) and n.name == "emit")
    assert stated(node)[:-1] != arguments(_native.emit)


@pytest.mark.parametrize("name", [n for n in partscribe.__all__ if inspect.isfunction(getattr(partscribe, n))])
def test_functions_are_annotated_and_described(name):
    function = getattr(partscribe, name)
    signature = inspect.signature(function)
    assert signature.return_annotation is not inspect.Signature.empty
    assert all(p.annotation is not inspect.Parameter.empty for p in signature.parameters.values())
    described = set(re.findall(r"^    (\w+(?:, \w+)*) :", function.__doc__, re.M))
    names = {n for group in described for n in group.split(", ")}
    assert names <= set(signature.parameters), names
    for parameter in signature.parameters:
        assert parameter in SHARED or re.search(rf"\b{parameter}\b", function.__doc__), (name, parameter)


def test_all_is_all():
    public = {n for n, v in vars(partscribe).items() if inspect.isfunction(v) or inspect.isclass(v)}
    ours = {n for n in public if getattr(partscribe, n).__module__.startswith("partscribe") and not n.startswith("_")}
    assert ours == set(partscribe.__all__)
    assert (Path(partscribe.__file__).parent / "py.typed").exists()
