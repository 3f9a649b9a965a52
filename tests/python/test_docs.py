"""What the documentation shows is what happens: every example in it is run."""

import doctest
import re

import partscribe
import pytest

FLAGS = doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE


def run(text, names, where):
    runner, said = doctest.DocTestRunner(optionflags=FLAGS), []
    test = doctest.DocTestParser().get_doctest(text, names, where, where, 0)
    runner.run(test, out=said.append, clear_globs=False)
    names.update(test.globs)
    assert runner.failures == 0, "".join(said)
    return runner.tries


@pytest.fixture
def beside_the_corpus(root, tmp_path, monkeypatch):
    (tmp_path / "corpus").symlink_to(root / "corpus")
    monkeypatch.chdir(tmp_path)


def test_the_examples_of_the_page(root, beside_the_corpus):
    page = (root / "docs/python.md").read_text()
    blocks = re.findall(r"^```(\w*)\n(.*?)^```$", page, re.M | re.S)
    python = [text for language, text in blocks if language == "pycon"]
    # All code of Python is shown as a conversation, so that none is left out here.
    assert not [text for language, text in blocks if language in ("python", "py")]
    names = {}
    assert sum(run(text, names, "docs/python.md") for text in python) > 20


def test_the_example_of_the_package(beside_the_corpus):
    assert run(partscribe.__doc__, {}, "partscribe") == 4


def test_an_answer_that_is_no_longer_true_is_noticed():
    with pytest.raises(AssertionError, match="Expected"):
        run(">>> 1 + 1\n3\n", {}, "arithmetic")
