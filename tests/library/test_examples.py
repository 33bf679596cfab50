"""Every public name has an example in its documentation, and all examples give what they say."""

from __future__ import annotations

import doctest
import importlib
import inspect
import re
from functools import cached_property
from pathlib import Path

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib import pyplot

import cpm_core as cpm
from cpm_core.segmentation.method import _known_run_methods

OBJECTS = {name: getattr(cpm, name) for name in cpm.__all__ if hasattr(getattr(cpm, name), "__qualname__")}
"""Public functions and classes by name; the others are tables."""

ROOT = Path(cpm.__file__).parent

MODULES = [
    ".".join(path.relative_to(ROOT.parent).with_suffix("").parts)
    for path in sorted(ROOT.rglob("*.py"))
    if ">>> " in path.read_text(encoding="utf-8")
]
"""Modules with examples, of public names and of others."""

PARSER = doctest.DocTestParser()


def example_of(what):
    """Source of the examples in a docstring."""
    return "\n".join(example.source for example in PARSER.get_examples(inspect.getdoc(what) or ""))


def members_of(given):
    """Public methods and properties of a class, those of its bases in the library included."""
    found = {}
    for base in reversed(given.__mro__):
        if base.__module__.startswith("cpm_core"):
            found |= {
                name: member
                for name, member in vars(base).items()
                if not name.startswith("_")
                and isinstance(member, property | cached_property | classmethod | staticmethod | type(members_of))
            }
    return found


def without_example(name, given):
    """What of a public name has no example: itself, or one of its methods that neither has one nor is used in one."""
    shown = example_of(given)
    if not shown:
        return [name]
    missing = []
    for member, what in members_of(given).items() if inspect.isclass(given) else ():
        used = re.search(rf"\.{member}\b", shown)
        if not used and not example_of(getattr(what, "func", what)):
            missing.append(f"{name}.{member}")
    return missing


@pytest.fixture
def place(tmp_path, monkeypatch):
    """A folder that examples may write into, and plots without a window."""
    before = mpl.get_backend()
    pyplot.switch_backend("agg")
    monkeypatch.chdir(tmp_path)
    yield
    _known_run_methods.pop("slow", None)  # of an example
    pyplot.close("all")
    pyplot.switch_backend(before)


@pytest.mark.parametrize("name", MODULES)
def test_the_examples_give_what_they_say(name, place):
    finder, runner = doctest.DocTestFinder(recurse=True), doctest.DocTestRunner(optionflags=doctest.ELLIPSIS)
    module, report = importlib.import_module(name), []
    for test in finder.find(module, name, globs={"np": np, "cpm": cpm}):
        own = test.name.rsplit(".", 1)[-1]
        if own not in OBJECTS and hasattr(module, own):
            test.globs[own] = getattr(module, own)
        runner.run(test, out=report.append)
    assert runner.summarize(verbose=False).failed == 0, "".join(report)


@pytest.mark.parametrize("name", OBJECTS)
def test_every_public_name_has_an_example(name):
    assert without_example(name, OBJECTS[name]) == []
