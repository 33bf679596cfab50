"""A window in which something is measured."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from cpm_app.session.features.workspace import Workspace
from cpm_app.views.application import make_application
from cpm_app.views.main_window import make_window
from cpm_app.views.window.window import MainWindow

from tests.app.reading import treat_as_saved


@contextmanager
def shown_window(width: int, height: int) -> Iterator[MainWindow]:
    """A new window of some size [px], which is closed at the end without a question whether to save."""
    make_application()
    window = make_window(Workspace())
    window.resize(width, height)
    window.show()
    window.session.warm_up()
    yield window
    treat_as_saved(window)
    window.close()
