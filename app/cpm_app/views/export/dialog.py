"""Export dialog: what to write, in which formats and under which names, all at once."""

from __future__ import annotations

from collections.abc import Callable, Container, Mapping
from functools import partial
from pathlib import Path

from PySide6.QtCore import QRectF, Qt, Signal
from PySide6.QtWidgets import (
    QCheckBox,
    QComboBox,
    QDialog,
    QFormLayout,
    QHBoxLayout,
    QLabel,
    QLineEdit,
    QPushButton,
    QSpinBox,
    QTreeWidget,
    QTreeWidgetItem,
    QVBoxLayout,
    QWidget,
)

from cpm_app.model.document import objects
from cpm_app.model.document.document import Document
from cpm_app.model.export import (
    EXPORT_TITLES,
    ExportFile,
    ExportKind,
    ExportOrder,
    describe_export,
    export_file_name,
    list_export_formats,
    prepare_export,
    simplify_result,
)
from cpm_app.model.text.language import localize_number, tr
from cpm_app.session.session import Session
from cpm_app.session.storage.preferences import Preferences
from cpm_app.views.export.frames import MAX_FRAME_WIDTH, MIN_FRAME_WIDTH, AnimationPlan, frame_size, sample_steps
from cpm_app.views.widgets.containers import AcceptButtons, create_wrapped_label, fill_layout
from cpm_app.views.widgets.fields import DecimalField
from cpm_app.views.window.dialogs import FileDialogs, ask_to_replace
from cpm_core import Skeleton
from cpm_core.formats import SURFACE_SUFFIXES, count_left_out
from cpm_core.formats.meshes.simplification import MAX_SMOOTHING, Simplification
from cpm_core.image import CONVENTIONS
from cpm_core.numerics.packages import has_package
from cpm_core.numerics.types import frozen
from cpm_core.shapes import select_measures

_EXPORT_KEY_PREFIX = "export/"
"""Start of the preferences of this dialog."""

CHECKED_FORMATS_KEY = _EXPORT_KEY_PREFIX + "formats"
"""Preference: the checked formats, each as kind and suffix."""

DEFAULT_FORMATS = [
    "objects:.table.csv",
    "contours:.svg",
    "surface:.stl",
    "skeleton:.svg",
    "lines:.swc",
    "measures:.csv",
    "pages:.measures.csv",
]
"""Formats that are checked until the user checks others."""

_UNASKED_KINDS: frozenset[ExportKind] = frozenset({"pages", "turntable", "run"})
"""Kinds that hold more than what is shown, or take long: they are not written unasked, but for objects on pages."""

_UNCOUNTED_KINDS = frozenset({"pages", "measures", "space", "turntable", "run"})
"""Kinds that the summary only names, without counting their contents."""

_LIST_WIDTH = 430
"""Smallest width of the list of formats [px]."""

_SPACE_TITLES = {"LPS": tr("Left, back, head (LPS), as in DICOM"), "RAS": tr("Right, front, head (RAS), as in NIfTI")}
"""Titles of the coordinate conventions."""


class FormatList(QTreeWidget):
    """List of what can be written, with a box to check for each format; those checked last are checked.

    Parameters
    ----------
    preferences : Preferences
        Where the checked formats are kept.
    counts : mapping
        Number of items of each kind.
    in_volume, of_dicom : bool
        Whether they are in a volume, and whether the image is from DICOM.
    only : str
        The kind of which alone formats are checked; empty for all.
    unasked : frozenset of str
        Kinds of which no formats are checked at first.
    """

    def __init__(
        self,
        preferences: Preferences,
        counts: Mapping[ExportKind, int],
        in_volume: bool,
        of_dicom: bool = False,
        only: ExportKind | None = None,
        unasked: frozenset[ExportKind] = _UNASKED_KINDS,
    ) -> None:
        super().__init__()
        self._preferences, self._only = preferences, only
        self.setHeaderLabels([tr("What"), tr("File")])
        self.setAccessibleName(tr("What to export"))
        self.rows: dict[tuple[ExportKind, str], QTreeWidgetItem] = {}
        """Rows of the formats by kind and suffix."""
        wanted = [only] if only else list(counts)
        known = [key for key in self._kept_formats if key.partition(":")[0] in wanted]
        checked = known or DEFAULT_FORMATS
        for what, count in counts.items():
            title = EXPORT_TITLES[what][0]
            group = QTreeWidgetItem(self, [f"{title} ({count})" if count > 1 else title])
            group.setExpanded(what == wanted[0])
            for suffix, name in list_export_formats(what, in_volume, of_dicom).items():
                row = self.rows[what, suffix] = QTreeWidgetItem(group, [name])
                row.setCheckState(0, Qt.CheckState.Unchecked)
                if f"{what}:{suffix}" in checked and what in wanted and (only or what not in unasked):
                    row.setCheckState(0, Qt.CheckState.Checked)
                    group.setExpanded(True)
            if what == only:
                self.scrollToItem(group, self.ScrollHint.PositionAtTop)
        self.resizeColumnToContents(0)

    @property
    def checked_formats(self) -> tuple[tuple[ExportKind, str], ...]:
        """Kind and suffix of the checked formats."""
        return tuple(key for key, row in self.rows.items() if row.checkState(0) == Qt.CheckState.Checked)

    def remember_formats(self) -> None:
        """Keep the checked formats for the next time; those that are not in the list stay as they were."""
        rows = {f"{what}:{suffix}" for what, suffix in self.rows if self._only in (None, what)}
        others = [key for key in self._kept_formats if key not in rows]
        self._preferences.store_key(CHECKED_FORMATS_KEY, [*others, *map(":".join, self.checked_formats)])

    @property
    def _kept_formats(self) -> list[str]:
        return self._preferences.read_key(CHECKED_FORMATS_KEY, DEFAULT_FORMATS)


