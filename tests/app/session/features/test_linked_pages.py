"""The objects of all pages of a stack, measured for its table."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import tifffile
from cpm_app.model.document import objects
from cpm_app.model.document.document import Document, ImageReference
from cpm_app.session.features.kept_pages import StackSource, link_pages

from cpm_core import Contour
from cpm_core.formats import Reading


def test_objects_are_measured_again_only_when_they_or_the_size_of_a_pixel_have_changed(tmp_path: Path) -> None:
    path = tmp_path / "cells.tif"
    tifffile.imwrite(path, np.arange(2 * 40 * 40, dtype=np.uint16).reshape(2, 40, 40), metadata={"axes": "TYX"})
    source = StackSource(str(path), 2)
    square = Contour(np.array([(5.0, 5.0), (5.0, 20.0), (20.0, 20.0), (20.0, 5.0)]), True)
    documents = {}
    for number in (1, 2):
        place = ImageReference.from_image(path, source.pages[number - 1], Reading(page=number))
        item = objects.object_from_contours(1, 1, [square])
        documents[number] = objects.accept_objects(Document(place), [item])
    made = link_pages(source, {}, (), documents, {})
    changed = {
        1: documents[1],
        2: replace(documents[2], image=replace(documents[2].image, spacing=(0.5, 0.5), unit="µm")),
    }
    again = link_pages(source, {}, (), changed, made.measured)
    (_, one), (_, other) = again.measured[1], again.measured[2]
    assert one is made.measured[1][1]
    assert other is not made.measured[2][1]
    assert other.spacing == (0.5, 0.5)
    more = objects.rename_objects(documents[1], [1], "cell")
    third = link_pages(source, {}, (), {1: more}, again.measured)
    assert third.measured[1][1].contours[0].name == "cell"
