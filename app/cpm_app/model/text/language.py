"""The language of the window: sentences, what errors report, and numbers.

The source is written in English, and so is all that the command line writes. A catalog ``cpm.mo`` of gettext in
``assets/languages/<language>/LC_MESSAGES`` gives the sentences of another language; a sentence that it lacks stays
English. The preferences choose the language; by default it is that of the environment (``LANGUAGE``, ``LC_ALL``,
``LC_MESSAGES``, ``LANG``), or of the system where the environment names none.

Sentences of the window pass through `tr` as literals. `cpm_core` knows no language: its names of parameters, shapes
and formats are in the catalogs, as are the sentences of
``assets/languages/core_sentences.txt``; `translate_core_text` does. Other errors and notes of the core, which hold
numbers and names, are shown in English.

To add a language, say Dutch:

1. ``python assets/languages/update.py nl`` begins ``assets/languages/nl/LC_MESSAGES/cpm.po`` with all sentences.
   The sentence "English" is translated by the name of the language in itself, the program replaces what is in braces
   (``{key:run}`` by the key of that action), and ``&`` precedes the letter that chooses an entry of a menu. An
   activity, such as "opening {name}", is put into "Something unexpected happened while {activity}": translate both so
   that they fit, for instance by a noun.
2. ``python assets/languages/update.py`` brings all translations up to date, makes their catalogs, and lists the
   sentences that still lack a translation. Translate "English" last: a language can be chosen once its name is there.

Tests find sentences in the source that pass through neither, and open the window in a language made up of brackets.
"""

from __future__ import annotations

import gettext
import os
from collections.abc import Sequence
from pathlib import Path

from cpm_app.model.text.assets import find_asset_folder

_CATALOG_DOMAIN = "cpm"

LANGUAGE_KEY = "language"
"""Key of the preference, which is read before anything else."""

SYSTEM_LANGUAGE = "system"
"""Value of the preference that follows the language of the system."""

_SOURCE_LANGUAGE = "en"
"""Language that the sentences are written in."""

_LANGUAGE_VARIABLES = ("LANGUAGE", "LC_ALL", "LC_MESSAGES", "LANG")
"""Variables of the environment that name a language."""

MAX_SHOWN_LETTERS = 4000
"""Most letters shown of a text from outside: the layout of a million would take minutes."""

_catalog: gettext.NullTranslations = gettext.translation(_CATALOG_DOMAIN, find_asset_folder("languages"), fallback=True)
_marks: dict[int, str] = {}


def tr(message: str, /, **values: object) -> str:
    """Translate a sentence into the language of the window, and fill in the values of what is in braces, if any."""
    sentence = _catalog.gettext(message)
    return sentence.format(**values) if values else sentence


def translate_core_text(text: str) -> str:
    """Translate a text that is no literal here, such as a name of the core; return it unchanged if unknown."""
    return _catalog.gettext(text) if text else text


def explain_error(error: Exception) -> str:
    """Describe an error in a sentence; for an error with a file, begin with the name of the file."""
    if isinstance(error, OSError) and error.strerror and isinstance(error.filename, str | Path):
        return f"{Path(error.filename).name}: {explain_system_error(error)}"
    return translate_core_text(str(error))


def explain_system_error(error: OSError) -> str:
    """Return what the system reports, without the name of a file."""
    return translate_core_text(error.strerror or str(error))


def elide_middle(text: str, max_length: int = MAX_SHOWN_LETTERS) -> str:
    """Shorten a text to at most `max_length` letters by leaving out its middle."""
    if len(text) <= max_length:
        return text
    half = (max_length - 1) // 2
    return f"{text[:half]}…{text[-half:]}"


def use_number_marks(decimal: str, group: str) -> None:
    """Set the decimal mark, and the separator of groups of three digits, in which numbers are written."""
    global _marks  # noqa: PLW0603  # a language is chosen once, at the start
    _marks = str.maketrans({".": decimal, ",": group})


def localize_number(number: str) -> str:
    """Replace the marks of a number that Python has formatted by those of the language."""
    return number.translate(_marks)


def use_language(name: str, system_languages: Sequence[str] = ()) -> None:
    """Translate into a language; must be called before modules with sentences are imported.

    Parameters
    ----------
    name : str
        A name of `list_languages`; any other one chooses the language of the environment.
    system_languages : sequence of str
        Names of the languages of the system, such as ``"de-DE"``, the preferred one first. They count where the
        environment names none, as on Windows and macOS.
    """
    global _catalog  # noqa: PLW0603  # sentences are translated while modules are imported
    if name == _SOURCE_LANGUAGE:
        _catalog = gettext.NullTranslations()
        return
    wanted = [name] if name in list_languages() else None
    if wanted is None and not any(map(os.environ.get, _LANGUAGE_VARIABLES)):
        exact = [each.replace("-", "_") for each in system_languages]
        wanted = [part for each in exact for part in (each, each.partition("_")[0])]
    if wanted is not None and _SOURCE_LANGUAGE in wanted:  # those who prefer the source language need no further one
        wanted = wanted[: wanted.index(_SOURCE_LANGUAGE)]
    _catalog = gettext.translation(_CATALOG_DOMAIN, find_asset_folder("languages"), wanted, fallback=True)


def current_language() -> str:
    """Return the name of the language in use."""
    return _catalog.info().get("language", _SOURCE_LANGUAGE)


def list_languages() -> dict[str, str]:
    """Return the names of all languages, such as ``"de"``, with what their speakers call them."""
    found = {_SOURCE_LANGUAGE: "English"}
    place = find_asset_folder("languages")
    for file in sorted(place.glob(f"*/LC_MESSAGES/{_CATALOG_DOMAIN}.mo")) if place else ():
        name = file.parents[1].name
        found[name] = gettext.translation(_CATALOG_DOMAIN, place, [name]).gettext("English")
    return found
