"""How often the recursion runs within one sample: as seldom as the error bound allows."""

from __future__ import annotations

from collections.abc import Callable
from math import inf
from typing import Protocol, TypeVar

from gen.lowering.recursion.guarantee import Proof

#: Numbers of runs that are tried, in order.
_SUBSTEPS = (1, 2, 4, 8)


class _Provable(Protocol):
    @property
    def proof(self) -> Proof | None: ...


_Lowered = TypeVar("_Lowered", bound=_Provable)


def fewest_substeps(
    order: int, limit_K: float, lower_with: Callable[[int], _Lowered], *, hopeless: float = inf
) -> _Lowered:
    """The first lowering whose proven bound holds, else the one with the smallest bound, else the first.

    Parameters
    ----------
    order
        The component's; order 1 is exact at any step, so a finer one is not tried.
    limit_K
        The error bound to aim for.
    lower_with
        Lowers the component with a number of substeps.
    hopeless
        A bound of so many times the limit lets the next number be left out: a proof takes its time.
    """
    best = lower_with(_SUBSTEPS[0])
    far = False
    for substeps in _SUBSTEPS[1:]:
        smallest = best.proof.bound_K if best.proof is not None else inf
        if smallest <= limit_K or order == 1:
            break
        far = not far and hopeless * limit_K < smallest < inf
        if far:
            continue
        tried = lower_with(substeps)
        if tried.proof is not None and tried.proof.bound_K < smallest:
            best = tried
    return best
