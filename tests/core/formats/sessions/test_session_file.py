"""Session files: a saved session is read back unchanged, and a damaged file is refused in one sentence."""

from __future__ import annotations

import dataclasses
import json
import math
import re
from dataclasses import fields, replace
from pathlib import Path
from typing import Annotated, Any, Literal, get_args, get_origin, get_type_hints

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import cpm_core
from cpm_core.formats.common.content import compute_fingerprint
from cpm_core.formats.common.json_values import LARGEST_NUMBER
from cpm_core.formats.sessions.session_file import (
    ImageFile,
    SessionFile,
    decode_session,
    encode_session,
    find_session_image,
    load_session,
    save_session,
)
from cpm_core.image.region import Region
from cpm_core.objects.segmented import SegmentedObject, SegmentedObjects
from cpm_core.parameters import AUTOMATIC_PARAMETERS, PARAMETERS, PRESETS, Parameters
from cpm_core.parameters.choices import CHOICE_PARAMETERS
from cpm_core.shapes import SHAPES_BY_NAME, Circle, PolygonRegion
from cpm_core.shapes.document_shapes import count_axes

numbers = st.floats(-LARGEST_NUMBER, LARGEST_NUMBER, allow_nan=False)
ranges = {"radius": st.floats(0.5, 1e5), "spacing": st.floats(0.5, 1e5), "fraction": st.floats(0.0, 1.0)}
ranges["axis"] = st.integers(0, 2)
ranges["strength"] = st.floats(-10.0, 10.0)


def values(hint: Any, name: str) -> st.SearchStrategy[Any]:
    """Values of a field of any shape."""
    if name == "radii":
        return st.tuples(ranges["radius"], ranges["radius"])
    if name in ranges:
        return ranges[name]
    if get_origin(hint) is Annotated:
        several, *counts = get_args(hint)
        item = values(get_args(several)[0], "")
        return st.one_of(*(st.tuples(*count * [item]) for count in counts))
    if get_origin(hint) is tuple:
        items = get_args(hint)
        if items[-1] is Ellipsis:
            return st.lists(values(items[0], ""), min_size=3, max_size=6, unique=True).map(tuple)
        return st.tuples(*(values(item, "") for item in items))
    if get_origin(hint) is Literal:
        return st.sampled_from(get_args(hint))
    if hint is Region:
        return st.sampled_from([*SURFACES, Region.from_mask(SURFACES[0].mask, SURFACES[0].origin)])
    assert hint is float, hint
    return numbers


CORNERS = np.array([(x, y, z) for z in (0, 3) for y in (0, 3) for x in (0, 3)], np.float32)
SIDES = ((0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5))
TRIANGLES = np.array([(a, *pair) for a, b, c, d in SIDES for pair in ((b, c), (c, d))])
SURFACES = [Region.from_surface(cpm_core.Surface(corners, TRIANGLES)) for corners in (CORNERS, CORNERS / 3.0 - 7.0)]


def any_of(kind: type) -> st.SearchStrategy[Any]:
    hints = get_type_hints(kind, include_extras=True)
    drawn = st.fixed_dictionaries({field.name: values(hints[field.name], field.name) for field in fields(kind)})
    return drawn.map(lambda given: made(kind, given)).filter(lambda one: one is not None)


def made(kind: type, given: dict[str, Any]) -> Any:
    """A shape; None where it does not allow the values together, as a grid of too many places."""
    try:
        return kind(**given)
    except ValueError:
        return None


shapes = st.one_of(*(any_of(kind) for kind in SHAPES_BY_NAME.values()))
drawings = st.sampled_from((2, 3)).flatmap(
    lambda axes: st.lists(shapes.filter(lambda one: count_axes(one) in (axes, None)), max_size=5)
)
"""Shapes of images, or of volumes."""


