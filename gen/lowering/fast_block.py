"""First-order components in blocks: one product for :data:`BLOCK` samples, exact while PWM is constant.

With a(p) the rate of one sample, y = 1 - (1 - a)^BLOCK that of a block, T the rise at the block's start and j samples
since then, the rise now is

    T + m (1 + (1-m)/2 y + (1-m)(2-m)/6 y^2 + ..) y (S - T),        m = j / BLOCK.

At a change of PWM within a block the board computes that, and the rise from which the block *would* have had to start
for the new PWM to give the same rise now:

    T = rise now - m (1 + (1+m)/2 y + (1+m)(2+m)/6 y^2 + ..) y (S - rise now)        (both: binomial series)

The block goes on from there.  Nothing else is stored, and the order in which components take turns never changes.
"""

from __future__ import annotations

import numpy as np

from gen.lowering.bounds import Array
from gen.lowering.dynamics import Dynamics, LoweringError
from gen.lowering.fast_format import BLOCK, RESIDUE_BITS, FastComponent, FastLayout, choose_scale, fast_loss
from gen.lowering.program import Integers, Proof

#: Second and third terms of the series above for j = 1, 2, 3, times 256.
FORWARD = ((24, 14), (32, 16), (24, 10))
BACKWARD = ((40, 30), (96, 80), (168, 154))


def lower(name: str, exact: Dynamics, slot: int) -> FastComponent:
    """Formats, integers and proof of a first-order component.

    Raises
    ------
    LoweringError
        If it is too fast for blocks.
    """
    low = min(exact.start[0], float(exact.steady.min()))
    high = max(exact.start[1], float(exact.steady.max()))
    # The board's T may lie a block before the present: further out by the share y of the distance, and its square.
    a = exact.rates[:, 0]
    y = -np.expm1(BLOCK * np.log1p(-a))
    distance = np.maximum(high - exact.steady, exact.steady - low) * (1.0 + 1e-3) + 0.01
    earlier = distance * (1.0 + 2.0 * y)
    reach = float(max(earlier.max(), high + (distance * 2.0 * y).max(), -low + (distance * 2.0 * y).max()))
    scale = choose_scale(reach)
    bits = 32 + RESIDUE_BITS
    if y.max() * 2.0**bits >= 2.0**32 - 1.0:
        raise LoweringError(f"component {name}: no fast form, its rate {a.max():.1e} is too fast for blocks of samples")
    rates = np.rint(y * 2.0**bits).astype(np.int64)[:, None]
    layout = FastLayout(scale=scale, gaps=())
    # floor(x1) - steady stands for x1 - (steady + 1/2).
    steady = np.rint(exact.steady / layout.steady_lsb - 0.5).astype(np.int64)
    bound = worst_error(exact, layout, rates, steady, earlier)
    return FastComponent(
        name=name,
        order=1,
        layout=layout,
        rates=rates,
        steady=steady,
        slot=slot,
        start_range_mK=exact.start_range_mK,
        proof=Proof(rise_range_K=(low - 0.01, high + 0.01), increment_range_K=(), bound_K=bound),
    )


def worst_error(exact: Dynamics, layout: FastLayout, rates: Integers, steady: Integers, distance: Array) -> float:
    """Largest error of the rise that the board gives out, in K, for any PWM sequence.

    The error obeys e -> (1 - a) e in each sample, and is changed at most by what ``_injections`` says in the four
    samples of a block.  So |e| <= B at the blocks' starts, if B (1 - prod(1 - a)) is no less than the sum of the four,
    whatever PWM each of them has: the smallest such B is found by bisection.
    """
    a = exact.rates[:, 0]
    contraction = a * (1.0 - 1.5 * a.max())  # 1 - prod(1 - a_i) is at least the sum of these
    injections = _injections(exact, layout, rates, steady, distance)
    low, high = 0.0, float((injections.sum(axis=0) / contraction).max()) * 10.0
    while np.max(injections - high * contraction, axis=1).sum() > 0.0:
        high *= 2.0
    for _ in range(60):
        middle = (low + high) / 2.0
        if np.max(injections - middle * contraction, axis=1).sum() > 0.0:
            low = middle
        else:
            high = middle
    within = injections.max(axis=1).sum()  # before the block's end has contracted it
    y = rates[:, 0] * 2.0 ** -layout.rate_bits[0]
    straight = (
        float((y**2 * distance * (1.0 + y)).max()) / 8.0
    )  # the chord between a block's ends: y^2 d j (4 - j) / 32
    output = 2.0 * layout.high_lsb[0] + (1.0 + fast_loss(narrow=True)) * layout.word_lsb[0]
    return float(high + within + straight + output + float(y.max()) * layout.steady_lsb / 2.0)


def _injections(exact: Dynamics, layout: FastLayout, rates: Integers, steady: Integers, distance: Array) -> Array:
    """What can change the error in each of a block's samples, by the PWM of that sample, in K, shape (BLOCK, rows)."""
    word = layout.word_lsb[0]
    y = np.asarray(rates[:, 0] * 2.0 ** -layout.rate_bits[0], dtype=np.float64)
    exact_y = -np.expm1(BLOCK * np.log1p(-exact.rates[:, 0]))
    steady_error = np.abs((steady + 0.5) * layout.steady_lsb - exact.steady)
    # Every sample runs towards a steady rise that is a little wrong, with a rate that is a little wrong.
    drift = exact.rates[:, 0] * steady_error + np.abs(y - exact_y) / exact_y * exact.rates[:, 0] * distance * 1.01
    result = np.tile(drift, (BLOCK, 1))
    # The block's end: x1 rounded down (its middle is in S), and the product's loss.
    result[BLOCK - 1] += y * 0.5 * layout.steady_lsb + fast_loss(narrow=True) * word
    for j in range(1, BLOCK):
        result[j - 1] += _moved(layout, y, distance, j)
        result[j] += _moved(layout, y, distance, j)
    return result


def _moved(layout: FastLayout, y: Array, distance: Array, j: int) -> Array:
    """Error of one evaluation of the series, in K, shape (rows,)."""
    word = layout.word_lsb[0]
    products = (0.5 * j / BLOCK + 0.5) * word  # both to nearest
    factor = 3.0 * 2.0**-32 * y * distance  # the series as a number of 32 bits, its terms rounded down
    rest = 1.1 * y**4 * distance  # its fourth term and all after it: m(m+1)(m+2)(m+3)/24 < 1, and so on
    return np.asarray(products + factor + rest, dtype=np.float64)
