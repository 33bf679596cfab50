"""Execution of the jobs of a batch: in this process, in several processes, or on a dask cluster."""

from __future__ import annotations

import gc
import logging
import multiprocessing
import os
import signal
import threading
import time
from collections.abc import Callable, Generator, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import field, replace
from pathlib import Path
from typing import Any, Literal

from cpm_core.cli.inputs import fit_scales_to_image, list_image_notes
from cpm_core.cli.output import collect_run_facts
from cpm_core.formats import encode_files
from cpm_core.formats.common.atomic import write_together
from cpm_core.formats.common.content import try_fingerprint
from cpm_core.formats.common.provenance import VERSION
from cpm_core.formats.sessions.session_file import SessionFile
from cpm_core.formats.sessions.session_run import load_session_image, run
from cpm_core.numerics.packages import MissingPackageError
from cpm_core.numerics.parallel import count_cores, limit_cores
from cpm_core.numerics.types import Callback, Texts, frozen
from cpm_core.parameters import Parameters
from cpm_core.results import is_likely, replace_by_objects
from cpm_core.warm_up import is_compiled, warm_up

_LOG = logging.getLogger(__name__)

_JOB_POLL_INTERVAL = 0.2
"""Time between two checks for cancellation [s]."""

_PROCESS_DIED = "The process that worked on it ended unexpectedly; perhaps there was not enough memory."
"""Error of an image whose process died."""


BatchKind = Literal["objects", "contours"]
"""What is written of each image."""

NamedFiles = tuple[tuple[Path, str], ...]
"""Files to write, each with the suffix of its format."""


@frozen
class BatchRow:
    """Outcome for one image.

    Attributes
    ----------
    image : str
        The image as the user named it.
    facts : mapping
        As in ``cpm run --json``, and the number of objects; empty when it failed.
    files : tuple of str
        Names of the files that were written, in the folder of the batch.
    trouble : str
        Why it failed, in a sentence, or empty.
    notes : tuple of str
        Changes on reading, and omissions from a file.
    image_sha256, session_sha256 : str
        Hashes of the image and the session file.
    settings : str
        Settings in addition to the session: other parameters, steps, formats.
    version : str
        Version of the program.
    finished : str
        When it was finished, in UTC.
    """

    image: str
    facts: dict[str, object] = field(default_factory=dict)
    files: Texts = ()
    trouble: str = ""
    notes: Texts = ()
    image_sha256: str = ""
    session_sha256: str = ""
    settings: str = ""
    version: str = VERSION
    finished: str = ""

    @property
    def found(self) -> int:
        """Number of objects, or of contours where only those were written."""
        return int(str(self.facts.get("objects", self.facts.get("contours", 0))))


@frozen
class BatchJob:
    """A run on one image."""

    number: int  # index of the image
    row: BatchRow  # values known in advance
    path: str
    session: SessionFile  # start, regions and charges
    parameters: Parameters
    max_steps: int | None
    files: NamedFiles
    kind: BatchKind = "objects"


def run_job(job: BatchJob) -> BatchRow:
    """Find the objects of one image, or its contours, and write all files that can hold them, or none."""
    try:
        began = time.perf_counter()
        image = load_session_image(job.path, job.session)
        parameters, small = fit_scales_to_image(job.parameters, image)
        shown = result = run(image, job.session, parameters, job.max_steps)
        facts = collect_run_facts(result)
        if job.kind == "objects":
            facts["objects"], facts["likely"] = len(result.objects), sum(map(is_likely, result.objects))
            shown = replace_by_objects(result, result.objects, job.session.objects)
        facts["seconds"] = round(time.perf_counter() - began, 3)
        notes, suffixes = [*list_image_notes(image, parameters), *small], dict(job.files)
        contents = encode_files(
            shown,
            job.files if facts.get("objects", 1) else (),
            image=job.path,
            warn=lambda _, sentence: notes.append(sentence),
            refused=lambda file, reason: notes.append(f"{suffixes[file]} was not written: {reason}"),
        )
        write_together(contents)
        files = tuple(file.name for file, _ in contents if file in suffixes)
        return replace(job.row, facts=facts, files=files, notes=tuple(notes), image_sha256=image.sha256)
    except Exception as error:  # a defect must not stop the other images
        reason = str(error)
        if isinstance(error, MemoryError):
            reason = "There is not enough memory for this image."
        elif not isinstance(error, ValueError):
            _LOG.info("an unexpected error", exc_info=error)
            reason = f"Something unexpected happened: {type(error).__name__}: {error}."
        return replace(job.row, trouble=reason, image_sha256=try_fingerprint(Path(job.path)))


