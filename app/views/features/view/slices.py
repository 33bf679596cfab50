"""The slices of a volume: which is shown, across which axis."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

from PySide6.QtCore import QPoint

from app.model.preferences.table import UNIT
from app.model.state.situation import Condition, has_volume
from app.model.text.language import tr
from app.model.volume.slices import AXES, Slices
from app.session.features.latest import MadeLater
from app.session.scene import Scene
from app.views.canvas.image_view import ImageView
from app.views.canvas.volume.side_view import Cross, SideView
from app.views.canvas.volume.slice_bar import SliceBar
from app.views.widgets.action_spec import STATE, ActionSpec
from app.views.window.feature import Feature, FeatureContext
from cpm_core.image.image import Image

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
        self._later: list[MadeLater] = []
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
            ActionSpec(name=name, menu=_MENU, text=text, do=partial(self._go, by), shortcuts=(key,), tip=tip,
                       when=lambda situation: has_volume(situation) or self._pages.count > 1)
            for name, text, key, by, tip in moves
        ]  # fmt: skip
        axes = [
            ActionSpec(name=f"slices_across_{axis}", menu=_MENU, text=tr("Across the &{axis}").format(axis=name),
                       do=partial(self._turn, axis), shortcuts=(f"Ctrl+Shift+{axis + 1}",),
                       tip=tr("Show slices across this axis: {axis}.").format(axis=name), group=STATE,
                       gap=axis == 0, when=has_volume, holds=self._is_across(axis))
            for axis, name in enumerate(AXES)
        ]  # fmt: skip
        sides = ActionSpec(name="three_slices", menu=_MENU, text=tr("&Three slices side by side"), do=self._toggle,
                           shortcuts=("Shift+Q",), group=STATE, gap=True, when=has_volume,
                           tip=tr("Show the slices across the other axes beside the canvas, linked by a cross."),
                           holds=lambda _: self._wanted)  # fmt: skip
        return (*through, *axes, sides)

    def close(self) -> bool:
        """End the threads that make parts of slices."""
        for later in self._later:
            later.close()
        return True

    def _draw_later(self, view: ImageView) -> None:
        """Draw what takes long of the slices of a view when it has been made on another thread."""
        view.sections.later = later = MadeLater(self.context.session)
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
            area.canvas.menu_wanted.emit(point)

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
        view.asked.connect(self._open_menu)
        view.went.connect(self._slices.through)
        view.passed.connect(self._slices.pass_on)
        self.sides += (view,)
        self.context.turns.ask(self._show)

    def _show_size(self) -> None:
        """Show the size of a voxel in another unit."""
        self._shown = (None, None)
        self._show()
