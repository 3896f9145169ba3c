"""The thermal model: components whose rise over ambient obeys A(d/dt) T = K |PWM|."""

from __future__ import annotations

from dataclasses import dataclass
from decimal import Decimal, localcontext
from functools import cached_property
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gen.arrays import FloatArray, IntArray
from gen.model.schedules import EXACT, Schedule

if TYPE_CHECKING:
    import control

    from gen.model.network import Network

Outside = Literal["extrapolate", "hold"]
MAX_PWM = 255
"""The largest count of an 8-bit PWM."""
PWM_LEVELS = MAX_PWM + 1
"""How many |PWM| there are: 0..255."""
ROOM_degC = 25.0
"""The ambient where none is given or measured."""
AMBIENT_MARGIN_K = 10.0
"""An ambient that acts at once may lie so far outside of the declared domain."""


@dataclass(frozen=True)
class Pole:
    """One pole of a component.

    Parameters
    ----------
    real, imag
        Real and imaginary part as schedules, in rad/s; imag is None for a real pole.
    """

    real: Schedule
    imag: Schedule | None = None


@dataclass(frozen=True)
class Component:
    """One part of the motor, with A monic of the given order and the gain K, both scheduled by |PWM|.

    Parameters
    ----------
    name
        A C identifier.
    order
        1..4, the number of poles.
    gain
        K in K/s^order per PWM count.
    poles
        The poles one by one; A = real(poly(poles)).
    negative_gain
        "zero": where K is negative outside the validity range, it is taken as 0. None: K is used as it is.
    validity
        The |PWM| range on which the schedules were identified.
    outside
        Outside of it the schedules "extrapolate", or "hold" their value at the nearest end.
    description
        For people.
    """

    name: str
    order: int
    gain: Schedule
    poles: tuple[Pole, ...]
    validity: tuple[int, int] = (0, MAX_PWM)
    outside: Outside = "extrapolate"
    negative_gain: Literal["zero"] | None = None
    description: str = ""

    def denominator(self, pwm: ArrayLike) -> FloatArray:
        """Give A, each coefficient correctly rounded to float64.

        Parameters
        ----------
        pwm
            Integer |PWM|, shape (n,), 0..255.

        Returns
        -------
        FloatArray
            Shape (n, order + 1), highest power first, monic; column k in 1/s^k.
        """
        return self._denominators[_counts(pwm)]

    def dropped_imaginary(self, pwm: ArrayLike) -> FloatArray:
        """Give the imaginary parts that real(poly(poles)) drops, shape (n, order + 1), columns as in A."""
        return self._dropped[_counts(pwm)]

    def raw_gain(self, pwm: ArrayLike) -> FloatArray:
        """Give K as the schedule has it, before the treatment of negative values, shape (n,)."""
        return self._gains[_counts(pwm)]

    def effective_gain(self, pwm: ArrayLike) -> FloatArray:
        """Give K after the treatment of negative values, shape (n,), in K/s^order per count."""
        counts = _counts(pwm)
        gain = self._gains[counts]
        if self.negative_gain == "zero":
            lo, hi = self.validity
            gain = np.where((gain < 0.0) & ((counts < lo) | (counts > hi)), 0.0, gain)
        return np.asarray(gain, dtype=np.float64)

    def steady_rise(self, pwm: ArrayLike) -> FloatArray:
        """Give the rise at which the component settles at constant |PWM|: K |PWM| / A(0), shape (n,), K."""
        counts = _counts(pwm)
        return np.asarray(self.effective_gain(counts) * counts / self._denominators[counts, -1], dtype=np.float64)

    def state_matrices(self, pwm: ArrayLike) -> tuple[FloatArray, FloatArray]:
        """Give the companion form for the state (T, T', T'', ...) and the input |PWM|.

        Parameters
        ----------
        pwm
            Integer |PWM|, shape (n,), 0..255.

        Returns
        -------
        A, B
            Shapes (n, order, order) and (n, order), in s, K and counts.
        """
        counts = _counts(pwm)
        a = np.zeros((counts.size, self.order, self.order))
        b = np.zeros((counts.size, self.order))
        for i in range(self.order - 1):
            a[:, i, i + 1] = 1.0
        a[:, -1, :] = -self._denominators[counts, :0:-1]
        b[:, -1] = self.effective_gain(counts)
        return a, b

    @cached_property
    def _gains(self) -> FloatArray:
        return np.asarray([float(self.gain.exact(self._held(x))) for x in range(PWM_LEVELS)])

    @cached_property
    def _denominators(self) -> FloatArray:
        return self._expanded[0]

    @cached_property
    def _dropped(self) -> FloatArray:
        return self._expanded[1]

    @cached_property
    def _expanded(self) -> tuple[FloatArray, FloatArray]:
        """Both parts of poly(poles) at 0..255, expanded in decimal so that only one rounding is left."""
        real = np.empty((PWM_LEVELS, self.order + 1))
        imag = np.empty_like(real)
        for x in range(PWM_LEVELS):
            held = self._held(x)
            with localcontext(EXACT):
                poly = [(Decimal(1), Decimal(0))]
                for pole in self.poles:
                    poly = _times_root(poly, pole.real.exact(held), pole.imag.exact(held) if pole.imag else Decimal(0))
            real[x] = [float(re) for re, _ in poly]
            imag[x] = [float(im) for _, im in poly]
        return real, imag

    def _held(self, pwm: int) -> int:
        if self.outside == "hold":
            return min(max(pwm, self.validity[0]), self.validity[1])
        return pwm


