"""What an effect is."""

from __future__ import annotations

from abc import ABC
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal

from pydantic import BaseModel, ConfigDict, Field

from gen.arrays import FloatArray

if TYPE_CHECKING:
    from gen.model.dynamics import ThermalModel

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

Role = Literal["size", "level", "time constant", "reference", "shape"]
"""What a fitted number says of an effect, and what is asked of it before the effect is accepted.

=============  ===========================================================================================
size           how large it is: one sign and like values in every fold, told from none, not at its limit
level          how large it is at one |PWM|, as a factor: has no zero to be told from, only to be determined
time constant  how slow it is: determined by the data, not at its limits
reference      what it is measured against: nothing
shape          where or how it acts: nothing
=============  ===========================================================================================
"""

Kind = Literal["channel", "component", "ambient"]


@dataclass(frozen=True)
class Input:
    """Something measured or modelled that an effect reads; a parameter names it.

    Parameters
    ----------
    parameter
        The parameter that holds the name.
    of
        ``channel``: an extra column of run files, a channel of the board. ``component``: another component, whose rise
        is read, or such a column. ``ambient``: the measured ambient, which the board has anyway.
    units
        Ends of the columns' names, such as ``("_bar",)``. A component's name that is misspelt must not pass for a
        column: a column instead of a component has to end in one of them; the name of a plain channel is free.
    quantity
        What it is, such as "current": the report says that no run holds it.
    neutral
        The value at which the effect does nothing, or the parameter that holds that value: the board's before it is
        told one. None: the ambient for a temperature, else 0.
    limits
        Range on the board where the file's wiring says nothing. None: by the unit.
    """

    parameter: str
    of: Kind = "channel"
    units: tuple[str, ...] = ()
    quantity: str = ""
    neutral: str | float | None = None
    limits: tuple[float, float] | None = None

    def fits(self, column: str) -> bool:
        """Whether a column's name ends in one of the units, in small letters or capitals."""
        return column.lower().endswith(tuple(unit.lower() for unit in self.units))


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
    role
        What it says of the effect.

    Raises
    ------
    ValueError
        If `low` is not positive in a logarithm or a time constant.
    """

    name: str
    start: float
    low: float
    high: float
    log: bool = False
    role: Role = "size"

    def __post_init__(self) -> None:
        if (self.log or self.role == "time constant") and self.low <= 0.0:
            raise ValueError(f"{self.name}: a lower limit of {self.low:g} has no logarithm")


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

    @property
    def size(self) -> int | None:
        """Place of the free parameter that says how large the effect is: its first size or level.

        A hypothesis without one is known by its time constant; None where it has none either.
        """
        for roles in (("size", "level"), ("time constant",)):
            for place, free in enumerate(self.free):
                if free.role in roles:
                    return place
        return None

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
    pwm: FloatArray
    count: FloatArray
    reverse: FloatArray
    standstill: FloatArray
    rate: FloatArray
    heat: FloatArray
    rise: FloatArray
    ambient: FloatArray
    measured_ambient: FloatArray
    others: dict[str, FloatArray]
    channels: dict[str, FloatArray]
    inner: FloatArray


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
    inputs: ClassVar[tuple[Input, ...]] = ()
    """What it reads beside the PWM and its component's own temperature."""
    lookalikes: ClassVar[Mapping[str, str]] = {}
    """Name of another effect -> the experiment that tells this one from it."""
    nonlinear: ClassVar[bool] = False
    """heat and per_rise are the tangent at the rise that they are given; else they do not depend on it."""
    everywhere: ClassVar[bool] = False
    """Where it acts on one component it acts on all (the room's temperature)."""
    heats: ClassVar[bool] = True
    """It has a state E; else it only stands between temperature and reading, or changes nothing but the start."""
    tau: ClassVar[str | None] = None
    """The parameter with E's own time constant in s; where it is None, and without one, E decays with the component."""
    over_pwm: ClassVar[str | None] = None
    """The parameter with the |PWM| that the entries of list parameters belong to."""
    replaces_ambient: ClassVar[bool] = False
    """It brings the measured ambient to a model that counts from its fixed one."""
    of_single_speeds: ClassVar[bool] = False
    """Where each speed was run once, no left-out run can tell of it: then :meth:`local` is judged on stretches."""
    tolerance_K: ClassVar[float | None] = None
    """An error of the reading up to this is every sensor's nature: fitted as a constant beside hypotheses of all other
    effects, and written down as this one by :meth:`calibrated`. One effect of the catalogue has it."""

    def variants(self, setting: Setting) -> list[Variant]:
        """Hypotheses worth a fit for these data; none where a channel is missing."""
        raise NotImplementedError

    def local(self, setting: Setting) -> Variant | None:
        """The hypothesis that says nothing of speeds that were not run; None where there is none."""
        return None

    def calibrated(self, error_K: float) -> dict[str, float]:
        """Parameters that stand for a constant error within the tolerance."""
        raise NotImplementedError

    def own_tau(self, p: Values) -> Lanes:
        """E's own time constant in s, None where E decays with the component."""
        return None if self.tau is None else p.get(self.tau)

    def reads(self, p: Values, *kinds: Kind) -> list[tuple[Input, str]]:
        """Inputs of some kinds (all where none is given) that these parameters name, each with the name."""
        return [
            (source, str(p[source.parameter]))
            for source in self.inputs
            if p.get(source.parameter) is not None and (not kinds or source.of in kinds)
        ]

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

    def columns(self, components: Collection[str]) -> list[str]:
        """Extra columns that it reads, in a model of these components."""
        named = self.effect.reads(self.values, "channel", "component")
        return [name for source, name in named if source.of == "channel" or name not in components]

    def sources(self, components: Collection[str]) -> list[str]:
        """Those of these components whose rise it reads."""
        return [name for _, name in self.effect.reads(self.values, "component") if name in components]
