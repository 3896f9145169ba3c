"""Linear algebra in one thread."""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from typing import ParamSpec, TypeVar

_Given = ParamSpec("_Given")
_Result = TypeVar("_Result")


def one_thread(function: Callable[_Given, _Result]) -> Callable[_Given, _Result]:
    """Keep the linear algebra library to one thread while a function runs.

    The matrices are small: more threads would only wait for each other. In a notebook numpy is loaded long before, so
    that an environment variable comes too late.
    """

    @wraps(function)
    def limited(*args: _Given.args, **kwargs: _Given.kwargs) -> _Result:
        import scipy.linalg  # noqa: F401 - libraries are limited that are there: numpy's and scipy's own
        from threadpoolctl import threadpool_limits

        with threadpool_limits(1, user_api="blas"):
            return function(*args, **kwargs)

    return limited
