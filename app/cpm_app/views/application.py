"""Desktop application: sets Qt up, opens the window and runs until it is closed."""

from __future__ import annotations

import signal
import sys

import pyqtgraph as pg
from PySide6.QtCore import QLibraryInfo, QLocale, QTimer, QTranslator
from PySide6.QtGui import QIcon, QPixmapCache
from PySide6.QtWidgets import QApplication

from cpm_app.model.text.assets import find_asset
from cpm_app.model.text.language import current_language, use_number_marks
from cpm_app.views.features.help import HelpFeature
from cpm_app.views.main_window import open_window
from cpm_app.views.window.python_hooks import UnexpectedErrors

SWITCH_INTERVAL = 0.0002
"""Longest time that the window waits for the interpreter while the worker computes [s]."""

PIXMAP_CACHE_SIZE = 256 * 1024
"""Size of the cache for rendered layers [KB]; if it is too small, every frame paints each layer again."""


def make_application() -> QApplication:
    """Return the QApplication, set up in the style and the language of the window."""
    application = QApplication.instance() or QApplication(sys.argv[:1])
    assert isinstance(application, QApplication)
    application.setApplicationName("cpm")
    application.setApplicationDisplayName("CPM")
    application.setDesktopFileName("cpm")
    application.setStyle("Fusion")
    application.setWindowIcon(QIcon(str(find_asset("icons/cpm.svg"))))
    locale = locale_of(current_language(), QLocale.system())
    QLocale.setDefault(locale)
    use_number_marks(locale.decimalPoint(), locale.groupSeparator())
    # Qt's own dialogs, for files and colors, use the language of the window if Qt has it
    translator = QTranslator(application)
    if translator.load(
        QLocale(current_language()), "qtbase", "_", QLibraryInfo.path(QLibraryInfo.LibraryPath.TranslationsPath)
    ):
        application.installTranslator(translator)
    pg.setConfigOptions(imageAxisOrder="row-major", antialias=False)
    QPixmapCache.setCacheLimit(PIXMAP_CACHE_SIZE)
    sys.setswitchinterval(SWITCH_INTERVAL)
    return application


def locale_of(name: str, desktop: QLocale) -> QLocale:
    """Return the locale of a language: that of the desktop if it has the same language."""
    own = QLocale(name)
    return desktop if desktop.language() == own.language() else own


def run_application(path: str | None) -> int:
    """Run the desktop program and return its exit status."""
    application = make_application()
    window = open_window(path)
    unexpected = UnexpectedErrors(window.session)
    window.get_feature(HelpFeature).offer_guide()
    # Ctrl+C in the terminal closes the window; Python handles signals only while it runs, hence the timer.
    signal.signal(signal.SIGINT, lambda *_: window.close())
    wake = QTimer()
    wake.timeout.connect(lambda: None)
    wake.start(200)
    status = application.exec()
    window.close()
    unexpected.restore_hooks()
    return status
