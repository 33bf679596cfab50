"""Makes the pictures of the window that README.md shows, from the real window on the first sample.

    python assets/screenshots/make_screenshots.py

Needs a display, be it a virtual one, with room for a window of 1280 by 760.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from PySide6.QtCore import QDeadlineTimer, QEventLoop

from app.views import theme
from app.views.application import make_application, open_window

HERE = Path(__file__).parent
PATIENCE = 60_000
"""Longest wait for anything [ms]."""

MIDWAY = 17
"""Step of the picture taken while the particles move."""


def wait(condition: Callable[[], bool]) -> None:
    """Let the window live until a condition holds."""
    application, deadline = make_application(), QDeadlineTimer(PATIENCE)
    while not condition():
        if deadline.hasExpired():
            raise TimeoutError("the window did not get there in a minute")
        application.processEvents(QEventLoop.ProcessEventsFlag.WaitForMoreEvents, 20)


def main() -> None:
    """Run the sample and take its pictures."""
    make_application()
    window = open_window()
    window.resize(1280, 760)
    theme.apply_theme(theme.LIGHT)
    session = window.session
    wait(lambda: session.idle and not session.status.busy)
    session.set_pace(60.0)
    session.run()
    wait(lambda: session.status.step >= MIDWAY)
    session.pause()
    wait(lambda: session.idle)
    window.grab().save(str(HERE / "window.png"))
    session.set_pace(None)
    session.run()
    wait(lambda: session.status.phase == "finished" and session.idle)
    window.grab().save(str(HERE / "rest.png"))
    window.close()


if __name__ == "__main__":
    main()