@frozen
class Exportable:
    """What can be exported besides the scene: selected objects and contours, finished pages, and the run.

    Objects are `on_pages` if there are any on several pages.
    `visible_part` returns the part of the image that frames show. Files in `written_paths` have been exported before
    and are replaced without a question.
    """

    objects: frozenset[int]
    contours: frozenset[int]
    page_count: int
    on_pages: bool
    last_step: int
    has_space_view: bool
    visible_part: Callable[[], QRectF]
    written_paths: Container[Path]


class ExportDialog(QDialog):
    """Dialog that lists what can be written and in which formats, with the names of the files."""

    export_requested = Signal(object, object)
    """The user exports: the order, and the settings of the animation of the run."""

    def __init__(
        self,
        parent: QWidget,
        session: Session,
        preferences: Preferences,
        files: FileDialogs,
        exportable: Exportable,
        only: ExportKind | None = None,
    ) -> None:
        super().__init__(parent)
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self._session, self._preferences, self._files, self._exportable = session, preferences, files, exportable
        image, scene = session.image, session.scene
        assert image is not None
        self._image = image
        self._volume = scene.slices is not None
        self._result = getattr(scene.reconstruction, "result", None)
        self.folder = files.find_starting_folder("export")
        unasked = _UNASKED_KINDS - ({"pages"} if exportable.on_pages else set())
        of_dicom = image.hounsfield is not None
        self.list = FormatList(preferences, self._count_items(), self._volume, of_dicom, only, unasked)
        self.list.setMinimumSize(_LIST_WIDTH, parent.height() // 3)
        self.only, self.everywhere = QCheckBox(tr("Selection only")), QCheckBox(tr("in all formats"))
        self.units, self.space = QCheckBox(tr("Physical units ({unit})", unit=image.unit)), QComboBox()
        self.units.setChecked(True)
        self.tolerance, self._vertices, self._size = DecimalField(0.0, 10.0, 0.1, 1, " px"), QLabel(), QLabel()
        self.tolerance.setValue(0.5)
        self.tolerance.setAccessibleName(tr("Simplify"))
        self.rounds = _create_number_field(tr("Rounds of smoothing"), 0, MAX_SMOOTHING, 0)
        self.triangles = _create_number_field(tr("Triangles"), 1, 100, 100, " %")
        self.triangles.setEnabled(has_package("fast_simplification"))
        self.triangles.setToolTip(
            tr("Leaving out triangles needs the package {package}.", package="fast-simplification")
        )
        self.first = _create_number_field(tr("First step"), 0, exportable.last_step, 0)
        self.last = _create_number_field(tr("Last step"), 0, exportable.last_step, exportable.last_step)
        self.stride = _create_number_field(tr("Steps per frame"), 1, max(exportable.last_step, 1), 1)
        self.width_field = _create_number_field(tr("Width"), MIN_FRAME_WIDTH, MAX_FRAME_WIDTH, 640, " px")
        self.speed = _create_number_field(tr("Speed"), 1, 50, 15, tr(" per second"))
        self._kept: dict[str, QWidget] = {
            "everywhere": self.everywhere, "units": self.units, "tolerance": self.tolerance, "every": self.stride,
            "width": self.width_field, "speed": self.speed, "rounds": self.rounds, "triangles": self.triangles,
        }  # fmt: skip
        """Fields whose values are kept for the next export."""
        stem = image.source.partition(".")[0] if self._volume else Path(image.source).stem
        self.base, self._folder_button = QLineEdit(stem), QPushButton()
        self.summary = create_wrapped_label()
        self.summary.setMinimumHeight(2 * self.summary.fontMetrics().lineSpacing())
        self.classes: dict[int, QLineEdit] = {}
        for name, field in self._kept.items():
            setting = field.metaObject().userProperty()
            setting.write(field, preferences.read_key(_EXPORT_KEY_PREFIX + name, setting.read(field)))
        for space in CONVENTIONS:
            self.space.addItem(_SPACE_TITLES[space], space)
        self._lay_out()
        self._on_settings_changed()

    @property
    def checked_files(self) -> tuple[ExportFile, ...]:
        """Files whose formats are checked."""
        return tuple(
            ExportFile(self.folder / self.list.rows[format_].text(1), *format_) for format_ in self.list.checked_formats
        )

    @property
    def export_order(self) -> ExportOrder:
        """Files and settings that the user has selected."""
        only = self.only.isChecked()
        return ExportOrder(
            self.checked_files,
            self._exportable.objects if only else None,
            self._exportable.contours if only else None,
            self.tolerance.value(),
            self.everywhere.isChecked(),
            self.space.currentData(),
            self.units.isChecked(),
            Simplification(self.rounds.value(), self.triangles.value() / 100.0 if self.triangles.isEnabled() else 1.0),
        )

    @property
    def animation_plan(self) -> AnimationPlan:
        """Settings of the animation of the run."""
        return AnimationPlan(
            sample_steps(self.first.value(), max(self.last.value(), self.first.value()), self.stride.value()),
            frame_size(self._exportable.visible_part(), self.width_field.value()),
            self.speed.value(),
        )

    def accept(self) -> None:
        """Name the classes, remember the settings and request the export, after a question about existing files."""
        order, written_before = self.export_order, self._exportable.written_paths
        asked = [file.path.name for file in order.files if file.path.exists() and file.path not in written_before]
        if not order.files or (asked and not ask_to_replace(self, asked[0], len(asked) - 1)):
            return
        named = {number: field.text() for number, field in self.classes.items() if field.text()}
        self._session.edit(tr("name classes"), partial(_name_classes, names=named))
        self.list.remember_formats()
        for name, field in self._kept.items():
            self._preferences.store_key(_EXPORT_KEY_PREFIX + name, field.metaObject().userProperty().read(field))
        self.export_requested.emit(order, self.animation_plan)
        super().accept()

    # Internal

    def _lay_out(self) -> None:
        buttons = AcceptButtons(self, tr("&Export"))
        self.export_button = buttons.accept_button

        def select_folder() -> None:
            folder = self._files.ask_for_folder(tr("Folder of the files"), "export", self)
            if folder:
                self.folder = Path(folder)
                self._on_settings_changed()

        self._folder_button.clicked.connect(select_folder)
        self._form = form = QFormLayout()
        found = self._session.document.objects
        for category in sorted({item.category for item in found.items if not item.hidden}):
            field = self.classes[category] = QLineEdit(found.classes[category - 1].name)
            field.setPlaceholderText(tr("Name of the class"))
            field.setAccessibleName(tr("Class {number}", number=category))
            form.addRow(field.accessibleName(), field)
        self._thin = _create_row(self.tolerance, self.everywhere, self._vertices)
        self._smooth = _create_row(
            QLabel(self.rounds.accessibleName()), self.rounds, QLabel(self.triangles.accessibleName()), self.triangles
        )
        self._steps = _create_row(self.first, QLabel(tr("to")), self.last, QLabel(tr("every")), self.stride)
        self._frames = _create_row(self.width_field, self.speed)
        for title, part in (
            ("", self.only),
            (tr("Simplify"), self._thin),
            (tr("Surface"), self._smooth),
            ("", self.units),
            (tr("Coordinates"), self.space),
            (tr("Steps"), self._steps),
            (tr("Frames"), self._frames),
            ("", self._size),
            (tr("Name"), self.base),
            (tr("Folder"), self._folder_button),
            ("", self.summary),
        ):
            form.addRow(title, part)
            part.setAccessibleName(title)
        for changed in (
            *(box.toggled for box in (self.only, self.everywhere, self.units)),
            *(field.valueChanged for field in (self.first, self.last, self.stride, self.width_field, self.speed)),
            self.tolerance.valueChanged,
            self.base.textChanged,
            self.list.itemChanged,
        ):
            changed.connect(self._on_settings_changed)
        layout = QVBoxLayout(self)
        layout.addWidget(self.list, 1)
        layout.addLayout(form)
        layout.addWidget(buttons)
        self.export_button.setDefault(
            True
        )  # only once it is in the dialog; earlier, Tab would make another button the default

    def _count_items(self) -> dict[ExportKind, int]:
        """Count the items of each kind that can be exported."""
        scene, exportable = self._session.scene, self._exportable
        counts: dict[ExportKind, int] = {"objects": sum(not item.hidden for item in scene.document.objects.items)}
        if isinstance(self._result, Skeleton):
            counts["lines" if self._volume else "skeleton"] = 1
        elif self._result is not None and self._result.surface is not None:
            counts["surface"] = 1
        elif self._result is not None and not self._volume:
            counts["contours"] = len(self._result.contours)
        counts |= {
            "pages": exportable.page_count,
            "measures": len(select_measures(scene.document.shapes)),
            "space": exportable.has_space_view,
            "turntable": exportable.has_space_view,
            "run": exportable.last_step > 0,
        }
        return {what: count for what, count in counts.items() if count}

    def _on_settings_changed(self, *_: object) -> None:
        """Show the names of the files, the fields that matter for the selection, and the summary."""
        base, first = self.base.text().strip(), next(iter(self.list.rows), ("", ""))[0]
        self.list.blockSignals(True)
        for (what, suffix), row in self.list.rows.items():
            row.setText(1, export_file_name(base, what, suffix, what == first))
            row.setToolTip(1, row.text(1))
        self.list.blockSignals(False)
        folder = str(self.folder)
        self._folder_button.setText(
            self.fontMetrics().elidedText(folder, Qt.TextElideMode.ElideMiddle, _LIST_WIDTH - 60)
        )
        self._folder_button.setToolTip(folder)
        order = self.export_order
        whats = {file.kind for file in order.files}
        suffixes = {file.suffix for file in order.files if file.kind in ("objects", "contours", "surface", "lines")}
        drawn = bool(whats & {"objects", "contours"}) and not self._volume
        show = self._form.setRowVisible
        for field in self.classes.values():
            show(field, "objects" in whats)
        show(self.only, bool(self._exportable.objects or self._exportable.contours))
        show(self._thin, drawn)
        show(self._smooth, bool(suffixes & SURFACE_SUFFIXES) and self._volume)
        show(self.units, bool(self._image.unit))
        show(self.space, self._image.geometry is not None and bool(suffixes & SURFACE_SUFFIXES) and self._volume)
        for part in (self._steps, self._frames, self._size):
            show(part, "run" in whats)
        self.setWindowTitle(EXPORT_TITLES[next(iter(whats))][1] if len(whats) == 1 else tr("Export"))
        self._show_summary(order)

    def _show_summary(self, order: ExportOrder) -> None:
        """Describe what will be written."""
        document, parts, vertices = self._session.document, list[str](), [0, 0]
        problem = "" if order.files else tr("Choose what to export.")
        for what in dict.fromkeys(file.kind for file in order.files):
            suffixes = [file.suffix for file in order.files if file.kind == what]
            if what in _UNCOUNTED_KINDS:
                parts.append(EXPORT_TITLES[what][0])
                continue
            result = prepare_export(self._result, document, order, what, self._image)
            text = describe_export(result, what, suffixes[0])
            parts.append(tr("{contents} of this page", contents=text) if self._exportable.page_count else text)
            if not self._volume and all(count_left_out(result, suffix) == len(result.contours) for suffix in suffixes):
                problem = tr("Nothing can be exported: {what}.", what=parts[-1])
            vertices[0] += sum(len(contour.points) for contour in result.contours)
            if any(map(order.should_simplify, suffixes)) and not self._volume:
                vertices[1] += sum(len(contour.points) for contour in simplify_result(result, order).contours)
        few, many = (localize_number(f"{count:,}") for count in reversed(vertices))
        self._vertices.setText(tr("{few} of {many} vertices", few=few, many=many) if vertices[1] else "")
        plan = self.animation_plan
        steps, (width, height) = len(plan.steps), plan.size
        self._size.setText(tr("{count} frames of {width} × {height} px", count=steps, width=width, height=height))
        if not self.base.text().strip():
            problem = tr("Name the files.")
        count = tr("1 file") if len(order.files) == 1 else tr("{count} files", count=len(order.files))
        self.summary.setText(problem or tr("{files}: {contents}.", files=count, contents=", ".join(parts)))
        self.export_button.setEnabled(not problem)
        self.resize(self.size().expandedTo(self.sizeHint()))


def _name_classes(document: Document, names: dict[int, str]) -> Document:
    for number, name in names.items():
        document = objects.name_class(document, number, name)
    return document


def _create_row(*parts: QWidget) -> QWidget:
    row = QWidget()
    fill_layout(QHBoxLayout(row), *parts)
    return row


def _create_number_field(title: str, low: int, high: int, value: int, suffix: str = "") -> QSpinBox:
    field = QSpinBox()
    field.setAccessibleName(title)
    field.setRange(low, high)
    field.setSuffix(suffix)
    field.setValue(value)
    return field
