"""The modes: shape recovery, automatic segmentation, skeleton."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from pathlib import Path

from app.model.document.document import Mode
from app.model.document.modes import MODES, use_mode
from app.model.state.situation import Condition, Situation, has_contours
from app.model.text.language import tr
from app.session.storage.output_folder import output_folder
from app.views.widgets.action_spec import STATE, ActionSpec
from app.views.window.dialogs import ask_for_export
from app.views.window.feature import Feature

_KEYS = {"shape": "Alt+1", "automatic": "Alt+2", "skeleton": "Alt+3"}


class ModesFeature(Feature):
    """The choice of the mode, and the export of the skeleton."""

    def action_specs(self) -> Sequence[ActionSpec]:
        """One mode each, and the export of the skeleton."""
        modes = [
            ActionSpec(name=f"mode_{name}", menu="Run", text=info.title, do=partial(self._use, name),
                       shortcuts=(_KEYS[name],), tip=info.about, icon=f"mode_{name}", group=STATE, holds=_is(name),
                       gap=index == 0, short=info.short)
            for index, (name, info) in enumerate(MODES.items())
        ]  # fmt: skip
        export = ActionSpec(name="export_skeleton", menu="File", text=tr("Export s&keleton…"), do=self._export,
                            shortcuts=("Ctrl+Shift+K",),
                            tip=tr("Write the branches of the skeleton with their radii to a file."),
                            icon="mode_skeleton", when=_has_skeleton)  # fmt: skip
        return (*modes, export)

    def _use(self, mode: Mode) -> None:
        session = self.context.session
        if session.document.mode != mode:
            name = tr("mode “{mode}”").format(mode=MODES[mode].title.replace("&", ""))
            session.edit(name, lambda document: use_mode(document, mode))
        # The action must show the state of the document even if it has not changed.
        self.context.refresh()

    def _export(self) -> None:
        image = self.context.session.document.image
        stem = Path(image.name).stem if image else "image"
        folder = output_folder(self.context.preferences, self.context.session.document)
        chosen = ask_for_export(self.context.window, str(folder / f"{stem}_skeleton.svg"))
        if chosen:
            self.context.session.export(chosen)


def _is(mode: Mode) -> Condition:
    return lambda situation: situation.document.mode == mode


def _has_skeleton(situation: Situation) -> bool:
    return situation.status.method == "skeleton" and has_contours(situation)
