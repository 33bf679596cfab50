"""The tests themselves: each of them asserts something, in a folder and of a sentence that can be found."""

import ast
from collections import defaultdict
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import pytest

TESTS = Path(__file__).parent
ROOT = TESTS.parent
FILES = sorted(TESTS.rglob("*.py"))
FUNCTION = ast.FunctionDef | ast.AsyncFunctionDef
CHECKS = {"raises", "warns", "fail", "waitUntil", "waitSignal", "run_state_machine_as_test"}
"""Functions of other libraries that fail when something is not as it should be."""

WAITS = ("hand.wait", "hand.wait_for_phase", "keys.wait")
"""Methods of fixtures that do so."""


def find_unconditional(statements: list[ast.stmt]) -> Iterator[ast.AST]:
    """Nodes of statements but for those that a condition or an early end may skip."""
    for statement in statements:
        yield from _find_inside(statement)
        if isinstance(statement, ast.If) and any(
            isinstance(node, ast.Return | ast.Continue | ast.Break) for node in ast.walk(statement)
        ):
            return


def _find_inside(node: ast.AST) -> Iterator[ast.AST]:
    if isinstance(node, FUNCTION | ast.Lambda | ast.ClassDef):
        return
    yield node
    if isinstance(node, ast.If | ast.IfExp):
        yield from _find_inside(node.test)
        return
    for field, value in ast.iter_fields(node):
        if isinstance(value, list) and all(isinstance(one, ast.stmt) for one in value):
            if not (isinstance(node, ast.Try) and field == "orelse"):
                yield from find_unconditional(value)
        elif not (isinstance(node, ast.Try) and field == "handlers"):
            for one in value if isinstance(value, list) else (value,):
                if isinstance(one, ast.AST):
                    yield from _find_inside(one)


def find_unchecked_tests(sources: dict[str, str]) -> list[str]:
    """Tests, as module and name, that may end without an assertion; helpers that always assert count as assertions."""
    called: dict[tuple[str, str], set[str]] = {}  # by module and function; "assert" stands for the statement
    imported: dict[str, set[str]] = {}  # from other modules of tests
    for module, source in sources.items():
        imported[module] = set()
        for node in ast.walk(ast.parse(source)):
            if isinstance(node, FUNCTION):
                inside = list(find_unconditional(node.body))
                names = {ast.unparse(one.func) for one in inside if isinstance(one, ast.Call)}
                called[module, node.name] = names | {"assert" for one in inside if isinstance(one, ast.Assert)}
            elif isinstance(node, ast.ImportFrom) and (node.level or (node.module or "").startswith("tests.")):
                imported[module] |= {alias.name for alias in node.names}
    checking: set[tuple[str, str]] = set()
    while True:
        helpers = {name for _, name in checking}
        known = {module: imported[module] & helpers for module in sources}
        found = {
            (module, name)
            for (module, name), names in called.items()
            if any(is_check(one) or one in known[module] or (module, one) in checking for one in names)
        }
        if found == checking:
            break
        checking = found
    return [f"{module}: {name}" for module, name in called if name.startswith("test_") and (module, name) not in found]


def is_check(name: str) -> bool:
    """Whether what is called by this name fails a test."""
    last = name.rpartition(".")[2]
    return name == "assert" or name in WAITS or last in CHECKS or last.startswith("assert_")


@cache
def read_sources() -> dict[str, str]:
    return {path.relative_to(TESTS).as_posix(): path.read_text(encoding="utf-8") for path in FILES}


def test_no_test_can_end_without_an_assertion() -> None:
    assert find_unchecked_tests(read_sources()) == []


@pytest.mark.parametrize(
    ("body", "is_checked"),
    [
        ("assert a", True),
        ("for b in a:\n  assert b", True),
        ("with pytest.raises(ValueError):\n  a()", True),
        ("helper()", True),
        ("hand.wait(a)", True),
        ("a()", False),
        ("if a:\n  assert b", False),
        ("if a:\n  assert b\nelse:\n  assert c", False),
        ("for b in a:\n  if b:\n    continue\n  assert b", False),
        ("if a:\n  return\nassert b", False),
        ("def inner():\n  assert a", False),
        ("a.helper()", False),
    ],
)
def test_a_test_that_can_end_without_an_assertion_is_seen(body: str, is_checked: bool) -> None:
    lines = "".join(f"\n  {line}" for line in body.splitlines())
    source = f"def test_a():{lines}\ndef helper():\n  assert d"
    assert find_unchecked_tests({"a": source}) == ([] if is_checked else ["a: test_a"])


def find_folders(path: Path, pattern: str) -> set[str]:
    """Folders below this one that hold such files, by their paths from here."""
    return {file.parent.relative_to(path).as_posix() for file in path.rglob(pattern)} - {"."}


@pytest.mark.parametrize(("tests", "source"), [("core", "cpm_core"), ("app", "app/cpm_app")])
def test_folders_of_tests_mirror_those_of_the_source(tests: str, source: str) -> None:
    assert find_folders(TESTS / tests, "*.py") - find_folders(ROOT / source, "*.py") == set()


def test_each_room_of_the_core_has_a_folder_of_tests() -> None:
    rooms = {folder.split("/")[0] for folder in find_folders(ROOT / "cpm_core", "*.py")}
    assert rooms - {folder.split("/")[0] for folder in find_folders(TESTS / "core", "test_*.py")} == set()


SHORTEST_SENTENCE = 5
"""Words from which on a text is a sentence of the program; fewer are its category."""


def find_sentences(source: str) -> set[str]:
    """Sentences that a module asserts or expects of an error."""
    texts: list[ast.AST] = []
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Assert):
            texts += ast.walk(node.test)
        elif isinstance(node, ast.keyword) and node.arg == "match":
            texts += ast.walk(node.value)
    found = {text.value for text in texts if isinstance(text, ast.Constant) and isinstance(text.value, str)}
    plain = {text.replace("\\", "").strip("^$. \n") for text in found}
    return {text for text in plain if len(text.split()) >= SHORTEST_SENTENCE}


def test_a_sentence_is_asserted_word_by_word_in_one_place() -> None:
    places = defaultdict(list)
    for module, source in read_sources().items():
        for sentence in find_sentences(source):
            places[sentence].append(module)
    assert {sentence: modules for sentence, modules in places.items() if len(modules) > 1} == {}
