"""The bar below the canvas with the channels of a file, which a composite shows together."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from PySide6.QtCore import QSize, Qt
from PySide6.QtWidgets import QMenu, QSizePolicy, QToolBar, QToolButton

from cpm_app.model.display.channels import CHANNEL_COLORS
from cpm_app.model.text.language import tr
from cpm_app.views.layers.image_layer import ImageLayer
from cpm_app.views.theme.icons import create_swatch
from cpm_app.views.widgets.actions import ActionButton, add_menu_action

_SHOWN_NAME_LENGTH = 16
"""Largest number of characters of a name that is shown."""


class ChannelBar(QToolBar):
    """Switch of the composite, and a button for each channel: shown or not, with a menu of its color.

    The channel that is open is bold; `choose` opens another one by its index. The bar is hidden if there is only one.
    """

    def __init__(self, layer: ImageLayer, choose: Callable[[int], object]) -> None:
        super().__init__()
        self._layer, self._choose = layer, choose
        self._names: list[str] = []
        self.composite = ActionButton("composite")
        self.composite.setSizePolicy(QSizePolicy.Policy.Fixed, QSizePolicy.Policy.Fixed)
        self.setIconSize(QSize(14, 14))
        self.buttons: list[QToolButton] = []
        """The buttons of the channels."""
        self.addWidget(self.composite)
        layer.changed.connect(self.show_channels)
        self.hide()

    def show_channels(self) -> None:
        """Show the channels of the file, and which of them are shown."""
        layer, names = self._layer, [channel.name for channel in self._layer.scene.channels]
        if names != self._names:
            self._names = names
            for action in self.actions()[1:]:
                self.removeAction(action)
                action.deleteLater()
            self.buttons = [self._create_button(*each) for each in enumerate(names)]
        for index, (button, look) in enumerate(zip(self.buttons, layer.looks, strict=True)):
            font = button.font()
            font.setBold(index == layer.open_channel)
            button.setFont(font)
            button.setIcon(create_swatch(look.color))
            button.setChecked(look.shown)
            button.setEnabled(layer.is_composite)
        self.setVisible(bool(names))

    def _create_button(self, index: int, name: str) -> QToolButton:
        button, menu, layer = QToolButton(), QMenu(self), self._layer
        button.setText(name if len(name) <= _SHOWN_NAME_LENGTH else f"{name[:_SHOWN_NAME_LENGTH]}…")
        button.setToolTip(tr("{channel}: show or hide it. A run finds the edges of the channel in bold.", channel=name))
        button.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextBesideIcon)
        button.setFocusPolicy(Qt.FocusPolicy.TabFocus)
        button.setCheckable(True)
        button.toggled.connect(lambda shown: layer.set_look(index, shown=shown))
        add_menu_action(menu, tr("&Work on this channel"), partial(self._choose, index))
        menu.addSeparator()
        for color, title in CHANNEL_COLORS.items():
            add_menu_action(menu, title, partial(layer.set_look, index, color=color)).setIcon(create_swatch(color))
        button.setMenu(menu)
        button.setPopupMode(QToolButton.ToolButtonPopupMode.MenuButtonPopup)
        self.addWidget(button)
        return button
