"""Volumes and stacks: slices, pages, and the view in space."""

from __future__ import annotations

from functools import partial
from pathlib import Path

from PySide6.QtCore import QPoint
from PySide6.QtWidgets import QWidget

from cpm_app.model.preferences.table import UNIT_PREFERENCE, WHEEL_PREFERENCE
from cpm_app.model.state.situation import Situation, has_volume
from cpm_app.model.text.language import tr
from cpm_app.model.volume.slices import AXIS_NAMES, Slices
from cpm_app.session.exchange.messages import FilesExported, Report
from cpm_app.session.features.background import AsyncCache
from cpm_app.session.scene import Scene
from cpm_app.session.tasks.tasks import BackgroundTask
from cpm_app.views.canvas.canvas import ToolView
from cpm_app.views.canvas.channel_bar import ChannelBar
from cpm_app.views.canvas.side_view import SideView, SliceCross
from cpm_app.views.canvas.slice_bar import SliceBar
from cpm_app.views.features.animation import provenance_comment, start_animation_task, start_writing_task
from cpm_app.views.panels.pages import PageBar, PagePanel
from cpm_app.views.volume.space_clicks import draw_shape_at, select_body_at
from cpm_app.views.volume.space_marks import FRAMES_PER_SECOND, TURN_FRAMES, animation_size, render_picture, render_turn
from cpm_app.views.volume.space_panel import SpacePanel, space_action_specs
from cpm_app.views.volume.space_view_builder import SpaceViewBuilder
from cpm_app.views.widgets.actions import ActionSpec
from cpm_app.views.widgets.fields import PLACE_JUMP
from cpm_app.views.window.docks import Panel
from cpm_app.views.window.window import Feature
from cpm_core import Image
from cpm_core.formats import write_picture
from cpm_core.numerics import Place
from cpm_core.numerics.types import Callback

_SLICES_GROUP = ">" + tr("Slices and pages")
"""Group in the list of keys."""

_SIDES_SHOWN_KEY = "volumes/three_slices"
"""Preference: whether the slices across the other two axes are shown."""


