"""The structure of a transfer function without zeros, and the parameters in which it is fitted.

Each real pole is fitted by the logarithm of its time constant; a pair by the logarithms of its natural time
constant 1/omega and of its damping zeta (above 1 the pair is two real poles). Every value of these parameters is a
stable system, and a relative error of a time constant is what an absolute error of a parameter is.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gen.arrays import FloatArray

ComplexArray = NDArray[np.complex128]
PoleArray = NDArray[Any]
"""float64, or complex128 where there is a pair."""

_NEAR_CRITICAL = 1e-6
"""|zeta^2 - 1| below this is moved to it: the response hardly changes (1e-6 of it), and roots stay apart."""


@dataclass(frozen=True)
class Structure:
    """Order, and whether the two faster poles are a pair.

    Attributes
    ----------
    order
        1..4.
    pair
        Whether the last two parameters describe a pair that may be complex.
    """

    order: int
    pair: bool = False

    @property
    def name(self) -> str:
        """For people."""
        return f"{self.order}" + (" (pair)" if self.pair else "")

    @property
    def real(self) -> int:
        """Number of real poles outside of the pair."""
        return self.order - 2 if self.pair else self.order

    def poles(self, theta: FloatArray) -> PoleArray:
        """Give the poles.

        Parameters
        ----------
        theta
            Shape (..., order): log time constants (s); of a pair log(1/omega) and log(zeta).

        Returns
        -------
        array
            Shape (..., order), rad/s; complex only with a pair.
        """
        real = -np.exp(-theta[..., : self.real])
        if not self.pair:
            return np.asarray(real, dtype=np.float64)
        omega, zeta = np.exp(-theta[..., -2]), np.exp(theta[..., -1])
        square = zeta**2 - 1.0
        square = np.where(np.abs(square) < _NEAR_CRITICAL, np.copysign(_NEAR_CRITICAL, square), square)
        half = np.sqrt(square.astype(np.complex128))
        pair = omega[..., None] * np.stack([-zeta + half, -zeta - half], axis=-1)
        return np.concatenate([real.astype(np.complex128), pair], axis=-1)

    def sorted(self, theta: FloatArray) -> FloatArray:
        """Put the real poles into the order slowest first; shape kept."""
        result = theta.copy()
        result[..., : self.real] = -np.sort(-theta[..., : self.real], axis=-1)
        return result

    @property
    def labels(self) -> tuple[str, ...]:
        """Names of the parameters, in order."""
        real = tuple(f"tau{i + 1}" for i in range(self.real))
        return (*real, "1/omega", "zeta") if self.pair else real


CANDIDATES = (
    Structure(1),
    Structure(2),
    Structure(2, True),
    Structure(3),
    Structure(3, True),
    Structure(4),
    Structure(4, True),
)
"""From simple to rich."""


GAP = (0.0, 1e-6, 1e-5, 4e-4)
"""By order - 1: share of themselves by which coinciding poles are moved apart. Divided differences of n poles lose
gap^(n-1) of the 16 digits; what is left is below 1e-6. A response of 50 K changes by less than 1 mK up to order 3, and
by less than 0.03 K at order 4; where all three coincide and time constants change a hundredfold with speed, by up to
0.1 K at order 3, too."""


def separated(poles: PoleArray) -> PoleArray:
    """Move poles that (nearly) coincide apart by a small share of themselves, see `GAP`."""
    result = poles
    gap = GAP[poles.shape[-1] - 1]
    for i in range(poles.shape[-1]):
        for j in range(i):
            near = np.abs(result[..., i] - result[..., j]) < gap * np.abs(result[..., i])
            if np.any(near):
                result = result.copy() if result is poles else result
                result[..., i] = np.where(near, result[..., j] * (1.0 + gap), result[..., i])
    return result
