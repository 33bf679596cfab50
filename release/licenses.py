"""Gathers the licenses of the program and of all that is handed out with it into one text.

``python release/licenses.py FILE`` writes it for what is installed beside this Python. It takes the license files of
each distribution, and where one has none the license that it names.
"""

from __future__ import annotations

import re
import sys
from importlib import metadata
from pathlib import Path

from packaging.requirements import Requirement

ROOT = Path(__file__).resolve().parents[1]

EXTRAS = ("gui",)
"""Extras that the application holds."""

_LICENSE = re.compile(r"licen[cs]e|copying|notice|authors", re.IGNORECASE)

_RULE = "\n\n" + "=" * 100 + "\n\n"

_OF_PYTHON = (
    "Python itself is under the license of the Python Software Foundation: https://docs.python.org/3/license.html"
)


def distributions(name: str = "cpm-particles", extras: tuple[str, ...] = EXTRAS) -> dict[str, metadata.Distribution]:
    """Collect a distribution and all that it needs at run time, by name."""
    found: dict[str, metadata.Distribution] = {}
    waiting = [(name, extras)]
    while waiting:
        wanted, chosen = waiting.pop()
        key = re.sub(r"[-_.]+", "-", wanted).lower()
        if key in found:
            continue
        try:
            found[key] = metadata.distribution(wanted)
        except metadata.PackageNotFoundError:
            continue
        for line in found[key].requires or ():
            needed = Requirement(line)
            if needed.marker is None or any(needed.marker.evaluate({"extra": extra}) for extra in (*chosen, "")):
                waiting.append((needed.name, tuple(needed.extras)))
    return dict(sorted(found.items()))


def license_of(distribution: metadata.Distribution) -> str:
    """Return the texts of its licenses, or the name of its license."""
    files = [file for file in distribution.files or () if _LICENSE.search(file.name) and ".dist-info" in str(file)]
    texts = [Path(str(file.locate())).read_text(encoding="utf-8", errors="replace") for file in files]
    if texts:
        return "\n\n".join(text.strip() for text in texts)
    told = distribution.metadata
    classified = [
        line.rpartition(" :: ")[2] for line in told.get_all("Classifier", []) if line.startswith("License ::")
    ]
    return told.get("License-Expression") or "; ".join(classified) or told.get("License") or "not told"


def gathered() -> str:
    """Join the licenses of all, each under the name and version of its distribution."""
    own = f"CPM\n\n{(ROOT / 'LICENSE').read_text(encoding='utf-8').strip()}"
    others = (
        f"{name} {found.version}\n\n{license_of(found)}"
        for name, found in distributions().items()
        if name != "cpm-particles"
    )
    return _RULE.join((own, _OF_PYTHON, *others)) + "\n"


if __name__ == "__main__":
    Path(sys.argv[1]).write_text(gathered(), encoding="utf-8")
