"""Panel of the layers, which is also their legend: a row for each, its settings folded away."""

from __future__ import annotations

from functools import partial

from PySide6.QtCore import QSize, Qt, QTimer
from PySide6.QtWidgets import QCheckBox, QHBoxLayout, QVBoxLayout, QWidget

from cpm_app.model.text.language import tr
from cpm_app.views.layers import Layers
from cpm_app.views.layers.layer import Layer
from cpm_app.views.layers.layer_form import LayerForm
from cpm_app.views.theme.icons import create_swatch
from cpm_app.views.widgets.actions import LAYER_ACTION_PREFIX, Actions
from cpm_app.views.widgets.containers import FoldButton, VerticalScrollArea, fill_layout
from cpm_app.views.widgets.fields import MarkedSlider

_FOLD_BUTTON_WIDTH = 18
"""Width of the button that unfolds the settings [px]."""

_MIN_LAYERS_HEIGHT = 60
"""Smallest height of the panel [px]."""

_MIN_OPACITY = 0.05
"""Smallest opacity of a layer."""

_OPACITY_STEP = 0.05
"""Increment of the opacity."""


class LayersPanel(VerticalScrollArea):
    """Panel with one row per layer."""

    def __init__(self, layers: Layers) -> None:
        self.rows = {layer.name: LayerRow(layer) for layer in layers}
        self.boxes: dict[str, QCheckBox] = {name: row.box for name, row in self.rows.items()}
        content = QWidget()
        fill_layout(QVBoxLayout(content), *self.rows.values(), None, margins=(6, 8, 8, 4), spacing=2)
        super().__init__(content, _MIN_LAYERS_HEIGHT)
        self.setFocusProxy(next(iter(self.boxes.values())))
        for row in self.rows.values():
            # the position of the settings is known only after the layout has been updated
            row.fold.toggled.connect(
                lambda _, row=row: QTimer.singleShot(0, row, partial(self.ensureWidgetVisible, row, 0, 4))
            )

    def use_actions(self, actions: Actions) -> None:
        """Give the rows the tooltips of the actions that show or hide layers, with their keys."""
        for name, box in self.boxes.items():
            box.setToolTip(actions[f"{LAYER_ACTION_PREFIX}{name}"].toolTip())


class LayerRow(QWidget):
    """Check box of a layer, with opacity and settings below."""

    def __init__(self, layer: Layer) -> None:
        super().__init__()
        self.layer = layer
        self.box = QCheckBox(layer.title)
        self.box.setIconSize(QSize(16 * max(len(layer.colors), 1), 14))
        self.box.setFocusPolicy(Qt.FocusPolicy.TabFocus)
        self.box.toggled.connect(layer.set_shown)
        if layer.colors:
            self.box.setIcon(create_swatch(*layer.colors))
        self.fold = FoldButton()
        self.fold.setFixedWidth(_FOLD_BUTTON_WIDTH)
        self.fold.setAccessibleName(tr("Settings: {layer}", layer=layer.title))
        self.fold.setToolTip(tr("Settings of this layer."))
        self.fold.toggled.connect(self._on_fold_toggled)
        self.opacity = MarkedSlider(_MIN_OPACITY, 1.0, _OPACITY_STEP)
        self.opacity.setAccessibleName(tr("Opacity: {layer}", layer=layer.title))
        self.opacity.setToolTip(tr("Opacity; double-click to restore."))
        self.opacity.moved_to.connect(layer.set_opacity)
        self.opacity.restored.connect(partial(layer.set_opacity, 1.0))
        self.settings: QWidget | None = None
        head = fill_layout(QHBoxLayout(), self.fold, self.box, spacing=2, wide=self.box)
        self._column = fill_layout(QVBoxLayout(self), head, spacing=2)
        layer.changed.connect(self._on_layer_changed)
        self._on_layer_changed()

    def _on_layer_changed(self) -> None:
        self.box.setChecked(self.layer.shown)
        self.opacity.show_value(self.layer.opacity)

    def _on_fold_toggled(self, unfolded: bool) -> None:
        if unfolded and self.settings is None:
            self.settings = LayerForm(self.layer)
            self.settings.setContentsMargins(_FOLD_BUTTON_WIDTH + 4, 0, 0, 8)
            self.settings.rows.insertRow(0, tr("Opacity"), self.opacity)
            self._column.addWidget(self.settings)
        if self.settings is not None:
            self.settings.setVisible(unfolded)
