"""The certificate of a network: the differential equations, what is claimed of each state, and the words' unit.

    C_i dT_i/dt = sum of G (T_other - T_i) + sum of P (1 + k (T_i - T_reference))

On a path with a law d f(|d|) stands in the place of a difference d, or that of fourth powers in kelvin.
A sensor that lags is a state of its own, ``dT/dt = (T_node - T) / lag``, and so is how far one has drifted since the
start, ``dD/dt = (D_end - D) / tau``. Numbers are read as float64, which is exact.
"""

from __future__ import annotations

from math import isfinite
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, model_validator


def _finite(value: float) -> float:
    if not isfinite(value):
        raise ValueError("expected a finite number")
    return value


Number = Annotated[float, Field(strict=True), AfterValidator(_finite)]
Positive = Annotated[Number, Field(gt=0)]
Width = Annotated[Number, Field(ge=0)]
#: Place of something in a list of the certificate.
Place = Annotated[int, Field(strict=True, ge=0)]
Identifier = Annotated[str, Field(pattern=r"^[A-Za-z_]\w*$")]
Level = Annotated[int, Field(strict=True, ge=0, le=255)]
#: A told value, in thousandths of its unit.
Thousandths = Annotated[int, Field(strict=True, gt=-(1 << 31), lt=1 << 31)]


class _Strict(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)


class Told(_Strict):
    """A channel: what is told is held to this range.

    Attributes
    ----------
    column
        For people.
    low, high, neutral
        In thousandths.
    """

    column: str
    low: Thousandths
    high: Thousandths
    neutral: Thousandths

    @model_validator(mode="after")
    def _in_order(self) -> Told:
        if not self.low <= self.neutral <= self.high:
            raise ValueError("a channel's range is empty, or does not hold its neutral value")
        return self


class Factor(_Strict):
    """What a channel's value multiplies a conductance or a power by; below 0 it counts as 0.

    Attributes
    ----------
    channel
        Which, the ambient being 0.
    polynomial
        Highest power first; empty for a table.
    at, value
        A table, linear between its points, its ends held.
    bits
        The board's word w means w 2^-bits.
    """

    channel: Place
    polynomial: list[Number] = []
    at: list[Number] = []
    value: list[Number] = []
    bits: Annotated[int, Field(strict=True, ge=-64, le=64)]

    @model_validator(mode="after")
    def _one_kind(self) -> Factor:
        if bool(self.polynomial) == bool(self.at) or len(self.at) != len(self.value):
            raise ValueError("a factor is either a polynomial or a table")
        if any(b <= a for a, b in zip(self.at, self.at[1:], strict=False)):
            raise ValueError("a table's points do not increase")
        return self


class State(_Strict):
    """A state, what is claimed of it.

    Attributes
    ----------
    name
        Its enumerator in the C++, without the prefix.
    capacity_J_per_K
        Of a node.
    start_factor
        Of a node that nobody measures: its rise over the ambient at the start, for each kelvin at which it would rest.
    start_from
        Instead of where it would rest: a measured node, and the rise for each kelvin of its own, of each.
    lags, time_constant_s
        Instead: which node it lags behind, and its time constant.
    drifts_to_K
        Instead of `lags`: where a drift that begins at 0 ends.
    range_degC
        What the exact solution never leaves.
    error_K
        Largest difference between the board's state and the exact one.
    """

    name: Identifier
    capacity_J_per_K: Positive | None = None
    start_factor: Annotated[Number, Field(ge=0)] | None = None
    start_from: tuple[tuple[Place, Annotated[Number, Field(ge=0)]], ...] | None = None
    lags: Place | None = None
    drifts_to_K: Number | None = None
    time_constant_s: Positive | None = None
    range_degC: tuple[Number, Number]
    error_K: Positive

    @model_validator(mode="after")
    def _one_kind(self) -> State:
        kinds = (self.capacity_J_per_K, self.lags, self.drifts_to_K)
        if sum(kind is not None for kind in kinds) != 1 or (self.capacity_J_per_K is None) != (
            self.time_constant_s is not None
        ):
            raise ValueError("a state is either a node or lags behind one, or drifts")
        if self.range_degC[0] >= self.range_degC[1]:
            raise ValueError("a range is empty")
        return self


