"""The equations of one lane of a network whose paths have laws, as compiled steps take them."""

from __future__ import annotations

from typing import NamedTuple

from gen.arrays import FloatArray, IntArray


class Lane(NamedTuple):
    """One lane of a flow, as arrays.

    Attributes
    ----------
    matrix, constant, rates
        As in :class:`~gen.model.law_solution.LawFlow`, shapes (n, n), (n,) and (n, paths).
    first, second
        Of each path: its ends' positions among the states, shape (paths,).
    polynomials, radiating
        The paths' laws, as in :attr:`~gen.model.laws.LawsTogether.arrays`.
    """

    matrix: FloatArray
    constant: FloatArray
    rates: FloatArray
    first: IntArray
    second: IntArray
    polynomials: FloatArray
    radiating: FloatArray
