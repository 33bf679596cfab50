"""Shapes of images and shapes of volumes: each is for one kind of image, and never taken for the other."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest

from cpm_core import Image
from cpm_core.formats.common.json_values import shape_to_json
from cpm_core.formats.sessions.session_file import SessionFile, decode_session, encode_session
from cpm_core.shapes import Circle, Everywhere, Points, Shape, Sphere
from cpm_core.shapes.document_shapes import check_axes, compute_seeds, count_axes
from tests.faults.fuzzing.inputs.session_samples import IMAGE, SAMPLES, VOLUME

DISK, BALL = Circle((20.0, 20.0), 6.0), Sphere((9.0, 9.0, 9.0), 4.0)


def drawn(name: str, folder: Path) -> tuple[Shape, ...]:
    """The shapes of a session with all kinds."""
    return decode_session(json.dumps(SAMPLES[name](folder)).encode(), name).shapes


@pytest.mark.parametrize("size", [(40, 40), (18, 19, 20)])
def test_shapes_of_the_other_kind_are_refused_by_name_and_size(size: tuple[int, ...], tmp_path: Path) -> None:
    here, there = (IMAGE, VOLUME) if len(size) == 2 else (VOLUME, IMAGE)
    check_axes(drawn(here, tmp_path), size)
    foreign = [shape for shape in drawn(there, tmp_path) if count_axes(shape) is not None]
    assert len(foreign) > 3
    for shape in foreign:
        with pytest.raises(ValueError, match=re.escape(f"shape 1 ({shape.title}) is for ")) as caught:
            check_axes([shape], size, "a.png")
        assert f"but a.png is taken as a{'n image' if len(size) == 2 else ' volume'} of " in str(caught.value)
        assert " x ".join(map(str, size)) in str(caught.value)


def test_particles_in_space_do_not_start_in_a_plane() -> None:
    with pytest.raises(
        ValueError, match=r"shape 1 \(point\) is for volumes, but image is taken as an image of 40 x 40"
    ):
        compute_seeds(Image(np.eye(40)), [Points(((9.0, 9.0, 9.0),))], 0.0)


@pytest.mark.parametrize("shapes", [(DISK, BALL), (BALL, Everywhere("grid"), DISK)])
def test_a_session_that_mixes_images_and_volumes_is_refused(shapes: tuple[Shape, ...]) -> None:
    plain = json.loads(encode_session(SessionFile(), Path()))
    plain["shapes"] = [shape_to_json(shape) for shape in shapes]
    with pytest.raises(ValueError, match=r"^a.cpm: shape \d \(\w+\) is for \w+, but shape 1 \(\w+\) is for ") as caught:
        decode_session(json.dumps(plain).encode(), "a.cpm")
    assert str(caught.value).endswith("keep those of one kind.")
    with pytest.raises(ValueError, match=re.escape(str(caught.value).removeprefix("a.cpm: "))):
        encode_session(SessionFile(shapes=shapes), Path())
