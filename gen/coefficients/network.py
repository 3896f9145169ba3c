"""The network in the coefficient document: nodes, paths, heats, and the channels that they read."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import Discriminator, Field, Tag, model_validator

from gen.coefficients.base import Celsius, ColumnName, Name, NotNegative, Number, Part, fault, listed, told
from gen.coefficients.schedule import Exp1, Exp2, Poly, Tabulated
from gen.model.laws import Convection, Law, Radiation
from gen.model.network import Network
from gen.model.network_parts import AMBIENT, Channel, Curve, Factor, Heat, Node, Path, PowerLaw, Sensor
from gen.model.schedules import Schedule

MOST_NODES = 16
MOST_AT_START = 8.0
"""K of a hidden node's rise at the start, for each K of all sensed nodes: what is proven holds up to that."""
MOST_TOLD = 2e6
"""What a board is told, in thousandths, has 32 bits."""
APART = (
    "values a thousandth apart at least: a board is told channels in whole thousandths of their unit, so write it in a "
    "smaller one"
)
CURVES = ("poly", "exp1", "exp2", "table", "power")

AtRest = Annotated[NotNegative | None, Field(description="The value at PWM 0, where it is not the curve's.")]


class PolyCurve(Poly):
    """A polynomial in |PWM|, and a value of its own at rest."""

    at_rest: AtRest = None


class Exp1Curve(Exp1):
    """An exponential in |PWM|, and a value of its own at rest."""

    at_rest: AtRest = None


class Exp2Curve(Exp2):
    """A sum of two exponentials in |PWM|, and a value of its own at rest."""

    at_rest: AtRest = None


class TableCurve(Tabulated):
    """A table over |PWM|, and a value of its own at rest."""

    at_rest: AtRest = None


class PowerEntry(Part):
    """constant + forced * (|PWM| / full_scale) ** exponent."""

    constant: NotNegative
    forced: NotNegative
    exponent: Annotated[Number, Field(ge=0.05, le=10)]


class PowerCurve(Part):
    """A power law in |PWM|, and a value of its own at rest."""

    power: PowerEntry
    at_rest: AtRest = None


def _kind(data: Any) -> str | None:  # noqa: ANN401
    if isinstance(data, Part):
        return f"tag:{next(iter(type(data).model_fields))}"
    if not isinstance(data, dict):
        return None
    present = [kind for kind in CURVES if kind in data]
    return f"tag:{present[0]}" if len(present) == 1 else None


CurveEntry = Annotated[
    Annotated[PolyCurve, Tag("tag:poly")]
    | Annotated[Exp1Curve, Tag("tag:exp1")]
    | Annotated[Exp2Curve, Tag("tag:exp2")]
    | Annotated[TableCurve, Tag("tag:table")]
    | Annotated[PowerCurve, Tag("tag:power")],
    Discriminator(_kind, custom_error_type="curve", custom_error_message="not a curve"),
]


class FactorPoints(Part):
    """Factors at strictly increasing values of the channel; linear between them, outside the end values hold."""

    at: Annotated[tuple[Number, ...], Field(min_length=2, max_length=16)]
    value: Annotated[tuple[NotNegative, ...], Field(min_length=2, max_length=16)]

    @model_validator(mode="after")
    def _check(self) -> FactorPoints:
        for i, at in enumerate(self.at):
            if not -MOST_TOLD <= at <= MOST_TOLD:
                raise fault(f"found {at:g}, expected values within +-2e6", "at", i)
        for i in range(1, len(self.at)):
            if self.at[i] <= self.at[i - 1]:
                raise fault(f"found {self.at[i]:g} after {self.at[i - 1]:g}, expected strictly increasing", "at", i)
            if told(self.at[i]) == told(self.at[i - 1]):
                raise fault(f"found {self.at[i]:g} after {self.at[i - 1]:g}, expected {APART}", "at", i)
        if len(self.value) != len(self.at):
            raise fault(f"found {len(self.value)} values, expected {len(self.at)}, one for each point", "value")
        return self


class FactorEntry(Part):
    """What a channel multiplies: a polynomial in its value, highest power first, or a table."""

    channel: ColumnName
    poly: Annotated[tuple[Number, ...], Field(min_length=1, max_length=4)] | None = None
    table: FactorPoints | None = None

    @model_validator(mode="after")
    def _check(self) -> FactorEntry:
        if (self.poly is None) == (self.table is None):
            found = "neither" if self.poly is None else "both"
            raise fault(f'found {found}, expected one of "poly" and "table"')
        return self

    def factor(self) -> Factor:
        """Give the model's factor."""
        if self.table is not None:
            return Factor(self.channel, at=tuple(map(told, self.table.at)), value=self.table.value)
        return Factor(self.channel, polynomial=self.poly or ())


