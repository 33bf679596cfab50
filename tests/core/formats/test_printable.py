"""Names that come from elsewhere do no harm in any file, on a terminal or in a spreadsheet."""

import csv
import json
import xml.etree.ElementTree as ET
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cpm_core.formats import CONTOURS_WRITABLE, load_contours, to_bytes
from cpm_core.formats.common.printable import escape_cell, make_printable, unescape_cell

from .drawn import LINE_AND_SQUARE, RESULT

WILD = "a\x00\x1b[31m\n\udce9\x85\ufffe<&>"


def named(name, result=RESULT):
    contours = tuple(replace(contour, name=name) for contour in result.contours)
    return replace(result, contours=contours, source=f"{name}.png")


@pytest.mark.parametrize("suffix", CONTOURS_WRITABLE)
def test_every_format_takes_every_name(suffix):
    result = named(WILD)
    content = to_bytes(replace(result, contours=result.contours[:1]), suffix)
    assert content
    if suffix == ".svg":
        assert "\ufffd[31m" in " ".join(ET.fromstring(content).itertext())
    elif suffix.endswith("json"):
        json.loads(content)
        assert b"\\ud" not in content.lower() and b"\\u00" not in content
    elif suffix.endswith("csv"):
        assert b"\x1b" not in content
        assert len(list(csv.DictReader(content.decode().splitlines()))) >= 1


@given(st.text(st.characters(codec=None)))
def test_what_is_printed_can_be_encoded_and_has_no_controls(text):
    shown = make_printable(text)
    assert len(shown) == len(text)
    assert shown.encode().decode() == shown
    assert not any(letter < " " or "\x7f" <= letter <= "\x9f" for letter in shown)
    assert make_printable(shown) == shown


@pytest.mark.parametrize("name", ["=1+1", "+cmd|' /C calc'!A0", "-2", "@SUM(A1)", "'=x", "''", "plain", "it's"])
def test_a_name_is_no_formula_in_a_spreadsheet_and_is_read_back(tmp_path, name):
    content = to_bytes(named(name, LINE_AND_SQUARE), ".csv")
    cells = {row["name"] for row in csv.DictReader(content.decode().splitlines())}
    assert not any(content.startswith(("=", "+", "-", "@")) for content in cells)
    (tmp_path / "a.csv").write_bytes(content)
    assert {contour.name for contour in load_contours(tmp_path / "a.csv")} == {name}


@given(st.text())
def test_a_cell_gives_back_its_text(text):
    assert unescape_cell(escape_cell(text)) == make_printable(text)
