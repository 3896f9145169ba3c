"""Lower the effects of a coefficient file: their own equations, given symbols, become tapes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import exp, expm1
from typing import Any

import numpy as np

from gen.arrays import FloatArray
from gen.coefficients import Coefficients
from gen.coefficients.checks.effect_checks import GROWS, declared_ranges, place_of
from gen.errors import CheckFailed
from gen.lowering.effects.chain import chain
from gen.lowering.effects.channels import channels
from gen.lowering.effects.contraction import Contraction, contraction
from gen.lowering.effects.graph import Graph, Node
from gen.lowering.effects.program import (
    FOLLOWER_BITS,
    KELVIN_BITS,
    KELVIN_LIMIT,
    WEIGHT_BITS,
    Channel,
    EffectComponent,
    EffectsProgram,
    Follower,
    Inner,
    Lag,
)
from gen.lowering.effects.tape import Tape, record
from gen.lowering.fixed.component import FixedComponent
from gen.lowering.float32 import FloatComponent
from gen.lowering.kinds import Arithmetic
from gen.lowering.recursion.dynamics import domain_rows
from gen.lowering.sensors import COUNT_K, sensor_limits
from gen.model import Component, ThermalModel
from gen.model.effects import Applied, Moment
from gen.model.effects.channel_ranges import channel_ranges
from gen.model.effects.gains import Domain, ZERO_K_degC
from gen.model.effects.runaway import Runaway
from gen.model.extended import own_rate

#: The clock of a reading that grows with time stops where it has grown by so much, or after so many samples.
_MOST_GROWTH_K = 500.0
_MOST_SAMPLES = 2**28
#: From this rate times Ts on a rise's mean within a sample takes another term (see `EffectComponent.sixth`).
_FAST = 7e-4
#: A part with effects may be so much hotter or colder than its baseline can be: once more its own range.
_WIDER = 1.0

Lowered = FixedComponent | FloatComponent


def lower_effects(
    coefficients: Coefficients, arithmetic: Arithmetic, components: Sequence[Lowered]
) -> EffectsProgram | None:
    """Lower all effects that are more than changed entries of the model; None without any.

    Parameters
    ----------
    coefficients
        Model and effects.
    arithmetic
        Of the firmware.
    components
        The lowered baseline.

    Raises
    ------
    CheckFailed
        If an equation needs what the board cannot give; the message names the effect. If temperatures may grow without
        end with the effects; the message has the JSON path of the one that adds most to it.
    """
    effects = coefficients.effects
    if not effects:
        return None
    model = coefficients.model
    declared = declared_ranges(coefficients.document)
    apart = coefficients.document.thermocouple_columns
    for limits in sensor_limits(coefficients):
        if limits.channel in apart:
            declared[limits.channel] = limits.lowest * COUNT_K, limits.highest * COUNT_K
    entries = [entry.applied() for entry in coefficients.document.effects]
    told = channels(channel_ranges(model, effects, declared))
    builder = _Builder(model, effects, entries, arithmetic, components, told)
    parts = builder.parts()  # what no board can compute is refused with a better message than the next line has
    found = contraction(model, effects, builder.domain())
    if isinstance(found, Runaway):
        raise CheckFailed(f"{place_of(coefficients.document, found.applied)}: {found.message}: {GROWS}")
    return builder.program(parts, found)


@dataclass
class _Builder:
    model: ThermalModel
    effects: Sequence[Applied]
    document: Sequence[Applied]
    arithmetic: Arithmetic
    components: Sequence[Lowered]
    channels: tuple[Channel, ...]

    def __post_init__(self) -> None:
        self.rows = domain_rows(self.model)
        self.step = self.model.sample_time
        self.limits = [_rise_limits(component) for component in self.components]
        self.growth = max((_growth_K_per_h(applied) for applied in self.effects), default=0.0)
        #: The model counts from its fixed ambient where the measured one acts through an effect.
        fixed = any(applied.effect.replaces_ambient for applied in self.effects)
        self.fixed_ambient = self.model.ambient_fixed if fixed else None

    def domain(self) -> Domain:
        """Ranges of all that the equations read, as the board holds them; nothing is below absolute zero."""
        ambient, *told = self.channels
        coldest = ZERO_K_degC - ambient.low / 1000.0
        over = self.model.ambient_over
        ends = [(low * 2.0**-KELVIN_BITS - over[1], high * 2.0**-KELVIN_BITS - over[0]) for low, high in self.limits]
        rises = [(max(low, coldest), high) for low, high in ends]
        return Domain(
            rows=self.rows.astype(np.float64),
            rise=dict(zip(self.model.component_names, rises, strict=True)),
            ambient=(ambient.low / 1000.0, ambient.high / 1000.0),
            channels={channel.column: (channel.low / 1000.0, channel.high / 1000.0) for channel in told},
        )

    @property
    def elapsed_limit(self) -> int:
        """Samples after which the clock stops; 0 where no reading grows with time."""
        if not self.growth:
            return 0
        return min(_MOST_SAMPLES, int(_MOST_GROWTH_K / self.growth * 3600.0 / self.step))

    def parts(self) -> list[EffectComponent]:
        """The components whose rise or reading an effect changes, in order."""
        made = []
        for index, component in enumerate(self.model.components):
            own = [applied for applied in self.effects if applied.component == component.name]
            if own or self.fixed_ambient is not None:
                made.append(self._component(index, component, own))
        return made

    def program(self, made: Sequence[EffectComponent], found: Contraction) -> EffectsProgram:
        """All of it, with what is known of its contraction."""
        felt = sorted({number for part in made for kind, number in part.drives.operands if kind == "rise"})
        tracked = sorted({*felt, *(part.index for part in made)})
        return EffectsProgram(
            self.arithmetic,
            tuple(made),
            tuple(tracked),
            tuple(felt),
            tuple(self.limits[number] for number in tracked),
            self.channels,
            self.elapsed_limit,
            found,
        )

    # ---- operands ----

    def _rise(self, graph: Graph, index: int) -> Node:
        low, high = self.limits[index]
        return graph.operand("rise", index, low * 2.0**-KELVIN_BITS, high * 2.0**-KELVIN_BITS, KELVIN_BITS)

    def _over(self, graph: Graph) -> Node | float:
        """The ambient over what the baseline's rises count from; 0 where that is the ambient itself."""
        if not self.model.ambient_passes:
            return 0.0
        ambient = self.channels[0]
        return (graph.operand("channel", 0, ambient.low, ambient.high) - float(ambient.neutral)) * 0.001

    def _over_ambient(self, graph: Graph, index: int) -> Node:
        """A component's rise over the ambient."""
        rise = self._rise(graph, index)
        return rise - self._over(graph) if self.model.ambient_passes else rise

    def _channel(self, graph: Graph, number: int) -> Node:
        channel = self.channels[number]
        return graph.operand("channel", number, channel.low, channel.high) * 0.001

    def _ambient(self, graph: Graph) -> Node | float:
        """The ambient that the model counts from."""
        return self._channel(graph, 0) if self.fixed_ambient is None else self.fixed_ambient

    def _moment(self, graph: Graph, index: int, component: Component) -> Moment:
        m: Any = Moment()
        rate = own_rate(component)[self.rows]
        m.count = self.rows.astype(np.float64)
        m.pwm = m.count / self.model.full_scale
        m.rate, m.heat = rate, rate * component.steady_rise(self.rows)
        m.standstill = (self.rows == 0).astype(np.float64)
        m.reverse = graph.operand("reverse", 0, 0.0, 1.0)
        m.rise = self._over_ambient(graph, index)
        m.ambient, m.measured_ambient = self._ambient(graph), self._channel(graph, 0)
        m.others = {
            other.name: self._over_ambient(graph, number)
            for number, other in enumerate(self.model.components)
            if number != index
        }
        m.channels = {
            channel.column: self._channel(graph, number) for number, channel in enumerate(self.channels) if number
        }
        moment: Moment = m
        return moment

    # ---- a component ----

    def _component(self, index: int, component: Component, own: Sequence[Applied]) -> EffectComponent:
        graph = Graph(len(self.rows))
        m: Any = self._moment(graph, index, component)
        rate = own_rate(component)[self.rows]
        inners: list[Inner] = []
        inner_starts: list[Node] = []
        followers: list[Follower] = []
        targets: list[Node] = []
        passing = graph.node(0.0)
        at_start = _Start(self, graph)
        for applied in own:
            effect, p = applied.effect, applied.values
            at_start.pass_on(applied)
            if not effect.heats:
                continue
            tau = effect.own_tau(p)
            found = effect.inner(p, m)
            if found is not None:
                target, inner_tau = found
                begin = graph.node(effect.inner_start(p, at_start.seen))
                if isinstance(target, Node) or isinstance(inner_tau, Node):
                    raise CheckFailed(f'the inner state of the effect "{effect.name}" depends on more than |PWM|')
                inners.append(
                    self._inner(applied, np.asarray(target) + 0.0 * rate, inner_tau, begin, tau, component, rate)
                )
                bits = inners[-1].fraction_bits
                low = min(*inners[-1].targets, begin.entry.low * 2.0**bits) * 2.0**-bits
                high = max(*inners[-1].targets, begin.entry.high * 2.0**bits) * 2.0**-bits
                m.inner = graph.operand("inner", len(inners) - 1, low, high, bits)
                inner_starts.append(begin)
            if tau is None:
                heat = graph.node(effect.heat(p, m)) + graph.node(effect.per_rise(p, m)) * m.rise
                passing = passing + heat
                at_start.chain = at_start.chain + at_start.begin(applied)
            else:
                followers.append(self._follower(f"{effect.name}, E in K", tau))
                targets.append(graph.node(effect.heat(p, m)) * tau)
                at_start.followers.append(at_start.begin(applied))
        passes = any(a.effect.heats and a.effect.own_tau(a.values) is None for a in own)
        drive = passing * (1.0 / rate)
        outputs = [drive, *targets] if passes else targets
        readings, lags = self._readings(graph, index, own)
        starts = [(at_start.rise + self._over(graph)) * 1000.0]
        starts += [at_start.chain] if passes else []
        starts += [*at_start.followers, *inner_starts]
        return EffectComponent(
            index=index,
            name=component.name,
            chain=chain(self.model, component, self.components[index], drive.entry.magnitude) if passes else None,
            drives=record(graph, outputs, self.arithmetic),
            followers=tuple(followers),
            inners=tuple(inners),
            start=record(graph, starts, self.arithmetic),
            readings=readings,
            lags=lags,
            sixth=self._sixth(component, rate) if passes else (),
            notes=tuple(self._note(applied) for applied in own),
        )

    def _sixth(self, component: Component, rate: FloatArray) -> tuple[int, ...]:
        if component.order > 1 or float(rate.max()) * self.step < _FAST:
            return ()
        return tuple(round(float(v) * self.step / 6.0 * 2.0**WEIGHT_BITS) for v in rate)

    def _note(self, applied: Applied) -> str:
        number = next(i for i, entry in enumerate(self.document) if entry == applied)
        values = ", ".join(f"{key} {value}" for key, value in applied.values.items() if value is not None)
        return f"$.effects[{number}], {applied.effect.title} ({values}): {applied.effect.equation}"

    def _follower(self, label: str, tau: float) -> Follower:
        return Follower(label, tau, _share(-expm1(-self.step / tau)))

    def _inner(
        self, applied: Applied, target: FloatArray, inner_tau: float, begin: Node, tau: float | None,
        component: Component, rate: FloatArray,
    ) -> Inner:  # fmt: skip
        highest = max(float(np.abs(target).max()), begin.entry.magnitude)
        if highest > KELVIN_LIMIT:
            raise CheckFailed(f'the inner state of the effect "{applied.effect.name}" may reach {highest:g}')
        bits = WEIGHT_BITS if highest <= 1.0 else KELVIN_BITS
        slow = component.order > 1 and tau is None
        weight = _weight(self.step, inner_tau, None if slow else (float(rate.mean()) if tau is None else 1.0 / tau))
        return Inner(
            self._follower(f"{applied.effect.name}, H", inner_tau),
            bits,
            tuple(round(float(v) * 2.0**bits) for v in target),
            round(weight * 2.0**WEIGHT_BITS),
        )

    def _readings(self, graph: Graph, index: int, own: Sequence[Applied]) -> tuple[tuple[Tape, ...], tuple[Lag, ...]]:
        ambient, measured = self._ambient(graph), self._channel(graph, 0)
        elapsed = graph.operand("elapsed", 0, 0.0, float(self.elapsed_limit)) * self.step
        counted_from = self.channels[0].neutral / 1000.0 if self.model.ambient_passes else ambient
        shown: Any = self._rise(graph, index) + counted_from
        tapes, lags = [], []
        for applied in own:
            lag = applied.effect.lag(applied.values)
            if lag is not None:
                tapes.append(record(graph, [graph.node(shown)], self.arithmetic))
                lags.append(_lag(self.step, float(lag)))
                limit = float(KELVIN_LIMIT)
                shown = graph.operand("lagged", len(lags) - 1, -limit, limit, KELVIN_BITS)
            shown = applied.effect.reading(applied.values, shown, ambient, measured, elapsed)
        tapes.append(record(graph, [graph.node(shown) - measured], self.arithmetic))
        return tuple(tapes), tuple(lags)


