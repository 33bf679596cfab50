"""Compiling the loops of the model before their first use.

The first compilation takes many seconds: other processes compile the loops, each a part of them, and keep them in the
folder in which this one finds them. The calling process only waits, so that its window stays responsive.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence

from cpm_core.objects.warm_up import aside
from cpm_core.objects.warm_up.parts import FIRST, LATER, VOLUMES, Part

__all__ = ["FIRST", "LATER", "VOLUMES", "compile_ahead", "is_compiled", "warm_up", "warm_up_runs", "warm_up_volumes"]


def _never() -> bool:
    return False


def _ignored(_: float) -> None: ...


def warm_up(
    canceled: Callable[[], bool] = _never,
    told: Callable[[float], object] = _ignored,
    parts: Sequence[Part] = (*FIRST, *LATER),
    gently: bool = False,
) -> None:
    """Run every compiled loop of some parts once on small images; this may happen in a background thread.

    The first time this compiles the loops, in other processes where there is a second core, and keeps them; later it
    loads them. While it compiles, `told` is called with the fraction that is done. When `canceled()` becomes true the
    other processes are ended and nothing else is done. Other programs go before them if `gently`.
    """
    compile_ahead(parts, canceled, told, gently)
    for part in parts:
        if not canceled():
            part.once()


def warm_up_runs(canceled: Callable[[], bool] = _never, told: Callable[[float], object] = _ignored) -> None:
    """Load the loops of images, or compile those of a run: the others are then compiled while the program is used."""
    warm_up(canceled, told, FIRST)
    if is_compiled(LATER):
        warm_up(canceled, parts=LATER)
    else:
        given = {"parts": LATER, "gently": True}
        threading.Thread(target=warm_up, args=(canceled,), kwargs=given, name="cpm-compile", daemon=True).start()


def warm_up_volumes(canceled: Callable[[], bool] = _never, told: Callable[[float], object] = _ignored) -> None:
    """Run every compiled loop of volumes once on a small ball, as `warm_up` does those of images."""
    warm_up(canceled, told, VOLUMES)


def compile_ahead(
    parts: Sequence[Part],
    canceled: Callable[[], bool] = _never,
    told: Callable[[float], object] = _ignored,
    gently: bool = False,
) -> None:
    """Compile the loops of those parts that are not kept, as `warm_up` does, and load none of them."""
    aside.compile_parts([part for part in parts if not part.is_kept()], canceled, told, gently)


def is_compiled(parts: Sequence[Part] = (*FIRST, *LATER)) -> bool:
    """Whether loops are kept, or brought by the program, so that nothing has to be compiled."""
    return all(part.is_kept() for part in parts)
