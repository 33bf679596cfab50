"""The window that ``cpm`` opens, with images, preferences and journals in a folder of its own."""

from __future__ import annotations

import gc
import os
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from unittest import mock

import numpy as np
from cpm_app.views.application import make_application
from cpm_app.views.main_window import open_window
from cpm_app.views.window import dialogs
from cpm_app.views.window.window import MainWindow
from PIL import Image as Picture
from PySide6.QtCore import QCoreApplication, QEvent, QSettings
from PySide6.QtWidgets import QApplication

from cpm_core.warm_up import warm_up

from ..clock import now
from .watch import ANSWERS_WITHIN

SIDE = 96
IMAGES = ("discs.png", "ring.png", "stripes.png", "flat.png", "colors.png", "none.png")
"""Images in the folder: three to work on, one without contrast, one in color, and one that is none."""


def draw_images(folder: Path) -> None:
    """Draw the images."""
    row, col = np.indices((SIDE, SIDE))
    noise = np.random.default_rng(5).normal(0.0, 3.0, (SIDE, SIDE))
    far = np.hypot(row - SIDE / 2, col - SIDE / 2)
    discs = np.minimum(np.hypot(row - 30, col - 30), np.hypot(row - 62, col - 66)) < 17
    gray = {
        "discs.png": np.where(discs, 200.0, 40.0) + noise,
        "ring.png": np.where((far > 18) & (far < 34), 190.0, 60.0) + noise,
        "stripes.png": np.where(row // 12 % 2, 180.0, 50.0) + noise,
        "flat.png": np.full((SIDE, SIDE), 90.0),
    }
    for name, values in gray.items():
        Picture.fromarray(np.clip(values, 0, 255).astype(np.uint8)).save(folder / name)
    color = np.stack([gray["ring.png"], gray["discs.png"], gray["stripes.png"]], axis=-1)
    Picture.fromarray(np.clip(color, 0, 255).astype(np.uint8)).save(folder / "colors.png")
    (folder / "none.png").write_text("no image")


@contextmanager
def surroundings(folder: Path) -> Iterator[Path]:
    """Let the program find and keep all its files below a folder; give the folder of images."""
    os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")
    images = folder / "images"
    images.mkdir(exist_ok=True)
    draw_images(images)
    QSettings.setPath(QSettings.Format.IniFormat, QSettings.Scope.UserScope, str(folder / "settings"))
    make_application()
    warm_up()  # with the cache of compiled loops of this computer
    before = Path.cwd()
    with mock.patch.dict(os.environ, {"XDG_CACHE_HOME": str(folder / "cache"), "HOME": str(folder)}):
        os.chdir(folder)
        automatic = gc.isenabled()
        gc.disable()  # what is left of a closed window must not be destroyed on a thread of the next one
        try:
            yield images
        finally:
            os.chdir(before)
            if automatic:
                gc.enable()


def opened(path: Path) -> MainWindow:
    """A window that has opened an image, as ``cpm`` opens one."""
    window = open_window(str(path))
    window.session.set_pace(None)
    await_true(lambda: window.session.document.image is not None, "opening the first image")
    return window


def await_true(condition: Callable[[], bool], what: str, seconds: float = 6 * ANSWERS_WITHIN) -> None:
    """Let the window work until a condition holds."""
    began = now()
    while not condition():
        QApplication.processEvents()
        if now() - began > seconds:
            raise TimeoutError(f"{what} has not ended within {seconds:.0f} s.")
        time.sleep(0.001)


def settled(window: MainWindow) -> bool:
    """Whether nothing is going on in a window."""
    return window.session.idle and not window.session.opening_name


def ours(thread: threading.Thread) -> bool:
    """Whether a thread is one of a window; those among which a step is shared last as long as the process."""
    return thread.name.startswith("cpm-") and not thread.name.startswith("cpm-share")


@contextmanager
def discarding() -> Iterator[None]:
    """Let windows close without the question about unsaved work."""
    with mock.patch.object(dialogs, "ask_about_unsaved", lambda parent, name, lost: "discard"):
        yield


def destroyed(window: MainWindow) -> None:
    """Destroy a window that is closed, its session, and what is left of them."""
    window.session.deleteLater()
    window.deleteLater()
    QCoreApplication.sendPostedEvents(None, QEvent.Type.DeferredDelete)
    gc.collect()
