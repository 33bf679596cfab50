"""A value that begins with a minus sign is a value of every option, and no option itself."""

import argparse

import pytest

from cpm_core import cli

COMMANDS = next(
    action.choices for action in cli.build_parser()._actions if isinstance(action, argparse._SubParsersAction)
)  # fmt: skip
NEEDED = {"batch": ["--session=s", "--output=o"], "export": ["--to=a.svg"]}
TAKING = [
    (name, option)
    for name, parser in COMMANDS.items()
    for action in parser._actions
    for option in action.option_strings
    if action.nargs != 0 and "--help" not in action.option_strings
]


def read(name, *given):
    """What a command line says, or how it is refused."""
    parser = COMMANDS[name]
    named = [] if name in ("bench", "completion") else ["a.png"]
    try:
        return vars(parser.parse_args([*named, *NEEDED.get(name, ()), *given]))
    except ValueError as error:
        return str(error)


@pytest.mark.parametrize("value", ["-50,-50,3", "-.5,2", "-1e-3", "-Infinity"])
def test_every_option_reads_a_negative_number_as_it_does_after_an_equals_sign(value):
    assert len(TAKING) > 100
    for name, option in TAKING:
        assert read(name, option, value) == read(name, f"{option}={value}"), (name, option)
