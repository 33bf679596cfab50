"""Skeletons of objects and of closed contours, in place of what is found in the image."""

from __future__ import annotations

from collections.abc import Sequence

from app.model.document.modes import use_skeleton
from app.model.state.situation import Situation
from app.model.text.language import tr
from app.views.widgets.action_spec import ActionSpec
from app.views.window.feature import Feature
from cpm_core.contours.contour import Contour
from cpm_core.medial_axis.outlines import Outlined


class SkeletonsFeature(Feature):
    """What has a skeleton: objects, closed contours, or the image."""

    def action_specs(self) -> Sequence[ActionSpec]:
        """One action each."""
        return (
            ActionSpec(name="object_skeleton", menu="Objects", text=tr("S&keleton of the objects"), do=self._of_objects,
                       tip=tr("Find the center lines of the chosen objects and how thick they are."),
                       icon="mode_skeleton", gap=True,
                       when=lambda situation: bool(self.context.workspace.object_list.chosen)),
            ActionSpec(name="contour_skeleton", menu="Contours", text=tr("S&keleton of closed contours"),
                       do=self._of_contours, icon="mode_skeleton", gap=True, when=lambda _: bool(self._closed()),
                       tip=tr("Find the center lines inside the selected closed contours, or inside all of them.")),
            ActionSpec(name="image_skeleton", menu="Run", text=tr("Skeleton of the &whole image"), do=self._of_image,
                       tip=tr("Find center lines in the image again, not only in objects or closed contours."),
                       when=_is_outlined),
        )  # fmt: skip

    def _of_objects(self) -> None:
        chosen = sorted(self.context.workspace.object_list.chosen)
        self._find(tr("skeleton of objects"), Outlined(objects=tuple(chosen)))

    def _of_contours(self) -> None:
        lines = tuple(tuple((float(row), float(col)) for row, col in contour.points) for contour in self._closed())
        self._find(tr("skeleton of contours"), Outlined(contours=lines))

    def _of_image(self) -> None:
        self._find(tr("skeleton of the image"), Outlined())

    def _find(self, name: str, outlined: Outlined) -> None:
        session = self.context.session
        session.edit(name, lambda document: use_skeleton(document, outlined))
        if session.status.phase != "running":
            session.run()

    def _closed(self) -> list[Contour]:
        """The closed ones of the selected contours, or of all that have not been rejected if none is selected."""
        review = self.context.workspace.review
        items = review.chosen or [item for item in review.items if not item.reviewed.rejected]
        return [item.contour for item in items if item.contour.closed]


def _is_outlined(situation: Situation) -> bool:
    return bool(situation.document.outlines or situation.document.outlined_surfaces)
