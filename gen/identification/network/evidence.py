"""How far curves over speed bend: as the runs ask for, by the evidence, and not by what is predicted best of few runs.

Where few speeds were run, what a curve does between them is the prior's. One that bends as it likes may then follow one
run's peculiarities; one that cannot bend misses a machine whose curve does. Left-out errors of two or three runs do not
tell which it is. The evidence, the probability of all readings with the parameters integrated out, does: it weighs how
much better a curve that bends fits against how many others it might have been (MacKay, Bayesian interpolation, Neural
Computation 4, 1992; Rasmussen and Williams, Gaussian Processes for Machine Learning, 2006, 5.4).
"""

from __future__ import annotations

import numpy as np

from gen.arrays import FloatArray
from gen.identification.network.fitting.bends import BEND
from gen.identification.network.fitting.weights import slow_density, windows
from gen.identification.network.search import Found

STIFF = BEND / 8.0
"""Standard deviation of the logarithm by which curves bend that hardly do: a tenth."""
CLEAR = 6.0
"""Twice the logarithm of the ratio of evidences from which it speaks plainly (Kass and Raftery, J. American Statistical
Association 90, 1995: strong evidence)."""

EXPECTED = 2.0
"""Twice the logarithm of the odds before any run that a motor stands in still air, and that its heats grow with
temperature, as most do: 2.7 to 1 each."""

WARM = 20.0
"""Twice the logarithm of the odds before any run that what begins at one level began cold. They are high, as a network
that lacks something makes up for it by another room."""


def clearly_better(one: Found, other: Found) -> bool:
    """Whether the evidence is clearly for one of two networks."""
    return in_favour(one, other) >= CLEAR


def likely(warm: Found, without: Found) -> bool:
    """Whether what goes with temperature is taken: by the evidence, and by what is known before any run."""
    return in_favour(without, warm) <= EXPECTED


def plainly_warm(in_any_room: Found, in_its_room: Found) -> bool:
    """Whether runs that are taken to have begun cold did not, although they begin at one level."""
    return in_favour(in_any_room, in_its_room) > WARM


def in_favour(one: Found, other: Found) -> float:
    """Give twice the logarithm of the evidence's ratio of two networks of the same readings, for the first.

    Both are held against as many independent means: of the windows that the slower of their errors asks for.
    """
    lengths_s = np.maximum(*(slow_density(it.problem.inputs, it.fit.evaluated.residual)[1] for it in (one, other)))
    return _against(other, lengths_s) - _against(one, lengths_s)


def _against(found: Found, lengths_s: FloatArray) -> float:
    """Give minus twice the logarithm of the evidence but for a constant, by Laplace's approximation at the minimum.

    Readings are taken as means over windows that are independent of each other (see `weights`), whose variance is the
    residual's own: their part is then their number, whatever the network, and the logarithm of the variance.
    """
    problem = found.problem
    matrix, _ = problem.assembled(found.fit.normal, found.vector)
    wide = float(np.linalg.slogdet(matrix)[1] - np.linalg.slogdet(problem.prior.precision)[1])
    count = windows(problem.inputs, lengths_s)
    return problem.penalty(found.vector) + wide + float(np.sum(count * np.log(found.density)))
