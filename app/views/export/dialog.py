"""The export dialog: what is written, in which format, where to, and what the format leaves out."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import (
    QButtonGroup,
    QComboBox,
    QDialog,
    QDialogButtonBox,
    QFormLayout,
    QHBoxLayout,
    QLabel,
    QRadioButton,
    QVBoxLayout,
    QWidget,
)

from app.model.export.order import SOURCES, Account, Closing, ExportOrder, Given, account, chosen, closed, in_words
from app.model.text.language import tr
from app.session.exchange.messages import Report
from app.session.session import Session
from app.session.tasks.tasks import Task
from app.views.export.fields import FileFields, FormatField, PixelSizeField
from app.views.export.preview import Preview
from cpm_core.contours.result import Result
from cpm_core.formats import FOR_SKELETONS, OUTLINABLE, WRITABLE
from cpm_core.medial_axis.skeleton import Skeleton
from cpm_core.reconstruction.curve.closing import can_be_closed

_WIDTH = 330
"""Width of the fields [px]."""


@dataclass(frozen=True, eq=False, slots=True)
class Closed(Report):
    """Open contours have been closed for the preview of an order, or what that failed with."""

    dialog: ExportDialog
    order: ExportOrder
    result: Result | Skeleton | None
    trouble: str = ""


class ExportDialog(QDialog):
    """Asks what to export and where to, and shows it; `folder` and `stem` are where the file goes by default."""

    ordered = Signal(object, object)
    """Path of the file and the order for it."""

    def __init__(self, parent: QWidget, session: Session, selected: frozenset[int], place: Path, suffix: str) -> None:
        super().__init__(parent)
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self._session = session
        self._selected = selected
        self._task: Task | None = None
        image = session.image
        assert image is not None and session.document.image is not None
        self._whole = session.scene.contours.result or getattr(session.scene.reconstruction, "result", None)
        self.setWindowTitle(tr("Export skeleton") if isinstance(self._whole, Skeleton) else tr("Export contours"))
        self.sources = {source.name: QRadioButton(source.title) for source in SOURCES}
        skeleton = isinstance(self._whole, Skeleton)
        self.format = FormatField(FOR_SKELETONS if skeleton else WRITABLE)
        self.drawn = {"filled": QRadioButton(tr("Filled")), "outlines": QRadioButton(tr("Outlines"))}
        self.closing = QComboBox()
        self.pixel_size = PixelSizeField(image.spacing, image.unit)
        self.file = FileFields(place.parent, place.name, Path(session.document.image.path))
        self.counts, self.note = QLabel(), QLabel()
        self.preview = Preview(session.scene.display, image.shape)
        self._form = QFormLayout()
        self.buttons = QDialogButtonBox(QDialogButtonBox.StandardButton.Cancel)
        self.export_button = self.buttons.addButton(tr("&Export"), QDialogButtonBox.ButtonRole.AcceptRole)
        self._lay_out()
        self.export_button.setDefault(True)  # once it is in the dialog, else Tab makes another button the default
        self._fill()
        self.format.choose(suffix)
        self.file.use_suffix(self.format.suffix)
        self._connect()
        self._follow_format()

    @property
    def order(self) -> ExportOrder:
        """What is chosen."""
        source = next(name for name, button in self.sources.items() if button.isChecked())
        outlines = self.drawn["outlines"].isChecked() and self.format.suffix in OUTLINABLE
        spacing, unit = self.pixel_size.changed
        closing: Closing = self.closing.currentData() or ""
        selected = self._selected if source == "selected" else frozenset()
        return ExportOrder(source, selected, closing, outlines, spacing, unit)

    def accept(self) -> None:
        """Order the export."""
        if not self.export_button.isEnabled():
            return
        self.ordered.emit(self.file.path, self.order)
        super().accept()

    def done(self, result: int) -> None:
        """Stop the preview."""
        self._session.stop_listening(Closed, self._show_closed)
        if self._task is not None:
            self._task.cancel()
        super().done(result)

    # Internal

    def _lay_out(self) -> None:
        what = QVBoxLayout()
        what.setSpacing(2)
        group = QButtonGroup(self)
        for button in self.sources.values():
            group.addButton(button)
            what.addWidget(button)
        drawn, kinds = QHBoxLayout(), QButtonGroup(self)
        for button in self.drawn.values():
            kinds.addButton(button)
            drawn.addWidget(button)
        self.drawn["filled"].setChecked(True)
        self.closing.setAccessibleName(tr("Open contours"))
        _make_room_for_sentences(self.counts, self.note)
        self._form.addRow(tr("What"), what)
        self._form.addRow(tr("Format"), self.format)
        self._form.addRow(tr("Regions"), drawn)
        self._form.addRow(tr("Open contours"), self.closing)
        self._form.addRow("", self.counts)
        self._form.addRow(tr("Pixel size"), self.pixel_size)
        self._form.addRow(tr("File"), self.file)
        self._form.addRow("", self.note)
        left = QVBoxLayout()
        left.addLayout(self._form)
        left.addStretch(1)
        left.addWidget(self.buttons)
        layout = QHBoxLayout(self)
        layout.addLayout(left)
        layout.addWidget(self.preview, 1)

    def _fill(self) -> None:
        """Offer what there is, with counts."""
        result, session = self._whole if isinstance(self._whole, Result) else None, self._session
        given = Given(result, session.document, self._selected, session.image)
        for source in SOURCES:
            found, button = source.of(given), self.sources[source.name]
            count = _count(found, source.name)
            button.setText(f"{source.title} ({count})")
            button.setEnabled(count > 0)
        self._form.setRowVisible(0, not isinstance(self._whole, Skeleton))
        usable = [button for button in self.sources.values() if button.isEnabled()]
        (usable or list(self.sources.values()))[0].setChecked(True)

    def _connect(self) -> None:
        for button in (*self.sources.values(), *self.drawn.values()):
            button.clicked.connect(self._follow)
        self.format.activated.connect(lambda _: self._use_format())
        self.file.edited.connect(self._follow_name)
        self.closing.activated.connect(lambda _: self._follow())
        self.pixel_size.edited.connect(self._follow)
        self.buttons.accepted.connect(self.accept)
        self.buttons.rejected.connect(self.reject)
        self._session.listen(Closed, self._show_closed)

    def _use_format(self) -> None:
        self.file.use_suffix(self.format.suffix)
        self._follow_format()

    def _follow_name(self) -> None:
        if self.file.suffix and self.file.suffix != self.format.suffix:
            self.format.choose(self.file.suffix)
            self._follow_format()
        else:
            self._follow()

    def _follow_format(self) -> None:
        """Show what concerns the format."""
        self._form.setRowVisible(2, self.format.suffix in OUTLINABLE and not isinstance(self._whole, Skeleton))
        self._follow()

    def _follow(self) -> None:
        """Show what the present choice writes."""
        order = self.order
        result = self._chosen(order)
        self._offer_closing(result, order)
        order = self.order
        if not order.closing:
            self._show(result, result, order)
            return
        self.counts.setText(tr("Closing contours…"))
        self._enable(tr("Closing contours…"))
        if self._task is not None:
            self._task.cancel()
        image, parameters = self._session.image, self._session.document.parameters
        assert image is not None
        self._task = self._session.tasks.start(
            tr("Closing contours…"),
            lambda task: Closed(self, order, closed(result, order, image, parameters)),
            tr("closing contours"),
            lambda trouble: Closed(self, order, None, trouble),
        )

    def _chosen(self, order: ExportOrder) -> Result | Skeleton:
        return chosen(self._whole, self._session.document, order, self._session.image)

    def _offer_closing(self, result: Result | Skeleton, order: ExportOrder) -> None:
        """Offer to close open contours, where there are any that can be closed."""
        opened = [contour for contour in result.contours if not contour.closed]
        closable = sum(map(can_be_closed, opened)) if isinstance(result, Result) else 0
        self._form.setRowVisible(3, bool(opened) and isinstance(result, Result))
        lost = account(result, result, self.format.suffix, order).left_out
        choices = (
            ("", tr("Leave {count} out").format(count=lost) if lost else tr("Leave them open")),
            ("edges", tr("Close {count} along the edges").format(count=closable)),
            ("straight", tr("Close {count} by straight lines").format(count=closable)),
        )
        present = self.closing.currentData() or ""
        self.closing.clear()
        for closing, text in choices if closable else choices[:1]:
            self.closing.addItem(text, closing)
        self.closing.setCurrentIndex(max(0, self.closing.findData(present)))

    def _show_closed(self, report: Closed) -> None:
        if report.dialog is self and report.order == self.order:
            if report.result is not None:
                self._show(self._chosen(report.order), report.result, report.order)
            else:
                self._enable(report.trouble)

    def _show(self, before: Result | Skeleton, after: Result | Skeleton, order: ExportOrder) -> None:
        counts = account(before, after, self.format.suffix, order)
        masked = counts.left_out > 0
        written = [one for one in after.contours if one.closed or not masked]
        left = [one for one in after.contours if not one.closed and masked]
        bridges = [one.points for one in after.bridges] if isinstance(after, Result) else []
        filled = self.format.suffix in OUTLINABLE and not order.outlines and isinstance(after, Result)
        self.preview.show_export(written, left, bridges, filled)
        self.counts.setText(_words(after, counts, order))
        self._enable(tr("There is nothing to write in this format.") if not counts.written else "")

    def _enable(self, trouble: str) -> None:
        trouble = self.file.trouble or trouble
        self.export_button.setEnabled(not trouble)
        if not trouble and self.file.path.exists():
            trouble = tr("{name} is there already and will be replaced.").format(name=self.file.path.name)
        self.note.setText(trouble)


def _make_room_for_sentences(*labels: QLabel) -> None:
    for label in labels:
        label.setWordWrap(True)
        label.setMinimumSize(_WIDTH, 3 * label.fontMetrics().lineSpacing())
        label.setAlignment(Qt.AlignmentFlag.AlignTop)


def _count(found: Result | None, source: str) -> int:
    """How many objects, or contours, there are to write."""
    contours = found.contours if found is not None else ()
    return len({one.group for one in contours} if source == "objects" else contours)


def _words(result: Result | Skeleton, counts: Account, order: ExportOrder) -> str:
    """What is written, and why not everything is."""
    words = tr("Writes {what}.").format(what=in_words(counts))
    opened = sum(not contour.closed for contour in result.contours) if isinstance(result, Result) else 0
    if counts.left_out and order.closing:
        words += " " + tr("Their ends are too far apart to be closed.")
    elif counts.left_out:
        words += " " + tr("This format holds closed contours only.")
    elif opened:
        words += " " + tr("{count} are open.").format(count=opened)
    return words
