"""The command line, as tests call it."""

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
