"""Reads ``certificate.json``: the statement to be proven and the witnesses that prove it, all of them exact numbers.

The witnesses (the map, directions, shape, centre and widths of a :class:`Part`) may hold anything: wrong ones prove
nothing.
"""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path
from typing import Annotated, Literal

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, ValidationError

from gen.errors import InputError

FILE = "certificate.json"


def _exact(value: object) -> Fraction:
    """A number of the file without rounding: JSON's numbers are read as float64, texts as ratios."""
    if isinstance(value, bool) or not isinstance(value, int | float | str | Fraction):
        raise ValueError("expected a number")
    return Fraction(value)


Number = Annotated[Fraction, BeforeValidator(_exact)]
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

    poles: list[Pole]
    gain: Schedule
    held: tuple[int, int]
    no_gain_outside: tuple[int, int]


class Part(_Strict):
    """One component: what is claimed of it, and why it is so.

    Attributes
    ----------
    name, equation
        Of the exact solution.
    shape, place
        Which functions of the C++ run it, and its place in their arrays.
    substeps
        Runs of the recursion in a sample.
    fraction_bits
        The board's word w of x[i+1] means w 2^-bits K.
    start_mK
        The rises to start from.
    bound_K, reading_K
        The claims: largest error of the word that is read, and of ``NAME_rise_mK``.
    map
        x = map (T, Ts T', Ts^2 T'', ..) but for x[n-1]'s share of q, shape (n, n); Ts of a substep.
    directions
        c_j, shape (J, n), in the coordinates (T, Ts T', ..).
    shape_matrix
        c_j times this are unit vectors, shape (n, n): which of them are neighbours.
    centre, reach, error
        ``|c_j . (z - (centre, 0, ..))| <= reach_j`` of the exact state z, and error_j of the board's less z.
    """

    name: str
    equation: Equation
    shape: str
    place: int
    substeps: int = Field(ge=1)
    fraction_bits: list[int]
    start_mK: tuple[int, int]
    bound_K: Number
    reading_K: Number
    map: list[list[Number]]
    centre: Number
    shape_matrix: list[list[Number]]
    directions: list[list[Number]]
    reach: list[Number]
    error: list[Number]

    @property
    def order(self) -> int:
        """The component's order n."""
        return len(self.equation.poles)


class Unproven(_Strict):
    """A component without a claim, which saturates instead."""

    name: str
    proof: None


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
    """

    format: Literal["gen-certificate"]
    version: Literal[1]
    model: str
    coefficients_sha256: str
    arithmetic: Literal["fixed", "float"]
    schedule: Literal["table", "onboard"]
    sample_time_s: Number
    domain_pwm: tuple[int, int]
    components: list[Part | Unproven]

    @property
    def parts(self) -> list[Part]:
        """The components with a claim."""
        return [part for part in self.components if isinstance(part, Part)]


def read(folder: Path) -> Certificate:
    """Read a project's certificate.

    Raises
    ------
    InputError
        If it is missing or no certificate.
    """
    path = folder / FILE
    try:
        return Certificate.model_validate_json(path.read_bytes())
    except OSError as error:
        raise InputError(f"cannot be read: {error.strerror}; `gen build` writes it", file=str(path)) from error
    except ValidationError as error:
        first = error.errors()[0]
        place = "$" + "".join(f"[{key}]" if isinstance(key, int) else f".{key}" for key in first["loc"])
        raise InputError(f"is no certificate: {first['msg']}", file=str(path), place=place) from error
