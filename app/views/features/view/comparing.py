"""Looking closely: a wipe between two results, and a magnifier."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

from PySide6.QtCore import QElapsedTimer, QEvent, QObject, Qt
from PySide6.QtGui import QKeyEvent
from PySide6.QtWidgets import QMenu

from app.model.state.situation import Situation, has_image
from app.model.text.language import tr
from app.views.canvas.mirrors.magnifier import Magnifier
from app.views.canvas.mirrors.wipe import Wipe
from app.views.widgets.action_spec import STATE, ActionSpec, Submenu
from app.views.window.feature import Feature, FeatureContext
from cpm_core.contours.result import Result

_HELD = 350
"""Time after which the key of the magnifier counts as held: then it ends when the key is released [ms]."""


class ComparingFeature(Feature):
    """The wipe and the magnifier."""

    def __init__(self, context: FeatureContext) -> None:
        super().__init__(context)
        canvas = context.canvas_area.canvas
        self._other = context.workspace.other_result
        self.wipe = Wipe(canvas)
        self.magnifier = Magnifier(canvas)
        self._held = QElapsedTimer()
        self._keys = _Release(self)
        canvas.installEventFilter(self._keys)
        self.wipe.ended.connect(lambda: self._other.choose(None))
        self._other.changed.connect(self._show_wipe)
        context.session.scene_changed.connect(self._draw)
        context.session.image_changed.connect(lambda: self.magnifier.switch(False))

    def action_specs(self) -> Sequence[ActionSpec | Submenu]:
        """Compare, keep a result, magnify."""
        return (
            ActionSpec(name="wipe", menu="View", text=tr("Compare &two results"), do=self._other.toggle,
                       shortcuts=("Ctrl+D",), gap=True, when=has_image, group=STATE,
                       tip=tr("Show another result on the right of a divider that can be dragged."),
                       holds=lambda situation: self._other.chosen is not None),
            Submenu(name="wipe_with", menu="View", text=tr("Compare wit&h"), fill=self._fill),
            ActionSpec(name="keep_result", menu="View", text=tr("&Keep this result to compare"), do=self._other.keep,
                       shortcuts=("Ctrl+Shift+D",), tip=tr("Keep what is found now, to compare later results with it."),
                       when=self._has_result),
            ActionSpec(name="magnifier", menu="View", text=tr("&Magnifier"), do=self._switch, shortcuts=("M",),
                       tip=tr("Show what is under the pointer four times as large; hold the key for a short look."),
                       when=has_image, group=STATE, holds=lambda situation: self.magnifier.shown),
        )  # fmt: skip

    def release(self) -> None:
        """The key of the magnifier has been released; after a while that ends it."""
        if self.magnifier.shown and self._held.isValid() and self._held.elapsed() >= _HELD:
            self._switch()
        self._held.invalidate()

    def _switch(self) -> None:
        self.magnifier.switch(not self.magnifier.shown)
        if self.magnifier.shown:
            self._held.start()
        self.context.refresh()

    def _has_result(self, situation: Situation) -> bool:
        scene = self.context.session.scene
        found = None if scene.reconstruction is None else scene.reconstruction.result
        surface = isinstance(found, Result) and found.surface is not None
        return bool(scene.contours.items or scene.skeleton or surface or situation.document.objects.items)

    def _fill(self, menu: QMenu) -> None:
        for other in self._other.choices:
            action = menu.addAction(other.title)
            action.setCheckable(True)
            action.setChecked(other == self._other.chosen)
            action.triggered.connect(partial(self._other.choose, None if other == self._other.chosen else other))

    def _show_wipe(self) -> None:
        if self._other.chosen is None:
            self.wipe.end()
        else:
            self.wipe.begin(*self._other.titles)
            self._draw()
        self.context.refresh()

    def _draw(self) -> None:
        scene = self.context.session.scene
        if self._other.chosen is not None:
            self.wipe.draw(self._other.far(scene))
        self.magnifier.draw(self._other.near(scene))


class _Release(QObject):
    """Reports the release of the key of the magnifier."""

    def __init__(self, feature: ComparingFeature) -> None:
        super().__init__(feature.context.window)
        self._feature = feature

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Look for the key."""
        if not isinstance(event, QKeyEvent) or event.type() != QEvent.Type.KeyRelease:
            return False
        if event.key() == Qt.Key.Key_M and not event.isAutoRepeat():
            self._feature.release()
        return False
