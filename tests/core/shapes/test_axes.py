"""Shapes of images and shapes of volumes: each is for one kind of image, and never taken for the other."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import get_args

import numpy as np
import pytest

from cpm_core import Image, Parameters
from cpm_core.cli import main
from cpm_core.formats.sessions.plain_values import shape_to_plain
from cpm_core.formats.sessions.session_file import ImageFile, SessionFile, decode, encode, save_session
from cpm_core.shapes import Circle, Everywhere, Points, Shape, Sphere
from cpm_core.shapes.document_shapes import axes_of, check_axes, seeds_on
from tests.faults.fuzzing.inputs.session_samples import IMAGE, SAMPLES, VOLUME, write_images

DISK, BALL = Circle((20.0, 20.0), 6.0), Sphere((9.0, 9.0, 9.0), 4.0)


def drawn(name: str, folder: Path) -> tuple[Shape, ...]:
    """The shapes of a session with all kinds."""
    return decode(json.dumps(SAMPLES[name](folder)).encode(), name).shapes


def test_every_kind_of_shape_says_for_which_images_it_is(tmp_path: Path) -> None:
    flat, deep = drawn(IMAGE, tmp_path), drawn(VOLUME, tmp_path)
    assert {type(shape) for shape in (*flat, *deep)} == set(get_args(Shape))
    assert {axes_of(shape) for shape in flat} == {2, None}
    assert {axes_of(shape) for shape in deep} == {3, None}
    assert axes_of(Everywhere("grid")) is None


@pytest.mark.parametrize("size", [(40, 40), (18, 19, 20)])
def test_shapes_of_the_other_kind_are_refused_by_name_and_size(size: tuple[int, ...], tmp_path: Path) -> None:
    here, there = (IMAGE, VOLUME) if len(size) == 2 else (VOLUME, IMAGE)
    check_axes(drawn(here, tmp_path), size)
    for shape in drawn(there, tmp_path):
        if axes_of(shape) is None:
            continue
        with pytest.raises(ValueError, match=re.escape(f"shape 1 ({shape.title}) is for ")) as caught:
            check_axes([shape], size, "a.png")
        assert f"but a.png is taken as a{'n image' if len(size) == 2 else ' volume'} of " in str(caught.value)
        assert " x ".join(map(str, size)) in str(caught.value)


def test_particles_in_space_do_not_start_in_a_plane() -> None:
    with pytest.raises(
        ValueError, match=r"shape 1 \(point\) is for volumes, but image is taken as an image of 40 x 40"
    ):
        seeds_on(Image(np.eye(40)), [Points(((9.0, 9.0, 9.0),))], 0.0)


@pytest.mark.parametrize("shapes", [(DISK, BALL), (BALL, Everywhere("grid"), DISK)])
def test_a_session_that_mixes_images_and_volumes_is_refused(shapes: tuple[Shape, ...]) -> None:
    plain = json.loads(encode(SessionFile(), Path()))
    plain["shapes"] = [shape_to_plain(shape) for shape in shapes]
    with pytest.raises(ValueError, match=r"^a.cpm: shape \d \(\w+\) is for \w+, but shape 1 \(\w+\) is for ") as caught:
        decode(json.dumps(plain).encode(), "a.cpm")
    assert str(caught.value).endswith("keep those of one kind.")
    with pytest.raises(ValueError, match=re.escape(str(caught.value).removeprefix("a.cpm: "))):
        encode(SessionFile(shapes=shapes), Path())


def test_a_session_whose_shapes_do_not_suit_its_image_is_refused() -> None:
    content = encode(SessionFile(ImageFile("a.npy"), (BALL,)), Path()).replace(b'"shape": []', b'"shape": [40, 50]')
    with pytest.raises(
        ValueError, match=r"a.cpm: shape 1 \(sphere\) is for volumes, but the image is .* 40 x 50 pixels"
    ):
        decode(content, "a.cpm")


@pytest.mark.parametrize("command", [["run"], ["compare", "--circle", "20,20,6"], ["export", "--to", "a.csv"]])
def test_a_session_in_space_is_refused_on_an_image_in_one_sentence(
    command: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    write_images(tmp_path)
    monkeypatch.chdir(tmp_path)
    save_session(SessionFile(ImageFile(IMAGE), (BALL,), Parameters(scales=1)), Path("ball.cpm"))
    name, *more = command
    assert main([name, *(["ball.cpm"] if name == "export" else ["--session", "ball.cpm"]), *more]) == 2
    assert capsys.readouterr().err.endswith(
        f"cpm: shape 1 (sphere) is for volumes, but {IMAGE} is taken as an image of 40 x 40 pixels: "
        "choose an image of the kind that the shapes were drawn in.\n"
    )
    assert not Path("a.csv").exists()


def test_export_of_a_small_image_has_room_for_fewer_scales_as_a_run_has(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    np.save("small.npy", np.where(np.hypot(*np.mgrid[-9:10, -9:10]) < 6.0, 200.0, 20.0))
    save_session(SessionFile(ImageFile("small.npy"), (Circle((9.0, 9.0), 3.0),), Parameters(scales=3)), Path("a.cpm"))
    assert main(["export", "a.cpm", "--to", "a.csv"]) == 0
    assert "The image is small: scales is set to 2." in capsys.readouterr().err
