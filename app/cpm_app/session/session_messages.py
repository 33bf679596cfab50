"""Messages of a session to the user, and their categories, which decide when a message is cleared."""

from __future__ import annotations

from PySide6.QtCore import QObject, Signal

from cpm_app.model.text.language import elide_middle

OPENING_CATEGORY = "opening"
"""Category of messages about opening an image or a session."""

RUNNING_CATEGORY = "running"
"""Category of messages about the run."""

EDITING_CATEGORY = "editing"
"""Category of messages about edits of the document."""

SAVING_CATEGORY = "saving"
"""Category of messages about saving the session."""

EXPORTING_CATEGORY = "exporting"
"""Category of messages about exported files."""

FILMING_CATEGORY = "filming"
"""Category of messages about animations."""

CONTOURS_CATEGORY = "contours"
"""Category of messages about the reconstruction of contours."""

RECOVERY_CATEGORY = "recovery"
"""Category of messages about work restored after a crash."""

JOURNAL_CATEGORY = "journal"
"""Category of messages about the journal of unsaved work."""

UNEXPECTED_CATEGORY = "unexpected"
"""Category of messages about unexpected errors."""

PROJECT_CATEGORY = "project"
"""Category of messages about the states of the images of a folder."""

BATCH_CATEGORY = "batch"
"""Category of messages about the images of a folder."""

LASTING_CATEGORIES = frozenset({BATCH_CATEGORY, EDITING_CATEGORY, RUNNING_CATEGORY})
"""Categories whose news stays until the next edit, run or attempt, as it says what became of the last one."""

PROGRAM_CATEGORIES = (RECOVERY_CATEGORY, JOURNAL_CATEGORY, UNEXPECTED_CATEGORY, PROJECT_CATEGORY, BATCH_CATEGORY)
"""Categories of messages that do not concern the open image, and stay when another one is opened."""


class SessionMessages(QObject):
    """Announces messages for the user; `cpm_app.model.state.messages.Messages` decides which of them is shown."""

    shown = Signal(str, bool, str)
    """A message for the user, whether it is an error, and its category, or ""."""
    cleared = Signal(str)
    """Messages of this category no longer apply, because what they were about is attempted again."""

    def __init__(self, parent: QObject) -> None:
        super().__init__(parent)
        self._errors: dict[str, str] = {}

    def show(self, message: str, is_error: bool = False, category: str = "") -> None:
        """Show one sentence to the user; its category, such as `EXPORTING_CATEGORY`, decides when it is cleared."""
        self.shown.emit(elide_middle(message), is_error, category)

    def set_error(self, message: str, category: str) -> None:
        """Show the error of work that is repeated; an empty one clears it, because the work has succeeded.

        The same error is shown only once, so that the user can dismiss it.
        """
        before = self._errors.pop(category, "")
        if message:
            self._errors[category] = message
            if message != before:
                self.show(message, True, category)
        elif before:
            self.clear(category)

    def clear(self, *categories: str) -> None:
        """Clear the messages of some categories, because what they were about is attempted again."""
        for category in categories:
            self.cleared.emit(category)
