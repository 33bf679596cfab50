"""The modes: shape recovery, automatic segmentation, skeleton."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

from app.model.document.document import Mode
from app.model.document.modes import MODES, use_mode
from app.model.state.situation import Condition
from app.model.text.language import tr
from app.views.widgets.action_spec import STATE, ActionSpec
from app.views.window.feature import Feature

_KEYS = {"shape": "Ctrl+F1", "automatic": "Ctrl+F2", "skeleton": "Ctrl+F3"}


class ModesFeature(Feature):
    """The choice of the mode."""

    def action_specs(self) -> Sequence[ActionSpec]:
        """One mode each."""
        return [
            ActionSpec(name=f"mode_{name}", menu="Run", text=info.title, do=partial(self._use, name),
                       shortcuts=(_KEYS[name],), tip=info.about, icon=f"mode_{name}", group=STATE, holds=_is(name),
                       gap=index == 0, short=info.short)
            for index, (name, info) in enumerate(MODES.items())
        ]  # fmt: skip

    def _use(self, mode: Mode) -> None:
        session = self.context.session
        if session.document.mode != mode:
            name = tr("mode “{mode}”").format(mode=MODES[mode].title.replace("&", ""))
            session.edit(name, lambda document: use_mode(document, mode))
        # The action must show the state of the document even if it has not changed.
        self.context.refresh()


def _is(mode: Mode) -> Condition:
    return lambda situation: situation.document.mode == mode