class SensorEntry(Part):
    """What stands between a node and its reading."""

    offset_K: Annotated[Number, Field(ge=-50, le=50)] = 0.0
    lag_s: Annotated[NotNegative, Field(le=3600)] = 0.0
    gain_error: Annotated[
        Number,
        Field(gt=-0.9, le=2, description="Relative: what is shown over where the reading is right is (1 + g) times."),
    ] = 0.0
    gain_about: Annotated[
        Literal["ambient", "zero_degC"], Field(description="Where the reading is right: at the ambient, or at 0 degC.")
    ] = "ambient"
    drift_K: Annotated[
        Number, Field(ge=-500, le=500, description="How far the reading has moved in the end since switching on.")
    ] = 0.0
    drift_h: Annotated[Number, Field(ge=0.05, le=48, description="Time constant with which it does, h.")] | None = None

    @model_validator(mode="after")
    def _check(self) -> SensorEntry:
        if self.drift_K and self.drift_h is None:
            raise fault("is missing: a drift has a time constant", "drift_h")
        if self.drift_h is not None and not self.drift_K:
            raise fault("found a time constant of no drift", "drift_h")
        return self

    def sensor(self) -> Sensor:
        """Give the model's sensor."""
        settling = 0.0 if self.drift_h is None else 3600.0 * self.drift_h
        about = self.gain_about == "ambient"
        return Sensor(self.offset_K, self.lag_s, self.gain_error, about, self.drift_K, settling)


class NodeEntry(Part):
    """A heat capacity; with a sensor it is a component, without it is hidden."""

    name: Name
    description: str = ""
    capacity_J_per_K: Annotated[Number, Field(ge=1e-3, le=1e9)]
    sensor: SensorEntry | None = None
    start_factor: Annotated[
        Number,
        Field(ge=0, lt=8, description="Of a hidden node: its rise at the start, for each K at which it would rest."),
    ] = 1.0
    start_from: Annotated[
        dict[Name, Annotated[Number, Field(ge=0, lt=8)]] | None,
        Field(
            min_length=1,
            description="Of a hidden node: its rise at the start for each K of each sensed node's; times start_factor. "
            "Without it, where it would rest.",
        ),
    ] = None

    @model_validator(mode="after")
    def _check(self) -> NodeEntry:
        if self.sensor is not None and self.start_factor != 1.0:
            raise fault(
                f"found {self.start_factor:g}, expected none: a node with a sensor starts as read", "start_factor"
            )
        if self.start_from is None:
            return self
        if self.sensor is not None:
            raise fault("found weights, expected none: a node with a sensor starts as read", "start_from")
        whole = self.start_factor * sum(self.start_from.values())
        if whole >= MOST_AT_START:
            raise fault(f"found {whole:g} K for each K of all, expected less than {MOST_AT_START:g}", "start_from")
        return self


class ConvectionEntry(Part):
    """What natural convection multiplies a conductance by: it grows with the difference of both ends."""

    poly: Annotated[
        tuple[Number, ...],
        Field(min_length=1, max_length=4, description="Over the difference's magnitude in K, highest power first."),
    ]


class RadiationEntry(Part):
    """Heat that goes with the fourth powers of both ends' absolute temperatures."""

    reference_degC: Annotated[
        Celsius, Field(ge=-100, description="Temperature of both ends at which the conductance is what it says.")
    ] = 25.0


class PathEntry(Part):
    """A way for heat between two nodes, or between a node and the ambient."""

    between: Annotated[tuple[str, str], Field(description='Two nodes, or a node and "ambient".')]
    conductance_W_per_K: CurveEntry
    factors: Annotated[tuple[FactorEntry, ...], Field(max_length=4)] = ()
    convection: ConvectionEntry | None = None
    radiation: RadiationEntry | None = None

    @model_validator(mode="after")
    def _check(self) -> PathEntry:
        if self.between[0] == self.between[1]:
            raise fault(f'found "{self.between[0]}" twice, expected two different ends', "between", 1)
        if self.convection is not None and self.radiation is not None:
            raise fault('found "convection" beside "radiation", expected a path for each', "radiation")
        if self.radiation is not None and AMBIENT not in self.between:
            raise fault('found a path between two nodes, expected one to "ambient"', "radiation")
        return self

    @property
    def law(self) -> Law | None:
        """The model's law of its heat, None where that goes with the difference of both ends."""
        if self.convection is not None:
            return Convection(self.convection.poly)
        return None if self.radiation is None else Radiation(self.radiation.reference_degC)


class HeatEntry(Part):
    """A source of heat: P = power * factors * (1 + per_K (T - reference))."""

    node: str
    power_W: CurveEntry
    factors: Annotated[tuple[FactorEntry, ...], Field(max_length=4)] = ()
    per_K: Annotated[Number, Field(ge=-0.1, le=0.1)] = 0.0
    reference_degC: Celsius = 25.0


class ChannelEntry(Part):
    """A measured column that conductances or powers depend on; all of it counts to the thousandth of its unit."""

    column: ColumnName
    range: Annotated[tuple[Number, Number], Field(description="To which its values are held.")]
    neutral: Annotated[Number, Field(description="Its value until it is told.")]

    @model_validator(mode="after")
    def _check(self) -> ChannelEntry:
        low, high = self.range
        if low >= high:
            raise fault(f"found [{low:g}, {high:g}], expected the lower limit first", "range")
        if not -MOST_TOLD <= low <= high <= MOST_TOLD:
            raise fault(f"found [{low:g}, {high:g}], expected values within +-2e6", "range")
        if told(low) == told(high):
            raise fault(f"found [{low:g}, {high:g}], expected {APART}", "range")
        if not low <= self.neutral <= high:
            raise fault(f"found {self.neutral:g}, expected it within the range", "neutral")
        return self

    def channel(self) -> Channel:
        """Give the model's channel."""
        return Channel(self.column, told(self.range[0]), told(self.range[1]), told(self.neutral))


