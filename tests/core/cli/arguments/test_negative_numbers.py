"""A value that begins with a minus sign is a value of every option, and no option itself."""

import argparse
import json

import numpy as np
import PIL.Image
import pytest

from cpm_core import cli

COMMANDS = next(
    action.choices for action in cli.parser()._actions if isinstance(action, argparse._SubParsersAction)
)  # fmt: skip
NEEDED = {"batch": ["--session=s", "--output=o"], "export": ["--to=a.svg"]}
TAKING = [
    (name, option)
    for name, parser in COMMANDS.items()
    for action in parser._actions
    for option in action.option_strings
    if action.nargs != 0
]


def read(name, *given):
    """What a command line says, or how it is refused."""
    parser = COMMANDS[name]
    named = [] if name in ("bench", "completion") else ["a.png"]
    try:
        return vars(parser.parse_args([*named, *NEEDED.get(name, ()), *given]))
    except ValueError as error:
        return str(error)


@pytest.mark.parametrize("value", ["-50,-50,3", "-5", "-.5,2", "-1e-3", "-inf,1,1", "-Infinity"])
def test_every_option_reads_a_negative_number_as_it_does_after_an_equals_sign(value):
    assert len(TAKING) > 100
    for name, option in TAKING:
        assert read(name, option, value) == read(name, f"{option}={value}"), (name, option)


@pytest.fixture
def corner(tmp_path):
    """An image with a bright quarter of a disk, whose center lies outside the image."""
    row, col = np.mgrid[:60, :60]
    PIL.Image.fromarray((200 * (np.hypot(row + 5, col + 5) < 40)).astype(np.uint8)).save(tmp_path / "corner.png")
    return tmp_path / "corner.png"


def test_a_run_starts_from_a_circle_whose_center_lies_outside_the_image(corner, command):
    status, out, _ = command("run", corner, "--circle", "-5,-5,25", "--json")
    facts = json.loads(out)
    assert (status, facts["contours"]) == (0, 1)
    assert facts["provenance"]["shapes"] == [{"shape": "circle", "center": [-5.0, -5.0], "radius": 25.0}]


def test_methods_are_compared_from_a_polygon_that_begins_outside_the_image(corner, command):
    status, out, _ = command("compare", corner, "--polygon", "-5,-5,-5,20,20,20,20,-5", "--methods", "gvf", "--json")
    assert (status, json.loads(out)["methods"][0]["contours"]) == (0, 1)
