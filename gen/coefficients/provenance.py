"""Where a model's numbers come from, and how far off they are known to be."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field, model_validator

from gen.coefficients.base import CountRange, Number, Part, ordered

ERROR_WINDOWS = 60
"""A declared error is that of means of readings over this share of a run, as a sensor's noise is not the
model's: 95 % of them are within it."""


class ErrorBand(Part):
    """What the model is known to be off by, in a range of PWM; of means over a run's `ERROR_WINDOWS`-th part."""

    component: str
    pwm: CountRange
    model_minus_measured_K: Annotated[tuple[Number, Number], Field(description="[lowest, highest]")]
    note: str = ""

    @model_validator(mode="after")
    def _check(self) -> ErrorBand:
        ordered(*self.pwm, "pwm")
        ordered(*self.model_minus_measured_K, "model_minus_measured_K")
        return self


class Provenance(Part):
    """Where the numbers come from, and how good they are."""

    source: str
    method: str = ""
    data: tuple[str, ...] = ()
    fit: Annotated[
        dict[str, dict[str, Number]], Field(description="By component: figures of the fit, unit in the name.")
    ] = Field(default_factory=dict)
    error: tuple[ErrorBand, ...] = ()
    ambient_degC: Annotated[
        tuple[Number, Number] | None, Field(description="[lowest, highest] ambient of the runs in data.")
    ] = None

    @model_validator(mode="after")
    def _check(self) -> Provenance:
        if self.ambient_degC is not None:
            ordered(*self.ambient_degC, "ambient_degC")
        return self

    def said_by(self, source: str) -> Provenance:
        """Give the same with another source."""
        return self.model_copy(update={"source": source})
