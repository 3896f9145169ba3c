"""Lower a component to float32: float32 products and differences around 40-bit accumulators.

Plain float32 accumulation stagnates: near 45 K an addition rounds by up to 2e-6 K, which a slow pole of 1.25e-4 per
sample turns into 0.015 K.  Compensated sums repair that for two more float operations each.  The board instead adds
its float32 increments to 40-bit accumulators: an addition then only shifts the significand into place (some 85 cycles
in place of 110), loses at most the accumulator's lowest bit, and needs no compensation.

* x1 .. xn are accumulators: a 32-bit word with F fraction bits of its own, and 8 bits below it.
* Whatever is multiplied is float32: the words of S - x1 (an exact int32 difference), x2 .. xn are converted, which
  rounds each to 24 bits.  The rates absorb the powers of two between the words' units, which is exact.

At a change of PWM, x[n-1] += (q_new - q_old)/12 with q_new taken *after* the carry (:func:`increments.state_map`
demands that).  The board carries with q_new from before, and then corrects q_new by -C[n-2] times what was carried,
which leaves a factor of 1 + C[n-2]/12 on the carry for the proof to count.

Where no range can be proven, the accumulators stop at half their range, and every stop is counted.
"""

from gen.lowering.float32.component import CARRY, LIMIT_BITS, LOW_BITS, ONBOARD_STEADY_SHIFT, FloatComponent
from gen.lowering.float32.lower import lower_component, with_rows
from gen.lowering.float32.packing import Column, column_words, packed
from gen.lowering.float32.proof import half_ulp

__all__ = [
    "CARRY",
    "LIMIT_BITS",
    "LOW_BITS",
    "ONBOARD_STEADY_SHIFT",
    "Column",
    "FloatComponent",
    "column_words",
    "half_ulp",
    "lower_component",
    "packed",
    "with_rows",
]