@st.composite
def parameters(draw: st.DrawFn) -> Parameters:
    """Any that are allowed."""
    free = [info for info in PARAMETERS.values() if info.name not in ("w1", "w2", "scales", *AUTOMATIC_PARAMETERS)]
    drawn: dict[str, Any] = {info.name: draw(st.floats(info.low, info.high)) for info in free}
    w2 = draw(st.floats(0.01, 100.0))
    for name in AUTOMATIC_PARAMETERS:
        drawn[name] = draw(st.just("auto") | st.floats(PARAMETERS[name].low, PARAMETERS[name].high))
    drawn |= {name: draw(st.sampled_from(list(info.choices))) for name, info in CHOICE_PARAMETERS.items()}
    w1 = w2 * draw(st.floats(0.0, 0.99))
    return Parameters(**drawn, w1=w1, w2=w2, scales=draw(st.integers(1, 8)))


plain = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False, allow_infinity=False) | st.text(),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(), inner, max_size=3),
    max_leaves=8,
)
mappings = st.dictionaries(st.text(), plain, max_size=4)


def suiting(session: SessionFile) -> SessionFile:
    """A session whose image, if it tells its size, suits the shapes."""
    deep = any(count_axes(shape) == 3 for shape in session.shapes)
    return replace(session, image=None) if deep and session.image and session.image.shape else session


sessions = st.builds(
    SessionFile,
    image=st.sampled_from([None, ImageFile("a.png", 64 * "a", (4, 5), "/b/a.png"), ImageFile("/b/ü.png")]),
    shapes=drawings.map(tuple),
    parameters=parameters(),
    mode=st.text(),
    view=mappings,
    extra=st.dictionaries(st.text().map(lambda text: f"x-{text}"), plain, max_size=3),
).map(suiting)


@given(sessions)
@settings(max_examples=15, deadline=None, suppress_health_check=[HealthCheck.too_slow])
def test_what_is_written_is_read_again_exactly(session: SessionFile) -> None:
    assert decode_session(encode_session(session, Path("/folder")), "a.cpm") == session


def test_every_shape_and_every_parameter_is_kept() -> None:
    assert {field.name for field in fields(Parameters)} == {*PARAMETERS, *CHOICE_PARAMETERS}
    text = encode_session(SessionFile(), Path("/folder")).decode()
    assert all(f'"{name}"' in text for name in (*PARAMETERS, *CHOICE_PARAMETERS))
    assert all(dataclasses.is_dataclass(kind) for kind in SHAPES_BY_NAME.values())


def test_it_is_read_by_people_one_line_for_each_shape() -> None:
    drawn = (Circle((1.0, 2.0), 3.0), PolygonRegion(((0.0, 0.0), (0.0, 9.0), (9.0, 0.0))))
    lines = encode_session(SessionFile(shapes=drawn), Path("/folder")).decode().splitlines()
    assert lines[1:3] == ['  "cpm-session": 3,', f'  "program": "CPM {cpm_core.__version__}",']
    assert '    {"shape": "circle", "center": [1.0, 2.0], "radius": 3.0},' in lines
    assert sum('"shape"' in line for line in lines) == 2


@pytest.fixture
def image_file(tmp_path: Path) -> Path:
    path = tmp_path / "images" / "ü hand.png"
    path.parent.mkdir()
    path.write_bytes(b"not looked into")
    return path


def reference(path: Path) -> ImageFile:
    return ImageFile(str(path), compute_fingerprint(path), (10, 20))


def test_the_image_is_found_when_folder_and_session_have_moved_together(image_file: Path, tmp_path: Path) -> None:
    save_session(SessionFile(reference(image_file)), tmp_path / "a.cpm")
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    (tmp_path / "images").rename(elsewhere / "images")
    (tmp_path / "a.cpm").rename(elsewhere / "a.cpm")
    session = load_session(elsewhere / "a.cpm")
    assert session.image is not None
    assert find_session_image(session.image, elsewhere) == (elsewhere / "images" / "ü hand.png", ())