@dataclass(frozen=True)
class ThermalModel:
    """A motor: its components by transfer functions, or one network.

    Parameters
    ----------
    name
        The model's name.
    sample_time
        The board's step in s.
    full_scale
        The PWM count that is 100 %.
    validity, outside
        The |PWM| range on which the schedules were identified, and what holds outside of it.
    domain_pwm, domain_ambient, domain_temperature
        What the model has to stand: |PWM| in counts, ambient in degC, measured or start temperatures in degC.
    ambient_fixed
        The ambient in degC where it is not measured, or None.
    ambient_channel
        The column with the measured ambient, or None.
    components
        In the order of the file; none where there is a network.
    network
        The motor as a network, of which the sensed nodes are the components; None with transfer functions.
    ambient_at_once
        Components follow a change of the ambient at once, and not with their own dynamics.
    """

    name: str
    sample_time: float
    full_scale: int
    validity: tuple[int, int]
    outside: Outside
    domain_pwm: tuple[int, int]
    domain_ambient: tuple[float, float]
    domain_temperature: tuple[float, float]
    ambient_fixed: float | None
    ambient_channel: str | None
    components: tuple[Component, ...]
    network: Network | None = None
    ambient_at_once: bool = False

    @property
    def ambient_passes(self) -> bool:
        """Whether a change of the ambient passes the components' own dynamics."""
        return self.network is None and not self.ambient_at_once

    @property
    def ambient_told(self) -> tuple[float, float]:
        """What a board may be told of the ambient, in degC; values beyond are held to it."""
        low, high = self.domain_ambient
        if self.ambient_passes:
            return low, high
        return low - AMBIENT_MARGIN_K, high + AMBIENT_MARGIN_K

    @property
    def ambient_reference(self) -> float:
        """What rises count from while the ambient moves, in degC: the ambient until one is told."""
        low, high = self.ambient_told
        return min(max(ROOM_degC if self.ambient_fixed is None else self.ambient_fixed, low), high)

    @property
    def ambient_over(self) -> tuple[float, float]:
        """Lowest and highest ambient over the reference that acts on the components' dynamics, in K."""
        if not self.ambient_passes:
            return 0.0, 0.0
        low, high = self.ambient_told
        return low - self.ambient_reference, high - self.ambient_reference

    @property
    def component_names(self) -> tuple[str, ...]:
        """The components' names, in order."""
        if self.network is not None:
            return tuple(node.name for node in self.network.sensed)
        return tuple(component.name for component in self.components)

    def component(self, name: str) -> Component:
        """Give the component of that name.

        Raises
        ------
        KeyError
            When there is none.
        """
        for component in self.components:
            if component.name == name:
                return component
        raise KeyError(f"no component {name!r}; there are {', '.join(self.component_names)}")

    def transfer_function(self, component_name: str, pwm: int) -> control.TransferFunction:
        """Give K/A(s) at a constant |PWM|: input PWM counts, output rise in K, as python-control's object."""
        import control  # it pulls in matplotlib's pyplot, which no other use of the model needs

        component = self.component(component_name)
        gain = float(component.effective_gain([abs(pwm)])[0])
        return control.TransferFunction(
            [gain], component.denominator([abs(pwm)])[0], inputs=["pwm"], outputs=[component_name]
        )

    def zpk(self, component_name: str, pwm: int) -> control.TransferFunction:
        """Give the same from its zeros (none), the roots of A and its gain."""
        import control

        component = self.component(component_name)
        roots = np.roots(component.denominator([abs(pwm)])[0])
        return control.zpk(
            [],
            roots,
            float(component.effective_gain([abs(pwm)])[0]),
            inputs=["pwm"],
            outputs=[component_name],
        )

    def sampled(self, component_name: str, pwm: int) -> control.TransferFunction:
        """Give the system sampled at the model's sample time with a zero-order hold."""
        import control

        return control.sample_system(self.transfer_function(component_name, pwm), self.sample_time, method="zoh")


def _counts(pwm: ArrayLike) -> IntArray:
    array: NDArray[Any] = np.atleast_1d(np.asarray(pwm))
    if array.dtype.kind not in "iu":
        raise TypeError(f"|PWM| is an integer, not {array.dtype}")
    if array.size and (array.min() < 0 or array.max() > MAX_PWM):
        raise ValueError(f"|PWM| is 0..{MAX_PWM}, not {array.min()}..{array.max()}")
    return array.astype(np.int64)


def _times_root(poly: list[tuple[Decimal, Decimal]], re: Decimal, im: Decimal) -> list[tuple[Decimal, Decimal]]:
    """Multiply a complex polynomial, highest power first, by (s - (re + j im))."""
    zero = (Decimal(0), Decimal(0))
    return [
        (a - (c * re - d * im), b - (c * im + d * re))
        for (a, b), (c, d) in zip([*poly, zero], [zero, *poly], strict=True)
    ]
