"""Colours of parts, told apart with defective colour vision, too, and visible on light and on dark paper."""

from __future__ import annotations

COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#8f5fa8", "#8c6d5a")
"""One for each part (Okabe and Ito's first); further parts begin again."""
INK = "#808080"
"""Of what belongs to no part: PWM, ambient."""
BARS = {"recorded": "#dc143c", "derived": "#e69f00", "fault": "#808080"}
"""By the kind of a bar."""
BAR_NAMES = {
    "recorded": "alarm, recorded by the board",
    "derived": "alarm by the file's rules",
    "fault": "declared fault",
}


def colour(place: int | None) -> str:
    """The colour of a place in the palette."""
    return INK if place is None else COLOURS[place % len(COLOURS)]
