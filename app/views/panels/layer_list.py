"""The panel of the layers, which is also their legend."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from PySide6.QtCore import QPoint, QSize, Qt, QTimer, Signal
from PySide6.QtGui import QAction
from PySide6.QtWidgets import QCheckBox, QHBoxLayout, QScrollArea, QToolButton, QVBoxLayout, QWidget

from app.model.text.language import tr
from app.views.canvas.layers import Layers
from app.views.canvas.layers.layer import Layer
from app.views.canvas.layers.layer_form import LayerForm
from app.views.theme.icons import swatch
from app.views.theme.theme import Theme
from app.views.widgets.actions import LAYER, native
from app.views.widgets.fields import MarkedSlider

_FOLD, _OPACITY = 18, 84
"""Widths [px]."""

_LOWEST_OPACITY, _OPACITY_STEP = 0.05, 0.05


class LayersPanel(QWidget):
    """One row per layer."""

    def __init__(self, layers: Layers) -> None:
        super().__init__()
        self.rows = {layer.name: LayerRow(layer) for layer in layers}
        self.boxes: dict[str, QCheckBox] = {name: row.box for name, row in self.rows.items()}
        scrolled = QWidget()
        scrolled.setObjectName("scrolled")
        self.setFocusProxy(next(iter(self.boxes.values())))
        self._area = QScrollArea()
        self._area.setWidget(scrolled)
        self._area.setWidgetResizable(True)
        column = QVBoxLayout(scrolled)
        column.setContentsMargins(0, 0, 8, 0)
        column.setSpacing(3)
        for row in self.rows.values():
            column.addWidget(row)
            row.unfolded.connect(self._bring_into_view)
        column.addStretch(1)
        outer = QVBoxLayout(self)
        outer.setContentsMargins(6, 8, 4, 4)
        outer.addWidget(self._area)

    def use_theme(self, theme: Theme) -> None:
        """Show the colors of layers in use, which the preferences change."""
        for row in self.rows.values():
            row.show_color()

    def show_keys(self, keys: Mapping[str, Sequence[str]]) -> None:
        """Name the keys of layers, by their names, in the tooltips."""
        for name, row in self.rows.items():
            row.show_key(next(iter(keys.get(name, ())), ""))

    def _bring_into_view(self) -> None:
        row = self.sender()
        if isinstance(row, LayerRow):
            # the position of the settings is known only after the layout has been updated
            QTimer.singleShot(0, row, lambda: self._area.ensureWidgetVisible(row, 0, 4))


class LayerRow(QWidget):
    """Check box and opacity of a layer, with its settings below."""

    unfolded = Signal()
    """The settings have become visible."""

    def __init__(self, layer: Layer) -> None:
        super().__init__()
        self.layer = layer
        self.box = self._make_box()
        self.show_color()
        self.show_key(layer.shortcut)
        self.fold = self._make_fold()
        self.opacity = MarkedSlider(_LOWEST_OPACITY, 1.0, _OPACITY_STEP, None)
        self.opacity.setFixedWidth(_OPACITY)
        self.opacity.setAccessibleName(tr("Opacity: {layer}").format(layer=layer.title))
        self.opacity.setToolTip(tr("Opacity; double-click to restore."))
        self.settings: QWidget | None = None
        head = QHBoxLayout()
        head.setContentsMargins(0, 0, 0, 0)
        head.setSpacing(2)
        head.addWidget(self.fold)
        head.addWidget(self.box, 1)
        head.addWidget(self.opacity)
        self._column = QVBoxLayout(self)
        self._column.setContentsMargins(0, 0, 0, 0)
        self._column.setSpacing(2)
        self._column.addLayout(head)
        self.fold.toggled.connect(self._unfold)
        self.box.toggled.connect(layer.set_shown)
        self.opacity.moved_to.connect(layer.set_opacity)
        self.opacity.restored.connect(lambda: layer.set_opacity(1.0))
        opaque = QAction(tr("Restore the &opacity"), self)
        opaque.triggered.connect(lambda: layer.set_opacity(1.0))
        self.addAction(opaque)
        layer.changed.connect(self._show)
        self._show()

    def menu_at(self, point: QPoint | None) -> tuple[str, QPoint]:
        """The layer. See `MenuOwner`."""
        return f"{LAYER}{self.layer.name}", point if point is not None else self.box.geometry().center()

    def show_color(self) -> None:
        """Show the colors in use."""
        if self.layer.colors:
            self.box.setIcon(swatch(*self.layer.colors))

    def show_key(self, key: str) -> None:
        """Name the key in the tooltip."""
        self.box.setToolTip(f"{self.layer.tip} ({native(key)})" if key else self.layer.tip)

    def _make_box(self) -> QCheckBox:
        layer = self.layer
        box = QCheckBox(layer.title)
        box.setIconSize(QSize(16 * max(len(layer.colors), 1), 14))
        box.setFocusPolicy(Qt.FocusPolicy.TabFocus)
        return box

    def _make_fold(self) -> QToolButton:
        fold = QToolButton()
        fold.setObjectName("fold")
        fold.setCheckable(True)
        fold.setFixedWidth(_FOLD)
        fold.setFocusPolicy(Qt.FocusPolicy.TabFocus)
        fold.setArrowType(Qt.ArrowType.RightArrow)
        fold.setAccessibleName(tr("Settings: {layer}").format(layer=self.layer.title))
        fold.setToolTip(tr("Settings of this layer."))
        kept = fold.sizePolicy()
        kept.setRetainSizeWhenHidden(True)
        fold.setSizePolicy(kept)
        if not self.layer.settable:  # to show one without a parent would open a window
            fold.hide()
        return fold

    def _show(self) -> None:
        self.box.setChecked(self.layer.shown)
        self.opacity.show_value(self.layer.opacity)

    def _unfold(self, unfolded: bool) -> None:
        self.fold.setArrowType(Qt.ArrowType.DownArrow if unfolded else Qt.ArrowType.RightArrow)
        if unfolded and self.settings is None:
            self.settings = LayerForm(self.layer)
            self.settings.setContentsMargins(_FOLD + 4, 0, 0, 8)
            self._column.addWidget(self.settings)
        if self.settings is not None:
            self.settings.setVisible(unfolded)
        if unfolded:
            self.unfolded.emit()
