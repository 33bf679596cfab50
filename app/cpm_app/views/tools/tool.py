"""The base classes of tools, with which the pointer edits the drawing."""

from __future__ import annotations

import itertools
import math
from typing import Literal

from PySide6.QtCore import Qt
from PySide6.QtGui import QCursor

from cpm_app.model.document import edits
from cpm_app.model.document.document import ImageReference
from cpm_app.model.state.situation import TEXTS_IN_VOLUMES
from cpm_app.model.text.language import tr, translate_core_text
from cpm_app.model.volume.slices import Slice
from cpm_app.session.features.workspace import Workspace
from cpm_app.session.session import Session
from cpm_app.session.session_messages import EDITING_CATEGORY
from cpm_app.views.layers.drawing import DrawingLayer
from cpm_core.numerics import Place
from cpm_core.numerics.types import Callback
from cpm_core.shapes import Shape, relative_sides

Cursor = Qt.CursorShape

REMOVE_MODIFIER = Qt.KeyboardModifier.ShiftModifier
"""Key with which a click cuts or removes; window managers on Linux reserve clicks with Alt."""

_MIN_STROKE_MOVE = 0.25
"""Minimum distance between two places of a stroke [tolerances for hits]."""

MIN_DRAWN_AREA = 4.0
"""Area below which a closed path is taken for an accident [px²]."""

_gestures = itertools.count()


def draw_shape(session: Session, shape: Shape) -> None:
    """Add a shape to the document and select it."""
    name = tr("draw {shape}", shape=translate_core_text(shape.title))
    session.edit(name, lambda document: edits.add_shape(document, shape))
    session.select_shape(len(session.document.shapes) - 1)


class Tool:
    """Base class of tools; positions are (row, col) in px of the image, or (plane, row, col) in a volume.

    By default a gesture lasts while the button is down, and the tool has no size and no draft. `drawing` shows drafts
    and rings; `advised` is called when the advice of the tool may have changed.
    """

    name: str
    """Name in code, and name of its icon."""
    menu_text: str
    """Text in the menu."""
    short: str = ""
    """Text of its button; empty for that in the menu."""
    shortcut: str
    """Key that selects the tool."""
    panel: Literal["objects", "run", "measures"] = "run"
    """The tab of the right column that belongs to it."""
    tip: str = ""
    """Sentence on what the tool does."""
    guidance: str = ""
    """Advice until the tool has been used, and as long as nothing is drawn."""
    keyboard_tip: str
    """Sentence on what Enter does at the cross-hair."""
    works_by_clicks = False
    """Whether Enter is a click; otherwise Enter presses the button, and the next Enter releases it."""
    is_resizable = False
    """Whether the tool has a size."""
    keeps_draft = False
    """Whether the draft stays while another tool is used."""
    current_slice: Slice | None = None
    """Slice under the pointer; None in an image."""
    modifiers = Qt.KeyboardModifier.NoModifier
    """Modifier keys that are held; they may constrain the shape."""
    reach = 1.0
    """Tolerance for hits [px of the image]."""
    stroke_spacing = 1.0
    """Minimum distance between two places of a stroke [px of the image]."""
    drag_distance = 1.0
    """Distance from the press from which a click is a drag [tolerances for hits]."""

    def __init__(self, workspace: Workspace, drawing: DrawingLayer, advised: Callback) -> None:
        self._workspace, self._drawing, self._on_advice_changed = workspace, drawing, advised
        self._session = workspace.session
        self.used = False
        self.pointer: Place | None = None
        """Place of the pointer; None when it has left."""
        self.stroke: list[Place] = []
        """Places of the pointer since the button was pressed; empty while it is up."""
        self.is_dragged = False
        """Whether the pointer has left the place where the button was pressed."""
        self.set_up()

    def set_up(self) -> None:
        """Initialize the state kept between events."""

    @property
    def volume(self) -> ImageReference | None:
        """Volume that is open; None for an image."""
        image = self._session.document.image
        return image if image is not None and image.is_volume else None

    def position_in_slice(self, place: Place) -> Place:
        """Return a place as (row, col) in the view under the pointer."""
        return place if self.current_slice is None or len(place) == 2 else self.current_slice.drop_axis(place)

    def place_in_image(self, position: Place) -> Place:
        """Return the place in the image or in the volume of (row, col) in the view under the pointer."""
        return position if self.current_slice is None else self.current_slice.lift_position(position)

    def is_in_image(self, place: Place) -> bool:
        """Tell whether a place lies in the image or the volume, and not in the margin around it."""
        image = self._session.document.image
        return image is not None and all(-0.5 <= at <= side - 0.5 for at, side in zip(place, image.shape, strict=True))

    @property
    def pixel_sides(self) -> tuple[float, float]:
        """Height and width of a pixel in the view under the pointer [smallest side of a voxel]."""
        if self.current_slice is None or self.volume is None:
            return 1.0, 1.0
        down, right = self.current_slice.drop_axis(relative_sides(self.volume.spacing))
        return down, right

    @property
    def has_draft(self) -> bool:
        """Whether the tool has an unfinished draft while the button is up."""
        return False

    @property
    def usage(self) -> str:
        """Sentence on what the tool does, which in a volume may be another one."""
        return self.tip if self.volume is None else TEXTS_IN_VOLUMES.get(self.name, ("", self.tip))[1]

    @property
    def advice(self) -> str:
        """Sentence on what to do next, or empty."""
        return "" if self.used and self._session.document.shapes else self.guidance

    def press(self, at: Place) -> None:
        """Press the left button."""
        self.pointer, self.stroke, self.is_dragged, self.used = at, [at], False, True
        self.on_press(at)
        self.update_marks()

    def drag(self, at: Place) -> None:
        """Move with the button down, unless the gesture was canceled."""
        if self.stroke:
            self.pointer = at
            self.is_dragged = self.is_dragged or math.dist(self.stroke[0], at) > self.drag_distance * self.reach
            if math.dist(self.stroke[-1], at) >= max(self.stroke_spacing, _MIN_STROKE_MOVE * self.reach):
                self.stroke.append(at)
            self.on_drag(at)
            self.update_marks()

    def release(self) -> None:
        """Release the button."""
        if self.stroke:
            self.on_release()
        self._end_stroke()

    def hover(self, at: Place) -> None:
        """Move with the button up."""
        self.pointer = at
        self.on_hover(at)
        self.update_marks()

    @property
    def has_new_place(self) -> bool:
        """Whether the last move has extended the stroke."""
        return bool(self.stroke) and self.stroke[-1] is self.pointer

    def on_press(self, at: Place) -> None:
        """Handle a press of the left button."""

    def on_drag(self, at: Place) -> None:
        """Handle a move with the button down."""

    def on_release(self) -> None:
        """Handle the release of the button at the end of a stroke."""

    def on_hover(self, at: Place) -> None:
        """Handle a move with the button up."""

    def update_marks(self) -> None:
        """Draw the marks again, and give the advice that belongs to them."""
        self.draw_marks()
        self._on_advice_changed()

    def draw_marks(self) -> None:
        """Draw the draft, the ring or the preview of the tool, or hide them; called after each event."""

    def resize_by(self, by: float) -> None:
        """Enlarge the tool; negative values of `by` make it smaller."""

    def finish(self) -> None:
        """Finish the draft."""

    def remove_last_part(self) -> None:
        """Remove the last part of the draft."""

    def cancel(self) -> None:
        """Undo the gesture."""
        self._end_stroke()

    def set_in_use(self, in_use: bool) -> None:
        """Prepare for use, or end it."""

    def hide_marks(self) -> None:
        """Hide the marks of the tool when the pointer has left or another tool is used."""
        self.pointer = None
        self.update_marks()

    def _end_stroke(self) -> None:
        self.stroke, self.is_dragged = [], False
        self.update_marks()

    def show_message(self, text: str) -> None:
        """Tell the user why nothing was done."""
        self._session.messages.show(text, category=EDITING_CATEGORY)

    def cursor_at(self, at: Place) -> Cursor | QCursor:
        """Return the cursor over a position."""
        return Cursor.CrossCursor

    def has_handle_at(self, at: Place) -> bool:
        """Tell whether a handle of the selected shape lies at a position, so that a press there goes to this tool."""
        return False


