"""What is not known between the identified speeds, and where one more would help most."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from gen.arrays import FloatArray
from gen.identification.parts.general import General
from gen.identification.parts.joint import Model

COMPARABLE = 1.6
"""Forms whose leave-one-out error is within this factor of the best are taken for possible."""
NEAREST = 10
"""A new speed nearer than this to an identified one, in counts, is not proposed."""


@dataclass(frozen=True, eq=False)
class Band:
    """Standard deviation of the steady rise over |PWM|.

    Attributes
    ----------
    pwm
        Shape (m,).
    steady
        The model's steady rise, K.
    parameters_K
        From the parameters.
    forms_K
        From the choice of forms: how far the possible ones lie apart.
    """

    pwm: FloatArray
    steady: FloatArray
    parameters_K: FloatArray
    forms_K: FloatArray

    @property
    def total_K(self) -> FloatArray:
        """Both together."""
        return np.asarray(np.hypot(self.parameters_K, self.forms_K), dtype=np.float64)


def band(general: General, model: Model, low: int, high: int) -> Band:
    """Compute the band over a range of |PWM|."""
    pwm = np.arange(max(low, 1), high + 1, dtype=np.float64)
    steady = model.evaluate(pwm)[1]
    best = general.chosen.score
    possible = [
        o for o in general.options if not o.rejected and o.left_out is not None and o.score <= COMPARABLE * best
    ]
    if len(possible) > 1:
        curves = np.stack([o.shape.evaluate(o.vector, pwm)[1] for o in possible])
        weight = 1.0 / np.array([o.score + 1e-3 for o in possible]) ** 2
        forms = np.sqrt(np.average((curves - steady) ** 2, axis=0, weights=weight))
    else:
        forms = np.zeros(len(pwm))
    return Band(pwm, steady, model.steady_sd(pwm), forms)


def next_speed(bands: list[Band], identified: list[int], left_out: dict[int, float]) -> tuple[int, float] | None:
    """Give the |PWM| at which a new run would remove most uncertainty, and the standard deviation there, K.

    Between two identified speeds the forms' spread is backed by the leave-one-out errors of both: the spread of forms
    that share a bias would look small.

    Parameters
    ----------
    bands
        One per component, over the same |PWM|.
    identified
        Identified speeds above 0.
    left_out
        Largest leave-one-out error by identified speed, K.
    """
    if not bands or not len(bands[0].pwm):
        return None
    pwm = bands[0].pwm
    spread = np.max([b.total_K for b in bands], axis=0)
    known = np.array(sorted(identified), dtype=np.float64)
    for a, b in pairwise(known):
        inside = (pwm > a) & (pwm < b)
        backed = min(left_out.get(int(a), 0.0), left_out.get(int(b), 0.0)) / 4.0
        share = (pwm[inside] - a) * (b - pwm[inside]) / ((b - a) / 2.0) ** 2
        spread[inside] = np.hypot(spread[inside], backed * share)
    far = np.min(np.abs(pwm[:, None] - known[None, :]), axis=1) >= NEAREST
    if not far.any():
        return None
    at = int(np.argmax(np.where(far, spread, -1.0)))
    return int(pwm[at]), float(spread[at])
