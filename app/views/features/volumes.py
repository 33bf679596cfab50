"""Volumes and stacks: slices, pages, and the view in space."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from pathlib import Path

from PySide6.QtCore import QPoint
from PySide6.QtWidgets import QDockWidget

from app.model.display.space.view_in_space import ViewInSpace
from app.model.export import provenance_comment
from app.model.preferences.table import UNIT
from app.model.state.situation import Condition, Situation, has_volume
from app.model.text.language import tr
from app.model.volume.slices import AXES, Slices
from app.session.exchange.messages import Exported, Report
from app.session.features.background import AsyncCache
from app.session.features.stack_pages import WantedContour
from app.session.scene import Scene
from app.session.tasks.tasks import Task
from app.views.canvas.image_view import ImageView
from app.views.canvas.side_view import Cross, SideView
from app.views.canvas.slice_bar import SliceBar
from app.views.panels.pages import PageBar, PagePanel
from app.views.volume.seen_in_space import SeenInSpace
from app.views.volume.space_clicks import draw_at, select_at
from app.views.volume.space_marks import FRAMES, FRAMES_PER_SECOND, animation_size, picture_of, turn
from app.views.volume.space_panel import SpacePanel, specs
from app.views.widgets.actions import ActionSpec
from app.views.window.dialogs import Files
from app.views.window.feature import Feature, FeatureContext, Panel
from cpm_core import Image, write_animation
from cpm_core.formats import ANIMATED, FOR_STACKS, stack_suffix_of, write_picture
from cpm_core.numerics import Place

_MENU = "View>" + tr("Sli&ces and pages")
_JUMP = 10

_SIDES = "volumes/three_slices"
"""Preference: whether the slices across the other axes are shown."""


class SlicesFeature(Feature):
    """The line below the canvas, keys and wheel that go through a volume."""

    def __init__(self, context: FeatureContext) -> None:
        super().__init__(context)
        self.bar = SliceBar()
        self._shown: tuple[Slices | None, Image | None] = (None, None)
        self._slices = slices = context.workspace.slices
        self._pages = context.workspace.pages
        self.bar.moved.connect(slices.at)
        self.bar.turned.connect(slices.turn)
        self.bar.size_wanted.connect(lambda: context.do("pixel_size"))
        context.canvas_area.controls.addWidget(self.bar)
        self.sides: tuple[SideView, ...] = ()
        """Views of the slices across the other axes, made when they are first shown."""
        self._wanted = bool(context.preferences.get(_SIDES, True))
        self._cross = Cross(context.canvas_area.canvas)
        self._later: list[AsyncCache] = []
        self._draw_later(context.canvas_area.canvas)
        context.canvas_area.canvas.slice_wanted.connect(slices.go)
        context.session.scene_changed.connect(self._show)
        context.preferences.follow(UNIT, self._show_size)

    def action_specs(self) -> Sequence[ActionSpec]:
        """Next and previous slice, and the axis."""
        moves = (
            (
                "previous_slice",
                tr("&Previous slice or page"),
                "PgUp",
                -1,
                tr("Show the slice or page before this one."),
            ),
            ("next_slice", tr("&Next slice or page"), "PgDown", 1, tr("Show the slice or page after this one.")),
            ("slices_back", tr("Ten &back"), "Shift+PgUp", -_JUMP, tr("Show the slice or page ten before this one.")),
            ("slices_on", tr("Ten &on"), "Shift+PgDown", _JUMP, tr("Show the slice or page ten after this one.")),
        )
        through = [
            ActionSpec(name, _MENU, text, tip, partial(self._go, by), key,
                       when=lambda situation: has_volume(situation) or self._pages.count > 1)
            for name, text, key, by, tip in moves
        ]  # fmt: skip
        axes = [
            ActionSpec(f"slices_across_{axis}", _MENU, tr("Across the &{axis}").format(axis=name),
                       tr("Show slices across this axis: {axis}.").format(axis=name), partial(self._turn, axis),
                       f"Ctrl+Shift+{axis + 1}", gap=axis == 0, when=has_volume, holds=self._is_across(axis))
            for axis, name in enumerate(AXES)
        ]  # fmt: skip
        sides = ActionSpec("three_slices", _MENU, tr("&Three slices side by side"),
                           tr("Show the slices across the other axes beside the canvas, linked by a cross."),
                           self._toggle, "Shift+Q", gap=True, when=has_volume,
                           holds=lambda _: self._wanted)  # fmt: skip
        return (*through, *axes, sides)

    def close(self) -> bool:
        """End the threads that make parts of slices."""
        for later in self._later:
            later.close()
        return True

    def _draw_later(self, view: ImageView) -> None:
        """Draw what takes long of the slices of a view when it has been made on another thread."""
        view.sections.later = later = AsyncCache(self.context.session)
        later.completed.connect(view.draw_again)
        self._later.append(later)

    def use_keys(self) -> None:
        """Name the keys as they are now."""
        self.bar.show_keys()

    def _open_menu(self, point: QPoint) -> None:
        """Open the menu of what lies at a point of the screen; where nothing lies, the cross alone has moved."""
        area = self.context.canvas_area
        thing, _ = area.menu_at(area.mapFromGlobal(point))
        if thing != "image":
            area.canvas.pointer.menu_wanted.emit(point)

    def _go(self, by: int) -> None:
        """Go to another slice of a volume, or to another page of a stack."""
        (self._pages if self._pages.count else self._slices).go(by)

    def _toggle(self) -> None:
        self._wanted = not self._wanted
        self.context.preferences.put(_SIDES, self._wanted)
        self._show()
        self.context.refresh()

    def _turn(self, axis: int) -> None:
        self._slices.turn(axis)
        self.context.refresh()

    def _is_across(self, axis: int) -> Condition:
        return lambda _: self._slices.now is not None and self._slices.now.axis == axis

    def _show(self) -> None:
        scene = self.context.session.scene
        self._show_sides(scene)
        if (scene.slices, scene.whole) != self._shown:
            self._shown = scene.slices, scene.whole
            self.bar.show_slices(scene.slices, scene.whole)
            self.context.canvas_area.canvas.point_again()

    def _show_sides(self, scene: Scene) -> None:
        """Draw the other two slices, and where all three meet."""
        shown = scene.slices is not None and self._wanted
        self._cross.show(scene.slices if shown else None)
        if len(self.sides) < 2:
            if shown:
                self.context.turns.ask(self._make_side)
            return
        if self.sides[0].isVisibleTo(self.context.canvas_area) != shown:
            self.context.canvas_area.views.setColumnStretch(1, 1 if shown else 0)
            for view in self.sides:
                view.setVisible(shown)
        if shown and scene.slices is not None:
            others = [axis for axis in range(3) if axis != scene.slices.axis]
            for view, axis in zip(self.sides, others, strict=True):
                view.show_slice(scene, axis)

    def _make_side(self) -> None:
        """Make the view of a further slice, the next one below the first; both are shown at once."""
        area, row = self.context.canvas_area, len(self.sides)
        view = SideView(area.canvas, area)
        view.hide()
        area.level_drag.watch(view.viewport())
        area.views.setColumnStretch(0, 2)
        area.views.addWidget(view, row, 1)
        self._draw_later(view)
        view.pointer.menu_wanted.connect(self._open_menu)
        view.went.connect(self._slices.through)
        view.passed.connect(self._slices.pass_on)
        self.sides += (view,)
        self.context.turns.ask(self._show)

    def _show_size(self) -> None:
        """Show the size of a voxel in another unit."""
        self._shown = (None, None)
        self._show()


_PAGES_MENU = "Run>" + tr("Pages of a &stack")


class PagesFeature(Feature):
    """The line that chooses a page, the actions for all pages, and their table."""

    def __init__(self, context: FeatureContext) -> None:
        super().__init__(context)
        self._pages = pages = context.workspace.pages
        self.bar = PageBar()
        self.panel = PagePanel(pages, WantedContour(pages, context.workspace.review).show)
        self.bar.moved.connect(pages.open)
        self.bar.asked.connect(self._run_or_stop)
        self.bar.followed.connect(self._follow)
        self.panel.export.clicked.connect(self.export)
        context.canvas_area.controls.addWidget(self.bar)
        pages.set_session_file(context.document_file)
        pages.changed.connect(self._show)
        pages.found.connect(context.refresh)
        context.session.document_changed.connect(lambda _: self._show_bar())
        context.preferences.follow(UNIT, self.panel.show_rows)

    def action_specs(self) -> Sequence[ActionSpec]:
        """Run all pages, or those from this one on; follow; export."""
        pages = self._pages
        return (
            ActionSpec("run_pages", _PAGES_MENU, tr("&Run all pages"),
                       tr("Run every page of the stack, one after the other, in the background."), pages.run,
                       "Ctrl+Shift+Return", when=self._can_run),
            ActionSpec("run_pages_on", _PAGES_MENU, tr("Run from this page &on"),
                       tr("Run this page and all after it, one after the other, in the background."),
                       lambda: pages.run(pages.number), when=self._can_run),
            ActionSpec("follow_pages", _PAGES_MENU, tr("&Follow from page to page"),
                       tr("Start each page from the contours of the one before."),
                       lambda: self._follow(not pages.following), gap=True, when=lambda _: pages.count > 1,
                       holds=lambda _: pages.following),
            ActionSpec("export_pages", "File", tr("Export all pa&ges…"),
                       tr("Write the contours, labels or measures of all pages that are done."), self.export,
                       when=lambda _: pages.result is not None and bool(pages.result.results)),
        )  # fmt: skip

    def panels(self) -> Sequence[Panel]:
        """The table of all pages."""
        return (
            Panel(name="pages", title=tr("Pages"), widget=self.panel, area="bottom", tab="below", shown=False,
                  height=160, shortcut="Shift+F11"),
        )  # fmt: skip

    def use_keys(self) -> None:
        """Name the keys as they are now."""
        self.bar.show_keys()

    def export(self) -> None:
        """Ask where to write what was found on all pages, and write it."""
        found = self._pages.result
        if found is None:
            return
        kinds = [
            Files(text[:1].upper() + text[1:], (suffix,)) for suffix, text in FOR_STACKS.items() if suffix != ".tiff"
        ]
        name = f"{Path(found.source).stem}_pages.measures.csv"
        path = self.context.files.ask_where_to_save("export", tr("Export all pages"), name, kinds)
        if path is not None and stack_suffix_of(path):
            self._pages.export(path)

    # Internal

    def _can_run(self, situation: Situation) -> bool:
        pages = self._pages
        return pages.count > 1 and not pages.running and situation.document.mode != "skeleton"

    def _run_or_stop(self) -> None:
        if self._pages.running:
            self._pages.cancel()
        else:
            self._pages.run()

    def _follow(self, following: bool) -> None:
        self._pages.following = following
        self._show()

    def _show(self) -> None:
        self._show_bar()
        self.context.refresh()

    def _show_bar(self) -> None:
        pages, session = self._pages, self.context.session
        possible = session.document.mode != "skeleton" and bool(session.document.starts)
        self.bar.show_pages(
            pages.number, pages.count, following=pages.following, running=pages.running, possible=possible
        )


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
        self.panel.view.picked.connect(self._pick)
        self.panel.bar.changed.connect(context.refresh)
        context.canvas_area.level_drag.watch(self.panel.view)
        for layer in (layers.particles, layers.image, layers.drawing, layers["objects"], layers["truth"]):
            layer.changed.connect(self._show)

    def panels(self) -> Sequence[Panel]:
        """The view."""
        return (Panel(name=_NAME, title=tr("In space"), widget=self.panel, shown=False, shortcut="Shift+F9"),)

    def action_specs(self) -> Sequence[ActionSpec]:
        """What the menu of the view offers, and both exports."""
        return (
            *specs(self.panel, self.context.session),
            ActionSpec("export_space", "File", tr("Export picture in s&pace…"),
                       tr("Export what the view in space shows as a picture."), self.ask_for_picture, when=has_volume),
            ActionSpec("export_turntable", "File", tr("Export &turntable…"),
                       tr("Export a full turn of the view in space as GIF, APNG or MP4."), self.ask_for_turntable,
                       when=has_volume),
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
        return self.panel.contents

    @property
    def _comment(self) -> str:
        """How the pictures came about, for their file."""
        return provenance_comment(self.context.session.document, steered=self.context.session.status.steered)

    def _ask(self, title: str, ending: str, kinds: Sequence[Files]) -> Path | None:
        image = self.context.session.document.image
        stem = Path(image.name).stem if image is not None else "cpm"
        return self.context.files.ask_where_to_save("export", title, f"{stem}_{ending}", kinds)

    def _pick(self, place: Place) -> None:
        """Move the slices there, and draw there what the tool in use draws without a slice."""
        self.context.workspace.slices.through(place)
        tool = self.context.canvas_area.canvas.hold.tool
        camera, image = self.panel.view.camera, self.context.session.image
        if tool is not None and tool.name == "objects" and camera is not None and image is not None:
            select_at(self.context.workspace.object_selection, camera, image.spacing, place)
        elif tool is not None:
            draw_at(self.context.session, tool.name, place)

    def _reveal(self) -> None:
        """A volume is seen in space from the start; an image has no space."""
        if self.context.session.scene.slices is not None:
            self.context.reveal(_NAME)
        elif isinstance(dock := self.panel.parentWidget(), QDockWidget):
            dock.hide()

    def _show(self, *_: object) -> None:
        self.panel.show_contents(self._seen.of(self.context.session.scene, self._layers))
