"""What the C++ makes of two temperatures for a path with a law, compared with the law over all that they can be.

The function is run on a machine of its own, in which its arguments are what polynomials of any degree are made of.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gen.certificate.exact import ROUGHLY
from gen.certificate.network.arithmetic import Number
from gen.certificate.network.forms import Form, Space
from gen.certificate.network.laws import Ends, Law
from gen.certificate.network.machine import Machine
from gen.certificate.network.memory import Model, Pointer
from gen.certificate.network.source import Unit
from gen.certificate.refuted import Refuted

#: Fraction bits of a slope's word.
SLOPE_BITS = 30
_AWAY_FROM_0 = (
    "int32_t {name}(int32_t d, int32_t *slope) {{ const int32_t driving = {name}_of(d < 0 ? -d : d, slope); "
    "if (*slope < 0) {{ *slope = 0; }} return d < 0 ? -driving : driving; }}"
)


@dataclass(frozen=True)
class Evaluated:
    """How far a function is off.

    Attributes
    ----------
    driving
        From what drives, in words.
    slope
        From its slope.
    """

    driving: float
    slope: float


def evaluated(unit: Unit, name: str, law: Law, words: list[Ends], bits: int) -> Evaluated:
    """Run a law's function.

    Parameters
    ----------
    unit
        Whose.
    name
        Of the function.
    law
        What it should be.
    words
        Ends of its arguments, in words: a difference's, or both temperatures'.
    bits
        Fraction bits of a temperature's word.

    Raises
    ------
    Refuted
        If it is written otherwise, or a number may leave its type.
    """
    if law.polynomial:
        # The other sign gives the same with the other sign, and a slope below 0 is nearer to what it should be at 0.
        if unit.texts.get(name) != [_AWAY_FROM_0.format(name=name)]:
            raise Refuted(f"{name} is no function of a difference's magnitude that the proof knows")
        space = Space([], [(0.0, max(map(abs, words[0])))], 1)
        name = f"{name}_of"
    else:
        space = Space([], words, 1)
    arguments = [space.factor(k) for k in range(len(words))]
    slope = [Number("int32_t", space.number(np.nan))]
    machine = Machine(unit, {}, space, Model([]), _no_channel)
    natural = bool(law.polynomial)
    found = machine.call(name, *(Number("int32_t", one, natural) for one in arguments), Pointer(slope, 0))
    if not isinstance(found, Number) or not (law.polynomial or slope[0].at_least_0):
        raise Refuted(f"{name} gives no number, or a slope that may be negative")
    degrees = [one.times(2.0**-bits) for one in arguments]
    driving = law.driving_form(space, degrees[0], degrees[-1] if len(degrees) > 1 else None).times(2.0**bits)
    steep = slope[0].form.times(2.0**-SLOPE_BITS)
    return Evaluated(_apart(found.form, driving), _apart(steep, law.slope_form(space, degrees[0])))


def _apart(found: Form, exact: Form) -> float:
    off = float((found - exact).largest.max()) * (1.0 + ROUGHLY)
    if not np.isfinite(off):
        raise Refuted("what a law makes of temperatures has no bound")
    return off


def _no_channel(name: str, channel: int) -> Number:
    raise Refuted(f"{name} of channel {channel} is no part of a law")
