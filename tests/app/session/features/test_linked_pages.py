"""The objects of all pages of a stack, measured for its table."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import tifffile
from cpm_app.model.document import objects
from cpm_app.model.document.document import Document, ImageReference
from cpm_app.session.features import kept_pages
from cpm_app.session.features.background import IdentityCache
from cpm_app.session.features.kept_pages import StackSource, link_pages

from cpm_core import Contour, Result
from cpm_core.formats import Reading


def test_objects_are_measured_again_only_when_they_or_the_size_of_a_pixel_have_changed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "cells.tif"
    tifffile.imwrite(path, np.arange(2 * 40 * 40, dtype=np.uint16).reshape(2, 40, 40), metadata={"axes": "TYX"})
    source = StackSource(str(path), 2)
    square = Contour(np.array([(5.0, 5.0), (5.0, 20.0), (20.0, 20.0), (20.0, 5.0)]), True)
    documents = {}
    for number in (1, 2):
        place = ImageReference.from_image(path, source.pages[number - 1], Reading(page=number))
        item = objects.object_from_contours(1, 1, [square])
        documents[number] = objects.accept_objects(Document(place), [item])
    measured, measure, seen = IdentityCache(), kept_pages.build_objects_result, []

    def counted(document: Document) -> Result | None:
        seen.append(document)
        return measure(document)

    monkeypatch.setattr(kept_pages, "build_objects_result", counted)

    def object_results(documents: dict[int, Document]) -> dict[int, Result]:
        found = link_pages(source, {}, (), documents, measured).table[0]
        return {page.number: page.result for page in found.pages}

    object_results(documents)
    assert len(seen) == 2
    changed = {
        1: documents[1],
        2: replace(documents[2], image=replace(documents[2].image, spacing=(0.5, 0.5), unit="µm")),
    }
    assert object_results(changed)[2].spacing == (0.5, 0.5)
    assert seen[2:] == [changed[2]]
    more = objects.rename_objects(documents[1], [1], "cell")
    assert object_results({1: more})[1].contours[0].name == "cell"
