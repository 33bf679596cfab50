"""Execution of the jobs of a batch: in this process, in several processes, or on a dask cluster."""

from __future__ import annotations

import logging
import multiprocessing
import signal
import time
from asyncio import CancelledError
from collections.abc import Callable, Generator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from cpm_core.cli.inputs import notes_on, reviewed, with_room
from cpm_core.cli.output import facts_of_run
from cpm_core.contours.result import Result
from cpm_core.formats import encoded, load_image, omission
from cpm_core.formats.common.atomic import interrupts_handled
from cpm_core.formats.common.content import fingerprint_if_read
from cpm_core.formats.common.provenance import with_shapes
from cpm_core.formats.images.reading import DEFAULT
from cpm_core.formats.sessions.session_file import SessionFile, part_for
from cpm_core.numerics.parallel import at_most, cores
from cpm_core.parameters import Parameters
from cpm_core.segmentation.evolve import segment
from cpm_core.shapes.document_shapes import charges_of, regions_of, seeds_on
from cpm_core.warm_up import is_compiled, warm_up

_LOG = logging.getLogger(__name__)

_LOOK = 0.2
"""Time between two looks at whether to go on [s]."""

_DIED = "The process that worked on it ended unexpectedly; perhaps there was not enough memory."


@dataclass(frozen=True, slots=True)
class Job:
    """A run on one image."""

    number: int  # index of the image
    path: str
    session: SessionFile  # start, regions, charges and review
    parameters: Parameters
    max_steps: int | None
    suffixes: tuple[str, ...]  # formats to write


@dataclass(frozen=True, slots=True)
class Done:
    """Result of a job; when it failed, `error` is one sentence and the rest is empty."""

    number: int  # index of the image
    facts: dict[str, object] = field(default_factory=dict)  # as in ``cpm run --json``
    files: dict[str, bytes] = field(default_factory=dict)  # suffix -> content
    error: str = ""
    notes: tuple[str, ...] = ()  # what was changed on reading, or left out of a file
    sha256: str = ""  # of the image file


def do(job: Job) -> Done:
    """Find the contours of one image; the files are only encoded, and the batch writes them together."""
    try:
        began = time.perf_counter()
        named, shapes = job.session.image, job.session.shapes
        image = load_image(job.path, **part_for(Path(job.path), DEFAULT if named is None else named.reading))
        parameters, small = with_room(job.parameters, image)
        found = segment(
            image,
            seeds_on(image, shapes, parameters.smoothing, parameters.channel),
            parameters,
            max_steps=job.max_steps,
            regions=regions_of(shapes, job.session.objects.barriers),
            charges=charges_of(shapes),
        )
        result = reviewed(with_shapes(found, shapes), image, parameters, job.session, kept=False)
        facts = facts_of_run(result, time.perf_counter() - began)
        files, notes = _files(result, job.suffixes)
        return Done(job.number, facts, files, notes=(*notes_on(image, parameters), *small, *notes), sha256=image.sha256)
    except Exception as error:  # a defect of the program does not concern the other images
        reason = str(error)
        if isinstance(error, MemoryError):
            reason = "There is not enough memory for this image."
        elif not isinstance(error, ValueError):
            _LOG.info("an unexpected error", exc_info=error)
            reason = f"Something unexpected happened: {type(error).__name__}: {error}."
        return Done(job.number, error=reason, sha256=fingerprint_if_read(Path(job.path)))


def _files(result: Result, suffixes: Sequence[str]) -> tuple[dict[str, bytes], list[str]]:
    """The files of a result by suffix, and why some hold less than it or cannot be made; ValueError when none can."""
    files: dict[str, bytes] = {}
    notes: list[str] = []
    failures: list[ValueError] = []
    for suffix in suffixes:
        try:
            files[suffix] = encoded(result, suffix)
            notes += filter(None, [omission(result, suffix)])
        except ValueError as error:
            failures.append(error)
            notes.append(f"{suffix} was not written: {error}")
    if failures and not files:
        raise failures[0]
    return files, notes


