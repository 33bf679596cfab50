"""Settings that every test shares."""

import os

import pytest

from cpm_core.compilation import warm_up

# No window of a test shall flash on a person's screen unless asked for by naming a platform.
os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")


@pytest.fixture(scope="session")
def compiled_loops() -> None:
    """Compile the model's loops, so that no test of the window has to wait for that."""
    warm_up()
