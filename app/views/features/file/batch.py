"""The session applied to a folder of images."""

from __future__ import annotations

from collections.abc import Sequence

from app.model.state.situation import has_image
from app.model.text.language import tr
from app.session.features.image_batch import TOPIC, BatchDone
from app.views.export.batch.dialog import BatchDialog
from app.views.widgets.action_spec import ActionSpec
from app.views.window.dialog_feature import DialogFeature
from app.views.window.feature import FeatureContext


class BatchFeature(DialogFeature[BatchDialog]):
    """Opens the dialog, and says when all images are done."""

    def __init__(self, context: FeatureContext) -> None:
        super().__init__(context)
        context.session.listen(BatchDone, self._tell)

    def action_specs(self) -> Sequence[ActionSpec]:
        """Open it."""
        return (
            ActionSpec(name="apply_to_folder", menu="File", text=tr("Apply this session to a &folder…"), do=self.open,
                       shortcuts=("Ctrl+Alt+E",), when=has_image,
                       tip=tr("Run every image of a folder with what is drawn and set here.")),
        )  # fmt: skip

    def made(self) -> BatchDialog:
        """The dialog, on the folder of the image."""
        context = self.context
        return BatchDialog(context.window, context.session, context.workspace.batch, context.files.begin("open"))

    def _tell(self, _: BatchDone) -> None:
        batch = self.context.workspace.batch
        self.context.session.say(batch.in_words, batch.failed > 0, TOPIC)
