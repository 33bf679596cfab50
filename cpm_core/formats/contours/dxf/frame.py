"""The frame of a drawing: what DXF of release 2007 needs around its entities."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Mapping, Sequence

Tags = list[object]
"""Group codes and values in turn."""

VERSION = "AC1021"
"""Release 2007: the first with names in any letters (UTF-8)."""

_NO_OWNER = "0"
_STANDARD = "Standard"


class Frame:
    """Makes the sections of a drawing, and gives each entry its handle."""

    def __init__(self) -> None:
        self._handles = itertools.count(1)
        self.model = self._handle()
        self._paper = self._handle()
        self._entities: Tags = []

    def add(self, kind: str, layer: str, look: Sequence[object], subclass: str, *geometry: object) -> None:
        """Add an entity on a layer; `look` and `geometry` are group codes and values."""
        tags: Tags = [0, kind, 5, self._handle(), 330, self.model, 100, "AcDbEntity", 8, layer]
        self._entities += [*tags, *look, 100, subclass, *geometry]

    def text(self, comments: Iterable[str], header: Mapping[str, Sequence[object]], layers: Mapping[str, int]) -> bytes:
        """The whole drawing, with the variables of a header and layers with their numbered colors."""
        tables, blocks, objects = self._tables(layers), self._blocks(), self._objects()
        lines: Tags = [part for comment in comments for part in (999, comment)]
        variables = {"$ACADVER": (1, VERSION), "$HANDSEED": (5, self._handle()), **header}
        lines += [0, "SECTION", 2, "HEADER"]
        for name, values in variables.items():
            lines += [9, name, *values]
        lines += [0, "ENDSEC", 0, "SECTION", 2, "CLASSES", 0, "ENDSEC"]
        sections = {"TABLES": tables, "BLOCKS": blocks, "ENTITIES": self._entities, "OBJECTS": objects}
        for name, content in sections.items():
            lines += [0, "SECTION", 2, name, *content, 0, "ENDSEC"]
        lines += [0, "EOF"]
        return ("\n".join(map(str, lines)) + "\n").encode()

    def _handle(self) -> str:
        return f"{next(self._handles):X}"

    def _tables(self, layers: Mapping[str, int]) -> Tags:
        solid: Tags = [70, 0, 3, "", 72, 65, 73, 0, 40, "0.0"]
        font: Tags = [70, 0, 40, "0.0", 41, "1.0", 50, "0.0", 71, 0, 42, "1.0", 3, "txt", 4, ""]
        kinds = dict.fromkeys(("ByBlock", "ByLayer", "Continuous"), solid)
        lines = self._table("VPORT", "", {}) + self._table("LTYPE", "AcDbLinetypeTableRecord", kinds)
        looks: dict[str, Tags] = {name: [70, 0, 62, number, 6, "Continuous"] for name, number in layers.items()}
        lines += self._table("LAYER", "AcDbLayerTableRecord", looks)
        lines += self._table("STYLE", "AcDbTextStyleTableRecord", {_STANDARD: font})
        lines += self._table("VIEW", "", {}) + self._table("UCS", "", {})
        lines += self._table("APPID", "AcDbRegAppTableRecord", {"ACAD": [70, 0]})
        lines += self._table("DIMSTYLE", "AcDbDimStyleTableRecord", {_STANDARD: [70, 0]})
        handles = {"*Model_Space": self.model, "*Paper_Space": self._paper}
        return lines + self._table("BLOCK_RECORD", "AcDbBlockTableRecord", {name: [] for name in handles}, handles)

    def _table(self, name: str, subclass: str, entries: Mapping[str, Tags], handles: Mapping[str, str] = {}) -> Tags:
        owner = self._handle()
        lines: Tags = [0, "TABLE", 2, name, 5, owner, 330, _NO_OWNER, 100, "AcDbSymbolTable", 70, len(entries)]
        if name == "DIMSTYLE":
            lines += [100, "AcDbDimStyleTable", 71, 0]
        for entry, tags in entries.items():
            code = 105 if name == "DIMSTYLE" else 5
            lines += [0, name, code, handles.get(entry) or self._handle(), 330, owner, 100, "AcDbSymbolTableRecord"]
            lines += [100, subclass, 2, entry, *tags]
        return [*lines, 0, "ENDTAB"]

    def _blocks(self) -> Tags:
        lines: Tags = []
        for name, owner in (("*Model_Space", self.model), ("*Paper_Space", self._paper)):
            paper: Tags = [67, 1] if owner == self._paper else []
            lines += [0, "BLOCK", 5, self._handle(), 330, owner, 100, "AcDbEntity", *paper, 8, "0"]
            lines += [100, "AcDbBlockBegin", 2, name, 70, 0, 10, "0.0", 20, "0.0", 30, "0.0", 3, name, 1, ""]
            lines += [0, "ENDBLK", 5, self._handle(), 330, owner, 100, "AcDbEntity", *paper, 8, "0"]
            lines += [100, "AcDbBlockEnd"]
        return lines

    def _objects(self) -> Tags:
        root, group = self._handle(), self._handle()
        lines: Tags = [0, "DICTIONARY", 5, root, 330, _NO_OWNER, 100, "AcDbDictionary", 281, 1]
        lines += [3, "ACAD_GROUP", 350, group, 0, "DICTIONARY", 5, group, 330, root]
        return [*lines, 100, "AcDbDictionary", 281, 1]
