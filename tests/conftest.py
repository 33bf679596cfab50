"""Settings that every test shares."""

import gc
import os
import signal
import subprocess
import sys
from collections.abc import Generator, Iterator
from pathlib import Path

import pytest
from hypothesis import HealthCheck, settings

from cpm_core.numerics.parallel import count_cores
from cpm_core.warm_up import is_compiled, warm_up

TESTS = Path(__file__).parent
_MOST_WORKERS = 4
"""Processes beyond which the memory that each one takes costs more than it saves."""

# No window of a test shall flash on a person's screen unless asked for by naming a platform.
os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")

# Tests read the sentences of the source, on the computer of a person of any language.
os.environ["LANGUAGE"] = "en"

# Processes that tests start need not compile the sources again, which takes each of them half a second.
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
sys.dont_write_bytecode = False

# No test depends on how fast the computer is, nor on chance: examples never tried before are for the second tier.
settings.register_profile(
    "ordinary", max_examples=40, deadline=None, derandomize=True, suppress_health_check=[HealthCheck.too_slow]
)
settings.register_profile("chance", settings.get_profile("ordinary"), derandomize=False)
settings.load_profile(os.environ.get("CPM_EXAMPLES", "ordinary"))


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_auto_num_workers(config: pytest.Config) -> int:
    """One process for each core; none beside the first for single files, which begin sooner without."""
    few = all((config.invocation_params.dir / name.partition("::")[0]).is_file() for name in config.args)
    return 0 if few or count_cores() == 1 else min(count_cores(), _MOST_WORKERS)


def pytest_sessionstart(session: pytest.Session) -> None:
    """Compile the model's loops and the tests once, before the processes that share them begin."""
    if getattr(session.config.option, "numprocesses", None) and not is_compiled():
        processes = [
            subprocess.Popen(
                [
                    sys.executable,
                    "-c",
                    f"import pytest, cpm_core.warm_up as loops; loops.{call}();"
                    f"pytest.main(['--collect-only', '-q', '-n0', {str(TESTS / folder)!r}])",
                ],
                stdout=subprocess.DEVNULL,
            )
            for call, folder in (("warm_up", "app"), ("warm_up_volumes", "core"))
        ]
        for process in processes:
            assert process.wait() == 0


@pytest.hookimpl(wrapper=True)
def pytest_collection() -> Generator[None]:
    """Leave modules and collected tests, which stay to the end, out of every collection of garbage."""
    gc.disable()
    collected = yield
    gc.collect()
    gc.freeze()
    gc.enable()
    return collected


@pytest.fixture(scope="session")
def compiled_loops() -> None:
    """Compile the model's loops, so that no test of the window has to wait for that."""
    warm_up()


@pytest.fixture
def interrupts_heeded() -> Iterator[None]:
    """Let processes that a test starts heed interrupts, even where a script has started the tests in the background.

    What a shell without job control starts there ignores them, and hands that on to all that it starts itself.
    """
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)
