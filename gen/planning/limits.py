"""Within what a run must stay."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from gen.arrays import BoolArray, FloatArray
from gen.coefficients import Coefficients
from gen.coefficients.alarms import OverTemperature
from gen.errors import InputError
from gen.model.network import Network
from gen.model.network_parts import PWM
from gen.planning.hypotheses import Remaining
from gen.refinement.network.fitting.anchors import USUAL_AMBIENT
from gen.refinement.network.fitting.data import Data

SLOWEST = 0.15
"""Share of the greatest PWM below which no motor is asked to turn."""
SPEEDS, BACK = 5, 2
"""PWM levels forwards, and backwards."""


@dataclass(frozen=True, eq=False)
class Limits:
    """What a run may be.

    Attributes
    ----------
    levels
        PWM that may be commanded, counts, increasing by size.
    hottest
        Of each of the file's nodes, the sensed ones first, shape (n,), degC; the margin is taken off.
    """

    levels: tuple[int, ...]
    hottest: FloatArray

    def kept(self, hottest: FloatArray) -> BoolArray:
        """Whether runs keep to it, by their hottest temperatures, shape (K, n) to (K,)."""
        return np.asarray(np.all(hottest <= self.hottest, axis=1))


@dataclass(frozen=True)
class Wishes:
    """What the user asks for.

    Attributes
    ----------
    hours
        Length of the run.
    max_pwm
        Greatest |PWM|, counts; None: the file's domain's.
    limit_degC
        Greatest temperature of any part, degC; None: the domain's.
    margin_K
        How far predictions stay below each limit.
    ambient_degC
        Of the room; None: as it was in the runs.
    reverse
        Whether it may turn backwards; None: where a run did, and a hypothesis depends on it.
    seed
        Of the search.
    """

    hours: float
    max_pwm: int | None = None
    limit_degC: float | None = None
    margin_K: float = 3.0
    ambient_degC: float | None = None
    reverse: bool | None = None
    seed: int = 0


def limits_of(coefficients: Coefficients, wishes: Wishes, data: Data, remaining: Remaining) -> Limits:
    """Put together what the file and the user allow.

    Parameters
    ----------
    coefficients
        The file.
    wishes
        The user's.
    data, remaining
        Whether the motor turned backwards, and whether it matters.

    Raises
    ------
    InputError
        If no PWM is left.
    """
    document = coefficients.document
    low, high = document.validity.pwm
    high = min(high, document.domain.pwm[1])
    if wishes.max_pwm is not None:
        if wishes.max_pwm < max(low, 1):
            place = "--max-pwm"
            raise InputError(
                f"found {wishes.max_pwm}, expected at least {max(low, 1)}, where the file is valid", place=place
            )
        high = min(high, wishes.max_pwm)
    slow = max(low, document.domain.pwm[0], round(SLOWEST * document.validity.pwm[1]), 1)
    turning = np.unique(np.rint(np.linspace(min(slow, high), high, SPEEDS)).astype(np.int64)).tolist()
    rest = [0] if document.domain.pwm[0] == 0 else []
    back = turning[-1 : -2 * BACK - 1 : -2][:BACK] if _backwards(coefficients, wishes, data, remaining) else []
    network = coefficients.model.network
    assert network is not None
    top = np.full(len(network.nodes), document.domain.temperature_degC[1])
    if wishes.limit_degC is not None:
        top = np.minimum(top, wishes.limit_degC)
    names = remaining.hypotheses[0].shape.names
    room = coefficients.model.ambient_fixed if coefficients.model.ambient_fixed is not None else USUAL_AMBIENT
    for rule in document.alarms:
        if isinstance(rule, OverTemperature):
            at = names.index(rule.component)
            top[at] = min(top[at], rule.limit_degC, _shown_at(network, rule.component, rule.limit_degC, room))
    return Limits((*rest, *turning, *(-level for level in back)), top - wishes.margin_K)


def _shown_at(network: Network, name: str, limit_degC: float, room: float) -> float:
    """Where a node is whose sensor shows a limit, degC; its offset is small beside the margin."""
    sensor = network.nodes[network.index(name)].sensor
    return limit_degC if sensor is None else float(replace(sensor, offset=0.0).temperature(limit_degC, room))


def _backwards(coefficients: Coefficients, wishes: Wishes, data: Data, remaining: Remaining) -> bool:
    if wishes.reverse is not None:
        return wishes.reverse
    network = coefficients.model.network
    reads = network is not None and any(channel.column == PWM for channel in network.channels)
    matters = reads or any(one.name == "direction" for one in remaining.hypotheses)
    return data.offered.backwards and matters


def nothing_is_cold_enough(limits: Limits, hottest: FloatArray, names: tuple[str, ...], level: int) -> InputError:
    """Say that even the coolest run is beyond a limit.

    Parameters
    ----------
    limits
        The limits.
    hottest
        Of the coolest run, shape (n,), degC.
    names
        Of the nodes.
    level
        Its PWM.
    """
    node = int(np.argmax(hottest - limits.hottest))
    return InputError(
        f"{names[node]} comes to {hottest[node]:.1f} degC at PWM {level} already; the limits less the margin allow "
        f"{limits.hottest[node]:.1f} degC",
        place="--limit-degC",
    )
