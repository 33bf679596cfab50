"""What was done in the window as a script."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from app.model.export.script import Script, script_of
from app.model.export.stack_script import script_of_stack
from app.model.state.situation import Situation
from app.model.text.language import tr
from app.session.exchange.messages import Report
from app.session.signals import EXPORTING
from app.session.storage.session_file import DocumentFile
from app.session.tasks.tasks import Task
from app.views.export.script_dialog import ScriptDialog
from app.views.widgets.action_spec import ActionSpec
from app.views.window.feature import Feature, FeatureContext
from app.views.window.file_dialogs import Files
from cpm_core.formats.atomic import write_together
from cpm_core.formats.sessions.session_file import SUFFIX


class ScriptFeature(Feature):
    """Shows the workflow as a program in Python and as a command line."""

    def __init__(self, context: FeatureContext) -> None:
        super().__init__(context)
        self.dialog: ScriptDialog | None = None
        self._document_file: DocumentFile | None = None

    def keep(self, document_file: DocumentFile) -> None:
        """Know the session file, which a script may read."""
        self._document_file = document_file

    def action_specs(self) -> Sequence[ActionSpec]:
        """Open the dialog."""
        return (
            ActionSpec(name="show_script", menu="File", text=tr("Wor&kflow as a script…"), do=self.open,
                       when=_can_be_told,
                       tip=tr("Show what was done here as a program in Python and as a command line.")),
        )  # fmt: skip

    def open(self) -> None:
        """Show the script of the document as it is now."""
        document = self.context.session.document
        if document.image is None:
            return
        file = self._document_file
        session = file.path if file is not None and file.path is not None else None
        pages = self.context.workspace.pages.drawn
        if pages is not None and document.mode != "skeleton":
            script = script_of_stack(pages)
        else:
            script = script_of(document, session or Path(document.image.path).absolute().with_suffix(SUFFIX))
        self.dialog = ScriptDialog(self.context.window, script, self._note(script, file, session), self._save)
        self.dialog.finished.connect(self.dialog.deleteLater)
        self.dialog.finished.connect(self._forget)
        self.dialog.open()

    def _note(self, script: Script, file: DocumentFile | None, session: Path | None) -> str:
        said = [tr("It begins anew with what is drawn and set now, and finds the same contours."), script.note]
        if self.context.session.status.steered:
            said.append(tr("The run that is shown was changed on its way, and may differ from a new one."))
        if script.reads_session and (session is None or file is None or file.unsaved):
            said.append(tr("It reads the session file: save the session first."))
        return " ".join(filter(None, said))

    def _save(self, text: str, suffix: str) -> Path | None:
        kinds = (Files(tr("Python") if suffix == ".py" else tr("Commands"), (suffix,)),)
        image = self.context.session.document.image
        name = f"{Path(image.name).stem if image is not None else 'contours'}{suffix}"
        path = self.context.files.ask_where_to_save("export", tr("Save the script"), name, kinds, parent=self.dialog)
        if path is not None:
            self._write(path, text)
        return path

    def _write(self, path: Path, text: str) -> None:
        def work(_: Task) -> Report | None:
            write_together([(path, text.encode())])
            return None

        session = self.context.session
        session.attempt(EXPORTING)
        session.tasks.start(
            tr("Writing {name}…").format(name=path.name), work, tr("writing {name}").format(name=path.name)
        )

    def _forget(self, _: int) -> None:
        self.dialog = None


def _can_be_told(situation: Situation) -> bool:
    """Whether there is an image, and a start where one is needed."""
    document = situation.document
    return document.image is not None and (bool(document.starts) or document.mode == "skeleton")
