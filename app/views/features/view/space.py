"""The view in space of a volume: its panel, and its pictures for files."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from pathlib import Path

from app.model.display.space.view_in_space import ViewInSpace
from app.model.export.provenance import comment_on
from app.model.state.situation import has_volume
from app.model.text.language import tr
from app.session.exchange.messages import Exported, Report
from app.session.tasks.tasks import Task
from app.views.volume.seen_in_space import SeenInSpace
from app.views.volume.space_actions import specs
from app.views.volume.space_hand import SpaceHand
from app.views.volume.space_panel import SpacePanel
from app.views.volume.turntable import FRAMES, FRAMES_PER_SECOND, animation_size, picture_of, turn
from app.views.widgets.action_spec import ActionSpec
from app.views.window.feature import Feature, FeatureContext, Panel
from app.views.window.file_dialogs import Files
from cpm_core.formats.animations.animation import ANIMATED, write_animation
from cpm_core.formats.animations.snapshot_strip import write_picture
from cpm_core.numerics.types import Place

_NAME = "space"


class SpaceFeature(Feature):
    """Shows volume, particles and surface in space, and writes what is seen as a picture or a full turn."""

    def __init__(self, context: FeatureContext) -> None:
        super().__init__(context)
        self.panel = SpacePanel(context.session)
        self._seen = SeenInSpace()
        self._layers = layers = context.canvas_area.canvas.layers
        context.session.scene_changed.connect(self._show)
        context.session.image_changed.connect(lambda: context.turns.ask(self._reveal))
        self._hand = SpaceHand(context.session, self.panel.view)
        self.panel.view.picked.connect(self._pick)
        self.panel.bar.changed.connect(context.refresh)
        context.canvas_area.level_drag.watch(self.panel.view)
        for layer in (layers.particles, layers.image, layers.drawing, layers["objects"], layers["truth"]):
            layer.changed.connect(self._show)

    def panels(self) -> Sequence[Panel]:
        """The view."""
        return (
            Panel(name=_NAME, title=tr("In space"), widget=self.panel, shown=False, share=1.5, shortcut="Shift+F9"),
        )

    def action_specs(self) -> Sequence[ActionSpec]:
        """What the menu of the view offers, and both exports."""
        return (
            *specs(self.panel, self.context.session),
            ActionSpec(name="export_space", menu="File", text=tr("Export picture in s&pace…"), do=self.ask_for_picture,
                       tip=tr("Export what the view in space shows as a picture."), when=has_volume),
            ActionSpec(name="export_turntable", menu="File", text=tr("Export &turntable…"), do=self.ask_for_turntable,
                       tip=tr("Export a full turn of the view in space as GIF, APNG or MP4."), when=has_volume),
        )  # fmt: skip

    def close(self) -> bool:
        """End the thread that draws."""
        self.panel.view.close_thread()
        return True

    def ask_for_picture(self) -> None:
        """Ask where to save what is seen, and write it."""
        path = self._ask(tr("Export picture in space"), "space.png", [Files(tr("PNG image"), (".png",))])
        if path is not None:
            self.write_picture(path)

    def write_picture(self, path: Path) -> Task | None:
        """Write what is seen."""
        view, camera = self._view, self.panel.view.camera
        if view is None or camera is None:
            return None
        draw = partial(picture_of, view, camera, self.panel.view.room, self.panel.view.look, self.panel.view.marks)
        comment = self._comment

        def work(task: Task) -> Report:
            write_picture(draw(), path, comment)
            return Exported(path)

        name = tr("Writing {name}…").format(name=path.name)
        return self.context.session.tasks.start(
            name, work, tr("writing {name}").format(name=path.name), cancellable=False
        )

    def ask_for_turntable(self) -> None:
        """Ask where to save a full turn, and write it."""
        kinds = [Files(text, (suffix,)) for suffix, text in ANIMATED.items()]
        path = self._ask(tr("Export turntable"), "turntable.gif", kinds)
        if path is not None:
            self.write_turntable(path)

    def write_turntable(self, path: Path) -> Task | None:
        """Write a full turn of what is seen."""
        shown, view, camera = self.panel.view, self._view, self.panel.view.camera
        if view is None or camera is None:
            return None
        size = animation_size(shown.room)
        frames = partial(turn, view, camera.enlarged(size[0] / shown.room[0]), size, shown.look, shown.marks)
        comment = self._comment

        def work(task: Task) -> Report | None:
            def advance(count: int) -> None:
                task.advance(count / FRAMES)

            written = write_animation(frames(), path, FRAMES_PER_SECOND, advance, lambda: task.cancelled, comment)
            return Exported(path) if written else None

        return self.context.session.tasks.start(
            tr("Writing {name}…").format(name=path.name), work, tr("writing {name}").format(name=path.name)
        )

    # Internal

    @property
    def _view(self) -> ViewInSpace | None:
        return None if self.panel.contents is None else self.panel.contents.view(self.panel.bar.shown)

    @property
    def _comment(self) -> str:
        """How the pictures came about, for their file."""
        return comment_on(self.context.session.document, steered=self.context.session.status.steered)

    def _ask(self, title: str, ending: str, kinds: Sequence[Files]) -> Path | None:
        image = self.context.session.document.image
        stem = Path(image.name).stem if image is not None else "cpm"
        return self.context.files.ask_where_to_save("export", title, f"{stem}_{ending}", kinds)

    def _pick(self, place: Place) -> None:
        """Move the slices there, and draw there what the tool in use draws without a slice."""
        self.context.workspace.slices.through(place)
        tool = self.context.canvas_area.canvas.tool
        if tool is not None and tool.name == "objects":
            self._hand.select(self.context.workspace.object_selection, place)
        elif tool is not None:
            self._hand.put(tool.name, place)

    def _reveal(self) -> None:
        """A volume is seen in space from the start; an image has no space."""
        if self.context.session.scene.slices is not None:
            self.context.reveal(_NAME)
        else:
            self.context.conceal(_NAME)

    def _show(self, *_: object) -> None:
        self.panel.show_contents(self._seen.of(self.context.session.scene, self._layers))
