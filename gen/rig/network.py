"""The thermal network: from heat paths and masses to a linear system at each speed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from gen.arrays import FloatArray
from gen.rig.parameters import AMBIENT, HeatPath


class Network:
    """Nodes with heat capacities, joined by heat paths.

    The temperatures T follow ``C dT/dt = -G(s) T + g(s) T_ambient + q``.

    Parameters
    ----------
    capacities_J_per_K
        By node, in the order of the state vector.
    paths
        Between two nodes, or a node and ``ambient``.
    """

    def __init__(self, capacities_J_per_K: Mapping[str, float], paths: Sequence[HeatPath]) -> None:
        self.nodes = tuple(capacities_J_per_K)
        self.capacities = np.array(list(capacities_J_per_K.values()))
        self.paths = tuple(paths)
        self._still = np.array([path.still_W_per_K for path in paths])
        self._forced = np.array([path.forced_W_per_K for path in paths])
        self._exponent = np.array([path.exponent for path in paths])
        n = len(self.nodes)
        place = {name: index for index, name in enumerate(self.nodes)}
        # Row k of `_spread` is what path k, at 1 W/K, adds to the n x (n + 1) matrix [-G, g], flattened.
        spread = np.zeros((len(paths), n, n + 1), dtype=np.float64)
        for k, path in enumerate(paths):
            a, b = (n if name == AMBIENT else place[name] for name in (path.a, path.b))
            for here, there in ((a, b), (b, a)):
                if here < n:
                    spread[k, here, here] -= 1.0
                    spread[k, here, there] += 1.0
        self._spread = spread.reshape(len(paths), -1)

    def conductances(self, speed: float) -> FloatArray:
        """W/K of each path at a speed as a fraction of the rated one, shape (paths,)."""
        return np.asarray(self._still + self._forced * np.power(speed, self._exponent), dtype=np.float64)

    def flows(self, conductances: FloatArray) -> FloatArray:
        """``[-G, g]`` in W/K, shape (n, n + 1): heat into each node from every node's temperature and ambient's."""
        n = len(self.nodes)
        flows: FloatArray = (conductances @ self._spread).reshape(n, n + 1)
        return flows

    def rates(self, conductances: FloatArray) -> FloatArray:
        """`flows` over the capacities, 1/s, shape (n, n + 1)."""
        return np.asarray(self.flows(conductances) / self.capacities[:, None], dtype=np.float64)


def steady(flows: FloatArray, heat_W: FloatArray, ambient_degC: float) -> FloatArray:
    """Temperatures at which nothing changes, degC, shape (n,)."""
    return np.asarray(np.linalg.solve(-flows[:, :-1], heat_W + flows[:, -1] * ambient_degC), dtype=np.float64)


def propagator(rates: FloatArray, step_s: float) -> FloatArray:
    """``h * phi1(h A)`` with ``phi1(Z) = (exp(Z) - 1) / Z``, shape (n, n): exact for a constant right-hand side.

    ``T(t + h) = T + h phi1(h A) (A T + b)``. The series converges for every Z; with steps below the network's fastest
    time constant a dozen terms reach double precision.
    """
    Z = rates[:, :-1] * step_s
    n = len(Z)
    term = np.eye(n)
    total = term.copy()
    bound = float(np.abs(Z).sum(axis=1).max())
    size, k = 1.0, 1
    while size > 1e-17:
        k += 1
        term = term @ Z / k
        total += term
        size *= bound / k
    return total * step_s
