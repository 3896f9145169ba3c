"""Kinds of arithmetic and schedule, and what integers are held in."""

from __future__ import annotations

from typing import Literal

Arithmetic = Literal["fixed", "float"]


ScheduleKind = Literal["table", "onboard"]


#: Bits after the binary point of what is given out in thousandths: times 125 it fits 32 bits.
OUTPUT_BITS = 25
