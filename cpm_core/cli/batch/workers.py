"""Execution of the jobs of a batch: in this process, in several processes, or on a dask cluster."""

from __future__ import annotations

import logging
import multiprocessing
import multiprocessing.connection
import signal
from asyncio import CancelledError
from collections.abc import Callable, Generator, Sequence
from contextlib import suppress
from multiprocessing.connection import Connection
from multiprocessing.process import BaseProcess
from typing import Any

from cpm_core.cli.batch.jobs import Done, Job, do
from cpm_core.formats.common.atomic import interrupts_handled
from cpm_core.numerics.parallel import at_most, cores
from cpm_core.objects.warm_up import is_compiled, warm_up

_LOG = logging.getLogger(__name__)

_PATIENCE = 5.0
"""How long a scheduler is waited for at the end [s]."""

_LOOK = 0.2
"""Time between two looks at whether to go on [s]."""

_DIED = "The process that worked on it ended unexpectedly; perhaps there was not enough memory."


def here(
    jobs: Sequence[Job], workers: int | None, go_on: Callable[[], object] | None = None
) -> Generator[Done, None, None]:
    """Do jobs on this computer and yield results as they finish.

    There is one process for each core unless `workers` gives a number. With one, jobs are done in this process, unless
    there is `go_on`. That is called several times a second, and what it raises ends all processes. A job whose process
    dies is tried once more, as the last one.
    """
    count, each = _shared(workers, len(jobs))
    if count <= 1 and (go_on is None or not jobs):
        with at_most(each):
            yield from map(do, jobs)
        return
    _compile_once(go_on)
    waiting = list(reversed(jobs))
    tried: set[int] = set()
    crew = [_Worker(each) for _ in range(count)]
    try:
        for worker in crew:
            worker.give(waiting.pop())
        while any(worker.job for worker in crew):
            busy = {worker.line: worker for worker in crew if worker.job}
            if go_on is not None:
                go_on()
            for line in multiprocessing.connection.wait(list(busy), _LOOK if go_on is not None else None):
                worker = busy[line]  # type: ignore[index]  # only those connections were given
                job = worker.job
                assert job is not None
                done = worker.take()
                again = worker.dead and job.number not in tried
                if again:  # perhaps others took the memory, or somebody ended the process
                    tried.add(job.number)
                    waiting.insert(0, job)
                if worker.dead and waiting:
                    crew[crew.index(worker)] = worker = _Worker(each)
                if waiting:
                    worker.give(waiting.pop())
                if not again:
                    yield done
    finally:
        for worker in crew:
            worker.end()


def _shared(workers: int | None, jobs: int) -> tuple[int, int]:
    """How many processes do so many jobs, and how many cores each uses: one, where there are not fewer jobs than cores.

    Threads within a process gain less than a process more, and whoever gives a number means so many cores.
    """
    count = min(workers or cores(), jobs)
    return count, 1 if workers else max(1, cores() // max(1, count))


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
    for name in ("distributed", "distributed.client"):  # what it would log, with tracebacks, is said in sentences
        logging.getLogger(name).setLevel(logging.CRITICAL)
    waiting = {job.number for job in jobs}
    futures: list[Any] = []
    try:
        futures = client.map(do, jobs, pure=False)
        number = {future.key: job.number for future, job in zip(futures, jobs, strict=True)}
        for future in as_completed(futures):
            done = _result(future, number[future.key])
            waiting.discard(done.number)
            yield done
    except (Exception, CancelledError) as error:  # whatever dask raises when its scheduler has gone
        _LOG.info("%s: %s", type(error).__name__, error)
        for left in sorted(waiting):
            yield Done(left, error=f"The scheduler at {address} has gone; start it again, and the same command.")
    finally:
        with suppress(Exception, CancelledError):
            client.cancel(futures)
        with suppress(Exception, CancelledError):
            client.close(timeout=_PATIENCE)


def _result(future: Any, number: int) -> Done:
    """What a future of dask holds, which is then let go: dask keeps all that is referred to."""
    failure = future.exception()
    done = Done(number, error=f"{_DIED} ({failure})") if failure is not None else future.result()
    future.release()
    assert isinstance(done, Done)
    return done


def _compile_once(go_on: Callable[[], object] | None) -> None:
    """Compile the loops once if they are not in the cache of this computer, before every process does it."""

    def stopped() -> bool:
        try:
            if go_on is not None:
                go_on()
        except Exception:  # it is raised again where nothing has to be ended first
            return True
        return False

    if not is_compiled():
        warm_up(stopped)
        if go_on is not None:
            go_on()


class _Worker:
    """A process that does one job after the other, and uses so many cores."""

    def __init__(self, use: int) -> None:
        context = multiprocessing.get_context("spawn")
        self.line, theirs = context.Pipe()
        self.job: Job | None = None
        self.dead = False
        self._process: BaseProcess = context.Process(target=_work, args=(theirs, use), daemon=True)
        with interrupts_handled(signal.SIG_IGN):  # this process ends those that it starts
            self._process.start()
        theirs.close()

    def give(self, job: Job) -> None:
        """Send it a job."""
        self.job = job
        with suppress(OSError):  # a process that has ended is noticed by `take`
            self.line.send(job)

    def take(self) -> Done:
        """Receive the result of its job."""
        assert self.job is not None
        number, self.job = self.job.number, None
        try:
            done = self.line.recv()
            assert isinstance(done, Done)
            return done
        except (EOFError, OSError):
            self.dead = True
            self.end()
            return Done(number, error=_DIED)

    def end(self) -> None:
        """Kill it."""
        self._process.kill()
        self._process.join()
        self.line.close()


def _work(line: Connection, use: int) -> None:
    """Do the jobs that arrive on a connection, until it is closed, on so many cores."""
    with suppress(EOFError, OSError), at_most(use):
        while True:
            line.send(do(line.recv()))
