"""The language of the window: the texts of menus, panels, dialogs and hints pass through `tr`.

Sentences of the core (each `ValueError`, notes on a file that was read) and the phrases of `app.session` that name an
activity in an error message are always in English.

The source is written in English. A catalog ``cpm.mo`` of gettext in ``assets/languages/<language>/LC_MESSAGES`` gives
the sentences of another language; a sentence that it lacks stays English. The preferences choose the language; by
default it is that of the environment (``LANGUAGE``, ``LC_ALL``, ``LC_MESSAGES``, ``LANG``).

To add a language, say Dutch:

1. ``python assets/languages/make_template.py`` writes ``assets/languages/cpm.pot`` with all sentences, also those
   of the core (parameters, shapes, samples) among them.
2. ``msginit -i assets/languages/cpm.pot -l nl -o assets/languages/nl/LC_MESSAGES/cpm.po`` begins the translation.
   The sentence "English" is translated by the name of the language in itself, the program replaces what is in braces
   (``{key:run}`` by the key of that action), and ``&`` stands before the letter that chooses an entry of a menu.
3. ``python assets/languages/update.py`` brings all translations up to date, makes their catalogs, and lists the
   sentences that still lack a translation.

A test finds sentences in the source that do not pass through `tr`, another opens the window in a language made up of
brackets.
"""

from __future__ import annotations

import gettext

from app.model.text.assets import folder

_DOMAIN = "cpm"

KEY = "language"
"""Key of the preference, which is read before anything else."""

OF_THE_DESKTOP, _SOURCE = "system", "en"

_catalog: gettext.NullTranslations = gettext.translation(_DOMAIN, folder("languages"), fallback=True)


def tr(said: str) -> str:
    """The sentence in the language of the window, unchanged where there is no translation."""
    return _catalog.gettext(said)


def use_language(name: str) -> None:
    """Translate into a language; must be called before modules with sentences are imported.

    Parameters
    ----------
    name : str
        A name of `languages`; any other one stands for the language of the environment.
    """
    global _catalog  # noqa: PLW0603  # sentences are translated while modules are imported
    if name == _SOURCE:
        _catalog = gettext.NullTranslations()
    else:
        wanted = [name] if name in languages() else None
        _catalog = gettext.translation(_DOMAIN, folder("languages"), wanted, fallback=True)


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
