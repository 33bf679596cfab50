"""The panel of the view in space: the controls above the view."""

from __future__ import annotations

from PySide6.QtCore import QPoint
from PySide6.QtWidgets import QVBoxLayout, QWidget

from app.model.display.space.shown_parts import Contents, ShownParts
from app.model.volume.slices import ends_of
from app.session.session import Session
from app.views.volume.space_bar import SpaceBar
from app.views.volume.space_view import SpaceView


class SpacePanel(QWidget):
    """Shows contents as the controls say."""

    def __init__(self, session: Session) -> None:
        super().__init__()
        self._contents: Contents | None = None
        self.bar = SpaceBar(ShownParts())
        self.view = SpaceView(session)
        self.bar.changed.connect(self._show)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.setSpacing(0)
        layout.addWidget(self.bar)
        layout.addWidget(self.view, 1)

    @property
    def contents(self) -> Contents | None:
        """What could be shown."""
        return self._contents

    def menu_at(self, point: QPoint | None) -> tuple[str, QPoint]:
        """The menu of the view; see `MenuOwner`."""
        return "" if self._contents is None else "space", point or self.view.geometry().center()

    def show_contents(self, contents: Contents | None) -> None:
        """Show another volume, or what a run has found in it since."""
        self._contents = contents
        if contents is not None:
            self.view.marks.unit, self.view.marks.names = contents.image.unit, ends_of(contents.image)
        self._show()

    def _show(self) -> None:
        self.view.show_view(None if self._contents is None else self._contents.view(self.bar.shown))
