"""What a session file holds beside the drawing and is of use without: runs, pages, ground truth, comparison."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from cpm_core.formats.sessions.compared_methods import compared_from_plain
from cpm_core.formats.sessions.plain_values import from_plain
from cpm_core.formats.sessions.session_json import Plain
from cpm_core.objects.methods import Compared
from cpm_core.parameters.quotation import shown


@dataclass(frozen=True, slots=True)
class TruthFile:
    """The ground truth of a session.

    Attributes
    ----------
    path : str
        Its file; a relative path starts at the folder of the session file.
    absolute : str
        Another path where it may be.
    tolerance : float
        Distance up to which boundaries count as the same [px].
    holes : bool
        Whether a contour inside another one is a hole.
    """

    path: str
    absolute: str = ""
    tolerance: float = 2.0
    holes: bool = True


def place_to_plain(place: str, folder: Path) -> dict[str, Any]:
    """A path relative to a folder if it lies there, with the absolute one, else as it is."""
    path, folder = Path(place), folder.resolve()
    if path.is_absolute() and path.is_relative_to(folder):
        return {"path": path.relative_to(folder).as_posix(), "absolute": str(path)}
    return {"path": place}


def beside_document(plain: Plain) -> tuple[Plain, Plain, TruthFile | None, Compared, tuple[str, ...]]:
    """Runs, pages, ground truth and comparison, and sentences on what is wrong: the rest is of use without them."""
    faults: list[str] = []
    runs = _named(plain, "runs", "recorded runs", faults)
    pages = _named(plain, "pages", "other pages of the stack", faults)
    truth = None
    try:
        truth = None if plain.get("truth") is None else from_plain(TruthFile, plain["truth"], "truth")
        if truth is not None and (not truth.path or "\0" in truth.path + truth.absolute or truth.tolerance < 0.0):
            raise ValueError(f"truth names {shown(truth.path)} within {truth.tolerance:g} px.")
    except ValueError as error:
        truth = None
        faults.append(f"The ground truth was left out: {error}")
    comparison = compared_from_plain(plain["comparison"], faults) if "comparison" in plain else Compared()
    return runs, pages, truth, comparison, tuple(faults)


def _named(plain: Plain, name: str, words: str, faults: list[str]) -> Plain:
    """An entry that is an object with named values; for any other a sentence is added to the faults."""
    given = plain.get(name, {})
    if isinstance(given, dict):
        return given
    faults.append(f"The {words} were left out: they are {shown(given)}, not an object with named values.")
    return {}
