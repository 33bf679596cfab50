"""Silence: keeps libraries written in C from talking to the user."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Iterator


@contextlib.contextmanager
def native_silence() -> Iterator[None]:
    """Send the standard error of the whole process nowhere for a moment.

    libtiff prints every oddity of a file straight to the file descriptor, and Pillow offers no way to tell it not to.
    """
    try:
        kept = os.dup(2)
    except OSError:  # a window without a console has no standard error to keep quiet
        yield
        return
    nowhere = os.open(os.devnull, os.O_WRONLY)
    try:
        os.dup2(nowhere, 2)
        yield
    finally:
        os.dup2(kept, 2)
        os.close(kept)
        os.close(nowhere)
