"""The dialogs that ask for a file."""

from __future__ import annotations

from pathlib import Path

from PySide6.QtWidgets import QFileDialog, QWidget

from cpm_core.formats import READABLE, WRITABLE


def ask_for_image(parent: QWidget, folder: str) -> str:
    """Path of an image to open, empty when the user has thought better of it."""
    patterns = " ".join(f"*{suffix}" for suffix in READABLE)
    chosen, _ = QFileDialog.getOpenFileName(parent, "Open image", folder, f"Images ({patterns});;All files (*)")
    return chosen


def ask_for_export(parent: QWidget, suggestion: str) -> str:
    """Path to export contours to, empty when the user has thought better of it; a suffix left out is added."""
    filters = {f"{text} (*{suffix})": suffix for suffix, text in WRITABLE.items()}
    chosen, used = QFileDialog.getSaveFileName(parent, "Export contours", suggestion, ";;".join(filters))
    if chosen and not Path(chosen).suffix:
        chosen += filters.get(used, next(iter(WRITABLE)))
    return chosen