class ShapeTool(Tool):
    """Base class of tools whose gesture adds or changes one shape of the document, as one step of undo."""

    keyboard_tip = tr("Enter picks up, arrow keys move, Enter puts down.")

    def set_up(self) -> None:
        """Initialize the state kept between events."""
        self._index: int | None = None
        self._before: Shape | None = None
        self._gesture = ""

    def on_release(self) -> None:
        """Keep the shape as it is."""
        self._end_gesture()

    def cancel(self) -> None:
        """Restore the shape, or delete it when the gesture has added it."""
        index = self._index
        if self._before is not None:
            self._put_shape(tr("move"), self._before)
        elif index is not None and self._drawn_shape is not None:
            self._session.edit("", lambda document: edits.delete_shape(document, index), self._gesture)
        self._end_gesture()
        super().cancel()

    @property
    def _drawn_shape(self) -> Shape | None:
        """Shape of the gesture; None while the document does not contain it."""
        shapes = self._session.document.shapes
        return shapes[self._index] if self._index is not None and self._index < len(shapes) else None

    def _begin_gesture(self, index: int | None = None) -> None:
        """Begin a gesture on a shape of the document, by default on a new one."""
        shapes = self._session.document.shapes
        self._index = len(shapes) if index is None else index
        self._before = None if index is None else shapes[index]
        self._gesture = f"{self.name} {next(_gestures)}"

    def _end_gesture(self) -> None:
        self._index = self._before = None
        self._session.end_gesture()

    def _put_shape(self, activity: str, shape: Shape) -> None:
        """Add the shape of the gesture to the document, or replace it there; the activity may name it."""
        index, activity = self._index, activity.format(shape=translate_core_text(shape.title))
        if index is not None and self._drawn_shape is not None:
            self._session.edit(activity, lambda document: edits.replace_shape(document, index, shape), self._gesture)
        elif index is not None and self._before is None:
            self._session.edit(activity, lambda document: edits.add_shape(document, shape), self._gesture)