def here(
    jobs: Sequence[Job], workers: int | None, go_on: Callable[[], object] | None = None
) -> Generator[Done, None, None]:
    """Do jobs on this computer and yield results as they finish.

    There is one process for each core unless `workers` gives a number. With one, jobs are done in this process, unless
    there is `go_on`. That is called several times a second, and what it raises ends all processes. When a process dies,
    the jobs that were in work are done again at the end, each in a process of its own.
    """
    count = min(workers or cores(), len(jobs))
    each = 1 if workers else max(1, cores() // max(1, count))  # where there are more cores than jobs
    if count <= 1 and (go_on is None or not jobs):
        with at_most(each):
            yield from map(do, jobs)
        return
    if not is_compiled():  # once, before every process does it
        warm_up()
    waiting, suspects = list(reversed(jobs)), []
    while waiting:
        for done in _in_processes(waiting, count, each, go_on):
            if isinstance(done, Job):
                suspects.append(done)
            else:
                yield done
    for job in suspects:
        for done in _in_processes([job], 1, each, go_on):
            yield Done(job.number, error=_DIED) if isinstance(done, Job) else done


def _in_processes(
    waiting: list[Job], count: int, each: int, go_on: Callable[[], object] | None
) -> Generator[Done | Job, None, None]:
    """Do the last jobs of a list in so many processes, each on so many cores.

    Where a process dies the jobs that were in work are yielded themselves, and the others stay in the list.
    """
    pool = ProcessPoolExecutor(count, multiprocessing.get_context("spawn"), _begin, (each,))
    working: dict[Future[Done], Job] = {}
    broken = False
    try:
        while working or (waiting and not broken):
            while waiting and not broken and len(working) < count:  # no more, so that few results wait in memory
                try:
                    with interrupts_handled(signal.SIG_IGN):  # this process ends those that it starts
                        working[pool.submit(do, waiting[-1])] = waiting[-1]
                    waiting.pop()
                except BrokenProcessPool:
                    broken = True
            if go_on is not None:
                go_on()
            for future in wait(working, _LOOK, FIRST_COMPLETED).done:
                job = working.pop(future)
                try:
                    done: Done | Job = future.result()
                except BrokenProcessPool:
                    done, broken = job, True
                yield done
    finally:
        processes = list((pool._processes or {}).values())
        pool.shutdown(wait=False, cancel_futures=True)
        for process in processes:
            process.kill()


def _begin(use: int) -> None:
    """Let a new process use so many cores."""
    at_most(use).__enter__()


def elsewhere(jobs: Sequence[Job], address: str) -> Generator[Done, None, None]:
    """Do jobs on the workers of a dask scheduler, which must see the same files under the same names.

    ValueError when dask is not installed, or no scheduler answers at the address.
    """
    try:
        from distributed import Client, as_completed
    except ImportError:
        raise ValueError(
            "--scheduler needs the package distributed, which is not installed: install it "
            '(pip install "cpm-particles[batch]"), or use --workers.'
        ) from None
    try:
        client = Client(address, timeout=10)
    except (OSError, ValueError, TimeoutError) as error:
        raise ValueError(f'--scheduler is "{address}" but no scheduler answers there: {error}.') from error
    waiting = {job.number for job in jobs}
    futures: list[Any] = []
    try:
        futures = client.map(do, jobs, pure=False)
        numbers = {future.key: job.number for future, job in zip(futures, jobs, strict=True)}
        for future in as_completed(futures):
            number, failure = numbers[future.key], future.exception()
            done = Done(number, error=f"{_DIED} ({failure})") if failure is not None else future.result()
            future.release()  # dask keeps all that is referred to
            waiting.discard(number)
            yield done
    except (Exception, CancelledError) as error:  # whatever dask raises when its scheduler has gone
        _LOG.info("%s: %s", type(error).__name__, error)
        for left in sorted(waiting):
            yield Done(left, error=f"The scheduler at {address} has gone; start it again, and the same command.")
    finally:
        with suppress(Exception, CancelledError):
            client.cancel(futures)
        with suppress(Exception, CancelledError):
            client.close(timeout=5)