class Path(_Strict):
    """A way for heat from a node to another one, or to the ambient (None).

    Attributes
    ----------
    between
        Its ends.
    conductance_W_per_K
        By |PWM| of the domain, every factor 1.
    at_rest_W_per_K
        At |PWM| 0, where hidden nodes start.
    factors
        All multiply it.
    convection
        Of natural convection: f over |d| in K, highest power first.
    radiation_degC
        Of radiation: the conductance is that at this temperature of both ends.
    scale
        Of a law: what the C++ has of it is that much less, and the path's rates are that much more.
    """

    between: tuple[Place, Place | None]
    conductance_W_per_K: list[Width]
    at_rest_W_per_K: Width
    factors: list[Place] = []
    convection: Annotated[list[Number], Field(min_length=1, max_length=4)] | None = None
    radiation_degC: Annotated[Number, Field(gt=-273.15)] | None = None
    scale: Positive = 1.0

    @property
    def has_law(self) -> bool:
        """Whether its heat is no multiple of a difference."""
        return self.convection is not None or self.radiation_degC is not None

    @model_validator(mode="after")
    def _one_law(self) -> Path:
        if self.convection is not None and self.radiation_degC is not None:
            raise ValueError("a path has one law at most")
        if self.radiation_degC is not None and self.between[1] is not None:
            raise ValueError("a path radiates to the ambient alone")
        if self.scale != 1.0 and not self.has_law:
            raise ValueError("a path without a law has a scale")
        return self


class Heat(_Strict):
    """Heat at a node.

    Attributes
    ----------
    node
        Where.
    power_W
        By |PWM| of the domain, every factor 1 and the node at the reference.
    per_K, reference_degC
        Its growth with the node's temperature.
    factors
        All multiply it.
    """

    node: Place
    power_W: list[Number]
    per_K: Number = 0.0
    reference_degC: Number = 0.0
    factors: list[Place] = []


class Equations(_Strict):
    """A network's differential equations over the domain.

    Attributes
    ----------
    channels
        The ambient first, in degC.
    factors, paths, heats
        What the equations are made of.
    """

    channels: list[Told] = Field(min_length=1)
    factors: list[Factor]
    paths: list[Path]
    heats: list[Heat]


class Component(_Strict):
    """A sensed node, and what is claimed of its reading.

    Attributes
    ----------
    name
        Of the component.
    node, state
        What is measured; what is read, another one where the sensor lags.
    drift
        A state that is added; none for a sensor that does not drift.
    shown_K
        Added to what is shown at last.
    shown_per_K, shown_about
        Of a sensor whose gain is wrong: g, which adds g (T - base), the base being the ambient or 0 degC.
    bound_K, reading_K
        Largest error of the reading's word, and of ``NAME_rise_mK`` against the ambient that was told last.
    """

    name: Identifier
    node: Place
    state: Place
    drift: Place | None = None
    shown_K: Number
    shown_per_K: Annotated[Number, Field(gt=-1)] | None = None
    shown_about: Literal["ambient", "zero_degC"] | None = None
    bound_K: Width
    reading_K: Width

    @model_validator(mode="after")
    def _about_something(self) -> Component:
        if (self.shown_per_K is None) != (self.shown_about is None):
            raise ValueError("a gain is about nothing, or nothing is about a base")
        return self


