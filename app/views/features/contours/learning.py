"""The actions for learning which contours count."""

from __future__ import annotations

from collections.abc import Sequence

from app.model.state.situation import Situation
from app.model.text.language import tr
from app.views.widgets.action_spec import STATE, ActionSpec
from app.views.window.feature import Feature, FeatureContext


class LearningFeature(Feature):
    """Learning from kept and rejected contours."""

    def __init__(self, context: FeatureContext) -> None:
        super().__init__(context)
        self._learning = context.workspace.learning
        self._review = context.workspace.review
        self._review.changed.connect(context.refresh)

    def action_specs(self) -> Sequence[ActionSpec]:
        """Learn, and the next contour to judge."""
        return (
            ActionSpec(name="learn", menu="Contours", text=tr("L&earn from kept and rejected contours"),
                       do=self._learning.switch, shortcuts=("Shift+L",),
                       tip=tr("Leave out contours that resemble rejected ones more than kept ones. Contours with a "
                              "verdict, a name or a color stay as they are."),
                       group=STATE, checked=True, gap=True, when=self._can_learn,
                       holds=lambda situation: situation.document.learning),
            ActionSpec(name="doubtful_contour", menu="Contours", text=tr("Select most dou&btful contour"),
                       do=self._learning.select_most_doubtful, shortcuts=("Shift+D",),
                       tip=tr("Select the contour whose verdict teaches most: long, and neither like kept nor like "
                              "rejected ones."),
                       when=lambda situation: bool(self._review.items)),
        )  # fmt: skip

    def close(self) -> bool:
        """Stop the thread of measurements."""
        self._learning.close()
        return True

    def _can_learn(self, situation: Situation) -> bool:
        document = situation.document
        return document.learning or any(mark.verdict for mark in document.marks)
