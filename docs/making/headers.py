"""What readers take from the header of a file, and what they report, read out of their code."""

from __future__ import annotations

import ast
import inspect
from collections.abc import Iterator, Sequence
from types import ModuleType

from cpm_core.formats.images import (
    dicom,
    dicom_series,
    dicom_slide,
    metaimage,
    microscopy,
    nifti,
    nrrd,
    ome_zarr,
    raster,
    stack,
    tiff,
)
from cpm_core.image import gray_levels
from docs.making.tables import table

_READERS: dict[str, tuple[ModuleType, ...]] = {
    "all images": (stack, gray_levels),
    "PNG, JPEG and other pictures": (raster,),
    "TIFF": (tiff,),
    "CZI, LIF, ND2": (microscopy,),
    "NIfTI, Analyze 7.5": (nifti,),
    "DICOM": (dicom, dicom_series, dicom_slide),
    "NRRD": (nrrd,),
    "MetaImage": (metaimage,),
    "OME-Zarr": (ome_zarr,),
}
"""Kind of file -> the modules that read it."""

_HEADERS = ("dataset", "entries", "entry", "group", "header", "hyperstack", "info", "known", "one", "shared", "tags")
"""Names that headers and their parts have in these modules."""

_PARTS = ("keyframe", "page", "picture", "volume")
"""Names that opened files and their pages have, whose attributes are taken."""

_NO_ENTRIES = ("asarray", "convert", "dataobj", "file_map", "format", "header", "info", "seek", "tags")
"""Attributes of these that lead to other things."""

_HEADER_LISTS = ("names", "tags")
"""Ends of the names of lists of entries."""


def headers() -> str:
    """Entries that each reader takes, and the sentences by which it reports what it changed, assumed or left out."""
    lines = []
    for kind, modules in _READERS.items():
        trees = [ast.parse(inspect.getsource(module)) for module in modules]
        entries = sorted(
            {entry for tree in trees for entry in _find_entries(tree)}, key=lambda entry: (entry.lower(), entry)
        )
        notes = dict.fromkeys(note for tree in trees for note in _find_notes(tree))
        lines.append((kind, ", ".join(f"`{entry}`" for entry in entries) or "none", " ".join(notes) or "nothing"))
    return table(("kind", "what is taken from the header", "what is reported"), lines)


def _find_entries(tree: ast.AST) -> Iterator[str]:
    """Find the names by which a module looks up entries of a header, and the attributes that it takes."""
    for node in ast.walk(tree):
        match node:
            case ast.Call(ast.Attribute(header, "get" | "valueof"), [name, *_]) if _is_named(header, _HEADERS):
                yield from _find_texts(name)
            case ast.Call(ast.Attribute(header, method)) if method[:4] == "get_" and _is_named(header, _HEADERS):
                yield method[4:]
            case ast.Call(ast.Name("parse_numbers"), names):
                yield from (text for name in names for text in _find_texts(name))
            case ast.Attribute(part, name) if (
                _is_named(part, _PARTS) and name[:4] != "get_" and name not in _NO_ENTRIES
            ):
                yield name
            case ast.Subscript(header, name) if _is_named(header, _HEADERS):
                yield from _find_texts(name)
            case ast.Compare(name, _, [header]) if _is_named(header, _HEADERS):
                yield from _find_texts(name)
            case ast.Assign([ast.Name(listed)], names) | ast.For(ast.Name(listed), names):
                if isinstance(names, ast.Tuple) and listed.lower().endswith(_HEADER_LISTS):
                    yield from _find_texts(names)


def _is_named(node: ast.AST, names: Sequence[str]) -> bool:
    """Return whether the last name in an expression is one of these."""
    node = node.func if isinstance(node, ast.Call) else node
    return getattr(node, "attr", getattr(node, "id", "")) in names


def _find_texts(node: ast.AST) -> Iterator[str]:
    """Find the texts in an expression."""
    for part in ast.walk(node):
        if isinstance(part, ast.Constant) and isinstance(part.value, str) and part.value.strip():
            yield part.value


def _find_notes(tree: ast.AST) -> Iterator[str]:
    """Find the sentences of a module that are no errors and no docstrings; what they are filled with is an ellipsis."""
    errors = (one for one in ast.walk(tree) if isinstance(one, ast.Raise) or _is_named(one, ("UnreadableError",)))
    refused = {id(part) for error in errors for part in ast.walk(error)}
    refused |= {id(node.value) for node in ast.walk(tree) if isinstance(node, ast.Expr)}
    refused |= {id(part) for node in ast.walk(tree) if isinstance(node, ast.JoinedStr) for part in node.values}
    for node in ast.walk(tree):
        if id(node) in refused or not isinstance(node, ast.Constant | ast.JoinedStr):
            continue
        parts = node.values if isinstance(node, ast.JoinedStr) else [node]
        text = "".join(str(part.value) if isinstance(part, ast.Constant) else "…" for part in parts)
        if text.endswith(".") and (text[0].isupper() or text[0] == "…") and " " in text:
            yield text
