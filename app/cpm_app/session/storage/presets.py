"""The user's presets: one file each in a folder next to the preferences."""

from __future__ import annotations

import hashlib
import logging
import re
from dataclasses import replace
from pathlib import Path

from PySide6.QtCore import QObject, Signal

from cpm_app.model.parameters.presets import (
    PRESET_SUFFIX,
    Preset,
    built_in_presets,
    check_preset_name,
    decode_preset,
    encode_preset,
)
from cpm_app.model.text.language import tr
from cpm_app.session.storage.preferences import open_settings
from cpm_core.formats import write_together

_log = logging.getLogger(__name__)


class PresetStore(QObject):
    """The presets of the program, and those of the user in a folder, by default next to the preferences."""

    changed = Signal()
    """The presets have changed."""

    def __init__(self, folder: Path | None = None, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self.folder = folder or Path(open_settings().fileName()).parent / "presets"
        self._files: dict[str, Path] = {}
        self._own: tuple[Preset, ...] = ()
        self._read_folder()

    @property
    def presets(self) -> tuple[Preset, ...]:
        """The presets of the program, then the user's, by name."""
        return (*built_in_presets(), *self._own)

    def save(self, preset: Preset) -> Preset:
        """Store a preset, in place of one of the same name; ValueError for an invalid name, OSError of the disk."""
        kept = replace(preset, name=check_preset_name(preset.name), key="")
        readable = re.sub(r"[^A-Za-z0-9]+", "_", kept.name).strip("_")[:40]
        unique = f"{readable}-{hashlib.sha256(kept.name.encode()).hexdigest()[:8]}{PRESET_SUFFIX}"
        self.folder.mkdir(parents=True, exist_ok=True)
        write_together([(self._files.get(kept.name, self.folder / unique), encode_preset(kept))])
        self._read_folder()
        return kept

    def delete(self, name: str) -> None:
        """Remove a preset of the user; raise ValueError if there is none of this name."""
        if name not in self._files:
            raise ValueError(tr("You have no preset named “{name}”.", name=name))
        self._files[name].unlink(missing_ok=True)
        self._read_folder()

    def _read_folder(self) -> None:
        """Read the folder; files that cannot be read are left out."""
        found: dict[str, tuple[Preset, Path]] = {}
        for path in sorted(self.folder.glob(f"*{PRESET_SUFFIX}")):
            try:
                preset = decode_preset(path.read_bytes())
            except (ValueError, OSError) as error:
                _log.warning("%s: %s", path, error)
                continue
            found.setdefault(preset.name, (preset, path))
        self._own = tuple(found[name][0] for name in sorted(found, key=str.casefold))
        self._files = {name: path for name, (_, path) in found.items()}
        self.changed.emit()
