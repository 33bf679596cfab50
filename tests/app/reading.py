"""What tests read from the window, and how they call its work saved."""

from __future__ import annotations

import numpy as np
from cpm_app.session.features.timeline_navigation import TimelineNavigation
from cpm_app.session.storage.session_file import DocumentFile
from cpm_app.views.features.files import OpenSaveFeature
from cpm_app.views.features.run import TimelineFeature
from cpm_app.views.layers.contours import ContourLayer
from cpm_app.views.layers.fields import FieldLayer
from cpm_app.views.panels.tables import SortableTable
from cpm_app.views.window.window import MainWindow

from cpm_core.objects.segmented import SegmentedObject
from cpm_core.shapes import Shape


def column_texts(table: SortableTable, name: str) -> list[str]:
    """The texts of a column, from top to bottom."""
    number = table.column_index(name)
    return [str(table.rows.index(row, number).data()) for row in range(len(table.rows.items))]


def treat_as_saved(window: MainWindow) -> None:
    """Let document and runs count as saved."""
    window.document_file.saved_document = window.session.document
    window.document_file.runs.mark_saved(window.session.scene.timeline.edition)


def contour_counts(layer: ContourLayer) -> tuple[int, int]:
    """How many contours of a layer are closed, and how many open."""
    closed = sum(contour.closed for contour in layer.scene.contours)
    return closed, len(layer.scene.contours) - closed


def image_name(window: MainWindow) -> str:
    """The name of the open image."""
    return window.session.document.image.name


def document_file(window: MainWindow) -> DocumentFile:
    """The session file of the window."""
    return window.get_feature(OpenSaveFeature).document_file


def navigation(window: MainWindow) -> TimelineNavigation:
    """What goes along the timeline."""
    return window.get_feature(TimelineFeature).navigation


def accepted_items(window: MainWindow) -> tuple[SegmentedObject, ...]:
    """The accepted objects."""
    return window.session.document.objects.items


def only_shape(window: MainWindow) -> Shape:
    """The shape that alone is drawn."""
    (shape,) = window.session.document.shapes
    return shape


def shown_message(window: MainWindow) -> str:
    """What the line of messages says."""
    return window.canvas_area.messages.text


def arrow_ends(layer: FieldLayer) -> np.ndarray:
    """Ends of the segments of the arrows of a field (row, col), shape (N, 2)."""
    x, y = layer.arrows.getData()
    return np.empty((0, 2)) if x is None else np.stack([y, x], axis=1)
