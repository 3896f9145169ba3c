"""What a coefficient file holds that runs do not say, of whichever model."""

from __future__ import annotations

from dataclasses import dataclass

from gen.model.dynamics import MAX_PWM

FIXED_LIMIT_K, FLOAT_LIMIT_K = 1e-3, 1e-2
"""Arithmetic errors up to which a build is accepted: a 250th and a 25th of a thermocouple amplifier's step of 0.25 K,
far below what any identification can know."""


@dataclass(frozen=True)
class Settings:
    """What the runs do not say.

    Attributes
    ----------
    name
        Of the model.
    sample_time_s, full_scale, nominal_speed_rpm
        Of the board and the motor.
    """

    name: str
    sample_time_s: float = 0.25
    full_scale: int = MAX_PWM
    nominal_speed_rpm: float = 2650.0


def said_beside(note: str) -> str:
    """Give what follows the method, or nothing."""
    return f". {note}" if note else ""