def test_the_image_is_found_when_only_the_session_has_moved_and_when_it_was_put_beside(
    image_file: Path, tmp_path: Path
) -> None:
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    save_session(SessionFile(reference(image_file)), tmp_path / "a.cpm")
    (tmp_path / "a.cpm").rename(elsewhere / "a.cpm")
    session = load_session(elsewhere / "a.cpm")
    assert session.image is not None
    assert find_session_image(session.image, elsewhere)[0] == image_file
    image_file.rename(elsewhere / image_file.name)
    assert find_session_image(session.image, elsewhere)[0] == elsewhere / image_file.name


def test_a_folder_with_a_series_is_found(tmp_path: Path) -> None:
    (tmp_path / "series").mkdir()
    reference = ImageFile(str(tmp_path / "series"))
    assert find_session_image(reference, tmp_path) == (tmp_path / "series", ())
    with pytest.raises(ValueError, match="was not found at"):
        find_session_image(replace(reference, path=""), tmp_path)


def test_a_missing_image_is_told_with_every_place_that_was_looked_at(image_file: Path, tmp_path: Path) -> None:
    save_session(SessionFile(reference(image_file)), tmp_path / "a.cpm")
    image_file.unlink()
    session = load_session(tmp_path / "a.cpm")
    assert session.image is not None
    with pytest.raises(ValueError, match="was not found at") as caught:
        find_session_image(session.image, tmp_path)
    assert str(image_file) in str(caught.value)
    assert str(tmp_path / image_file.name) in str(caught.value)


def test_a_changed_image_is_used_with_a_warning(image_file: Path, tmp_path: Path) -> None:
    save_session(SessionFile(reference(image_file)), tmp_path / "a.cpm")
    image_file.write_bytes(b"another picture")
    session = load_session(tmp_path / "a.cpm")
    assert session.image is not None
    path, (note,) = find_session_image(session.image, tmp_path)
    assert path == image_file
    assert "has changed since" in note


def test_unknown_parameters_are_told_and_missing_ones_have_their_defaults() -> None:
    session = decode_session(b'{"cpm-session": 3, "parameters": {"beta": 0.5, "viscosity": 3}}', "a.cpm")
    assert session.parameters == Parameters(beta=0.5)
    assert "viscosity" in session.notes[0]


def test_what_a_later_version_adds_is_kept_when_the_file_is_written_again(tmp_path: Path) -> None:
    session = decode_session(b'{"cpm-session": 3, "weather": {"sun": true}}', "a.cpm")
    save_session(replace(session, mode="shape"), tmp_path / "a.cpm")
    assert json.loads((tmp_path / "a.cpm").read_text())["weather"] == {"sun": True}


def test_nothing_is_lost_of_a_file_that_cannot_be_written(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "a.cpm"
    save_session(SessionFile(), path)
    before = path.read_bytes()

    def full(*_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("os.fsync", full)
    with pytest.raises(ValueError, match="No space left"):
        save_session(SessionFile(parameters=PRESETS["noisy"]), path)
    assert path.read_bytes() == before
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"", "not a session file"),
        (b'{"cpm-session": true}', "version True"),
        (b'{"cpm-session": 3, "shapes": [{"shape": "blob"}]}', '"blob" but must be one of circle'),
        (b'{"cpm-session": 3, "objects": {"classes": [{"name": "", "color": "#\\u001b\\n"}]}}', r"\x1b"),
        (b'{"cpm-session": 3, "shapes": [{"shape": "circle", "center": [1, 1e7], "radius": 2}]}', "1e+07"),
        (b'{"cpm-session": 3, "shapes": [{"shape": "points", "positions": []}]}', "shape 1 (points)"),
        (b'{"cpm-session": 3, "parameters": {"beta": -Infinity}}', "beta"),
        (b'{"cpm-session": 3, "parameters": {"beta": "auto"}}', 'beta is "auto"'),
        (b'{"cpm-session": 3, "view": {"layers": [1e999]}}', "view holds a number that is not finite"),
        (b'{"cpm-session": 3, "later": NaN}', "the session holds a number that is not finite"),
        (b'{"cpm-session": 3, "objects": {"classes": [{"name": "", "color": "red"}]}}', "#rrggbb"),
        (100_000 * b"[", "not a session file"),
    ],
)
def test_an_error_is_reported_in_one_sentence(content: bytes, words: str) -> None:
    with pytest.raises(ValueError, match=r"^a\.cpm") as caught:
        decode_session(content, "a.cpm")
    sentence = str(caught.value)
    assert words in sentence
    assert sentence.endswith(".")
    assert "\n" not in sentence
    assert len(sentence) < 300


