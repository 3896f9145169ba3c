"""The recursion of a component's own poles once more, driven by its effects: formats and the drive's limit."""

from __future__ import annotations

from math import ceil, log2

import numpy as np

from gen.arrays import FloatArray
from gen.lowering.effects.program import GUARD_BITS, Chain
from gen.lowering.fixed.component import FixedComponent
from gen.lowering.fixed.formats import RESIDUE_BITS
from gen.lowering.float32 import FloatComponent
from gen.lowering.recursion import increments
from gen.lowering.recursion.dynamics import Dynamics, dynamics
from gen.lowering.recursion.no_proof import NoProofError
from gen.lowering.recursion.reach import SwitchedRecursion
from gen.model import Component, ThermalModel

#: Room for rounding, and for what the increment form differs by.
_MARGIN = 1.02
#: Without a proof so much of a word is used; words are limited, too.
_UNPROVEN_SHARE = 0.25
#: In float32 the words are made coarser by at most so many bits to make room for large drives.
_MOST_COARSER = 12


def chain(
    model: ThermalModel, component: Component, lowered: FixedComponent | FloatComponent, magnitude_K: float
) -> Chain:
    """Find how far the drive may go so that no word of the recursion leaves its bits, whatever the PWM does.

    The recursion is linear, so what one kelvin of drive can do under arbitrary switching (the invariant polytope of
    :mod:`gen.lowering.recursion.reach`) scales. In fixed point the words have :data:`GUARD_BITS` more than the
    baseline's above its highest; in float32 their unit is made coarser where the drive needs it.

    Parameters
    ----------
    model, component, lowered
        The baseline's, whose rates and formats it shares.
    magnitude_K
        Largest magnitude of the drive, by the ranges of all that it depends on.
    """
    if isinstance(lowered, FixedComponent):
        bits = [f - RESIDUE_BITS for f in lowered.layout.fraction_bits]
        room, drive_bits = 2.0**GUARD_BITS, 38
    else:
        bits, room, drive_bits = list(lowered.fraction_bits), 1.0, 31
    capacity = room * 2.0 ** (31.0 - np.array(bits))
    exact = dynamics(model, component, lowered.substeps)
    largest = reached(exact) if not lowered.saturates else None
    reach = capacity / (largest * _MARGIN) if largest is not None else capacity[:1] * _UNPROVEN_SHARE
    limit_K = float(reach.min())
    coarser = 0
    if isinstance(lowered, FloatComponent):
        coarser = min(max(0, ceil(log2(max(magnitude_K, 1e-9) / limit_K))), _MOST_COARSER)
    limit = min(limit_K * 2.0 ** bits[0], 2.0**drive_bits - 128.0)
    return Chain(bits[0] - coarser, int(limit), largest is not None)


def reached(exact: Dynamics) -> FloatArray | None:
    """Largest magnitude of each word, and of the difference of rise and drive, for a drive and a start of up to 1 K.

    Returns
    -------
    FloatArray or None
        In K per sample^k, shape (n,), the first for the difference; None without a proof.
    """
    if exact.order == 1:
        return np.array([2.0])
    key = (exact.exact.tobytes(), exact.c.tobytes())
    if key not in _known:
        _known[key] = _enclosed(exact)
    return _known[key]


_known: dict[tuple[bytes, bytes], FloatArray | None] = {}


def _enclosed(exact: Dynamics) -> FloatArray | None:
    n = exact.order
    try:
        recursion = SwitchedRecursion(exact.exact)
        towards = (np.eye(n) - exact.exact)[:, :, 0]
        start = np.zeros((1, n))
        start[0, 0] = 1.0
        reach = recursion.bound(towards[:, None, :], start)
    except NoProofError:
        return None
    distance = reach.axes.copy()
    distance[0] += 1.0  # from the drive
    words = np.einsum("pij,j->pi", np.abs(increments.state_map(exact.c)), distance).max(axis=0)
    words[0] += 1.0
    return np.asarray(words)