class _Start:
    """What the start of a component depends on: the rise that its sensor shows, over the measured ambient."""

    def __init__(self, builder: _Builder, graph: Graph) -> None:
        self._graph = graph
        self._ambient = builder._ambient(graph)
        self._measured = builder._channel(graph, 0)
        limit = KELVIN_LIMIT * 1000.0
        shown = graph.operand("shown", 0, -limit, limit) * 0.001
        self.seen: Node = shown + (self._measured - self._ambient) if builder.fixed_ambient is not None else shown
        self.rise: Node = self.seen
        self.chain: Node = graph.node(0.0)
        self.followers: list[Node] = []

    def pass_on(self, applied: Applied) -> None:
        """Shift the true rise by what the effect says of it."""
        shift = applied.effect.start(applied.values, self.rise, self._ambient, self._measured)
        self.rise = self.rise + self._graph.node(shift)

    def begin(self, applied: Applied) -> Node:
        """E at the start."""
        return self._graph.node(applied.effect.begin(applied.values, self._ambient, self._measured))


def _rise_limits(component: Lowered) -> tuple[int, int]:
    """Where a rise with effects may lie, in 2^-20 K."""
    low, high = (value / 1000.0 for value in component.start_range_mK)
    if component.proof is not None:
        low, high = min(low, component.proof.rise_range_K[0]), max(high, component.proof.rise_range_K[1])
    wider = _WIDER * max(abs(low), abs(high))
    scale = 2**KELVIN_BITS
    return round(max(low - wider, -KELVIN_LIMIT) * scale), round(min(high + wider, KELVIN_LIMIT) * scale)


def _growth_K_per_h(applied: Applied) -> float:
    """What the clock alone adds to a reading in the first hour."""
    late, soon = (applied.effect.reading(applied.values, 0.0, 0.0, 0.0, elapsed) for elapsed in (3600.0, 0.0))
    return abs(float(late - soon))


def _weight(step: float, inner_tau: float, rate: float | None) -> float:
    """Mean of exp(-t/inner_tau) over a sample, weighted as a state of that rate does (plainly: None)."""
    s = 1.0 / inner_tau
    if rate is None:
        return -expm1(-s * step) / (s * step)
    if abs(rate - s) < 1e-6 * s:
        return rate * step * exp(-rate * step) / -expm1(-rate * step)
    return rate * (exp(-s * step) - exp(-rate * step)) / ((rate - s) * -expm1(-rate * step))


def _lag(step: float, lag: float) -> Lag:
    kept = exp(-step / lag)
    share = -expm1(-step / lag) * lag / step
    return Lag(lag, _share(share - kept), _share(1.0 - share))


def _share(value: float) -> int:
    """A share below 1 as 32 bits."""
    return int(min(round(value * 2.0**FOLLOWER_BITS), 2**FOLLOWER_BITS - 1))
