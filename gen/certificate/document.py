"""Reads ``certificate.json``: the statement to be proven and the witnesses that prove it, all of them exact numbers.

The witnesses (the map, directions, shape, centre and widths of a :class:`Part`) may hold anything: wrong ones prove
nothing.
"""

from __future__ import annotations

from math import isfinite
from pathlib import Path
from typing import Annotated, Literal

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, TypeAdapter, ValidationError, model_validator

from gen.certificate.exact import Ratio
from gen.certificate.network.document import NetworkCertificate
from gen.errors import InputError

FILE = "certificate.json"
#: Bits of a state's word below ``hi``.
LOW_BITS = {"fixed": 16, "float": 8}


def _exact(value: object) -> Ratio:
    """A number of the file without rounding: JSON's numbers are read as float64."""
    if isinstance(value, bool) or not isinstance(value, int | float | Ratio):
        raise ValueError("expected a number")
    if isinstance(value, float) and not isfinite(value):
        raise ValueError("expected a finite number")
    return Ratio(value)


Number = Annotated[Ratio, BeforeValidator(_exact)]
Width = Annotated[Number, Field(ge=0)]
Identifier = Annotated[str, Field(pattern=r"^[A-Za-z_]\w*$")]
#: A |PWM|.
Level = Annotated[int, Field(ge=0, le=255)]
#: Thousandths of a kelvin.
Start = Annotated[int, Field(ge=-(1 << 23), le=1 << 23)]
#: A polynomial in |PWM| - start, highest power first, from |PWM| = start to end (both included).
Piece = tuple[int, int, list[Number]]


class _Strict(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True, arbitrary_types_allowed=True)


class Schedule(_Strict):
    """A function of |PWM|: the sum of a e^(b |PWM|) over ``exponentials`` (a, b), or the first of ``pieces`` there."""

    exponentials: list[tuple[Number, Number]] = []
    pieces: list[Piece] = []


class Pole(_Strict):
    """A pole of A, in 1/s."""

    real: Schedule
    imag: Schedule | None = None


class Equation(_Strict):
    """A(d/dt) T = K |PWM|, A = the real part of the product of (d/dt - pole).

    Attributes
    ----------
    gain
        K, in K/s^order per count.
    held
        |PWM| is held within these where schedules are evaluated.
    no_gain_outside
        Outside of these a negative K is 0.
    """

    poles: list[Pole] = Field(min_length=1, max_length=4)
    gain: Schedule
    held: tuple[int, int]
    no_gain_outside: tuple[int, int]


class _Placed(_Strict):
    """A component in the C++.

    Attributes
    ----------
    name
        Of the exact solution.
    shape, place
        Which functions of the C++ run it, and its place in their arrays.
    substeps
        Runs of the recursion in a sample.
    """

    name: Identifier
    shape: Annotated[str, Field(pattern=r"^[A-Z]\w*$")]
    place: int = Field(ge=0)
    substeps: int = Field(ge=1, le=64)

    @property
    def at(self) -> str:
        """Its place in the state and in the coefficients, ``a[0]``."""
        return f"{self.shape.lower()}[{self.place}]"


