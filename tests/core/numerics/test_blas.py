"""Products of matrices keep to the thread that asks for them, and leave the process as it was."""

import time
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
import threadpoolctl

import cpm_core as cpm
from cpm_core.field.convolution import WindowedField
from cpm_core.numerics.parallel import limit_blas, limit_cores
from cpm_core.objects.prior.crops import resample_with_tent


def count_blas_threads():
    return [library["num_threads"] for library in threadpoolctl.threadpool_info() if library["user_api"] == "blas"]


def test_the_limit_of_threads_ends_with_its_context():
    with threadpoolctl.threadpool_limits(2, "blas"):
        before = count_blas_threads()
        with limit_blas():
            assert set(count_blas_threads()) == {1}
        assert count_blas_threads() == before


def test_two_threads_that_overlap_leave_the_limit_of_the_process_as_it_was():
    with threadpoolctl.threadpool_limits(2, "blas"):
        before, first, second = count_blas_threads(), limit_blas(), limit_blas()
        first.__enter__()
        second.__enter__()
        first.__exit__(None, None, None)
        assert set(count_blas_threads()) == {1}
        second.__exit__(None, None, None)
        assert count_blas_threads() == before


def test_the_limit_holds_on_whichever_thread_asks_for_it():
    with ThreadPoolExecutor(1) as living, threadpoolctl.threadpool_limits(2, "blas"):
        before = count_blas_threads()
        for submit in (living.submit, ThreadPoolExecutor(1).submit):
            limit = limit_blas()
            submit(limit.__enter__).result()
            assert set(count_blas_threads()) == {1}
            submit(limit.__exit__, None, None, None).result()
            assert count_blas_threads() == before


def click():
    cpm.partition(cpm.example("disk")).select([(10, 10)])


def sample_volume():
    resample_with_tent(np.ones((200, 200, 200)), [np.linspace(0.0, 199.0, 64)] * 3, (3.0, 3.0, 3.0))


def field_of_large_image():
    WindowedField(np.ones((2000, 2000), np.float32), None).field_in_window((slice(0, 2000), slice(0, 2000)))


@pytest.mark.parametrize("work", [click, sample_volume, field_of_large_image])
def test_on_one_core_no_other_thread_takes_processor_time(compiled_loops, work):
    work()
    with limit_cores(1), threadpoolctl.threadpool_limits(2, "blas"):
        used = time.process_time(), time.thread_time()
        work()
        process, caller = time.process_time() - used[0], time.thread_time() - used[1]
    assert process - caller < 0.01 + 0.01 * caller
