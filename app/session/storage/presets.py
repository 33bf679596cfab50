"""The user's presets: one file each in a folder beside the preferences."""

from __future__ import annotations

import hashlib
import itertools
import re
from dataclasses import replace
from pathlib import Path

from PySide6.QtCore import QObject, QSettings, Signal

from app.model.parameters.presets import SUFFIX, Preset, built_in, checked_name, read, written
from app.model.text.language import tr
from app.session.exchange.messages import sentence
from cpm_core.formats.common.atomic import write_together


class PresetStore(QObject):
    """The presets of the program, and those of the user in a folder, by default beside the preferences."""

    changed = Signal()
    """The presets have changed."""

    def __init__(self, folder: Path | None = None, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self.folder = folder or _beside_preferences()
        self._files: dict[str, Path] = {}
        self._own: tuple[Preset, ...] = ()
        self.troubles: tuple[str, ...] = ()
        """Sentences on files of the folder that cannot be read; they stay as they are."""
        self._read_folder()

    @property
    def presets(self) -> tuple[Preset, ...]:
        """The presets of the program, then the user's, by name."""
        return (*built_in(), *self._own)

    def called(self, name: str) -> Preset | None:
        """The preset of this name."""
        return next((preset for preset in self.presets if preset.name == name), None)

    def save(self, preset: Preset) -> Preset:
        """Store a preset, in place of one of the same name; ValueError for an invalid name, OSError from the disk."""
        kept = replace(preset, name=checked_name(preset.name), key="")
        self._write(self._place(kept.name), kept)
        self._read_folder()
        self.changed.emit()
        return kept

    def rename(self, old: str, new: str) -> None:
        """Rename a preset of the user; ValueError when there is none, or the new name is invalid or taken."""
        preset = self._users(old)
        name = checked_name(new)
        if name == old:
            return
        if name in self._files:
            raise ValueError(tr("There is a preset “{name}” already: choose another name.").format(name=name))
        before = self._files[old]
        self._write(self._place(name), replace(preset, name=name))
        before.unlink(missing_ok=True)
        self._read_folder()
        self.changed.emit()

    def delete(self, name: str) -> None:
        """Remove a preset of the user; ValueError when there is none of this name."""
        self._users(name)
        self._files[name].unlink(missing_ok=True)
        self._read_folder()
        self.changed.emit()

    def import_from(self, path: Path) -> Preset:
        """Import a preset file; a name that is taken gets a number.

        ValueError when the file is not a valid preset, OSError when it cannot be read.
        """
        preset = read(path.read_bytes(), path.name)
        name, number = preset.name, 2
        while name in self._files:
            name, number = f"{preset.name} {number}", number + 1
        return self.save(replace(preset, name=name))

    def export_to(self, preset: Preset, path: Path) -> None:
        """Export a preset to a file; OSError when it cannot be written."""
        self._write(path, preset)

    def _users(self, name: str) -> Preset:
        found = next((preset for preset in self._own if preset.name == name), None)
        if found is None:
            raise ValueError(tr("There is no preset “{name}” of your own.").format(name=name))
        return found

    def _place(self, name: str) -> Path:
        """The file of a preset: a readable name, unique for each preset name; never a file that cannot be read."""
        if name in self._files:
            return self._files[name]
        readable = re.sub(r"[^A-Za-z0-9]+", "_", name).strip("_")[:40]
        stem = f"{readable}-{hashlib.sha256(name.encode()).hexdigest()[:8]}"
        places = (self.folder / f"{stem}{number or ''}{SUFFIX}" for number in itertools.count())
        return next(place for place in places if not place.exists())

    def _write(self, path: Path, preset: Preset) -> None:
        path.parent.mkdir(parents=True, exist_ok=True)
        write_together([(path, written(preset))])

    def _read_folder(self) -> None:
        """Read the folder; files that are not presets are left out."""
        found: dict[str, tuple[Preset, Path]] = {}
        troubles = []
        for path in sorted(self.folder.glob(f"*{SUFFIX}")):
            try:
                preset = read(path.read_bytes(), path.name)
            except (ValueError, OSError) as error:
                troubles.append(sentence(error, tr("reading {name}").format(name=path.name)))
                continue
            found.setdefault(preset.name, (preset, path))
        self._own = tuple(found[name][0] for name in sorted(found, key=str.casefold))
        self._files = {name: path for name, (_, path) in found.items()}
        self.troubles = tuple(troubles)


def _beside_preferences() -> Path:
    settings = QSettings(QSettings.Format.IniFormat, QSettings.Scope.UserScope, "cpm", "cpm")
    return Path(settings.fileName()).parent / "presets"
