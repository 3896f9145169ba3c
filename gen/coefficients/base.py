"""What all parts of the coefficient document have in common."""

from __future__ import annotations

import difflib
from typing import Annotated, Any

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, model_validator
from pydantic_core import PydanticCustomError

from gen.coefficients.names import NAME_PATTERN, name_fault
from gen.model.dynamics import MAX_PWM

Number = Annotated[float, Field(allow_inf_nan=False)]
Positive = Annotated[float, Field(allow_inf_nan=False, gt=0)]
NotNegative = Annotated[float, Field(allow_inf_nan=False, ge=0)]
COLDEST_degC = -273.15
Celsius = Annotated[float, Field(allow_inf_nan=False, ge=COLDEST_degC, le=5000)]
Counts = Annotated[int, Field(ge=0, le=MAX_PWM)]
CountRange = tuple[Counts, Counts]
Note = Annotated[str, Field(description="Why it is so; for those who read the file.")]
ColumnName = Annotated[str, Field(pattern=r"^[A-Za-z][A-Za-z0-9_]*$", max_length=64)]


THOUSANDTHS = 1000
"""A board is told ambient and channels in whole thousandths of their unit."""


def told(value: float) -> float:
    """Give a value as a board is told it: what a file says of an ambient or a channel counts to the thousandth."""
    return round(value * THOUSANDTHS) / THOUSANDTHS


def fault(message: str, *at: str | int) -> PydanticCustomError:
    """Make the error for a validator to raise.

    Parameters
    ----------
    message
        What was found and what was expected.
    at
        The rest of the JSON path below the object that is being validated.
    """
    # Pydantic formats the template with the context; braces in the message must not be taken for fields.
    return PydanticCustomError("gen", "{message}", {"message": message, "at": at})


def _check_name(name: str) -> str:
    problem = name_fault(name)
    if problem:
        raise fault(problem)
    return name


Name = Annotated[str, Field(json_schema_extra={"pattern": NAME_PATTERN}), AfterValidator(_check_name)]


def ordered(low: float, high: float, *at: str | int) -> None:
    """Check that a range runs upwards.

    Raises
    ------
    PydanticCustomError
        When low > high.
    """
    if low > high:
        raise fault(f"found [{low:g}, {high:g}], expected the lower limit first", *at)


class Part(BaseModel):
    """A frozen object of the document that accepts its own keys and types only."""

    model_config = ConfigDict(strict=True, extra="forbid", frozen=True)

    @model_validator(mode="before")
    @classmethod
    def _known_keys(cls, data: Any) -> Any:  # noqa: ANN401
        """Name the unknown key first: a misspelt key is also a missing one, and the spelling is the cause.

        Lists become tuples, because strict mode takes a list for a tuple from JSON text only.
        """
        if isinstance(data, dict):
            for key in data:
                if key not in cls.model_fields:
                    near = difflib.get_close_matches(str(key), cls.model_fields, n=1, cutoff=0.6)
                    hint = f'did you mean "{near[0]}"?' if near else f"expected {listed(list(cls.model_fields))}"
                    raise fault(f'unknown key "{key}"; {hint}', str(key))
            return {key: tuple(value) if isinstance(value, list) else value for key, value in data.items()}
        return data


def listed(names: list[str], last: str = "or") -> str:
    """Write names as ``"a", "b" or "c"``."""
    quoted = [f'"{name}"' for name in names]
    return quoted[0] if len(quoted) == 1 else f"{', '.join(quoted[:-1])} {last} {quoted[-1]}"
