"""The language of the window: its texts pass through `tr`, those of the core through `from_core`.

The source is written in English, and so is all that the command line says. A catalog ``cpm.mo`` of gettext in
``assets/languages/<language>/LC_MESSAGES`` gives the sentences of another language; a sentence that it lacks stays
English. The preferences choose the language; by default it is that of the environment (``LANGUAGE``, ``LC_ALL``,
``LC_MESSAGES``, ``LANG``), or of the system where the environment names none.

`cpm_core` knows of no language. Its errors, notes and reasons reach the window as finished sentences with values in
them; ``assets/languages/core_templates.py`` finds in its source what they are made of, and `from_core` finds the
sentence again among these templates. The same holds for errors within `app` that name what is damaged in a file.

To add a language, say Dutch:

1. ``python assets/languages/update.py nl`` begins ``assets/languages/nl/LC_MESSAGES/cpm.po`` with all sentences.
   The sentence "English" is translated by the name of the language in itself, the program replaces what is in braces
   (``{key:run}`` by the key of that action), and ``&`` stands before the letter that chooses an entry of a menu. An
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

from app.model.text.assets import folder
from app.model.text.templates import Templates

_DOMAIN = "cpm"

KEY = "language"
"""Key of the preference, which is read before anything else."""

OF_THE_DESKTOP, _SOURCE = "system", "en"

_CORE = "core\x04"
"""Before a sentence of the core in a catalog: gettext's way to write a context."""

_NAMED_BY = ("LANGUAGE", "LC_ALL", "LC_MESSAGES", "LANG")
"""Variables of the environment that name a language."""


def _templates(catalog: gettext.NullTranslations) -> Templates:
    known = getattr(catalog, "_catalog", {})  # empty for English; gettext lists its entries nowhere else
    found = {key.removeprefix(_CORE): said for key, said in known.items() if str(key).startswith(_CORE)}
    return Templates(found)


_catalog: gettext.NullTranslations = gettext.translation(_DOMAIN, folder("languages"), fallback=True)
_core = _templates(_catalog)


def tr(said: str) -> str:
    """The sentence in the language of the window, unchanged where there is no translation."""
    return _catalog.gettext(said)


def from_core(said: str) -> str:
    """A finished sentence of the core in the language of the window, unchanged where it is not known."""
    return _core.translated(said, _catalog.gettext)


def use_language(name: str, of_the_system: Sequence[str] = ()) -> None:
    """Translate into a language; must be called before modules with sentences are imported.

    Parameters
    ----------
    name : str
        A name of `languages`; any other one stands for the language of the environment.
    of_the_system : sequence of str
        Names of the languages of the system, such as ``"de-DE"``, the preferred one first. They count where the
        environment names none, as on Windows and macOS.
    """
    global _catalog, _core  # noqa: PLW0603  # sentences are translated while modules are imported
    if name == _SOURCE:
        _catalog = gettext.NullTranslations()
    else:
        wanted = [name] if name in languages() else None
        if wanted is None and not any(map(os.environ.get, _NAMED_BY)):
            wanted = [part for each in of_the_system for part in _from_exact_to_general(each)]
        _catalog = gettext.translation(_DOMAIN, folder("languages"), _before_english(wanted), fallback=True)
    _core = _templates(_catalog)


def _from_exact_to_general(name: str) -> tuple[str, str]:
    """Names under which a language of the system may be found: as ``de_DE``, and as ``de``."""
    exact = name.replace("-", "_")
    return exact, exact.partition("_")[0]


def _before_english(wanted: list[str] | None) -> list[str] | None:
    """Languages that come before English, the language of the source: whoever prefers it reads nothing else."""
    return wanted[: wanted.index(_SOURCE)] if wanted is not None and _SOURCE in wanted else wanted


def language() -> str:
    """Name of the language in use."""
    return _catalog.info().get("language", _SOURCE)


def languages() -> dict[str, str]:
    """Names of all languages, such as ``"de"``, and what each is called by those who speak it."""
    found = {_SOURCE: "English"}
    place = folder("languages")
    for file in sorted(place.glob(f"*/LC_MESSAGES/{_DOMAIN}.mo")) if place else ():
        name = file.parents[1].name
        found[name] = gettext.translation(_DOMAIN, place, [name]).gettext("English")
    return found
