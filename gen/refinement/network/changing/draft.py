"""A network at the distinct inputs of some runs while effects are put on it, with its derivatives."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from gen.arrays import FloatArray
from gen.identification.network.fitting.partial import Partial
from gen.identification.network.fitting.physics import Physical

Slope = tuple[int, FloatArray]
"""A parameter's place, and the derivative by it at each distinct input, shape (L,)."""


class Quantity:
    """Conductances of Q paths, or heats of n nodes, with derivatives.

    Parameters
    ----------
    value
        Shape (L, Q).
    """

    def __init__(self, value: FloatArray) -> None:
        self.value = value
        self._slopes: list[tuple[int, int, FloatArray]] = []

    def add(self, at: int, value: FloatArray, slopes: Iterable[Slope]) -> None:
        """Add to one of them."""
        self.value[:, at] += value
        self._slopes += [(at, place, slope) for place, slope in slopes]

    def scale(self, at: int, factor: FloatArray, slopes: Iterable[Slope]) -> None:
        """Multiply one of them."""
        before = self.value[:, at].copy()
        self._slopes = [(of, by, slope * factor if of == at else slope) for of, by, slope in self._slopes]
        self._slopes += [(at, place, slope * before) for place, slope in slopes]
        self.value[:, at] = before * factor

    def slopes(self, at: int) -> list[Slope]:
        """Give the derivatives of one of them."""
        return [(by, slope) for of, by, slope in self._slopes if of == at]

    def partial(self) -> Partial:
        """Give the derivatives."""
        return Partial(
            np.array([of for of, _, _ in self._slopes], dtype=np.int64),
            np.array([by for _, by, _ in self._slopes], dtype=np.int64),
            np.array([slope for _, _, slope in self._slopes]).reshape(len(self._slopes), len(self.value)).T,
        )


class Draft:
    """Conductances in W/K; heats in W of nodes at 0 degC, and what they grow by with the node's temperature, W/K."""

    def __init__(self, capacity: FloatArray, levels: int, paths: int) -> None:
        self._capacity = capacity
        self.conductance = Quantity(np.zeros((levels, paths)))
        self.heat = Quantity(np.zeros((levels, capacity.size)))
        self.growth = Quantity(np.zeros((levels, capacity.size)))
        self._laws: list[tuple[int, tuple[int, int], FloatArray]] = []

    def warm(self, node: int, power: FloatArray, per_K: float, reference: float, slopes: Iterable[Slope]) -> None:
        """Add a heat of power (1 + per_K (T - reference))."""
        slopes = list(slopes)
        at_zero = 1.0 - per_K * reference
        self.heat.add(node, power * at_zero, [(place, slope * at_zero) for place, slope in slopes])
        if per_K:
            self.growth.add(node, power * per_K, [(place, slope * per_K) for place, slope in slopes])

    def scale_heats(self, node: int, factor: FloatArray, slopes: Iterable[Slope]) -> None:
        """Multiply all heat of a node."""
        slopes = list(slopes)
        self.heat.scale(node, factor, slopes)
        self.growth.scale(node, factor, slopes)

    def grow(self, node: int, per_K: FloatArray, reference: float, slopes: Iterable[Slope]) -> None:
        """Let all heat of a node grow with its temperature, by a share of it for each kelvin over the reference."""
        slopes = list(slopes)
        power, by_others = self.heat.value[:, node].copy(), self.heat.slopes(node)
        self.growth.add(
            node,
            per_K * power,
            [(place, slope * power) for place, slope in slopes]
            + [(place, per_K * slope) for place, slope in by_others],
        )
        self.heat.scale(node, 1.0 - reference * per_K, [(place, -reference * slope) for place, slope in slopes])

    def law(self, at: int, ends: tuple[int, int], excess: FloatArray) -> None:
        """Let a path carry more than the difference of its ends, the ambient as -1, by an excess in K, shape (L,)."""
        self._laws.append((at, ends, excess))

    def physical(self) -> Physical:
        """Give what the fit needs: what laws carry goes with conductances as they now are, and no effect scales it."""
        for at, ends, excess in self._laws:
            for node, sign in zip(ends, (-1.0, 1.0), strict=True):
                if node >= 0:
                    carried = sign * excess
                    slopes = [(place, slope * carried) for place, slope in self.conductance.slopes(at)]
                    self.heat.add(node, self.conductance.value[:, at] * carried, slopes)
        self._laws.clear()
        growing = bool(np.any(self.growth.value)) or self.growth.partial().by.size > 0
        return Physical(
            capacity=self._capacity,
            conductance=self.conductance.value,
            heat=self.heat.value,
            by_path=self.conductance.partial(),
            by_heat=self.heat.partial(),
            growth=self.growth.value if growing else None,
            by_growth=self.growth.partial() if growing else None,
        )
