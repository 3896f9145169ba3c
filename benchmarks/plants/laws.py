"""Conductances over speed: forms that air and oil follow, of which a power law is only one."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

import numpy as np


class Form(StrEnum):
    """How a conductance rises from rest to full speed."""

    CONSTANT = "constant"
    LINEAR = "linear"
    POWER = "power"
    SATURATING = "saturating"
    TRANSITION = "transition"


@dataclass(frozen=True)
class Law:
    """A conductance over speed.

    Parameters
    ----------
    rest
        At rest, W/K.
    gain
        What full speed adds, as a multiple of `rest`.
    form
        How it gets there.
    shape
        The exponent of a power; where a saturating one has half of its limit, or where the flow becomes turbulent, as
        shares of full speed. No meaning for the others.
    """

    rest: float
    gain: float = 0.0
    form: Form = Form.CONSTANT
    shape: float = 1.0

    def __call__(self, speed: float) -> float:
        """The conductance in W/K at a speed, 0..1."""
        return self.rest * (1.0 + self.gain * self._share(speed))

    def _share(self, speed: float) -> float:
        match self.form:
            case Form.CONSTANT:
                return 0.0
            case Form.LINEAR:
                return speed
            case Form.POWER:
                return float(speed**self.shape)
            case Form.SATURATING:
                return speed / (speed + self.shape) * (1.0 + self.shape)
            case Form.TRANSITION:
                low, here, high = (1.0 / (1.0 + np.exp((self.shape - s) / WIDTH)) for s in (0.0, speed, 1.0))
                return float((here - low) / (high - low))


WIDTH = 0.1
"""Over which share of full speed a flow becomes turbulent."""
