"""Settings that every test shares."""

import os
import signal
from collections.abc import Iterator

import pytest

from cpm_core.objects.warm_up import warm_up

# No window of a test shall flash on a person's screen unless asked for by naming a platform.
os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")

# Tests read the sentences of the source, on the computer of a person of any language.
os.environ["LANGUAGE"] = "en"


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
