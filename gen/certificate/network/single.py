"""Literals of float32."""

from __future__ import annotations

import re

import numpy as np

from gen.certificate.exact import Ratio
from gen.certificate.refuted import Refuted

_LITERAL = re.compile(r"\d+\.?\d*(?:e[+-]?\d+)?f")


def single(literal: str) -> float:
    """The float32 that the compiler reads.

    Raises
    ------
    Refuted
        If it is no literal of float32, or two of these are as near.
    """
    if not _LITERAL.fullmatch(literal):
        raise Refuted(f"{literal} is no number of float32")
    with np.errstate(over="ignore"):
        exact, found = Ratio(literal[:-1]), np.float32(literal[:-1])
    if not np.isfinite(found):
        raise Refuted(f"{literal} is no number of float32")
    off = abs(exact - Ratio(float(found)))
    beside = [float(np.nextafter(found, np.float32(end))) for end in (-np.inf, np.inf)]
    # Read by way of float64, which could round twice.
    if any(np.isfinite(other) and abs(exact - Ratio(other)) <= off for other in beside):
        raise Refuted(f"{literal} lies between two numbers of float32")
    return float(found)
