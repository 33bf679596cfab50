"""The bar below the canvas with the channels of a file, which a composite shows together."""

from __future__ import annotations

from functools import partial

from PySide6.QtCore import QSize, Qt
from PySide6.QtGui import QResizeEvent
from PySide6.QtWidgets import QFrame, QHBoxLayout, QMenu, QScrollArea, QSizePolicy, QToolButton

from cpm_app.model.display.channels import CHANNEL_COLORS
from cpm_app.model.text.language import tr
from cpm_app.views.layers.image_layer import FILE_RANGE, MANUAL_RANGE, RANGE_TITLES, ImageLayer
from cpm_app.views.theme.icons import create_swatch
from cpm_app.views.widgets.actions import ActionButton, add_menu_action
from cpm_app.views.widgets.containers import fill_layout

_SHOWN_NAME_LENGTH = 20
"""Largest number of characters of a name that is shown."""


class ChannelBar(QScrollArea):
    """Switch of the composite, and a button for each channel: shown or not, with a menu of its color and range.

    The channel that is open is bold. The bar is hidden unless there are several, and scrolls if they are many.
    """

    def __init__(self, layer: ImageLayer) -> None:
        super().__init__()
        self._layer = layer
        self._names: list[str] = []
        self.composite = ActionButton("composite")
        self.composite.setSizePolicy(QSizePolicy.Policy.Fixed, QSizePolicy.Policy.Fixed)
        self.buttons: list[QToolButton] = []
        """The buttons of the channels."""
        self._content = QFrame()
        self._content.setObjectName("slices")
        self._row = fill_layout(QHBoxLayout(self._content), self.composite, None, margins=(10, 3, 10, 3), spacing=4)
        self.setWidget(self._content)
        self.setWidgetResizable(True)
        self.setFrameShape(QFrame.Shape.NoFrame)
        layer.changed.connect(self._show_channels)
        self.hide()

    def resizeEvent(self, event: QResizeEvent) -> None:
        """Make room for the scroll bar if it is needed."""
        super().resizeEvent(event)
        self._fit_height()

    def _fit_height(self) -> None:
        needed, scroll_bar = self._content.minimumSizeHint(), self.horizontalScrollBar().sizeHint().height()
        self.setFixedHeight(needed.height() + (scroll_bar if needed.width() > self.width() else 0))

    def _show_channels(self) -> None:
        layer, names = self._layer, [channel.name for channel in self._layer.scene.channels]
        if names != self._names:
            self._names = names
            for button in self.buttons:
                button.deleteLater()
            self.buttons = [self._add_button(*each) for each in enumerate(names)]
            self.setVisible(bool(names))
            self._fit_height()
        for index, (button, look) in enumerate(zip(self.buttons, layer.looks, strict=True)):
            font = button.font()
            font.setBold(index == layer.open_channel)
            button.setFont(font)
            button.setIcon(create_swatch(look.color))
            button.setChecked(look.shown)
            button.setEnabled(layer.is_composite)

    def _add_button(self, index: int, name: str) -> QToolButton:
        """Add the button of a channel."""
        button, menu, change = QToolButton(), QMenu(self), partial(self._layer.set_look, index)
        button.setText(name[:_SHOWN_NAME_LENGTH])
        button.setIconSize(QSize(14, 14))
        button.setToolTip(tr("Show or hide the channel {name}. A run works on the one in bold.", name=name))
        button.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextBesideIcon)
        button.setFocusPolicy(Qt.FocusPolicy.TabFocus)
        button.setCheckable(True)
        button.clicked.connect(lambda shown: change(shown=shown))
        for color, title in CHANNEL_COLORS.items():
            chosen = add_menu_action(menu, title, partial(change, color=color), checked=False)
            chosen.setIcon(create_swatch(color))
            chosen.setData(color)
        menu.addSeparator()
        ranges = {
            way: add_menu_action(menu, title, partial(self._layer.set_channel_range, index, way), checked=False)
            for way, title in RANGE_TITLES.items()
        }

        def show_look() -> None:
            """Check color and range of the channel, and offer other ranges once it has been read."""
            for action in menu.actions():
                action.setChecked(action.data() == self._layer.looks[index].color)
            image, current = self._layer.find_channel_image(index), self._layer.channel_range(index)
            for way, action in ranges.items():
                action.setChecked(way == current)
                action.setEnabled(image is not None)
            ranges[FILE_RANGE].setVisible(image is not None and image.window is not None)
            ranges[MANUAL_RANGE].setVisible(current == MANUAL_RANGE)

        menu.aboutToShow.connect(show_look)
        button.setMenu(menu)
        button.setPopupMode(QToolButton.ToolButtonPopupMode.MenuButtonPopup)
        self._row.insertWidget(index + 1, button)
        return button
