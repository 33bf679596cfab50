"""Products of small matrices keep to the thread that asks for them, and leave the process as it was."""

import threadpoolctl

from cpm_core.numerics.parallel import limit_blas


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
