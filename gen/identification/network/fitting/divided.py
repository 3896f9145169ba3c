"""Divided differences of e^(lh) and of phi(l) = (e^(lh) - 1) / l over all pairs of a network's rates l, compiled."""

from __future__ import annotations

import numpy as np

from gen.arrays import FloatArray, SingleArray
from gen.compiled import compiled


@compiled
def divided_differences(
    rates: FloatArray, width: FloatArray, decay: FloatArray, phi: FloatArray, first: SingleArray, second: SingleArray
) -> None:
    """Fill in both, in ways that lose no figures where two rates are near each other, or near 0.

    Parameters
    ----------
    rates, decay, phi
        Of the modes at each distinct input, and e^(lh) and phi of them; shape (L, n).
    width
        h of each input, shape (L,), s.
    first, second
        Of e^(lh), and of phi, shape (L, n, n).
    """
    for at in range(rates.shape[0]):
        h = width[at]
        for i in range(rates.shape[1]):
            for j in range(i + 1):
                a, b = rates[at, i], rates[at, j]
                half = 0.5 * abs(a - b) * h
                middle = 0.5 * (a + b)
                if half < 1.0:
                    # e^(ah) - e^(bh) = 2 e^(mh) sinh((a-b)h/2): no cancellation, and exact to second order where a = b.
                    even = 1.0 + half * half / 6.0 if half < 1e-3 else np.sinh(half) / half
                    one = np.exp(middle * h) * h * even
                else:
                    one = (decay[at, i] - decay[at, j]) / (a - b)
                if half >= 0.1:
                    other = (phi[at, i] - phi[at, j]) / (a - b)
                elif abs(middle * h) < 1e-3:
                    # phi'(l) = (h e^(lh) - phi(l)) / l, by its series.
                    x = middle * h
                    other = h * h * (0.5 + x * (1.0 / 3.0 + x * (1.0 / 8.0 + x / 30.0)))
                else:
                    # phi(a) = int_0^h e^(at) dt, so its divided difference follows from that of e^(lh).
                    other = (one - phi[at, i]) / b
                first[at, i, j] = first[at, j, i] = one
                second[at, i, j] = second[at, j, i] = other
