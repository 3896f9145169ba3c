"""Logs whose input may have switched between their rows."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from gen.identification.logs.sources import Source

OFTEN = 0.15
"""Of the rows: an input that is another in so many may be another again before the next."""


def coarse(sources: Sequence[Source]) -> list[str]:
    """A sentence for the run whose input changes in most of its rows, where that is often; no model follows it then."""
    shares = [float(np.mean(np.diff(source.run.pwm) != 0)) for source in sources]
    worst = int(np.argmax(shares))
    if shares[worst] < OFTEN:
        return []
    return [
        f"{sources[worst].path}: PWM is another in {shares[worst]:.0%} of the rows than in the row before: where it "
        "switches between rows as well, the log does not say for how long it was on; log its mean, or more rows"
    ]