class NetworkCertificate(_Strict):
    """All of a network's ``certificate.json``.

    Attributes
    ----------
    model
        The C++ names' prefix.
    sample_time_s
        h.
    domain_pwm
        Lowest and highest |PWM|.
    fraction_bits
        What is read of a state's word w means w 2^-bits degC.
    start_mC
        The readings to start from.
    """

    format: Literal["gen-certificate"]
    version: Literal[2]
    model: Identifier
    coefficients_sha256: str
    arithmetic: Literal["fixed", "float"]
    sample_time_s: Positive
    domain_pwm: tuple[Level, Level]
    fraction_bits: Annotated[int, Field(strict=True, ge=4, le=30)]
    start_mC: tuple[Thousandths, Thousandths]
    equations: Equations
    states: list[State] = Field(min_length=1)
    components: list[Component] = Field(min_length=1)

    @property
    def parts(self) -> list[Component]:
        """The components with a claim: all of them."""
        return self.components

    @property
    def rows(self) -> int:
        """How many |PWM| the domain has."""
        return self.domain_pwm[1] - self.domain_pwm[0] + 1

    @property
    def has_gains(self) -> bool:
        """Whether the gain of a sensor is wrong."""
        return any(part.shown_per_K is not None for part in self.components)

    @property
    def hidden(self) -> list[int]:
        """Nodes that no component measures."""
        measured = {part.node for part in self.components}
        return [k for k, state in enumerate(self.states) if state.capacity_J_per_K and k not in measured]

    @property
    def has_drifts(self) -> bool:
        """Whether a sensor drifts."""
        return any(part.drift is not None for part in self.components)

    def statement(self) -> dict[str, Any]:
        """What it is about: equations, starts, states and components without what is claimed of them."""
        every = self.model_dump(mode="json", exclude_none=True)
        claims = {"bits", "scale", "range_degC", "error_K", "bound_K", "reading_K"}

        def stated(entries: list[dict[str, Any]]) -> list[dict[str, Any]]:
            return [{key: value for key, value in entry.items() if key not in claims} for entry in entries]

        equations = {key: stated(entries) for key, entries in every["equations"].items()}
        return {
            "equations": equations,
            "start_mC": every["start_mC"],
            "states": stated(every["states"]),
            "components": stated(every["components"]),
        }

    @model_validator(mode="after")
    def _fit_together(self) -> NetworkCertificate:
        if self.rows < 1 or self.start_mC[0] > self.start_mC[1]:
            raise ValueError("a range is empty")
        own, nodes = self.equations, [state.capacity_J_per_K is not None for state in self.states]

        def is_node(place: int) -> bool:
            return place < len(nodes) and nodes[place]

        ends = [end for path in own.paths for end in path.between if end is not None]
        measured = [part.node for part in self.components]
        lagging = [state.lags for state in self.states if state.lags is not None]
        if not all(map(is_node, [*ends, *measured, *lagging, *(heat.node for heat in own.heats)])):
            raise ValueError("what should be a node is none")
        drifting = [k for k, state in enumerate(self.states) if state.drifts_to_K is not None]
        if drifting != sorted(part.drift for part in self.components if part.drift is not None):
            raise ValueError("a drift is added to one reading, and nothing else is")
        if any(path.between[0] == path.between[1] for path in own.paths) or len(set(measured)) != len(measured):
            raise ValueError("a path from a node to itself, or a node with two sensors")
        for state in self.states:
            follows = [place for place, _ in state.start_from or ()]
            if not set(follows) <= set(measured) or len(set(follows)) < len(follows):
                raise ValueError("a start goes with nodes that nobody measures, or twice with one")
        used = [place for path in own.paths for place in path.factors]
        used += [place for heat in own.heats for place in heat.factors]
        if any(place >= len(own.factors) for place in used):
            raise ValueError("there is no such factor")
        if any(factor.channel >= len(own.channels) for factor in own.factors):
            raise ValueError("there is no such channel")
        if any(len(path.conductance_W_per_K) != self.rows for path in own.paths) or any(
            len(heat.power_W) != self.rows for heat in own.heats
        ):
            raise ValueError(f"a list over |PWM| is not {self.rows} numbers long")
        for part in self.components:
            if part.state != part.node and (
                part.state >= len(self.states) or self.states[part.state].lags != part.node
            ):
                raise ValueError("a component's state is not its node's")
        return self
