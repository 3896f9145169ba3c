"""The board's own supply, measured against the reference of 1.1 V that is in the chip."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field, model_validator

from gen.coefficients.base import Note, Part, fault

BANDGAP_mV = 1100.0
"""Typically; the data sheet ("System and Reset Characteristics") promises 1000 to 1200."""
HYSTERESIS_mV = 100.0
"""The supply is sound again so far above the limit."""
_LOW_mV = 4500.0
"""The Mega's 16 MHz are specified from here on (data sheet, "Speed Grades")."""
UNCALIBRATED_LOW_mV = 4200.0
"""A sound board has 4750 mV or more, and reads no less than 4310 where its reference has 1200 and its converter errs by
2 steps: with the hysteresis the cause ends there, too."""


class Supply(Part):
    """What is known of the chip's reference, and when the supply is low."""

    bandgap_mV: Annotated[
        float | None,
        Field(
            ge=1000,
            le=1200,
            allow_inf_nan=False,
            description="This chip's own reference, as docs/protection.md says how to find it; without it 1100, "
            "give or take 100.",
        ),
    ] = None
    low_mV: Annotated[
        float | None,
        Field(
            ge=3000,
            le=4900,
            allow_inf_nan=False,
            description="The cause supply_low is there below it, until 100 mV above; without it 4500 with bandgap_mV, "
            "4200 without.",
        ),
    ] = None
    note: Note | None = None

    @property
    def reference_mV(self) -> float:
        """What the supply is measured against, mV."""
        return BANDGAP_mV if self.bandgap_mV is None else self.bandgap_mV

    @property
    def limit_mV(self) -> float:
        """Below it the supply is low, mV."""
        if self.low_mV is not None:
            return self.low_mV
        return UNCALIBRATED_LOW_mV if self.bandgap_mV is None else _LOW_mV

    @model_validator(mode="after")
    def _check(self) -> Supply:
        if self.bandgap_mV is None and self.limit_mV > UNCALIBRATED_LOW_mV:
            raise fault(
                f'found {self.limit_mV:g} without "bandgap_mV": a sound board may read so little; expected at most '
                f'{UNCALIBRATED_LOW_mV:g}, or "bandgap_mV"',
                "low_mV",
            )
        return self
