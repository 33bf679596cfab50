"""Long work and how it is given up."""

from __future__ import annotations

from collections.abc import Sequence

from app.model.text.language import tr
from app.views.theme.theme import Theme
from app.views.widgets.action_spec import ActionSpec
from app.views.window.feature import Feature, FeatureContext
from app.views.window.task_bar import TaskBar


class TasksFeature(Feature):
    """What goes on beside the run, in the status bar."""

    def __init__(self, context: FeatureContext) -> None:
        super().__init__(context)
        self.bar = TaskBar(context.session.tasks)
        context.window.statusBar().addPermanentWidget(self.bar)

    def action_specs(self) -> Sequence[ActionSpec]:
        """Give up."""
        tasks = self.context.session.tasks
        return (
            ActionSpec(name="cancel_task", menu="Run", text=tr("Cancel what is being &prepared"), do=self.bar.cancel,
                       shortcuts=("Ctrl+.",), tip=tr("Give up what the status bar says is being done."), gap=True,
                       when=lambda situation: any(task.cancellable for task in tasks.current)),
        )  # fmt: skip

    def use_theme(self, theme: Theme) -> None:
        """Tint the button."""
        self.bar.use_theme(theme)
