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