@pytest.mark.parametrize("key", ["runs", "pages"])
def test_recorded_work_with_an_infinite_number_is_left_out_with_a_note(key: str) -> None:
    session = decode_session(b'{"cpm-session": 3, "%s": {"points": [[1.0, Infinity]]}}' % key.encode(), "a.cpm")
    assert not getattr(session, key)
    assert session.notes[0].endswith(f"left out: {key} holds a number that is not finite.")
    assert encode_session(session, Path("/folder"))


def test_files_that_are_none_are_told(tmp_path: Path) -> None:
    for path, words in ((tmp_path / "no.cpm", "does not exist"), (tmp_path, "is a folder")):
        with pytest.raises(ValueError, match=words):
            load_session(path)


CORNERS = ((1.0, 2.0), (3.0, 4.0), (5.0, 1.0))

sound = encode_session(
    SessionFile(
        ImageFile("a.png", 64 * "0", (4, 4)),
        (
            Circle((1.0, 2.0), 3.0),
            *(SHAPES_BY_NAME[name](((1.0, 2.0), (3.0, 4.0), (5.0, 1.0))) for name in ("stroke", "region")),
        ),
        objects=SegmentedObjects((SegmentedObject(1, (), name="ü", color="#00ff00", line=CORNERS),)),
        view={"layers": {"image": {"shown": True}}},
    ),
    Path("/folder"),
)


@given(st.lists(st.tuples(st.integers(0, len(sound) - 1), st.binary(max_size=3), st.integers(0, 9)), max_size=4))
@settings(max_examples=15, deadline=None)
def test_any_damage_is_told_or_does_not_matter(damages: list[tuple[int, bytes, int]]) -> None:
    content = sound
    for place, put, cut in damages:
        content = content[:place] + put + content[place + cut :]
    _is_sound_or_told(content)


tokens = st.sampled_from(
    [
        '"x"',
        "1e308",
        "-1e308",
        "123456789012345678901234567890",
        "null",
        "[]",
        "{}",
        "true",
        '"\\ud800"',
        '"\\u0000"',
        "-0.0",
    ]
)


@given(st.integers(0, 60), tokens)
@settings(max_examples=15, deadline=None)
def test_any_value_in_place_of_another_is_told_or_does_not_matter(which: int, token: str) -> None:
    found = list(_values.finditer(sound.decode()))
    match = found[which % len(found)]
    text = sound.decode()
    _is_sound_or_told((text[: match.start()] + token + text[match.end() :]).encode())


_values = re.compile(r'(?<=[:\[,] )(-?[\d.]+|"[^"]*"|true)')


def _is_sound_or_told(content: bytes) -> None:
    try:
        session = decode_session(content, "a.cpm")
    except ValueError as error:
        assert str(error).startswith("a.cpm")
        assert str(error).endswith(".")
        assert "\n" not in str(error)
        return
    again = decode_session(encode_session(session, Path("/folder")), "a.cpm")
    assert replace(again, notes=()) == replace(session, notes=())
    for shape in session.shapes:
        assert all(math.isfinite(number) for row in shape.outline for number in row)
    if session.image is not None:
        with pytest.raises(ValueError, match="was not found"):
            find_session_image(session.image, Path("/nowhere"))
