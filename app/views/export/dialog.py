"""The export dialog: what is written and in which format; it asks for the file at last."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from PySide6.QtCore import QSize, Qt, Signal
from PySide6.QtGui import QResizeEvent
from PySide6.QtWidgets import (
    QComboBox,
    QDialog,
    QFormLayout,
    QHBoxLayout,
    QLabel,
    QVBoxLayout,
    QWidget,
)

from app.model.export import SOURCES, ExportOrder, chosen, closed, formats, listed, summarize, summary_text
from app.model.state.surface_figures import figure_texts
from app.model.text.language import tr
from app.session.features.skeleton import description_of
from app.session.session import Session
from app.views.canvas.items.item import image_rectangle
from app.views.export.picture import Line, Picture
from app.views.theme import theme
from app.views.theme.theme import look
from app.views.widgets.containers import AcceptButtons, arrange, wrapped
from cpm_core import Result, Skeleton
from cpm_core.formats import FOR_CENTERLINES, FOR_SKELETONS, FOR_VOLUMES, IN_SPACE, OUTLINABLE, WRITABLE, palette
from cpm_core.image import CONVENTIONS
from cpm_core.reconstruction import can_be_closed

_WIDTH = 330
"""Width of the sentences [px]."""

_SLIGHTLY = 0.3
"""Opacity of the image, on which filled contours stand out."""

_SPACES = {
    "LPS": tr("To the left, back and head of the patient (LPS), as in DICOM"),
    "RAS": tr("To the right, front and head of the patient (RAS), as in NIfTI"),
}


class ExportDialog(QDialog):
    """Asks what to export and as what, and shows it.

    Parameters
    ----------
    parent : QWidget
        The window.
    session : Session
        What is exported.
    selected : frozenset of int
        Numbers of the selected contours.
    suffix : str
        Suffix of the format that is suggested.
    ask : callable
        Asks for a file with a suffix; None when the user cancels.
    """

    ordered = Signal(object, object)
    """Path of the file and the order for it."""

    def __init__(
        self,
        parent: QWidget,
        session: Session,
        selected: frozenset[int],
        suffix: str,
        ask: Callable[[QWidget, str], Path | None],
    ) -> None:
        super().__init__(parent)
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self._session, self._selected, self._ask = session, selected, ask
        image, scene = session.image, session.scene
        assert image is not None
        self._image = image
        self._volume = scene.slices is not None
        self._whole = scene.skeleton or scene.contours.result or getattr(scene.reconstruction, "result", None)
        skeleton = tr("Export center lines") if self._volume else tr("Export skeleton")
        result = tr("Export surface") if self._volume else tr("Export contours")
        self.setWindowTitle(skeleton if isinstance(self._whole, Skeleton) else result)
        self.source, self.format, self.regions, self.closing, self.space = (QComboBox() for _ in range(5))
        self.summary = wrapped()
        self.summary.setMinimumSize(_WIDTH, 3 * self.summary.fontMetrics().lineSpacing())
        self.summary.setAlignment(Qt.AlignmentFlag.AlignTop)
        self._fill(suffix)
        buttons = AcceptButtons(self, tr("&Export…"))
        self.export_button = buttons.accept_button
        self._form = QFormLayout()
        rows = (tr("What"), tr("Format"), tr("Regions"), tr("Open contours"), tr("Coordinates"))
        for title, field in zip(rows, (self.source, self.format, self.regions, self.closing, self.space), strict=True):
            field.setAccessibleName(title)
            field.activated.connect(self._follow)
            self._form.addRow(title, field)
        self._form.addRow("", self.summary)
        layout = QHBoxLayout(self)
        layout.addLayout(arrange(QVBoxLayout(), self._form, None, buttons))
        self.preview = None if self._volume else Preview(Picture(scene.display, image_rectangle(image.shape)))
        if self.preview is not None:
            layout.addWidget(self.preview, 1)
        self.export_button.setDefault(True)  # once it is in the dialog, else Tab makes another button the default
        self._follow()

    @property
    def suffix(self) -> str:
        """Suffix of the chosen format."""
        return str(self.format.currentData())

    @property
    def order(self) -> ExportOrder:
        """What is chosen."""
        source = self.source.currentData()
        return ExportOrder(
            source,
            self._selected if source == "selected" else frozenset(),
            self.closing.currentData() or "",
            outlines=bool(self.regions.currentData()) and self.suffix in OUTLINABLE,
            space=self.space.currentData(),
        )

    def accept(self) -> None:
        """Ask for the file and order the export."""
        path, image = self._ask(self, self.suffix), self._session.document.image
        if path is not None and image is not None and path.resolve() == Path(image.path).resolve():
            text = tr("{name} is the image itself: choose another name.")
            self.summary.setText(text.format(name=path.name))
        elif path is not None:
            self.ordered.emit(path, self.order)
            super().accept()

    # Internal

    def _fill(self, suffix: str) -> None:
        skeleton = isinstance(self._whole, Skeleton)
        if skeleton:
            self.source.addItem(tr("The center lines"), "all")
        for source in () if skeleton else SOURCES:
            count = self._count(source)
            if count and self._volume and source == "all":
                self.source.addItem(tr("The surface of the run"), source)
            elif count and (not self._volume or source == "objects"):
                self.source.addItem(f"{SOURCES[source]} ({count})", source)
        writable = FOR_VOLUMES if self._volume else WRITABLE
        if skeleton:
            writable = FOR_CENTERLINES if self._volume else FOR_SKELETONS
        for known, name in formats(of_volumes=self._volume).items():
            if known in writable:
                self.format.addItem(f"{name}  (*{known})", known)
        self.format.setMaxVisibleItems(24)
        self.format.setCurrentIndex(max(0, self.format.findData(listed(suffix))))
        self.regions.addItem(tr("Filled"), False)
        self.regions.addItem(tr("Outlines"), True)
        for space in CONVENTIONS:
            self.space.addItem(_SPACES[space], space)

    def _count(self, source: str) -> int:
        """How many contours or objects of a source there are to write."""
        document = self._session.document
        if source == "objects" and self._volume:
            return sum(not item.hidden for item in document.objects.items)
        try:
            found = chosen(self._whole, document, ExportOrder(source, self._selected))
        except ValueError:
            return 0
        if self._volume:
            return int(isinstance(found, Result) and found.surface is not None)
        return len({one.group for one in found.contours} if source == "objects" else found.contours)

    def _follow(self) -> None:
        """Show what concerns the present choice, and what it writes."""
        skeleton = isinstance(self._whole, Skeleton)
        self._form.setRowVisible(self.source, not skeleton)
        self._form.setRowVisible(self.regions, self.suffix in OUTLINABLE and not skeleton and not self._volume)
        placed = self._volume and self._image.geometry is not None
        self._form.setRowVisible(self.space, placed and self.suffix in IN_SPACE)
        self._form.setRowVisible(self.closing, False)
        if self._volume:
            self.summary.setText(self._volume_text())
            return
        document = self._session.document
        before = chosen(self._whole, document, self.order, self._image)
        self._offer_closing(before)
        order = self.order
        # In the preview contours are closed straight, which takes no time.
        straight = ExportOrder(order.source, closing="straight") if order.closing else ExportOrder(order.source)
        after = closed(before, straight, self._image, document.parameters)
        self._show(before, after, order)

    def _offer_closing(self, result: Result | Skeleton) -> None:
        """Offer to close open contours, where there are any that can be closed."""
        opened = [contour for contour in result.contours if not contour.closed]
        self._form.setRowVisible(self.closing, bool(opened) and isinstance(result, Result))
        closable = sum(map(can_be_closed, opened)) if isinstance(result, Result) else 0
        lost = summarize(result, result, self.suffix, self.order).left_out
        present = self.closing.currentData() or ""
        self.closing.clear()
        self.closing.addItem(tr("Leave {count} out").format(count=lost) if lost else tr("Leave them open"), "")
        if closable:
            self.closing.addItem(tr("Close {count} along the edges").format(count=closable), "edges")
            self.closing.addItem(tr("Close {count} by straight lines").format(count=closable), "straight")
        self.closing.setCurrentIndex(max(0, self.closing.findData(present)))

    def _show(self, before: Result | Skeleton, after: Result | Skeleton, order: ExportOrder) -> None:
        summary = summarize(before, after, self.suffix, order)
        words = tr("Writes {what}.").format(what=summary_text(summary))
        if summary.left_out and order.closing:
            words += " " + tr("Their ends are too far apart to be closed.")
        elif summary.left_out:
            words += " " + tr("This format holds closed contours only.")
        elif isinstance(after, Result) and (opened := sum(not contour.closed for contour in after.contours)):
            words += " " + tr("{count} are open.").format(count=opened)
        self.summary.setText(words if summary.written else tr("There is nothing to write in this format."))
        self.export_button.setEnabled(summary.written > 0)
        filled = self.suffix in OUTLINABLE and not order.outlines and isinstance(after, Result)
        colors = [f"#{red:02x}{green:02x}{blue:02x}" for red, green, blue in palette(255)[1:].tolist()]
        lines = [
            Line(contour, colors[index % len(colors)] if filled else "", filled)
            if contour.closed or not summary.left_out
            else Line(contour, look().color(theme.REJECTED), pale=True)
            for index, contour in enumerate(after.contours)
        ]
        assert self.preview is not None
        if filled:
            lines.sort(key=lambda line: -line.contour.area)
        self.preview.show_lines(lines, _SLIGHTLY if filled else 1.0)

    def _volume_text(self) -> str:
        """The figures of what is written of a volume, one in each line."""
        if isinstance(self._whole, Skeleton):
            return description_of(self._whole, self._image)
        if self.source.currentData() == "objects":
            count = self._count("objects")
            counted = tr("1 object") if count == 1 else tr("{count} objects").format(count=count)
            return tr("{count}; in a label volume each voxel has the number of its object.").format(count=counted)
        return "\n".join(f"{label}: {value}" for label, value, _ in figure_texts(self._session.status.surface))


class Preview(QLabel):
    """What the file will hold on the image, and, pale, what it will not."""

    def __init__(self, picture: Picture) -> None:
        super().__init__()
        self._picture = picture
        self._shown: tuple[list[Line], float] = [], 1.0
        self.setAlignment(Qt.AlignmentFlag.AlignCenter)
        self.setMinimumSize(300, 260)
        self.setAccessibleName(tr("Preview of the export"))

    def sizeHint(self) -> QSize:
        """Large enough to see single contours."""
        return QSize(460, 460)

    def show_lines(self, lines: list[Line], opacity: float) -> None:
        """Show lines on the image of some opacity."""
        self._shown = lines, opacity
        self.setPixmap(self._picture.drawn(self.size(), self.devicePixelRatioF(), lines, opacity))

    def resizeEvent(self, event: QResizeEvent) -> None:
        """Draw the picture in its new size."""
        self.show_lines(*self._shown)
