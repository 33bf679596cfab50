"""Long work and how it is given up."""

from __future__ import annotations

from collections.abc import Sequence

from app.model.text.language import tr
from app.views.theme.theme import Theme
from app.views.widgets.entry import Entry
from app.views.window.part import Desk, Part
from app.views.window.task_bar import TaskBar


class TasksPart(Part):
    """What goes on beside the run, in the status bar."""

    def __init__(self, desk: Desk) -> None:
        super().__init__(desk)
        self.bar = TaskBar(desk.session.tasks)
        desk.window.statusBar().addPermanentWidget(self.bar)
        desk.session.tasks.changed.connect(desk.session.status_changed)

    def entries(self) -> Sequence[Entry]:
        """Give up."""
        tasks = self.desk.session.tasks
        return (
            Entry(
                name="cancel_task",
                menu="Run",
                text=tr("Cancel what is being &prepared"),
                do=self.bar.cancel,
                shortcuts=("Ctrl+.",),
                tip=tr("Give up what the status bar says is being done."),
                gap=True,
                when=lambda situation: any(task.cancellable for task in tasks.current),
            ),
        )

    def use_theme(self, theme: Theme) -> None:
        """Tint the button."""
        self.bar.use_theme(theme)