class SlicesFeature(Feature):
    """Line below the canvas, keys and wheel that move through a volume."""

    def set_up(self) -> None:
        """Create the actions and connect them to what they depend on."""
        window, area = self.window, self.window.canvas_area
        self.bar = SliceBar()
        self._shown: tuple[Slices | None, Image | None] = (None, None)
        self._slices = slices = window.workspace.slices
        pages = window.workspace.pages
        self.bar.moved.connect(lambda number: slices.go_to(number - 1))
        self.bar.axis_wanted.connect(slices.set_axis)
        self.bar.size_wanted.connect(partial(window.trigger_action, "pixel_size"))
        area.controls.addWidget(self.bar)
        self.sides: tuple[SideView, ...] = ()
        """Views of the slices across the other axes, created when they are first shown."""
        self.space: QWidget | None = None
        """View in space, which is shown together with them."""
        self._sides_wanted = bool(window.preferences.read_key(_SIDES_SHOWN_KEY, True))
        self._cross = SliceCross(area.canvas)
        self._connect_view(area.canvas)
        window.preferences.call_on_change(WHEEL_PREFERENCE, self._set_wheel)
        area.flow.changed.connect(self._show_scene)
        window.preferences.call_on_change(UNIT_PREFERENCE, self.show_slice_position)
        window.shortcuts.changed.connect(self.bar.show_keys)

        def has_several_slices(situation: Situation) -> bool:
            return has_volume(situation) or pages.has_images

        def move_by(by: int) -> Callback:
            in_order = partial(window.workspace.object_selection.do_in_order, needs_page=False)
            return lambda: in_order(partial(pages.go_by, by)) if pages.has_images else slices.go_by(by)

        def create_axis_action(axis: int) -> ActionSpec:
            name = AXIS_NAMES[axis]
            return ActionSpec(f"slices_across_{axis}", _SLICES_GROUP, tr("Across the &{axis}", axis=name),
                              tr("Show slices across this axis: {axis}.", axis=name),
                              partial(slices.set_axis, axis), f"Ctrl+Shift+{axis + 1}", visible_when=has_volume,
                              checked_when=lambda _: slices.current is not None
                              and slices.current.axis == axis)  # fmt: skip

        self.actions = (
            ActionSpec("previous_slice", _SLICES_GROUP, "&Previous slice or page",
                       "Show the slice or page before this one.", move_by(-1), "PgUp", visible_when=has_several_slices),
            ActionSpec("next_slice", _SLICES_GROUP, "&Next slice or page",
                       "Show the slice or page after this one.", move_by(1), "PgDown", visible_when=has_several_slices),
            ActionSpec("slices_back", _SLICES_GROUP, "Ten &back", "Show the slice or page ten before this one.",
                       move_by(-PLACE_JUMP), "Shift+PgUp", visible_when=has_several_slices),
            ActionSpec("slices_on", _SLICES_GROUP, "Ten &on", "Show the slice or page ten after this one.",
                       move_by(PLACE_JUMP), "Shift+PgDown", visible_when=has_several_slices),
            *map(create_axis_action, range(3)),
            ActionSpec("three_slices", "View", "&Three slices and space",
                       "Show the slices across the other axes and the view in space, or one slice alone.",
                       self.toggle_sides,
                       "Shift+Q", gap=True, visible_when=has_volume, checked_when=lambda _: self._sides_wanted),
        )  # fmt: skip

    def _set_wheel(self) -> None:
        wheel = self.window.preferences.read_preference(WHEEL_PREFERENCE)
        self.window.canvas_area.canvas.wheel_zooms = wheel == "zooms"

    def _connect_view(self, view: ToolView) -> None:
        """Let a view move the slices; compute the slow parts of its own on another thread, and draw them later."""
        view.place_wanted.connect(self._slices.go_through)
        view.slice_step_wanted.connect(self._slices.step_along)
        view.sections.later = later = AsyncCache(self.session)
        later.completed.connect(view.redraw_scene)
        later.completed.connect(self.window.canvas_area.strip.legend.schedule_update)

    def _open_menu(self, point: QPoint) -> None:
        """Open the menu of the item at a point of the screen, if there is one."""
        area = self.window.canvas_area
        item, _ = area.menu_at(area.mapFromGlobal(point))
        if item != "image":
            area.canvas.menu_wanted.emit(point)

    def toggle_sides(self) -> None:
        """Show or hide the slices across the other axes, and the view in space."""
        self._sides_wanted = not self._sides_wanted
        self.window.preferences.store_key(_SIDES_SHOWN_KEY, self._sides_wanted)
        self._show_scene()

    def _show_scene(self) -> None:
        scene = self.window.canvas_area.flow.scene
        self._show_sides(scene)
        if (scene.slices, scene.full_image) != self._shown:
            self._shown = scene.slices, scene.full_image
            self.show_slice_position()
            self.window.canvas_area.canvas.report_resting_pointer()

    def show_slice_position(self) -> None:
        """Show the position of the slice in the preferred unit."""
        self.bar.show_slices(*self._shown)

    def _show_sides(self, scene: Scene) -> None:
        """Draw the other two slices and the lines where all three meet."""
        shown = scene.slices is not None and self._sides_wanted
        self._cross.show_slices(scene.slices if shown else None)
        if len(self.sides) < 2:
            if shown:
                self.window.turns.schedule_work(self._create_side_view)
            return
        if self.sides[0].isVisibleTo(self.window.canvas_area) != shown:
            grid = self.window.canvas_area.views
            for stretch in (grid.setColumnStretch, grid.setRowStretch):
                stretch(0, 3)
                stretch(1, 2 if shown else 0)
            for view in (*self.sides, self.space):
                if view is not None:
                    view.setVisible(shown)
        if shown and scene.slices is not None:
            others = [axis for axis in range(3) if axis != scene.slices.axis]
            for view, axis in zip(self.sides, others, strict=True):
                view.show_slice(scene, axis)

    def _create_side_view(self) -> None:
        """Create the view of another slice, the second one below the first."""
        area, row = self.window.canvas_area, len(self.sides)
        view = SideView(area.canvas, area)
        view.hide()
        area.level_drag.watch_widget(view.viewport())
        area.views.addWidget(view, row, 1)
        self._connect_view(view)
        view.menu_wanted.connect(self._open_menu)
        self.sides += (view,)
        self.window.turns.schedule_work(self._show_scene)


