"""Tasks in the background and their cancellation."""

from __future__ import annotations

from collections.abc import Sequence

from app.model.text.language import tr
from app.views.theme.theme import Theme
from app.views.widgets.action_spec import ActionSpec
from app.views.window.feature import Feature, FeatureContext
from app.views.window.task_bar import TaskBar


class TasksFeature(Feature):
    """Tasks in the status bar."""

    def __init__(self, context: FeatureContext) -> None:
        super().__init__(context)
        self.bar = TaskBar(context.session.tasks)
        context.window.statusBar().addPermanentWidget(self.bar)

    def action_specs(self) -> Sequence[ActionSpec]:
        """Cancel."""
        tasks = self.context.session.tasks
        return (
            ActionSpec(name="cancel_task", menu="Run", text=tr("Cancel background &task"), do=self.bar.cancel,
                       shortcuts=("Ctrl+.",), tip=tr("Cancel the task shown in the status bar."), gap=True,
                       when=lambda situation: any(task.cancellable for task in tasks.current)),
        )  # fmt: skip

    def use_theme(self, theme: Theme) -> None:
        """Color the button."""
        self.bar.use_theme(theme)
