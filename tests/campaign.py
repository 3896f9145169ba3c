"""How much of a campaign is run: all with GEN_CAMPAIGN=full, else a share, always the same."""

from __future__ import annotations

import os
from collections.abc import Iterable
from typing import TypeVar

FULL = os.environ.get("GEN_CAMPAIGN") == "full"
_Case = TypeVar("_Case")


def share(cases: Iterable[_Case], one_in: int = 3) -> list[_Case]:
    """Cases that are much alike, as defects planted in one program: every third of them, or all in a full campaign.

    Parameters
    ----------
    cases
        All. Lists go on in the order of what they are about, so that every third is of all kinds.
    one_in
        How many cases one stands for.
    """
    return list(cases)[:: 1 if FULL else one_in]
