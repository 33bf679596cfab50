"""How far a run is, shown on the terminal."""

from __future__ import annotations

import sys
import time

from cpm_core.particles import State

_REDRAW = 0.1  # [s] between two lines of progress


class Progress:
    """A line on a terminal that says how far the run is."""

    def __init__(self) -> None:
        self._due = 0.0

    def __call__(self, state: State) -> None:
        """Show a state, unless the last one was shown a moment ago."""
        now = time.monotonic()
        if now >= self._due:
            self._due = now + _REDRAW
            text = f"step {state.step}  scale {state.scale}  particles {state.count}"
            print(f"\r\x1b[2K{text}", end="", file=sys.stderr, flush=True)

    def clear(self) -> None:
        """Take the line away."""
        print("\r\x1b[2K", end="", file=sys.stderr, flush=True)
