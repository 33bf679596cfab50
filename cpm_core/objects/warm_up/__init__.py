"""Compiling the loops of the model before their first use.

The first compilation takes many seconds: other processes compile the loops, each a part of them, and keep them in the
folder in which this one finds them. The calling process only waits, so that its window stays responsive.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

from cpm_core.objects.warm_up import aside
from cpm_core.objects.warm_up.parts import FIRST, LATER, VOLUMES, Part


def warm_up(
    canceled: Callable[[], bool] = lambda: False,
    told: Callable[[float], object] = lambda _: None,
    parts: Sequence[Part] = (*FIRST, *LATER),
) -> None:
    """Run every compiled loop of some parts once on small images; this may happen in a background thread.

    The first time this compiles the loops, in other processes where there is a second core, and keeps them; later it
    loads them. While it compiles, `told` is called with the fraction that is done. When `canceled()` becomes true the
    other processes are ended and nothing else is done.
    """
    aside.compile_parts([part for part in parts if not part.is_kept()], canceled, told)
    for part in parts:
        if not canceled():
            part.once()


def warm_up_volumes(
    canceled: Callable[[], bool] = lambda: False, told: Callable[[float], object] = lambda _: None
) -> None:
    """Run every compiled loop of volumes once on a small ball, as `warm_up` does those of images."""
    warm_up(canceled, told, VOLUMES)


def is_compiled(parts: Sequence[Part] = (*FIRST, *LATER)) -> bool:
    """Whether loops are kept, or brought by the program, so that nothing has to be compiled."""
    return all(part.is_kept() for part in parts)
