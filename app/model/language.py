"""The language of the window: every sentence that a person reads passes through `tr`.

English is written in the source. A catalogue ``cpm.mo`` of gettext in ``assets/languages/<language>/LC_MESSAGES`` gives
the sentences of another language, chosen by the environment (``LANGUAGE``, ``LC_ALL``, ``LC_MESSAGES``, ``LANG``).
"""

from __future__ import annotations

import gettext
from collections.abc import Callable

from app.model.assets import folder

_DOMAIN = "cpm"

tr: Callable[[str], str] = gettext.translation(_DOMAIN, folder("languages"), fallback=True).gettext
"""The sentence in the language of the window, itself where there is no other."""
