"""Checks whether a window can be opened; Qt itself ends the process without a useful message."""

from __future__ import annotations

import ctypes
import os
import sys
from pathlib import Path

_README = "the README names the few system libraries that Qt needs"


def why_no_window() -> str:
    """One sentence on why no window can be opened here, or empty."""
    chosen = os.environ.get("QT_QPA_PLATFORM", "")
    if not sys.platform.startswith("linux") or chosen.partition(":")[0] not in ("", "xcb"):
        return ""
    if not chosen and os.environ.get("WAYLAND_DISPLAY"):
        return ""
    if not os.environ.get("DISPLAY"):
        return "There is no display to open a window on; use “cpm run IMAGE …” to work without one."
    # The plugin of Qt is loaded here, because only the loader reports which library is missing.
    from PySide6.QtCore import QLibraryInfo

    plugins = Path(QLibraryInfo.path(QLibraryInfo.LibraryPath.PluginsPath))
    try:
        ctypes.CDLL(str(plugins / "platforms" / "libqxcb.so"))
    except OSError as error:
        library = str(error).partition(":")[0]
        return f"Qt cannot open a window because {library} is missing; {_README}."
    return ""
