"""The language of the window: the texts of menus, panels, dialogs and hints pass through `tr`.

Sentences of the core (each `ValueError`, notes on a file that was read) and the phrases of `app.session` that name an
activity in an error message are always in English.

The source is written in English. A catalog ``cpm.mo`` of gettext in ``assets/languages/<language>/LC_MESSAGES`` gives
the sentences of another language, chosen by the environment (``LANGUAGE``, ``LC_ALL``, ``LC_MESSAGES``, ``LANG``).

To add a language, say Dutch:

1. ``python assets/languages/make_template.py`` writes ``assets/languages/cpm.pot`` with all sentences, also those
   of the core (parameters, shapes, samples) among them.
2. ``msginit -i assets/languages/cpm.pot -l nl -o assets/languages/nl/LC_MESSAGES/cpm.po`` begins the translation;
   ``msgmerge -U`` brings it up to date later. The program replaces what is in braces.
3. ``msgfmt assets/languages/nl/LC_MESSAGES/cpm.po -o assets/languages/nl/LC_MESSAGES/cpm.mo`` makes the catalog.

``pybabel init``, ``update`` and ``compile`` do the same. A test finds sentences in the source that do not pass through
`tr`, and another opens the window in a language made up of brackets.
"""

from __future__ import annotations

import gettext
from collections.abc import Callable

from app.model.text.assets import folder

_DOMAIN = "cpm"

tr: Callable[[str], str] = gettext.translation(_DOMAIN, folder("languages"), fallback=True).gettext
"""The sentence in the language of the window, unchanged where there is no translation."""