class PagesFeature(Feature):
    """Lines below the canvas that select a page and show channels, actions for all pages, and their table."""

    def set_up(self) -> None:
        """Create the actions and connect them to what they depend on."""
        window = self.window
        self._pages = pages = window.workspace.pages
        followed = window.workspace.followed_objects
        self.bar = PageBar()
        in_order = partial(window.workspace.object_selection.do_in_order, needs_page=False)
        self.panel = PagePanel(pages, lambda row: in_order(partial(pages.show_row, row)))
        self.panels = (Panel("pages", "Pages", self.panel, "Shift+F11", shown_at_start=False),)
        self.bar.moved.connect(lambda number: in_order(partial(pages.open_page, number)))
        self.panel.export.clicked.connect(partial(window.trigger_action, "export_pages"))
        layer = self.canvas.layers.image
        self.channels = ChannelBar(layer)
        window.canvas_area.controls.addWidget(self.bar)
        window.canvas_area.controls.addWidget(self.channels)
        # later: the layer changes before a session has restored which channels it shows
        layer.changed.connect(lambda: window.turns.schedule_work(read_channels))
        pages.set_session_file(window.document_file)
        pages.changed.connect(self._on_pages_changed)
        window.session.tasks.changed.connect(window.refresh_actions)
        pages.results_changed.connect(window.refresh_actions)
        window.preferences.call_on_change(UNIT_PREFERENCE, self.panel.show_rows)
        window.shortcuts.changed.connect(self.bar.show_keys)

        def read_channels() -> None:
            window.workspace.channel_images.show(layer.wanted_channels)

        def is_stack(_: Situation) -> bool:
            return pages.has_images

        def can_run(situation: Situation) -> bool:
            document = situation.document
            return document.mode != "skeleton" and bool(document.starts or document.objects.items)

        def name_run(_: Situation) -> str:
            every = tr("Run all &channels") if pages.source.kind == "channel" else tr("Run all &pages")
            return tr("Stop") if pages.running else every

        def toggle_run() -> None:
            if pages.running:
                pages.cancel()
            elif self.session.document.starts:
                pages.run_all()
            else:
                followed.follow_all_pages()

        self.actions = (
            ActionSpec("run_pages", "Run", "Run all &pages",
                       "Run every page of the stack, one after the other, in the background, or stop that; finished "
                       "pages are kept. It needs a start; without one the accepted objects are followed.",
                       toggle_run, "Ctrl+Shift+Return", gap=True, visible_when=is_stack,
                       when=lambda now: pages.running or (can_run(now) and not followed.running),
                       text_for=name_run),
            ActionSpec("run_pages_on", "Run", "Run from this page &on",
                       "Run this page and all pages after it, one after the other, in the background.",
                       lambda: pages.run_all(pages.number), visible_when=is_stack,
                       when=lambda now: not pages.running and can_run(now) and bool(now.document.starts)),
            ActionSpec("follow_pages", "Run", "&Follow from page to page",
                       "Start each page from the contours of the previous one instead of from the same drawing, and "
                       "offer the accepted objects of the previous page on it.",
                       pages.toggle_following, short=tr("Follow"), visible_when=is_stack,
                       checked_when=lambda _: pages.following),
            ActionSpec("follow_objects", "Objects", "Follow on all &pages",
                       "Find the accepted objects again on all pages after this one, in the background; pages with "
                       "objects stay as they are.", followed.follow_all_pages, "Ctrl+Shift+F", gap=True,
                       visible_when=is_stack,
                       when=lambda now: not followed.running and bool(now.document.objects.items)),
            ActionSpec("composite", "View", "Co&mposite of the channels",
                       "Show all channels of the file together, each in its color, or only the one of the run.",
                       layer.toggle_composite, short=tr("Composite"),
                       visible_when=lambda _: bool(layer.looks), checked_when=lambda _: layer.is_composite),
        )  # fmt: skip

    # Internal

    def _on_pages_changed(self) -> None:
        pages = self._pages
        self.bar.show_page(pages.number, pages.count, pages.source)
        self.window.docks.set_tab_available("pages", pages.has_images)
        self.window.refresh_actions()


