"""The drawing tools, and the initializations that need no drawing."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

from app.model.document import edits
from app.model.state.situation import Condition, has_image
from app.model.text.language import from_core, tr
from app.views.canvas.canvas_area import FIRST_TOOL
from app.views.canvas.tools import TOOLS
from app.views.widgets.action_spec import STATE, ActionSpec
from app.views.window.feature import Feature
from cpm_core.shapes import Everywhere, Kind

_STARTS: tuple[tuple[Kind, str, str, str], ...] = (
    ("grid", tr("Start everywhere (&grid)"), "Ctrl+G",
     tr("Start on a grid over the whole image; choose again to remove it.")),
    ("gradient", tr("Start on strong &edges"), "Ctrl+Shift+G",
     tr("Start where the gradient is large; choose again to remove it.")),
    ("centers", tr("Start at ce&nters"), "Ctrl+Shift+C",
     tr("Start at the centers of regions enclosed by edges; choose again to remove it.")),
)  # fmt: skip


class DrawFeature(Feature):
    """Tools for the initialization, regions, barriers and charges."""

    def action_specs(self) -> Sequence[ActionSpec]:
        """Tools, automatic initializations, and drawing by keys."""
        return (*self._tools(), *self._starts(), *self._by_keys())

    def _tools(self) -> Sequence[ActionSpec]:
        return [
            ActionSpec(name=tool.name, menu="Draw", text=tool.text,
                       do=partial(self.context.canvas_area.use_tool, tool.name),
                       shortcuts=(tool.shortcut,) if tool.shortcut else (), tip=tool.tip, icon=tool.name, group="tool",
                       checked=tool.name == FIRST_TOOL, gap=index > 0 and tool.group != TOOLS[index - 1].group,
                       when=has_image)
            for index, tool in enumerate(TOOLS)
        ]  # fmt: skip

    def _starts(self) -> Sequence[ActionSpec]:
        return [
            ActionSpec(name=f"start_{kind}", menu="Draw", text=text, do=partial(self._toggle, Everywhere(kind)),
                       shortcuts=(keys,), tip=tip, icon=kind, group=STATE, gap=index == 0, when=has_image,
                       holds=_starts_with(Everywhere(kind)))
            for index, (kind, text, keys, tip) in enumerate(_STARTS)
        ]  # fmt: skip

    def _by_keys(self) -> Sequence[ActionSpec]:
        middle = ActionSpec(name="add_circle", menu="Draw", text=tr("Add circle in the &middle"),
                            do=self.context.canvas_area.add_circle, shortcuts=("Ctrl+K",),
                            tip=tr("Add a circle in the middle of the visible part."), gap=True,
                            when=has_image)  # fmt: skip
        keyed = ActionSpec(
            name="cross_hair",
            menu="Draw",
            text=tr("Draw by &keys"),
            do=self.context.canvas_area.crosshair.toggle,
            tip=tr("Draw with the current tool by a cross-hair that arrow keys move; or press Enter on the image."),
            when=has_image,
        )
        return middle, keyed

    def _toggle(self, start: Everywhere) -> None:
        session = self.context.session
        name = from_core(start.title)
        if start in session.document.shapes:
            name = tr("remove {start}").format(start=name)
        session.edit(name, lambda document: edits.toggle_everywhere(document, start.kind))
        # The action must show the state of the document even if it has not changed.
        self.context.refresh()


def _starts_with(start: Everywhere) -> Condition:
    return lambda situation: start in situation.document.shapes
