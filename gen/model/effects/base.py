"""What an effect is."""

from __future__ import annotations

from abc import ABC
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Annotated, Any, ClassVar

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field

if TYPE_CHECKING:
    from gen.model.dynamics import ThermalModel

Array = NDArray[np.float64]
Lanes = Any
"""A number, or an array of them: one for each lane of a fit, and for each step where time comes first."""
Values = Mapping[str, Any]
"""Parameters by name: numbers (or arrays of them, one for each lane of a fit), texts, None, lists of these."""


class Parameters(BaseModel):
    """Parameters of an effect as the coefficient file has them: units in the names, physical ranges in the fields."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)


Tau = Annotated[
    float | None,
    Field(ge=1.0, le=40000.0, description="Time constant in s; null: the component's own at the present PWM."),
]
"""Time constant of an effect's own state."""


@dataclass(frozen=True)
class Free:
    """One number that a fit may choose.

    Parameters
    ----------
    name
        The parameter; ``name[i]`` is entry i of a list.
    start
        Where the fit starts.
    low, high
        Physical limits.
    log
        The fit works on the logarithm (time constants).
    """

    name: str
    start: float
    low: float
    high: float
    log: bool = False


@dataclass(frozen=True)
class Variant:
    """One concrete hypothesis: which entries are fixed and which are fitted.

    Parameters
    ----------
    fixed
        Parameters that are not fitted: a channel's name, ``tau_s: None``, a list of PWM levels.
    free
        The others.
    also
        Further starts, where a fit from one may end in a wrong place.
    """

    fixed: Mapping[str, Any] = field(default_factory=dict)
    free: tuple[Free, ...] = ()
    also: tuple[tuple[float, ...], ...] = ()

    def values(self, numbers: Lanes) -> dict[str, Any]:
        """Put fixed and free together; `numbers` holds one number or array for each free parameter, in order."""
        made: dict[str, Any] = dict(self.fixed)
        for free, number in zip(self.free, numbers, strict=True):
            if free.name.endswith("]"):
                made.setdefault(free.name.split("[")[0], []).append(number)
            else:
                made[free.name] = number
        return made


@dataclass(frozen=True)
class Setting:
    """What is known of the data when hypotheses are made.

    Parameters
    ----------
    component
        The component whose residual is to be explained.
    others
        The other components of the model.
    channels
        Mean of every extra channel that the runs have.
    levels
        |PWM| at which the motor ran for long, in counts.
    rate
        The component's own rate at the middle of the validity range, in 1/s.
    ambient_fixed
        Ambient in degC as the model has it, None where the model reads it already.
    ambient_measured
        The runs hold a measured ambient.
    varying
        The extra channels that change.
    reverse, warm
        Some run has PWM < 0; some run starts warm.
    """

    component: str
    others: tuple[str, ...]
    channels: Mapping[str, float]
    levels: tuple[int, ...]
    rate: float
    ambient_fixed: float | None
    ambient_measured: bool
    varying: frozenset[str]
    reverse: bool
    warm: bool

    def ending(self, *suffixes: str) -> list[str]:
        """Extra channels that change and whose unit (the end of the name) is one of these."""
        wanted = tuple(s.lower() for s in suffixes)
        return [name for name in self.channels if name in self.varying and name.lower().endswith(wanted)]


class Moment:
    """What drives an effect during one step (or, as arrays with a leading axis, during all of them).

    Attributes
    ----------
    pwm
        Mean |PWM| as a share of full scale; `count` is the same in counts.
    reverse, standstill
        Share of the step with PWM < 0 and with PWM = 0.
    rate, heat
        The component's own rate in 1/s and the baseline's heating, rate times steady rise, in K/s.
    rise, ambient
        The component's rise with all effects (K), and the ambient that it is counted from (degC).
    measured_ambient
        The measured ambient in degC.
    others
        Rise of the other components, K.
    channels
        Extra channels, mean of the step.
    inner
        The effect's inner state.
    """

    __slots__ = (
        "ambient",
        "channels",
        "count",
        "heat",
        "inner",
        "measured_ambient",
        "others",
        "pwm",
        "rate",
        "reverse",
        "rise",
        "standstill",
    )
    pwm: Array
    count: Array
    reverse: Array
    standstill: Array
    rate: Array
    heat: Array
    rise: Array
    ambient: Array
    measured_ambient: Array
    others: dict[str, Array]
    channels: dict[str, Array]
    inner: Array


class Effect(ABC):
    """A named physical effect.

    A subclass states its name, its equation, its parameters' model, the signature that tells it from look-alikes and
    overrides what it needs of the methods below; each works on arrays with a lane for each run and parameter set.
    """

    name: ClassVar[str]
    title: ClassVar[str]
    equation: ClassVar[str]
    parameters: ClassVar[type[Parameters]]
    signature: ClassVar[str]
    needs: ClassVar[str] = ""
    lookalikes: ClassVar[Mapping[str, str]] = {}
    """Name of another effect -> the experiment that tells this one from it."""
    nonlinear: ClassVar[bool] = False
    """heat and per_rise are the tangent at the rise that they are given; else they do not depend on it."""
    everywhere: ClassVar[bool] = False
    """Where it acts on one component it acts on all (the room's temperature)."""
    heats: ClassVar[bool] = True
    """It has a state E; else it only stands between temperature and reading, or changes nothing but the start."""

    def variants(self, setting: Setting) -> list[Variant]:
        """Hypotheses worth a fit for these data; none where a channel is missing."""
        raise NotImplementedError

    def heat(self, p: Values, m: Moment) -> Lanes:
        """Heating in K/s, but for the part that is proportional to the component's own rise."""
        raise NotImplementedError

    def per_rise(self, p: Values, m: Moment) -> Lanes:
        """That part, for each K of rise, in 1/s: q = heat + per_rise T_rise. It needs the component's own rate."""
        return 0.0

    def inner(self, p: Values, m: Moment) -> tuple[Lanes, Lanes] | None:
        """Target and time constant (s) of the inner state H, H' = (target - H)/tau; None without one."""
        return None

    def inner_start(self, p: Values, rise: Lanes) -> Lanes:
        """H at the start, given the measured rise there in K."""
        return 0.0

    def start(self, p: Values, rise: Lanes, ambient: Lanes, measured_ambient: Lanes) -> Lanes:
        """What the true rise at the start differs by from the one read off the sensor, in K."""
        return 0.0

    def begin(self, p: Values, ambient: Lanes, measured_ambient: Lanes) -> Lanes:
        """E at the start, in K."""
        return 0.0

    def reading(self, p: Values, temperature: Lanes, ambient: Lanes, measured_ambient: Lanes, elapsed: Lanes) -> Lanes:
        """What the sensor shows at a temperature in degC; `elapsed` in s since the start."""
        return temperature

    def lag(self, p: Values) -> Lanes:
        """Time constant of the sensor in s, None without lag."""
        return None

    def folded(self, p: Values, model: ThermalModel, component: str) -> ThermalModel | None:
        """The model with the effect in its own entries; None where it needs a state or a channel of its own."""
        return None


@dataclass(frozen=True)
class Applied:
    """An effect with its parameters, at a component.

    Parameters
    ----------
    effect
        From the registry.
    component
        Name of the component.
    values
        Parameters by name.
    """

    effect: Effect
    component: str
    values: Values
