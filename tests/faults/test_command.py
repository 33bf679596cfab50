"""The command tells what it found whenever it is stopped."""

import signal
import tempfile
import threading
import time
from pathlib import Path
from random import Random

import pytest

from . import __main__ as command
from .fuzzing.trials import at_length
from .kills.nursery import outcome
from .report import Budget, Report, going_on


def stopped_soon(budget: Budget) -> Report:
    """A part of an hour that finds one failure, and is stopped."""
    end = time.monotonic() + budget.seconds
    signal.raise_signal(signal.SIGTERM)
    assert not going_on(end)
    return Report(3, failures=("the first input fails",))


def trial(random: Random, folder: Path) -> int:
    """One input, and then one that takes long."""
    begun = folder.parent / "begun"
    if begun.exists():
        time.sleep(3600.0)
    begun.touch()
    return 1


def goes_on(seconds: float) -> int:
    """One input, until it is told to stop."""
    Path("..", "begun").touch()
    end = time.monotonic() + seconds
    while going_on(end):
        time.sleep(0.01)
    return 1 if time.monotonic() < end else 0


def stop_when(begun: Path) -> None:
    """Stop the command when a file exists."""
    while not begun.exists():
        time.sleep(0.01)
    signal.raise_signal(signal.SIGINT)


def test_a_command_that_is_stopped_tells_what_it_has_found(monkeypatch, capsys):
    monkeypatch.setattr(command, "PARTS", {"one": ("inputs", stopped_soon), "two": ("others", stopped_soon)})
    monkeypatch.setattr("sys.argv", ["faults", "--minutes", "60"])
    usual = signal.getsignal(signal.SIGTERM)
    assert command.main() == 1
    said = capsys.readouterr().out
    assert "one: the first input fails" in said
    assert "| inputs | 3 | 0 | 0.00 | 1 |" in said
    assert "others" not in said, "the next part began"
    assert signal.getsignal(signal.SIGTERM) is usual


@pytest.mark.parametrize("of", [trial, goes_on])
def test_other_processes_end_with_the_command_and_tell_theirs(monkeypatch, tmp_path, capsys, of):
    def in_a_process(budget: Budget) -> Report:
        found = at_length(trial, budget) if of is trial else outcome(budget.folder, of, 3600.0, busy=3600.0).value
        return found if isinstance(found, Report) else Report(found)

    stop = threading.Thread(target=stop_when, args=(tmp_path / "begun",))
    stop.start()
    monkeypatch.setattr(command, "PARTS", {"one": ("inputs", in_a_process)})
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    monkeypatch.setattr("sys.argv", ["faults", "--minutes", "60"])
    assert command.main() == 0
    stop.join()
    assert "| inputs | 1 | 0 |" in capsys.readouterr().out
