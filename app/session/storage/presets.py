"""A person's own presets: one file each in a folder beside the preferences."""

from __future__ import annotations

import hashlib
import logging
import re
from dataclasses import replace
from pathlib import Path

from PySide6.QtCore import QObject, QSettings, Signal

from app.model.parameters.presets import SUFFIX, Preset, built_in, checked_name, read, written
from app.model.text.language import tr
from cpm_core.formats.atomic import write_together

_LOG = logging.getLogger(__name__)


class PresetStore(QObject):
    """The presets there are.

    Parameters
    ----------
    folder : Path, optional
        Where a person's own are kept; beside the preferences unless told otherwise.
    parent : QObject, optional
        Owner.
    """

    changed = Signal()
    """There are other presets than before."""

    def __init__(self, folder: Path | None = None, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self.folder = folder or _beside_preferences()
        self._files: dict[str, Path] = {}
        self._own: tuple[Preset, ...] = ()
        self._look()

    @property
    def presets(self) -> tuple[Preset, ...]:
        """Those of the program, then a person's own by name."""
        return (*built_in(), *self._own)

    def called(self, name: str) -> Preset | None:
        """The preset of this name."""
        return next((preset for preset in self.presets if preset.name == name), None)

    def save(self, preset: Preset) -> Preset:
        """Keep a preset, in place of one of the same name.

        Raises
        ------
        ValueError
            When its name does not do.
        OSError
            When it cannot be written.
        """
        kept = replace(preset, name=checked_name(preset.name), key="")
        self._write(self._place(kept.name), kept)
        self._look()
        self.changed.emit()
        return kept

    def rename(self, old: str, new: str) -> None:
        """Give a preset of one's own another name.

        Raises
        ------
        ValueError
            When there is no such preset of one's own, or the new name does not do or is taken.
        """
        preset = self._of_ones_own(old)
        name = checked_name(new)
        if name == old:
            return
        if name in self._files:
            raise ValueError(tr("There is a preset “{name}” already: choose another name.").format(name=name))
        before = self._files[old]
        self._write(self._place(name), replace(preset, name=name))
        before.unlink(missing_ok=True)
        self._look()
        self.changed.emit()

    def delete(self, name: str) -> None:
        """Remove a preset of one's own.

        Raises
        ------
        ValueError
            When there is none of this name.
        """
        self._of_ones_own(name)
        self._files[name].unlink(missing_ok=True)
        self._look()
        self.changed.emit()

    def bring_in(self, path: Path) -> Preset:
        """Take over a preset from a file that somebody shared; a name that is taken gets a number.

        Raises
        ------
        ValueError
            When the file is no preset, or damaged.
        OSError
            When it cannot be read.
        """
        preset = read(path.read_bytes(), path.name)
        name, number = preset.name, 2
        while name in self._files:
            name, number = f"{preset.name} {number}", number + 1
        return self.save(replace(preset, name=name))

    def hand_out(self, preset: Preset, path: Path) -> None:
        """Write a preset to a file for somebody else.

        Raises
        ------
        OSError
            When it cannot be written.
        """
        self._write(path, preset)

    def _of_ones_own(self, name: str) -> Preset:
        found = next((preset for preset in self._own if preset.name == name), None)
        if found is None:
            raise ValueError(tr("There is no preset “{name}” of your own.").format(name=name))
        return found

    def _place(self, name: str) -> Path:
        """The file of a preset: readable, and another one for every name."""
        readable = re.sub(r"[^A-Za-z0-9]+", "_", name).strip("_")[:40]
        return self.folder / f"{readable}-{hashlib.sha256(name.encode()).hexdigest()[:8]}{SUFFIX}"

    def _write(self, path: Path, preset: Preset) -> None:
        path.parent.mkdir(parents=True, exist_ok=True)
        write_together([(path, written(preset))])

    def _look(self) -> None:
        """Read the folder; what is no preset is left alone."""
        found: dict[str, tuple[Preset, Path]] = {}
        for path in sorted(self.folder.glob(f"*{SUFFIX}")):
            try:
                preset = read(path.read_bytes(), path.name)
            except (ValueError, OSError) as error:
                _LOG.warning("%s", error)
                continue
            found.setdefault(preset.name, (preset, path))
        self._own = tuple(found[name][0] for name in sorted(found, key=str.casefold))
        self._files = {name: path for name, (_, path) in found.items()}


def _beside_preferences() -> Path:
    settings = QSettings(QSettings.Format.IniFormat, QSettings.Scope.UserScope, "cpm", "cpm")
    return Path(settings.fileName()).parent / "presets"