class NetworkEntry(Part):
    """The motor as one network of heat capacities."""

    channels: Annotated[tuple[ChannelEntry, ...], Field(max_length=8)] = ()
    nodes: Annotated[tuple[NodeEntry, ...], Field(min_length=1, max_length=MOST_NODES)]
    paths: Annotated[tuple[PathEntry, ...], Field(min_length=1, max_length=120)]
    heats: Annotated[tuple[HeatEntry, ...], Field(max_length=64)] = ()

    @model_validator(mode="after")
    def _check(self) -> NetworkEntry:
        names = self._check_nodes()
        columns = [channel.column for channel in self.channels]
        seen: dict[tuple[frozenset[str], type[Law] | None, frozenset[str]], int] = {}
        for i, path in enumerate(self.paths):
            for k, end in enumerate(path.between):
                _one_of(end, [*names, AMBIENT], "a node's name", "paths", i, "between", k)
            law = path.law
            kind = (None if law is None else type(law), frozenset(factor.channel for factor in path.factors))
            first = seen.setdefault((frozenset(path.between), *kind), i)
            if first != i:
                of_a_kind = "" if kind == (None, frozenset()) else " of a kind"
                expected = f"expected one path{of_a_kind} between two"
                raise fault(f"joins the same as paths[{first}]; {expected}", "paths", i, "between")
            self._check_factors(path.factors, columns, "paths", i)
        for i, heat in enumerate(self.heats):
            _one_of(heat.node, names, "a node's name", "heats", i, "node")
            self._check_factors(heat.factors, columns, "heats", i)
        return self

    def _check_nodes(self) -> list[str]:
        names = [node.name for node in self.nodes]
        seen: dict[str, int] = {}
        for i, name in enumerate(names):
            first = seen.setdefault(name.lower(), i)
            if first != i:
                taken = f'"{name}" is taken by nodes[{first}] ("{names[first]}")'
                raise fault(f"{taken}; expected names that differ in more than case", "nodes", i, "name")
        sensed = [node.name for node in self.nodes if node.sensor is not None]
        if not sensed:
            raise fault('no node has a "sensor"; expected one that is measured', "nodes")
        for i, node in enumerate(self.nodes):
            for name in node.start_from or ():
                _one_of(name, sensed, "the name of a node with a sensor", "nodes", i, "start_from", name)
        for i, channel in enumerate(self.channels):
            if channel.column in [other.column for other in self.channels[:i]]:
                raise fault(f'"{channel.column}" is there already', "channels", i, "column")
        return names

    def _check_factors(self, factors: tuple[FactorEntry, ...], columns: list[str], *at: str | int) -> None:
        for k, factor in enumerate(factors):
            _one_of(factor.channel, columns, "a column of network.channels", *at, "factors", k, "channel")

    def network(self, held: tuple[int, int] | None, full_scale: int) -> Network:
        """Give the model's network.

        Parameters
        ----------
        held
            |PWM| range outside of which curves keep their value at its end; None: they are continued.
        full_scale
            The PWM count that is 100 %.
        """
        return Network(
            tuple(
                Node(
                    node.name,
                    node.capacity_J_per_K,
                    None if node.sensor is None else node.sensor.sensor(),
                    node.description,
                    node.start_factor,
                    None if node.start_from is None else tuple(node.start_from.items()),
                )
                for node in self.nodes
            ),
            tuple(
                Path(*_ends(p.between), model_curve(p.conductance_W_per_K, full_scale), _factors(p.factors), p.law)
                for p in self.paths
            ),
            tuple(
                Heat(h.node, model_curve(h.power_W, full_scale), _factors(h.factors), h.per_K, h.reference_degC)
                for h in self.heats
            ),
            tuple(channel.channel() for channel in self.channels),
            held,
        )


def _ends(between: tuple[str, str]) -> tuple[str, str | None]:
    if between[0] == AMBIENT:
        return between[1], None
    return between[0], None if between[1] == AMBIENT else between[1]


def _factors(entries: tuple[FactorEntry, ...]) -> tuple[Factor, ...]:
    return tuple(entry.factor() for entry in entries)


def model_curve(entry: CurveEntry, full_scale: int) -> Curve:
    """Give the model's curve."""
    turning: Schedule
    if isinstance(entry, PowerCurve):
        turning = PowerLaw(entry.power.constant, entry.power.forced, entry.power.exponent, full_scale)
    else:
        turning = entry.schedule()
    return Curve(turning, entry.at_rest)


def _one_of(found: str, names: list[str], what: str, *at: str | int) -> None:
    if found not in names:
        there = f": {listed(names)}" if names else ", and there is none"
        raise fault(f'found "{found}", expected {what}{there}', *at)
