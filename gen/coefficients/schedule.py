"""Schedules in the coefficient document: exactly one of poly, exp1, exp2, table."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import Discriminator, Field, Tag, model_validator

from gen.coefficients.base import Counts, Number, Part, fault
from gen.model.schedules import ExponentialSum, Polynomial, Schedule, Table

KINDS = ("poly", "exp1", "exp2", "table")

# Slopes between values are finite, too.
TableValue = Annotated[Number, Field(ge=-1e300, le=1e300)]


class Poly(Part):
    """A polynomial in x = |PWM|, highest power first."""

    poly: Annotated[tuple[Number, ...], Field(min_length=1, description="Coefficients, highest power first.")]

    def schedule(self) -> Schedule:
        """Give the model's schedule."""
        return Polynomial(self.poly)


class Exp1(Part):
    """a exp(b x), x = |PWM|."""

    exp1: Annotated[tuple[Number, Number], Field(description="[a, b]")]

    def schedule(self) -> Schedule:
        """Give the model's schedule."""
        return ExponentialSum((self.exp1,))


class Exp2(Part):
    """a exp(b x) + c exp(d x), x = |PWM|."""

    exp2: Annotated[tuple[Number, Number, Number, Number], Field(description="[a, b, c, d]")]

    def schedule(self) -> Schedule:
        """Give the model's schedule."""
        return ExponentialSum((self.exp2[:2], self.exp2[2:]))


class Points(Part):
    """Values at strictly increasing |PWM|; outside of the table its end values hold."""

    pwm: Annotated[tuple[Counts, ...], Field(min_length=2, description="|PWM| in counts, strictly increasing.")]
    value: Annotated[tuple[TableValue, ...], Field(min_length=2, description="As many values.")]
    interpolation: Annotated[
        Literal["pchip", "linear"],
        Field(description="pchip: monotone cubic (Fritsch-Carlson). Outside of the table the end value holds."),
    ]

    @model_validator(mode="after")
    def _check(self) -> Points:
        for i in range(1, len(self.pwm)):
            if self.pwm[i] <= self.pwm[i - 1]:
                raise fault(f"found {self.pwm[i]} after {self.pwm[i - 1]}, expected strictly increasing PWM", "pwm", i)
        if len(self.value) != len(self.pwm):
            raise fault(f"found {len(self.value)} values, expected {len(self.pwm)}, one per PWM", "value")
        return self


class Tabulated(Part):
    """Interpolation in a table over |PWM|."""

    table: Points

    def schedule(self) -> Schedule:
        """Give the model's schedule."""
        return Table(self.table.pwm, self.table.value, self.table.interpolation)


def _kind(data: Any) -> str | None:  # noqa: ANN401
    """Choose the schedule's kind by its key, so that a fault in it is reported for this kind alone."""
    if isinstance(data, Part):
        return f"tag:{next(iter(type(data).model_fields))}"
    if not isinstance(data, dict):
        return None
    present = [kind for kind in KINDS if kind in data]
    return f"tag:{present[0]}" if len(present) == 1 else None


ScheduleEntry = Annotated[
    Annotated[Poly, Tag("tag:poly")]
    | Annotated[Exp1, Tag("tag:exp1")]
    | Annotated[Exp2, Tag("tag:exp2")]
    | Annotated[Tabulated, Tag("tag:table")],
    Discriminator(_kind, custom_error_type="schedule", custom_error_message="not a schedule"),
]