class Part(_Placed):
    """A component: what is claimed of it, and why it is so.

    Attributes
    ----------
    equation
        Of the exact solution.
    fraction_bits
        The board's word w, ``x[i].hi``, means w 2^-bits K.
    start_mK
        The rises to start from.
    bound_K, reading_K
        The claims: largest error of the word, and of ``NAME_rise_mK``.
    map
        x = map (T, Ts T', Ts^2 T'', ..) but for x[n-1]'s share of q, shape (n, n); Ts of a substep.
    directions
        c_j, shape (J, n), in the coordinates (T, Ts T', ..).
    shape_matrix
        c_j times this are unit vectors, shape (n, n): which of them are neighbours.
    centre, reach, error
        ``|c_j . (z - (centre, 0, ..))| <= reach_j`` of the exact state z, and error_j of the board's less z.
    """

    equation: Equation
    fraction_bits: list[Annotated[int, Field(ge=0, le=200)]]
    start_mK: tuple[Start, Start]
    bound_K: Number
    reading_K: Number
    map: list[list[Number]]
    centre: Number
    shape_matrix: list[list[Number]]
    directions: list[list[Number]]
    reach: list[Width]
    error: list[Width]

    @property
    def order(self) -> int:
        """The component's order n."""
        return len(self.equation.poles)

    @model_validator(mode="after")
    def _fit_together(self) -> Part:
        n = self.order
        if not len(self.directions) == len(self.reach) == len(self.error) > 0:
            raise ValueError("directions, reach and error differ in length")
        if not len(self.fraction_bits) == len(self.map) == len(self.shape_matrix) == n:
            raise ValueError(f"fraction_bits, map and shape_matrix are to have {n} entries, as there are poles")
        if any(len(row) != n for row in (*self.directions, *self.map, *self.shape_matrix)):
            raise ValueError(f"a row is not {n} numbers long")
        if self.start_mK[0] > self.start_mK[1]:
            raise ValueError("start_mK ends before it begins")
        return self


class Unproven(_Placed):
    """A component without a claim, which saturates instead."""

    order: int = Field(ge=1, le=4)
    proof: None


AnyPart = Part | Unproven


class Ambient(_Strict):
    """An ambient that acts on the equations: A(d/dt) T = K |PWM| + A(0) (ambient - reference), T over the reference.

    Attributes
    ----------
    reference_mC, low_mC, high_mC
        What rises count from, and the range that the ambient is held to, in thousandths of a degree Celsius.
    """

    reference_mC: int
    low_mC: int
    high_mC: int

    @property
    def over_mK(self) -> tuple[int, int]:
        """The range over the reference, in thousandths of a kelvin."""
        return self.low_mC - self.reference_mC, self.high_mC - self.reference_mC

    @model_validator(mode="after")
    def _fits(self) -> Ambient:
        low, high = self.over_mK
        if not -(1 << 23) < low <= 0 <= high < 1 << 23:
            raise ValueError("the reference lies outside of the ambient's range, or far from its ends")
        return self


class Certificate(_Strict):
    """All of ``certificate.json``.

    Attributes
    ----------
    model
        The C++ names' prefix.
    sample_time_s
        Ts.
    domain_pwm
        Lowest and highest |PWM|.
    ambient
        The one that acts on the equations; None where rises count from whatever it is.
    """

    format: Literal["gen-certificate"]
    version: Literal[1]
    model: Identifier
    coefficients_sha256: str
    arithmetic: Literal["fixed", "float"]
    schedule: Literal["table", "onboard"]
    sample_time_s: Width
    domain_pwm: tuple[Level, Level]
    ambient: Ambient | None = None
    components: list[AnyPart] = Field(min_length=1)

    @property
    def parts(self) -> list[Part]:
        """The components with a claim."""
        return [part for part in self.components if isinstance(part, Part)]


#: Version 1 is about transfer functions, version 2 about a network.
AnyCertificate = Certificate | NetworkCertificate
_ANY: TypeAdapter[AnyCertificate] = TypeAdapter(Annotated[AnyCertificate, Field(discriminator="version")])


def read(folder: Path) -> AnyCertificate:
    """Read a project's certificate.

    Raises
    ------
    InputError
        If it is missing or no certificate.
    """
    path = folder / FILE
    try:
        return _ANY.validate_json(path.read_bytes())
    except OSError as error:
        raise InputError(f"cannot be read: {error.strerror}; `gen build` writes it", file=str(path)) from error
    except ValidationError as error:
        first = error.errors()[0]
        # after the version that it was read as; checks of a whole part stand there, too, and are no keys
        within = [key for key in first["loc"][1:] if not str(key).startswith("function-")]
        place = "$" + "".join(f"[{key}]" if isinstance(key, int) else f".{key}" for key in within)
        if first["type"].startswith("union_tag"):
            place = "$.version"
        raise InputError(f"is no certificate: {first['msg']}", file=str(path), place=place) from error
