"""A section of a panel: a heading that folds the content below it."""

from __future__ import annotations

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QSizePolicy, QToolButton, QVBoxLayout, QWidget


class Section(QWidget):
    """A heading and a content that can be folded; it is initially visible if `unfolded`."""

    def __init__(self, title: str, content: QWidget, unfolded: bool = True) -> None:
        super().__init__()
        self._content = content
        self.fold = QToolButton()
        self.fold.setObjectName("fold")
        self.fold.setText(title)
        self.fold.setCheckable(True)
        self.fold.setChecked(unfolded)
        self.fold.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextBesideIcon)
        self.fold.setFocusPolicy(Qt.FocusPolicy.TabFocus)
        self.fold.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Fixed)
        self.fold.toggled.connect(self._show)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.setSpacing(2)
        layout.addWidget(self.fold)
        layout.addWidget(content)
        self._show(unfolded)

    def _show(self, unfolded: bool) -> None:
        self.fold.setArrowType(Qt.ArrowType.DownArrow if unfolded else Qt.ArrowType.RightArrow)
        self._content.setVisible(unfolded)
