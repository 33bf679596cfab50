"""A folder of images as a project: its panel, and the actions that lead from one image to the next."""

from __future__ import annotations

from functools import partial
from pathlib import Path

from PySide6.QtCore import QTimer

from cpm_app.model.state.situation import Situation
from cpm_app.model.text.language import tr
from cpm_app.views.panels.images import ImagePanel
from cpm_app.views.widgets.actions import ActionSpec
from cpm_app.views.window.dialogs import FileKind
from cpm_app.views.window.docks import Panel
from cpm_app.views.window.window import Feature


class ProjectFeature(Feature):
    """Panel of the images of a folder, with actions to mark them, to propose objects on all, and to export a table."""

    def set_up(self) -> None:
        """Create the actions and the panel and connect them to what they depend on."""
        window = self.window
        self._project = project = window.workspace.project
        project.set_session_file(window.document_file)
        self.panel = ImagePanel(project)
        self.panels = (Panel("images", "Images", self.panel, "Shift+F8", shown_at_start=False),)
        self._folder: Path | None = None
        project.changed.connect(self._on_changed)
        # after what has asked for it, such as the end of a task, has been dealt with
        project.image_wanted.connect(lambda path: QTimer.singleShot(0, window, partial(window.open_image, path, True)))
        self.panel.table.image_requested.connect(lambda path: window.open_image(path, True))

        def is_project(_: Situation) -> bool:
            return project.folder is not None

        def has_project_image(_: Situation) -> bool:
            return project.current is not None

        self.actions = (
            ActionSpec("next_undone", "File", "Next &undone image",
                       "Go on to the next image that is neither done nor doubtful.", project.go_to_next, "Alt+Down",
                       short=tr("Next"), visible_when=is_project),
            ActionSpec("image_done", "File", "Image is do&ne",
                       "Mark the image as done and go on to the next one; again removes the mark.",
                       partial(project.mark, "done"), "Ctrl+Return", short=tr("Done"), visible_when=is_project,
                       when=has_project_image, checked_when=lambda _: project.state == "done"),
            ActionSpec("image_doubtful", "File", "Image is dou&btful",
                       "Mark the image as doubtful and go on to the next one; again removes the mark.",
                       partial(project.mark, "doubtful"), "Alt+Return", short=tr("Doubtful"), visible_when=is_project,
                       when=has_project_image, checked_when=lambda _: project.state == "doubtful"),
            ActionSpec("apply_to_all", "File", "Apply to a&ll images",
                       "Run each untouched image with the settings of this one when it is opened, to review what is "
                       "proposed.", project.toggle_proposing, visible_when=is_project, when=has_project_image,
                       checked_when=lambda _: project.proposes),
            ActionSpec("export_all_images", "File", "Export &table of all images…",
                       "Export one table of all objects of all images.", self._ask_for_table, visible_when=is_project),
        )  # fmt: skip

    def _on_changed(self) -> None:
        folder = self._project.folder
        if folder != self._folder:
            self._folder = folder
            self.window.docks.set_tab_available("images", folder is not None)
            if folder is not None:
                self.window.docks.reveal_panel("images")
        self.window.refresh_actions()

    def _ask_for_table(self) -> None:
        folder = self._project.folder
        if folder is None:
            return
        kinds = [FileKind(tr("Tables"), (".csv",))]
        title = tr("Export table of all images")
        path = self.window.files.ask_where_to_save("export", title, f"{folder.name}_objects.csv", kinds)
        if path is not None:
            self._project.write_table(path)