def run_locally(
    jobs: Sequence[BatchJob], workers: int | None, check_cancelled: Callback | None = None
) -> Generator[tuple[BatchJob, BatchRow], None, None]:
    """Run jobs on this computer and yield results as they finish.

    There is one process per core unless `workers` gives a number. With one, jobs run in this process, unless there is
    `check_cancelled`: it is called several times a second, and an exception from it ends all processes. When a process
    dies, the jobs in progress are repeated at the end, each in a process of its own.
    """
    count = min(workers or count_cores(), len(jobs))
    each = 1 if workers else max(1, count_cores() // max(1, count))  # if there are more cores than jobs
    if count <= 1 and check_cancelled is None:
        with limit_cores(each):
            yield from ((job, run_job(job)) for job in jobs)
        return
    if not is_compiled():  # once, instead of in every process
        warm_up()
    waiting, suspects = list(reversed(jobs)), []
    while waiting:
        for job, row in _run_in_processes(waiting, count, each, check_cancelled):
            if row is None:
                suspects.append(job)
            else:
                yield job, row
    for job in suspects:
        for _, row in _run_in_processes([job], 1, each, check_cancelled):
            yield job, row or replace(job.row, trouble=_PROCESS_DIED)


def _run_in_processes(
    waiting: list[BatchJob], count: int, cores_each: int, check_cancelled: Callback | None
) -> Generator[tuple[BatchJob, BatchRow | None], None, None]:
    """Run jobs from the end of a list in `count` processes, each on `cores_each` cores.

    When a process dies, the jobs in progress have no row, and the others stay in the list.
    """
    try:
        pool = ProcessPoolExecutor(count, multiprocessing.get_context("spawn"), _initialize_worker, (cores_each,))
    except OSError as error:  # as in a container without shared memory
        raise ValueError(
            f"Other processes cannot be started ({error.strerror}), which need shared memory: use one worker."
        ) from error
    working: dict[Future[BatchRow], BatchJob] = {}
    broken = False
    try:
        while working or (waiting and not broken):
            while waiting and not broken and len(working) < count:  # no more, so that only few results wait in memory
                try:
                    working[pool.submit(run_job, waiting[-1])] = waiting[-1]
                    waiting.pop()
                except BrokenProcessPool:
                    broken = True
            if check_cancelled is not None:
                check_cancelled()
            for future in wait(working, _JOB_POLL_INTERVAL, FIRST_COMPLETED).done:
                job, row = working.pop(future), None
                try:
                    row = future.result()
                except BrokenProcessPool:
                    broken = True
                yield job, row
    finally:
        processes = list((pool._processes or {}).values())
        pool.shutdown(wait=False, cancel_futures=True)
        for process in processes:
            process.kill()


def _initialize_worker(core_count: int) -> None:
    """Let a new process use `core_count` cores, and exit when its parent is killed."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the parent ends it
    limit_cores(core_count).__enter__()
    parent = multiprocessing.parent_process()

    def end_with_parent() -> None:
        if parent is not None:
            parent.join()
            os._exit(1)

    threading.Thread(target=end_with_parent, daemon=True).start()


def run_on_scheduler(jobs: Sequence[BatchJob], address: str) -> Generator[tuple[BatchJob, BatchRow], None, None]:
    """Run jobs on the workers of a dask scheduler, which must see the same files under the same names.

    ValueError as for `connect_to_dask`.
    """
    waiting = dict(enumerate(jobs))
    with connect_to_dask(address) as client:
        try:
            for at, future in map_until_finished(client, run_job, jobs):
                job, failure = waiting.pop(at), future.exception()
                yield (
                    job,
                    future.result() if failure is None else replace(job.row, trouble=f"{_PROCESS_DIED} ({failure})"),
                )
        except (Exception, _cancelled_error()) as error:  # dask raises many kinds when its scheduler has gone
            _LOG.info("%s: %s", type(error).__name__, error)
            gone = f"The scheduler at {address} has gone; start it again, and the same command."
            yield from ((job, replace(job.row, trouble=gone)) for job in waiting.values())


@contextmanager
def connect_to_dask(address: str | None, workers: int | None = None) -> Iterator[Any]:
    """Connect to the dask scheduler at an address, or start one with local workers, by default one per core.

    ValueError when dask is not installed, or no scheduler answers at the address.
    """
    try:
        import dask
        from distributed import Client, LocalCluster
    except ImportError:
        raise MissingPackageError("A run by workers", "distributed") from None
    with ExitStack() as stack:
        # the profiler samples every 10 ms, which takes a tenth of a worker's time and of another worker's core
        stack.enter_context(dask.config.set({"distributed.worker.profile.enabled": False}))
        try:
            local = address or stack.enter_context(
                LocalCluster(
                    n_workers=workers or count_cores(),
                    threads_per_worker=1,
                    memory_limit=0,
                    dashboard_address=":0",
                    silence_logs=logging.ERROR,
                )
            )
            client = Client(local, timeout=10)
        except (OSError, ValueError, TimeoutError) as error:
            raise ValueError(f'--scheduler is "{address}" but no scheduler answers there: {error}.') from error
        try:
            yield client
        finally:
            with suppress(Exception, _cancelled_error()):
                client.close(timeout=5)


def _cancelled_error() -> type[BaseException]:
    """Return what dask raises in a thread that is cancelled."""
    from asyncio import CancelledError  # takes long to import, and every command imports this module

    return CancelledError


def map_until_finished(
    client: Any, function: Callable[[Any], Any], jobs: Sequence[Any]
) -> Generator[tuple[int, Any], None, None]:
    """Apply a function to jobs on the workers of a client; yield the index and the future of each as it finishes.

    When a worker dies, dask repeats its job on another one.
    """
    from distributed import as_completed

    waiting = {future: at for at, future in enumerate(client.map(function, jobs, pure=False))}
    try:
        for future in as_completed(list(waiting)):
            yield waiting.pop(future), future
            future.release()  # dask keeps every result that is referred to
    finally:
        with suppress(Exception, _cancelled_error()):
            client.cancel(list(waiting))


def run_on_one_core(function: Callable[[Any], Any], job: Any) -> Any:
    """Run a job on one core, as others have workers of their own, and leave nothing of it in memory."""
    if not gc.get_freeze_count():
        gc.freeze()  # the collector need not visit modules after each job
    try:
        with limit_cores(1):
            return function(job)
    finally:
        gc.collect()  # fields and their caches refer to one another
