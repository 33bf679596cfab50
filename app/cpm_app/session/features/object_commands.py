"""Commands on objects and proposals: accepting, rejecting and editing the selected ones."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Sequence
from functools import partial, reduce
from typing import Literal, TypeVar

from PySide6.QtCore import QObject

from cpm_app.model.document import objects
from cpm_app.model.document.document import Document
from cpm_app.model.document.objects import paint_volume_object
from cpm_app.model.text.keys import insert_keys
from cpm_app.model.text.language import localize_number, tr
from cpm_app.session.features.background import LatestOnlyWorker
from cpm_app.session.features.contour_selection import ContourSelection
from cpm_app.session.features.object_list import ObjectList
from cpm_app.session.features.object_rows import DRAFT_KEY, ItemKey, ObjectRow
from cpm_app.session.session import Session
from cpm_app.session.session_messages import EDITING_CATEGORY
from cpm_core.image.region import Region
from cpm_core.numerics import Place
from cpm_core.objects.segmented import (
    Halves,
    SegmentedObject,
    fill_between_slices,
    split_painted_object,
    unite_objects,
)
from cpm_core.results.found_objects import MIN_LIKELY_CONFIDENCE
from cpm_core.shapes import relative_sides

Made = TypeVar("Made")

ObjectState = Literal["frozen", "hidden"]
"""A state that is switched on and off."""


def describe_doubtful(count: int) -> str:
    """Describe what to do with a number of proposals all of which are doubtful."""
    least = localize_number(f"{100.0 * MIN_LIKELY_CONFIDENCE:.0f} %")
    words = tr(
        "Doubtful (below {least}): {count}. Click or {key:all_objects}, then Enter: accept · {key:reject}: reject"
    )
    return insert_keys(words, least=least, count=count)


class ObjectCommands(QObject):
    """Accepts, rejects and edits the selected objects and proposals, and accepts contours of the run as objects."""

    def __init__(self, session: Session, contour_selection: ContourSelection, object_list: ObjectList) -> None:
        super().__init__(session)
        self._session, self._contour_selection, self._list = session, contour_selection, object_list
        self._merging = LatestOnlyWorker(session, "cpm-merging", tr("merging objects"))
        session.image_changed.connect(self._merging.drop_waiting)

    # Accepting and rejecting

    @property
    def can_accept(self) -> bool:
        """Whether there is anything that Enter accepts."""
        return bool(self._list.pending_rows or self._contour_selection.selected_indices)

    def accept_pending(self) -> None:
        """Make objects of proposals, see `ObjectList.rows_to_accept`, and of the selected contours of the run.

        A closed contour becomes an object with its holes, an open one an open object.
        """
        offered, rows = self._list.pending_rows, self._list.rows_to_accept
        result, indices = self._session.scene.result, self._contour_selection.selected_indices
        copied = []
        if result is not None and indices and not self._list.objects.clicks:
            copied = objects.copy_contours_to_objects(self._list.objects, result, indices)
        if not rows and not copied:
            nothing = tr("There is nothing to accept: click in an object first.")
            words = describe_doubtful(len(offered)) if offered else nothing
            self._session.messages.show(words, category=EDITING_CATEGORY)
            return
        self._accept_rows(tr("accept {what}"), rows, copied=copied)
        self._session.end_gesture()
        if len(rows) < len(offered):
            self._list.select_objects(())  # else rejecting would be for what has just been accepted
            self._session.messages.show(describe_doubtful(len(offered) - len(rows)), category=EDITING_CATEGORY)

    def reject_selected(self) -> None:
        """Dismiss the selected proposals and remove the selected objects, none of which is proposed again.

        Without a selection, all proposals are dismissed, with a message. While an object is being selected or
        corrected, that is dropped, and an accepted one stays as it was.
        """
        selected = () if self._list.objects.clicks else self._list.selected_rows
        rows = selected or tuple(self._list.pending_rows)
        if self._has_frozen(rows):
            return
        count = self._remove_rows(tr("reject {what}"), rows, objects.reject_objects)
        if count and not selected:
            words = insert_keys(tr("Rejected proposals: {count}. {key:undo} brings them back."), count=count)
            self._session.messages.show(words, category=EDITING_CATEGORY)

    def delete_selected(self) -> None:
        """Remove the selected objects, and dismiss the selected proposals."""
        rows = self._list.selected_rows
        if self._has_frozen(rows):
            return
        if not any(row.kind == "object" for row in rows):
            self.reject_selected()
            return

        def delete(document: Document, numbers: Iterable[int], offered: Iterable[SegmentedObject]) -> Document:
            # another run may propose again what was accepted
            return objects.reject_objects(objects.delete_objects(document, numbers), (), offered)

        self._remove_rows(tr("delete {what}"), rows, delete)

    def toggle_overlap(self) -> None:
        """Toggle whether what is selected or painted may run over other objects."""
        overlaps = not self._list.objects.may_overlap
        words = tr("objects may overlap") if overlaps else tr("objects may not overlap")
        self._session.edit(words, lambda document: objects.set_overlap(document, overlaps))

    # Editing

    def rename_row(self, key: ItemKey, name: str) -> None:
        """Name a row, unless it has disappeared meanwhile; a proposal is accepted."""
        rows = [row for row in self._list.rows if row.key == key and row.item.name != name.strip()]
        self._accept_rows(tr("name {what}"), rows, lambda d, numbers: objects.rename_objects(d, numbers, name))

    def classify_selected(self, category: int) -> None:
        """Set the class of the selected objects and of new ones; proposals are accepted.

        Without a selection, the object being selected is accepted.
        """
        known, rows = self._list.objects, list(self._list.selected_rows)
        if not rows and known.clicks:
            rows = self._list.pending_rows
        used = {item.category for item in known.items}
        words = tr("class of {what}") if rows else tr("class of the next objects")
        self._accept_rows(words, rows, lambda document, numbers: objects.classify_objects(document, numbers, category))
        if rows and category not in used and used - {category} and not known.classes[category - 1].name:
            words = tr("Class {number} is new; the tab Objects has a field for its name.", number=category)
            self._session.messages.show(words, category=EDITING_CATEGORY)

    def name_class(self, category: int, name: str, color: str = "") -> None:
        """Name a class, and change its color unless that is empty."""
        self._session.edit(tr("name class"), lambda document: objects.name_class(document, category, name, color))

    def color_selected(self, color: str) -> None:
        """Color the selected objects; an empty color restores the color of their class."""
        self.edit_selected(
            tr("color {what}"), lambda document, numbers: objects.update_objects(document, numbers, color=color)
        )

    def toggle_state(self, state: ObjectState, key: ItemKey | None = None) -> None:
        """Freeze or hide the selected objects, or unfreeze or show them if all of them are frozen or hidden.

        With the key of a row that is not selected, only its object.
        """
        rows = [row for row in self._list.selected_rows if row.kind == "object"]
        if key is not None and key not in {row.key for row in rows}:
            rows = [row for row in self._list.rows if row.key == key and row.kind == "object"]
        on = not all(getattr(row.item, state) for row in rows)
        numbers = [row.key[1] for row in rows]
        words = {
            "hidden": (tr("show {what}"), tr("hide {what}")),
            "frozen": (tr("unfreeze {what}"), tr("freeze {what}")),
        }
        self._edit_rows(words[state][on], rows, lambda d: objects.update_objects(d, numbers, **{state: on}))

    def fade_selected(self, opacity: float) -> None:
        """Set the opacity of the selected objects; in one undo step until others are selected."""
        self.edit_selected(
            tr("opacity of {what}"),
            lambda document, numbers: objects.update_objects(document, numbers, opacity=opacity),
            f"opacity {sorted(self._list.selected_numbers)}",
        )

    def edit_selected(
        self, undo_text: str, edit: Callable[[Document, Collection[int]], Document], gesture: str = ""
    ) -> None:
        """Edit the selected objects; `undo_text` names the edit of ``{what}`` for undo."""
        rows = [row for row in self._list.selected_rows if row.kind == "object"]
        numbers = [row.key[1] for row in rows]
        self._edit_rows(undo_text, rows, lambda document: edit(document, numbers), gesture=gesture)

    def merge_selected(self) -> None:
        """Merge the selected objects and proposals with an area into one; in a volume on another thread."""
        rows = [row for row in self._list.selected_rows if not row.item.line]
        if not self._session.document.has_volume:
            if len(rows) > 1:
                self._accept_rows(tr("merge {what}"), rows, objects.merge_objects)
            return
        items, rows = self._list.selected_objects, [row for row in rows if row.kind == "object"]

        def replace_by_union(whole: SegmentedObject) -> None:
            self._edit_rows(tr("merge {what}"), rows, lambda document: objects.merge_into(document, items, whole))
            self._list.select_objects((whole.number,))

        if len(items) > 1:
            self._change_in_background(items, lambda: reduce(unite_objects, items), replace_by_union)

    def fill_between_slices(self) -> None:
        """Fill the slices across the axis in use between those in which the selected object is painted."""
        slices, image, items = self._session.scene.slices, self._session.document.image, self._list.selected_objects
        if slices is None or image is None or len(items) != 1:
            return
        (item,), axis = items, slices.axis
        name = self._list.title_of(item)

        def add_part(found: tuple[Region, int]) -> None:
            part, count = found
            if not count:
                self._session.messages.show(tr("{name} has no gap between the slices across this axis.", name=name))
                return
            words = tr("fill {what} between slices", what=name)
            self._session.edit(words, partial(paint_volume_object, number=item.number, part=part))
            self._session.messages.show(tr("Slices of {name} that were filled: {count}.", name=name, count=count))

        self._change_in_background(items, lambda: fill_between_slices(item.region, axis, image.spacing), add_part)

    def split_object_in_volume(self, whole: SegmentedObject, first: Place, second: Place) -> None:
        """Split an object of a volume between two places, on another thread; discarded if it has changed meanwhile."""
        image = self._session.document.image
        if image is not None:
            sides, items = relative_sides(image.spacing), [one for one in self._list.objects.items if one is whole]
            cut: Callable[[], Halves] = lambda: split_painted_object(whole, first, second, sides)  # noqa: E731
            self._change_in_background(items, cut, partial(self.split_object, whole))

    def split_object(self, whole: SegmentedObject, halves: Halves) -> None:
        """Replace an object, or one that is not accepted yet, by its halves, and select them."""
        before = {item.number for item in self._list.objects.items} - {whole.number}
        words = tr("split {what}", what=self._list.title_of(whole))
        self._session.edit(words, lambda document: objects.replace_by_halves(document, whole, halves))
        self._list.select_objects(item.number for item in self._list.objects.items if item.number not in before)

    # Internal

    def _has_frozen(self, rows: Sequence[ObjectRow]) -> bool:
        """Tell whether frozen objects are among rows that are to go, and show a message about the first of them."""
        frozen = next((row for row in rows if row.kind == "object" and row.item.frozen), None)
        if frozen is not None:
            words = tr("{name} is frozen: unfreeze it to remove it.", name=frozen.title)
            self._session.messages.show(words, category=EDITING_CATEGORY)
        return frozen is not None

    def _accept_rows(
        self,
        undo_text: str,
        rows: Sequence[ObjectRow],
        edit_accepted: Callable[[Document, Collection[int]], Document] = lambda document, _: document,
        copied: Sequence[SegmentedObject] = (),
    ) -> None:
        """Make objects of rows and of `copied` contours, and then edit the objects with the numbers of all of them."""
        given = [*(row.item for row in rows if row.kind == "proposal"), *copied]
        ends = any(row.key == DRAFT_KEY for row in rows)
        old = {row.key[1] for row in rows if row.kind == "object"}
        numbers: list[int] = []

        def accept_and_edit(document: Document) -> Document:
            before = {item.number for item in document.objects.items}
            document = objects.accept_objects(document, given, ends=ends)
            changed = old | {item.number for item in given}
            numbers[:] = [n.number for n in document.objects.items if n.number in changed or n.number not in before]
            return edit_accepted(document, numbers)

        with self._session.store.draw_once():
            self._edit_rows(undo_text, rows, accept_and_edit, len(copied))
            if given:
                self._list.select_objects(item.number for item in self._list.objects.items if item.number in numbers)

    def _remove_rows(
        self,
        undo_text: str,
        rows: Sequence[ObjectRow],
        remove: Callable[[Document, Iterable[int], Iterable[SegmentedObject]], Document],
    ) -> int:
        """Drop the draft if it is among the rows, and `remove` the objects and proposals; return how many of these."""
        draft = any(row.key == DRAFT_KEY for row in rows)
        offered = [row.item for row in rows if row.kind == "proposal" and row.key != DRAFT_KEY]
        numbers = [row.key[1] for row in rows if row.kind == "object"]

        def edit(document: Document) -> Document:
            # the draft is not kept as a rejected object: the user selected it, and may select it again
            return remove(objects.set_selection_clicks(document, ()) if draft else document, numbers, offered)

        self._edit_rows(undo_text, rows, edit)
        return len(offered)

    def _edit_rows(
        self,
        undo_text: str,
        rows: Sequence[ObjectRow],
        edit: Callable[[Document], Document],
        contours: int = 0,
        gesture: str = "",
    ) -> None:
        """Edit the document, as an undo step that names the edited rows and the number of accepted contours."""
        count = len(rows) + contours
        several = tr("{count} objects") if rows else tr("{count} contours")
        what = several.format(count=count)
        if count == 1:
            what = rows[0].title if rows else tr("contour")
        if count or "{what}" not in undo_text:
            self._session.edit(undo_text.format(what=what), edit, gesture)

    def _change_in_background(
        self, items: Sequence[SegmentedObject], compute: Callable[[], Made], on_result: Callable[[Made], object]
    ) -> None:
        """Change objects by a result of another thread, unless they have changed meanwhile."""

        def use_if_unchanged(made: Made) -> None:
            if all(any(known is item for known in self._list.objects.items) for item in items):
                on_result(made)
            else:
                self._session.messages.show(tr("The objects changed meanwhile: try again."), True)

        self._merging.submit(compute, use_if_unchanged)
