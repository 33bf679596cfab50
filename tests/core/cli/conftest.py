"""The command line, as tests call it, and what most of them run it on."""

import json

import numpy as np
import PIL.Image
import pytest

from cpm_core import cli


@pytest.fixture
def command(capsys):
    """Function that runs the command line and returns its exit status, output and error output."""

    def run(*arguments):
        status = cli.main([str(argument) for argument in arguments])
        output = capsys.readouterr()
        return status, output.out, output.err

    return run


@pytest.fixture
def told(command):
    """Function that runs the command line, which succeeds without a word, and returns what it prints as JSON."""

    def run(*arguments):
        status, out, err = command(*arguments, "--json")
        assert (status, err) == (0, "")
        return json.loads(out)

    return run


@pytest.fixture
def disk(tmp_path):
    """Path of an image of a bright disk of radius 18 around (40, 50)."""
    away = np.hypot(*(np.mgrid[:80, :100] - np.array([40.0, 50.0])[:, None, None]))
    PIL.Image.fromarray((220 * np.clip(18.5 - away, 0, 1)).astype(np.uint8)).save(tmp_path / "disk.png")
    return tmp_path / "disk.png"
