"""Interruptions: Ctrl+C may raise wherever Python code runs, so none runs where it does harm.

While Numba makes what a loop returns, it would end the process.
"""

import ast
import sys
from pathlib import Path

import numpy as np
import pytest

import cpm_core
from cpm_core import PRESETS, circle, segment, sphere

_PACKAGE = Path(cpm_core.__file__).parent
_HARMED = ("serialize.py",)
"""Parts of names of files whose code must not be interrupted; in the first Numba finds the class of a result."""

ROW, COL = np.indices((40, 44))
DISC = np.where(np.hypot(ROW - 20, COL - 22) < 12, 200.0, 20.0)
BALL = np.where(np.linalg.norm(np.indices((16, 16, 16)) - 7.5, axis=0) < 5.0, 100.0, 0.0)


def called_in(function):
    """Functions of files that must not be interrupted that a call runs once all is compiled and loaded."""
    function()
    found = set()

    def see(frame, event, _argument):
        name = frame.f_code.co_filename
        if event == "call" and any(part in name for part in _HARMED):
            found.add(f"{Path(name).name}: {frame.f_code.co_name}")

    sys.setprofile(see)
    try:
        function()
    finally:
        sys.setprofile(None)
    return found - {"threading.py: RLock"}  # it makes one, and takes none


@pytest.mark.parametrize(
    "run",
    [
        lambda: segment(DISC, circle((20, 22), 6.0), max_steps=9),
        lambda: segment(BALL, sphere((7.5, 7.5, 7.5), 2.5, 60), PRESETS["volume"], max_steps=9),
        lambda: cpm_core.partition(DISC).select([[20.0, 22.0]]),
    ],
    ids=["plane", "volume", "objects"],
)
def test_loops_give_their_results_without_python_code(compiled_loops, run):
    assert not called_in(run)


def _named(tree):
    """Names of the classes of named tuples in a module."""
    return {
        node.name
        for node in ast.walk(tree)
        if isinstance(node, ast.ClassDef) and any(ast.unparse(base) == "NamedTuple" for base in node.bases)
    }


def _is_loop(node):
    return {"compiled", "reordered", "inlined"} & {ast.unparse(decorator) for decorator in node.decorator_list}


def test_no_loop_gives_a_named_tuple_to_python():
    trees = [ast.parse(path.read_text("utf-8")) for path in _PACKAGE.rglob("*.py")]
    named = set().union(*map(_named, trees))
    functions = [node for tree in trees for node in ast.walk(tree) if isinstance(node, ast.FunctionDef)]
    making = {
        loop.name
        for loop in filter(_is_loop, functions)
        if loop.returns and any(isinstance(n, ast.Name) and n.id in named for n in ast.walk(loop.returns))
    }
    loops = {id(call) for loop in filter(_is_loop, functions) for call in ast.walk(loop)}
    outside = [
        ast.unparse(call)
        for tree in trees
        for call in ast.walk(tree)
        if isinstance(call, ast.Call)
        and isinstance(call.func, ast.Name)
        and call.func.id in making
        and id(call) not in loops
    ]
    assert named, "no class found"
    assert not outside, f"make {outside} from a plain tuple"
