"""Finds the sentences of the core in its source, with names for the values that are put in.

The core speaks English and knows of no language. Its errors, notes and reasons are formatted strings, so that what
reaches the window holds numbers and names already. Here each of these strings becomes a template: ``f"{path.name} has
{count} pages"`` is ``{name} has {count} pages``. The window finds the template of a sentence again by its fixed parts,
see `app.model.text.templates`.

Where a part of a string is chosen by a condition, as for one page and several, each choice makes a template of its own,
so that nobody has to translate halves of words.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator, Mapping
from itertools import product

_MOST_CONDITIONS = 3
"""Conditions in one string of which all combinations are written out."""

_WORDS = re.compile(r"[A-Za-z]{2,}[,:;]? [A-Za-z]{2,}")
"""Marks a literal as something that a person reads."""

_WORD = re.compile(r"[A-Za-z]{2,}")

_CODE = re.compile(r"[\n<>=#]|%s|import |doi:|\(\d{4}\)")
"""Marks a literal as the content of a file, as code, or as the name of a publication."""

OF_THE_SYSTEM = (
    "No such file or directory",
    "Permission denied",
    "Operation not permitted",
    "Read-only file system",
    "No space left on device",
    "Disk quota exceeded",
    "Input/output error",
    "Is a directory",
    "Not a directory",
    "File exists",
    "File name too long",
    "Device or resource busy",
    "Too many open files",
)
"""What systems say of files, which errors pass on."""

WORDS = (
    *("image", "volume", "page", "frame", "plane", "slice", "channel", "series", "time", "row", "column"),
    *("contour", "shape", "object", "points", "barrier", "two", "three", "four", "rows and columns"),
    *("pages", "frames", "planes"),
)
"""Single words that are values of sentences, and cannot be told from names in a source."""

_PASSING_ON = frozenset({"join", "repr", "str", "sorted", "min", "max", "shortened", "shown", "map"})
"""Functions whose first argument says more than their name."""

_ERRORS = ("Error", "Interrupt")
"""Ends of the names of errors."""

Choices = Mapping[str, bool]


def parts(tree: ast.AST) -> list[ast.AST]:
    """All nodes of a tree, as `ast.walk` gives them, in a quarter of its time."""
    found = [tree]
    for node in found:
        for value in vars(node).values():
            if isinstance(value, ast.AST):
                found.append(value)
            elif type(value) is list:
                found += [each for each in value if isinstance(each, ast.AST)]
    return found


def templates(source: str, errors_only: bool = False) -> Iterator[tuple[str, int]]:
    """Sentences in a source that do not pass through ``tr``, each with its line.

    Parameters
    ----------
    source : str
        Source of a module.
    errors_only : bool
        Only what errors are made with; otherwise every string of several words.
    """
    if errors_only and not any(f"{kind}(" in source for kind in _ERRORS):
        return
    nodes = parts(ast.parse(source))
    passed = _not_read(nodes)
    for node in nodes:
        if id(node) in passed:
            continue
        if isinstance(node, ast.Call) and _called(node).endswith(_ERRORS):
            for said in node.args:
                yield from _said(said, passed, _WORD, node.lineno)
        elif not errors_only and isinstance(node, ast.Constant | ast.JoinedStr | ast.BinOp):
            yield from _said(node, passed, _WORDS, node.lineno)


def _said(node: ast.expr, passed: set[int], readable: re.Pattern[str], line: int) -> Iterator[tuple[str, int]]:
    """Templates of an expression, which is then passed over, and of the words that are put into it."""
    if not isinstance(node, ast.Constant | ast.JoinedStr | ast.BinOp | ast.IfExp) or not _is_text(node):
        return
    passed.update(id(part) for part in parts(node))
    for written in _written_out(node):
        if readable.search(re.sub(r"\{\w+\}", " ", written)) and not _CODE.search(written):
            yield written, line
    for word in _words_put_in(node):
        if _WORD.search(word):
            yield word, line


def _is_text(node: ast.expr) -> bool:
    """Whether an expression is made of literal text."""
    if isinstance(node, ast.BinOp):
        return isinstance(node.op, ast.Add) and (_is_text(node.left) or _is_text(node.right))
    if isinstance(node, ast.IfExp):
        return _is_text(node.body) or _is_text(node.orelse)
    return isinstance(node, ast.JoinedStr) or (isinstance(node, ast.Constant) and isinstance(node.value, str))


def _not_read(nodes: list[ast.AST]) -> set[int]:
    """Nodes that nobody reads: descriptions of code, types, and what is translated by itself."""
    found: set[int] = set()
    for node in nodes:
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant):
            found.add(id(node.value))
        elif isinstance(node, ast.Call) and (_called(node) in {"tr", "from_core"} or _logs(node)):
            found.update(id(part) for argument in node.args for part in parts(argument))
        elif isinstance(node, ast.Assert):
            found.update(id(part) for part in parts(node))
        elif isinstance(node, ast.Dict):
            found.update(id(said) for key, said in zip(node.keys, node.values, strict=True) if _is_suffix(key))
        for field in ("annotation", "returns"):
            noted = getattr(node, field, None)
            if isinstance(noted, ast.expr):
                found.update(id(part) for part in parts(noted))
    return found


def _is_suffix(key: ast.expr | None) -> bool:
    """Whether a key of a table is a suffix of files: the tables of formats are read as a whole."""
    return isinstance(key, ast.Constant) and isinstance(key.value, str) and key.value.startswith(".")


def _logs(call: ast.Call) -> bool:
    return isinstance(call.func, ast.Attribute) and ast.unparse(call.func.value).lstrip("_") in {"log", "logger"}


def _called(call: ast.Call) -> str:
    return call.func.attr if isinstance(call.func, ast.Attribute) else getattr(call.func, "id", "")


def _written_out(node: ast.expr) -> list[str]:
    """The templates of an expression: one for each combination of its conditions."""
    conditions = sorted({ast.unparse(part.test) for part in _choices(node)})
    if len(conditions) > _MOST_CONDITIONS:
        conditions = []
    every = (dict(zip(conditions, taken, strict=True)) for taken in product((True, False), repeat=len(conditions)))
    return list(dict.fromkeys(_template(node, choices) for choices in every))


def _choices(node: ast.expr) -> list[ast.IfExp]:
    """Conditional expressions that choose between texts, and are themselves a part of the text."""
    if isinstance(node, ast.IfExp):
        return [node, *_choices(node.body), *_choices(node.orelse)] if _is_text(node) else []
    if isinstance(node, ast.JoinedStr):
        put_in = [part for part in node.values if isinstance(part, ast.FormattedValue)]
        return [choice for part in put_in if part.format_spec is None for choice in _choices(part.value)]
    if isinstance(node, ast.BinOp):
        return [*_choices(node.left), *_choices(node.right)]
    return []


def _template(node: ast.expr, choices: Choices) -> str:
    names: dict[str, str] = {}  # of placeholders, by their expressions

    def written(part: ast.expr) -> str:
        if isinstance(part, ast.Constant) and isinstance(part.value, str):
            return part.value
        if isinstance(part, ast.JoinedStr):
            return "".join(written(value) for value in part.values)
        if isinstance(part, ast.FormattedValue):
            plain = part.format_spec is None and isinstance(part.value, ast.IfExp | ast.JoinedStr)
            return written(part.value) if plain else put_in(part.value)
        if isinstance(part, ast.BinOp) and _is_text(part):
            return written(part.left) + written(part.right)
        if isinstance(part, ast.IfExp) and ast.unparse(part.test) in choices:
            return written(part.body if choices[ast.unparse(part.test)] else part.orelse)
        return put_in(part)

    def put_in(part: ast.expr) -> str:
        expression = ast.unparse(part)
        if expression not in names:
            name = _name(part)
            taken = sum(other.rstrip("0123456789") == name for other in names.values())
            names[expression] = f"{name}{taken + 1}" if taken else name
        return f"{{{names[expression]}}}"

    return written(node)


def _name(node: ast.expr) -> str:
    """A word for what an expression puts into a sentence."""
    if isinstance(node, ast.Call):
        called = _called(node)
        if called == "len":
            return "count"
        return _name(node.args[0]) if called in _PASSING_ON and node.args else called.strip("_") or "value"
    inner = {ast.BoolOp: "values", ast.BinOp: "left", ast.Subscript: "value", ast.Starred: "value"}.get(type(node))
    if inner is not None:
        within = getattr(node, inner)
        return _name(within[0] if isinstance(within, list) else within)
    named = node.attr if isinstance(node, ast.Attribute) else getattr(node, "id", "value")
    return named.strip("_").lower()


def _words_put_in(node: ast.expr) -> Iterator[str]:
    """Words that are chosen when a sentence is made, and are values of it."""
    for part in parts(node):
        options: list[ast.expr] = []
        if isinstance(part, ast.FormattedValue):
            inner = part.value
            if isinstance(inner, ast.BoolOp):
                options = inner.values
            elif isinstance(inner, ast.Subscript) and isinstance(inner.value, ast.Dict | ast.Tuple):
                options = inner.value.values if isinstance(inner.value, ast.Dict) else inner.value.elts
            elif isinstance(inner, ast.IfExp) and part.format_spec is not None:
                options = [inner.body, inner.orelse]
        yield from (each.value for each in options if isinstance(each, ast.Constant) and isinstance(each.value, str))
