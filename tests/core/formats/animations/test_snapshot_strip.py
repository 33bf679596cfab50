"""Snapshot strips: frames in rows with captions below them."""

from pathlib import Path

import matplotlib
import numpy as np
import PIL.Image
import pytest

from cpm_core.formats.animations import snapshot_strip
from cpm_core.formats.animations.snapshot_strip import strip, write_picture


def frame(level, shape=(60, 80)):
    return np.full((*shape, 3), level, np.uint8)


def test_frames_stand_in_rows_with_white_between_them():
    sheet = strip([frame(10 * k) for k in range(5)], columns=3, gap=7)
    assert sheet.dtype == np.uint8
    assert sheet.shape == (2 * 67 + 7, 3 * 87 + 7, 3)
    assert (sheet[:7] == 255).all()
    assert (sheet[:, :7] == 255).all()
    for number in range(5):
        top, left = 7 + number // 3 * 67, 7 + number % 3 * 87
        assert (sheet[top : top + 60, left : left + 80] == 10 * number).all()
    assert (sheet[74:, 7 + 2 * 87 :] == 255).all()


@pytest.mark.parametrize(("count", "across"), [(1, 1), (3, 3), (4, 4), (5, 4), (9, 4)])
def test_up_to_four_stand_in_a_row(count, across):
    assert strip([frame(0)] * count, gap=0).shape == (-(-count // across) * 60, across * 80, 3)


def test_captions_stand_below_their_frames_in_the_middle():
    sheet = strip([frame(200), frame(200)], ["step 40", "at rest"], gap=10)
    plain = strip([frame(200), frame(200)], gap=10)
    line = sheet.shape[0] - plain.shape[0]
    assert line > 10
    assert np.array_equal(sheet[:70], plain[:70])
    for left in (10, 100):
        ink = np.argwhere(sheet[70 : 70 + line, left : left + 80].min(axis=2) < 128)
        assert len(ink) > 20
        assert ink[:, 1].mean() == pytest.approx(40, abs=4)
    assert (sheet[70 : 70 + line, 92:98] == 255).all()
    assert (sheet[-10:] == 255).all()


def test_a_caption_wider_than_its_frame_is_cut_short():
    sheet = strip([frame(200), frame(200)], ["a caption that is far too long for its frame", ""], gap=10)
    beside = sheet[70:-10]
    assert (beside[:, :10] == 255).all()
    assert (beside[:, 90:] == 255).all()
    assert beside[:, 10:90].min() < 128


@pytest.mark.parametrize(
    ("text", "spelt"),
    [
        ("β = 0.8", "beta = 0.8"),
        ("Δt – 1", "Deltat - 1"),
        ("w₁", "w1"),
        ("5 − 3", "5 - 3"),
        ("日", "?"),
        ("2 µm", "2 um"),
        ("Größe 3²", "Grosse 32"),
        ("Łódź", "Lodz"),
        ("≤ 10⁻³", "<= 10-3"),
    ],
)
def test_letters_that_no_font_has_are_spelt_out(monkeypatch, text, spelt):
    monkeypatch.setattr(snapshot_strip, "_COMMON", ("no-such-font.ttf",))
    wide = frame(200, (60, 300))
    assert np.array_equal(strip([wide], [text]), strip([wide], [spelt]))


def test_letters_of_other_fonts_are_drawn_where_there_is_one(monkeypatch):
    other = Path(matplotlib.get_data_path()) / "fonts" / "ttf" / "DejaVuSans.ttf"
    wide = frame(200, (60, 300))
    monkeypatch.setattr(snapshot_strip, "_COMMON", ("no-such-font.ttf", str(other)))
    drawn = strip([wide], ["β = 0.8 µm"])
    plain = strip([wide], ["beta = 0.8 um"])
    monkeypatch.setattr(snapshot_strip, "_COMMON", ())
    assert np.array_equal(strip([wide], ["beta = 0.8 um"]), plain)
    assert np.array_equal(strip([wide], ["β = 0.8 µm"]), plain)
    assert drawn.shape != plain.shape or not np.array_equal(drawn, plain)


def test_letters_grow_with_the_frame_or_as_told():
    def height(sheet, below):
        ink = np.flatnonzero((sheet[below:].min(axis=2) < 128).any(axis=1))
        return ink[-1] - ink[0]

    small, large = frame(200, (100, 300)), frame(200, (600, 900))
    assert height(strip([large], ["Hg"], gap=0), 600) > 1.8 * height(strip([small], ["Hg"], gap=0), 100)
    assert height(strip([small], ["Hg"], gap=0, text_size=40), 100) > 30


def test_bad_input_is_refused_in_a_sentence():
    for arguments, sentence in (
        (([],), "needs at least one frame"),
        (([frame(0), frame(0, (60, 81))],), "all must hold uint8 of one shape"),
        (([frame(0)[..., 0]],), "all must hold uint8 of one shape"),
        (([frame(0)], ["a", "b"]), "There are 2 captions for 1 frames"),
        (([frame(0)], [], 0), "columns is 0 but must be a whole number from 1"),
        (([frame(0)], [], 1, -1), "gap is -1 but must be a whole number of px from 0 to 1000"),
    ):
        with pytest.raises(ValueError, match=sentence):
            strip(*arguments)


def test_a_strip_is_written_as_it_is(tmp_path):
    sheet = strip([frame(10), frame(90)], ["one", "two"])
    write_picture(sheet, tmp_path / "a.PNG")
    with PIL.Image.open(tmp_path / "a.PNG") as image:
        assert np.array_equal(np.asarray(image), sheet)
    with pytest.raises(ValueError, match=r"a\.jpg must end in \.png"):
        write_picture(sheet, tmp_path / "a.jpg")
    assert [path.name for path in tmp_path.iterdir()] == ["a.PNG"]
