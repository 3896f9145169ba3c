"""Hold the measured error against what is guaranteed and what the coefficient file allows."""

from __future__ import annotations

from collections.abc import Mapping

from gen.lowering.recursion.guarantee import rounded_up


def exceeded(bound_K: Mapping[str, float | None], error_K: Mapping[str, float], limit: float, entry: str) -> list[str]:
    """Give a sentence for each component whose measured error is larger than it may be.

    Parameters
    ----------
    bound_K
        By component, what is guaranteed, K; None where nothing could be proven.
    error_K
        By component, the largest measured distance from the exact solution, K.
    limit, entry
        The largest error with which a build is accepted, K, and the entry of `$.accuracy` that says so.
    """
    found = []
    for name, error in error_K.items():
        bound = bound_K[name]
        measured = f"component {name}: the measured error of {rounded_up(error):.1e} K exceeds"
        if bound is not None and error > bound:
            found.append(f"{measured} the guaranteed {rounded_up(bound):.1e} K: a defect of gen, please report it")
        elif error > limit:
            found.append(f"{measured} $.accuracy.{entry} = {limit:.1e} K")
    return found