class SpaceFeature(Feature):
    """View of volume, particles and surface in space, and its export as a picture or a full turn."""

    def set_up(self) -> None:
        """Create the actions and connect them to what they depend on."""
        window = self.window
        self.panel = SpacePanel(window.session)
        self.panels = (Panel("space", "In space", self.panel, "Shift+F9", shown_at_start=False),)
        self._seen, self._objects = SpaceViewBuilder(), window.workspace.object_list
        self.panel.view.hide()
        window.get_feature(SlicesFeature).space = self.panel.view
        window.canvas_area.views.addWidget(self.panel.view, 1, 0)
        self._layers = layers = window.canvas_area.canvas.layers
        window.canvas_area.flow.changed.connect(self._show_space)
        window.workspace.object_list.changed.connect(self._show_space)
        self.session.image_changed.connect(self.update_tab)
        self.panel.view.picked.connect(self._on_place_picked)
        self.panel.bar.changed.connect(window.refresh_actions)
        window.canvas_area.level_drag.watch_widget(self.panel.view)
        for layer in (
            layers.particles,
            layers.image,
            layers.drawing,
            layers["objects"],
            layers["truth"],
            layers["second"],
        ):
            layer.changed.connect(self._show_space)
        self.actions = tuple(space_action_specs(self.panel, window.session))

    def write_view(self, path: Path, turning: bool) -> None:
        """Write the view as a picture, or as an animation of a full turn."""
        room, seen, camera = self.panel.view.picture_size, self.panel.contents, self.panel.view.camera
        if seen is None or camera is None:
            return
        session, size = self.session, animation_size(room)
        comment = provenance_comment(session)

        def write_view_picture(_: BackgroundTask) -> Report:
            write_picture(render_picture(seen, camera, room), path, comment)
            return FilesExported(path)

        if turning:
            frames = render_turn(seen, camera.enlarged(size[0] / room[0]), size)
            start_animation_task(session, path, lambda _: frames, TURN_FRAMES, FRAMES_PER_SECOND)
        else:
            start_writing_task(session, path, write_view_picture)

    # Internal

    def _on_place_picked(self, place: Place) -> None:
        """Move the slices to a place, and apply the tool in use there if it works without a slice."""
        self.window.workspace.slices.go_through(place)
        tool = self.window.canvas_area.canvas.dispatcher.tool
        camera, image = self.panel.view.camera, self.session.image
        if tool is not None and tool.name == "objects" and camera is not None and image is not None:
            select_body_at(self.window.workspace.object_selection, camera, image.spacing, place)
        elif tool is not None:
            draw_shape_at(self.session, tool.name, place)

    def update_tab(self) -> None:
        """Show the tab for volumes only."""
        self.window.docks.set_tab_available("space", self.session.scene.slices is not None)

    def _show_space(self, *_: object) -> None:
        self.panel.show_contents(
            self._seen.build_view(self.window.canvas_area.flow.scene, self._layers, self._objects.measurer.bodies)
        )
