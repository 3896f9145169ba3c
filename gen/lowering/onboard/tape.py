"""What the board executes when PWM changes: a straight line of steps, each an int32 (or float32) or a small index.

The reference (:mod:`gen.lowering.onboard.evaluate`) executes the steps, :mod:`gen.firmware.onboard_cpp` prints them.

=================  ================================================================================================
step               result in fixed point (q: bits after the binary point)
=================  ================================================================================================
input              |PWM| held to table[0]..table[1] (uint8)
segment            number of the interval of the table with knots ``table`` (uint8)
local              |PWM| held to the table's ends, less the start of its interval (uint8)
constant           table[0]
row                table[segment]
power_series       Horner's rule in 40 bits: a = floor(a u / 2^8) + table[k] for all k, u = x or (shift 1) 255 - x;
                   then (a + 2^7) >> 8
times              (a x + 2^(7-shift)) >> (8-shift), a x if shift is 8     a int32, x uint8
mul                (a b - a0 b0 + 2^(31-shift)) >> (32-shift)             b >= 0; a0, b0 the lowest bytes
mul_signed         the same of (-a, -b) where b < 0
div                a 2^shift / b, a >= 0, b > 0, to nearest or (``round`` 0) down
div_signed         sign(a) div(abs(a), b)
add, sub, neg      plain; both operands have the result's format
.._modulo          modulo 2^32: products that wrap round, and sums of them that fit 32 bits nevertheless
shr, floor         ((a >> (shift-1)) + 1) >> 1   and   a >> shift
shl                a << shift
positive_outside   max(a, 0) where x < table[0] or x > table[1], else a
=================  ================================================================================================

In float32 every step is one operation; ``exponential`` is table[x >> 4] table[16 + (x & 15)], ``scale`` a product by
table[0], and there is no shift.
"""

from __future__ import annotations

from dataclasses import dataclass

from gen.lowering.fixed.formats import Format
from gen.lowering.kinds import Arithmetic
from gen.lowering.onboard.graph import UNLABELLED, Label

#: The least shift of a division.
DIVIDE_SHIFT = 24
#: By how many bits a power series is finer than its result.
GUARD_BITS = 8

Table = tuple[int, ...] | tuple[float, ...]


@dataclass(frozen=True)
class Step:
    """One operation on earlier steps' results.

    Attributes
    ----------
    op
        See the module's table.
    args
        Numbers of earlier steps.
    q
        Bits after the binary point of the result (0 for whole numbers and in float32).
    shift
        See the module's table.
    round
        Whether a division is rounded to nearest.
    table
        Whole numbers in fixed point, float32 values as Python floats otherwise.
    unsigned
        Whether the result is a uint32 (a sum that is never negative, or a rate) instead of an int32.
    label
        What it is.
    """

    op: str
    args: tuple[int, ...] = ()
    q: int = 0
    shift: int = 0
    round: bool = True
    table: Table = ()
    unsigned: bool = False
    label: Label = UNLABELLED


@dataclass(frozen=True)
class OnboardComponent:
    """The schedule of one component, evaluated on the board.

    Attributes
    ----------
    name, order, substeps, arithmetic
        As of the component it belongs to.
    domain
        Lowest and highest |PWM| for which the formats are proven; the caller holds its input to them.
    steps
        The tape.
    rates, steady
        Numbers of the steps with R[0..n-1] and S.  Fixed: formats as in ``layout``; a rate is a uint32.
    layout
        The formats of the component's recursion (fixed only).
    """

    name: str
    order: int
    substeps: int
    arithmetic: Arithmetic
    domain: tuple[int, int]
    steps: tuple[Step, ...]
    rates: tuple[int, ...]
    steady: int
    layout: Format | None
