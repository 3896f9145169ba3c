"""The theorem for a network: every claim of its certificate follows from the C++ beside it, or is refuted.

With T the exact state and e the board's less that, it is shown that

    low <= T <= high   and   |e| <= u

hold after a sample if they held before it, and that they hold at every start. docs/proof.md has the lemmas.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import inf
from pathlib import Path
from typing import Any

import numpy as np
from pycparser import c_ast

from gen.arrays import FloatArray
from gen.certificate.exact import ROUGHLY, Ratio
from gen.certificate.network.arithmetic import Arithmetic, Number
from gen.certificate.network.document import NetworkCertificate
from gen.certificate.network.evaluated import SLOPE_BITS, evaluated
from gen.certificate.network.flow import Bent, change, flows
from gen.certificate.network.forms import Form, Space
from gen.certificate.network.laws import Law, laws
from gen.certificate.network.machine import Machine
from gen.certificate.network.measured import Measured, Span, measure, spans
from gen.certificate.network.memory import Cell, Model
from gen.certificate.network.order import check_order
from gen.certificate.network.pure import RUN_ON_INPUTS, check_pure
from gen.certificate.network.rest import rest_weights
from gen.certificate.network.rows import Rows
from gen.certificate.network.sensors import Sensors
from gen.certificate.network.source import Unit, tables
from gen.certificate.network.words import low_bits
from gen.certificate.refuted import Refuted
from gen.certificate.source import Project
from gen.certificate.verdict import Verdict

#: A law's function is told its temperatures to so many words.
_TOLD_WORDS = 16.0


def prove(folder: Path, certificate: NetworkCertificate, tell: Callable[[str], None] = lambda _: None) -> list[Verdict]:
    """Prove every claim of an emitted network.

    Parameters
    ----------
    folder
        What ``gen build`` wrote.
    certificate
        Its own.
    tell
        Gets the name of what is worked on.

    Raises
    ------
    InputError
        If a file is missing, or a tool.
    Refuted
        If a claim does not follow.
    """
    project = Project(folder, certificate.model)
    tell(certificate.model)
    with np.errstate(all="ignore"):  # nothing compares with what comes of it, so it is refuted
        return NetworkProof(project, certificate).verdicts()


@dataclass(frozen=True)
class _Known:
    """A function of a channel's value: which factor it is, and what was found."""

    factor: int
    span: Span


class NetworkProof:
    """A network's proof.

    Parameters
    ----------
    project, certificate
        Whose.

    Raises
    ------
    Refuted
        If the C++ does not do what it should.
    """

    def __init__(self, project: Project, certificate: NetworkCertificate) -> None:
        self._certificate, self._project = certificate, project
        self._low_bits = low_bits(project)
        check_order(project, certificate)
        self._measured: Measured = measure(project, certificate, self._low_bits)
        self._sample, self._interface = Unit(project, "_step.cpp"), Unit(project, ".cpp")
        check_pure(self._interface, RUN_ON_INPUTS)
        self._tables = tables(project)
        self._unit = 2.0**-certificate.fraction_bits
        self._error = np.array([state.error_K for state in certificate.states])
        self._ranges = np.array([state.range_degC for state in certificate.states])
        ambient = certificate.equations.channels[0]
        self._ambient = (_degrees(ambient.low, -inf), _degrees(ambient.high, inf))
        self._sensors = Sensors(self._interface, self._measured, self._unit, self._ambient)
        self._functions, ends = self._factors()
        box = [
            (float(np.nextafter(low - error, -inf)), float(np.nextafter(high + error, inf)))
            for (low, high), error in zip(self._ranges, self._error, strict=True)
        ]
        self._laws = laws(certificate)
        both = [
            (self._told_ends(box[law.first]), self._told_ends(self._ambient if law.second is None else box[law.second]))
            for law in self._laws
        ]
        driving = [law.driving_ends(*ranges) for law, ranges in zip(self._laws, both, strict=True)]
        self._slopes = [law.slope_ends(*ranges) for law, ranges in zip(self._laws, both, strict=True)]
        steepest = [law.steepest(*ranges) for law, ranges in zip(self._laws, both, strict=True)]
        for law, (least, _) in zip(self._laws, self._slopes, strict=True):
            if not least >= 0.0:
                raise Refuted(f"the heat of path {law.path} may fall as a difference grows")
        self._space = Space([*box, self._ambient, *driving], [*ends, *self._slopes], certificate.rows)
        self._rows = Rows(flows(certificate), len(certificate.states), certificate.rows, [*ends, *self._slopes])
        self._bent = Bent(self._rows.speeds(np.array(box), self._ambient, driving), steepest) if self._laws else None

    def _told_ends(self, ends: tuple[float, float]) -> tuple[float, float]:
        """Ends of a temperature as the C++ may have it."""
        off = 2.0 * _TOLD_WORDS * self._unit
        return ends[0] - off, ends[1] + off

    def verdicts(self) -> list[Verdict]:
        """Prove everything; see :mod:`gen.certificate.network.check`.

        Raises
        ------
        Refuted
            At the first step that fails.
        """
        low, high = self._ranges.T
        count = self._rows.bounds(high, self._ambient[1], upper=True)
        count += self._rows.bounds(low, self._ambient[0], upper=False)
        self._check_starts()
        count += self._rows.holds(self._error, self.defects())
        return [self._read(number, count if number == 0 else 0) for number in range(len(self._certificate.components))]

    def _factors(self) -> tuple[dict[tuple[str, int], _Known], list[tuple[float, float]]]:
        """Which function of the C++ is which factor, and the ends of each factor."""
        found: list[tuple[str, int]] = []
        _Calls(self._sample, found).visit(self._sample.functions(f"{self._project.model}_advance")[0])
        names = {name for name, _ in found}
        for name in names:
            if len(self._sample.functions(name)) != 1:
                raise Refuted(f"{name} is there twice")
        check_pure(self._sample, names)
        measured = spans(self._project, self._certificate, found)
        known: dict[tuple[str, int], _Known] = {}
        ends: list[tuple[float, float] | None] = [None] * len(self._certificate.equations.factors)
        for call, candidates in measured.items():
            fitting = [(span.error, number, span) for number, span in enumerate(candidates) if span is not None]
            if not fitting:
                raise Refuted(f"{call[0]} is no factor of its channel")
            _, number, span = min(fitting, key=lambda one: one[:2])
            known[call] = _Known(number, span)
            for k, other in enumerate(candidates):
                if other is not None:
                    ends[k] = (other.low, other.high)
        if any(end is None for end in ends):
            raise Refuted("a factor has no function in the C++")
        return known, [end for end in ends if end is not None]

    def _of_channel(self, name: str, channel: int) -> Number:
        """What a function of a channel's value gives."""
        if name == "degrees" and channel == 0:
            return self._ambient_word(self._measured.ambient)
        known = self._functions.get((name, channel))
        if known is None:
            raise Refuted(f"{name} of channel {channel} is no factor")
        scale = 2.0 ** self._certificate.equations.factors[known.factor].bits
        form = self._space.factor(known.factor).times(scale).within(known.span.error * scale * (1.0 + ROUGHLY))
        if not np.all(form.largest < 2.0**31):
            raise Refuted(f"{name} may overflow")
        return Number("int32_t", form, known.span.natural)

    def _of_law(self, name: str, told: Sequence[Number]) -> tuple[Number, Number] | None:
        """What a function of two temperatures, or of their difference, gives for a path with a law; and its slope."""
        for place, law in enumerate(self._laws):
            expected = self._told(law)
            if len(told) == len(expected) and all(one.kind == "int32_t" for one in told):
                away = [float((one.form - form).largest.max()) for one, form in zip(told, expected, strict=True)]
                if max(away) <= _TOLD_WORDS:
                    return self._driven(name, place, told, sum(away))
        return None

    def _told(self, law: Law) -> list[Form]:
        """What a law's function should be told, in words."""
        first = self._space.temperature(law.first)
        second = self._space.temperature(len(self._ranges) if law.second is None else law.second)
        return [form.times(1.0 / self._unit) for form in ([first - second] if law.polynomial else [first, second])]

    def _driven(self, name: str, place: int, told: Sequence[Number], away: float) -> tuple[Number, Number]:
        """The law's own symbols, give or take what the function is off by and what it is told wrongly."""
        assert self._bent is not None
        law, bits = self._laws[place], self._certificate.fraction_bits
        words = [(float(one.form.ends[0].min()), float(one.form.ends[1].max())) for one in told]
        found = evaluated(self._sample, name, law, words, bits)
        told_off = self._bent.steepest[place] * away * self._unit
        driving = self._space.temperature(len(self._ranges) + 1 + place).times(1.0 / self._unit)
        off = found.driving + self._slopes[place][1] * away
        slope = self._space.factor(len(self._certificate.equations.factors) + place).times(2.0**SLOPE_BITS)
        steep = (found.slope + told_off) * 2.0**SLOPE_BITS
        return (
            self._fitting(name, driving.within(off * (1.0 + ROUGHLY)), natural=False),
            self._fitting(name, slope.within(steep * (1.0 + ROUGHLY)), natural=True),
        )

    @staticmethod
    def _fitting(name: str, form: Form, *, natural: bool) -> Number:
        if not np.all(form.largest < 2.0**31):
            raise Refuted(f"{name} may overflow")
        return Number("int32_t", form, natural)

    def _ambient_word(self, off: float) -> Number:
        form = self._space.temperature(len(self._ranges)).times(1.0 / self._unit).within(off)
        if not np.all(form.largest < 2.0**31 - 1.0):
            raise Refuted("the ambient may overflow")
        return Number("int32_t", form)

    def _words(self) -> list[Any]:
        """The states' words at the beginning of a sample."""
        scale = 2.0 ** (self._certificate.fraction_bits + self._low_bits)
        forms = [self._space.temperature(k).times(scale) for k in range(len(self._ranges))]
        return [Cell(form, self._low_bits) for form in forms]

    def _degrees_of(self, word: Any) -> Form:  # noqa: ANN401
        form: Form = word.form
        return form.times(2.0 ** -(self._certificate.fraction_bits + self._low_bits))

    def defects(self) -> FloatArray:
        """What a sample adds to each state's error, shape (P, n)."""
        model = Model(self._words())
        machine = Machine(self._sample, self._tables, self._space, model, self._of_channel, self._of_law)
        row = Arithmetic(self._space).known(np.arange(self._space.rows, dtype=np.float64), "uint8_t")
        machine.call(f"{self._project.model}_advance", row, self._ambient_word(self._measured.ambient))
        n = len(self._ranges)
        states = [self._space.temperature(k) for k in range(n)]
        factors = [self._space.factor(k) for k in range(len(self._certificate.equations.factors) + len(self._laws))]
        driving = [self._space.temperature(n + 1 + k) for k in range(len(self._laws))]
        ambient, own = self._space.temperature(n), flows(self._certificate)
        exact = change(self._space, states, ambient, factors, own, driving, self._bent)
        off = [self._degrees_of(word) - states[k] - exact[k] for k, word in enumerate(model.T)]
        return np.array([form.largest for form in off]).T

    def _check_starts(self) -> None:
        """Every start within the ranges, and its words within the errors."""
        certificate = self._certificate
        off = max(self._measured.start, self._measured.ambient) * self._unit * (1.0 + ROUGHLY)
        asked = [end / 1000.0 for end in certificate.start_mC]
        room = certificate.equations.channels[0].neutral / 1000.0
        begin: dict[int, tuple[float, float, float]] = {}
        for part in certificate.components:
            offset = self._measured.sensors[part.name].offset
            wrong = (off + abs(offset * self._unit - part.shown_K)) * (1.0 + ROUGHLY)
            low, high = asked[0] - part.shown_K, asked[1] - part.shown_K
            if certificate.has_gains:
                (low, high), started = self._sensors.start(part, (asked[0], asked[1]))
                wrong = max(wrong, started)
            # What is not started after a begin rests at the ambient.
            for place in {part.node, part.state}:
                begin[place] = (min(low, room), max(high, room), wrong)
            if part.drift is not None:
                begin[part.drift] = (0.0, 0.0, 0.0)
        hidden = self._hidden(begin)
        for place, (low, high, wrong) in {**begin, **hidden}.items():
            slack = ROUGHLY * (abs(low) + abs(high))
            if not (self._ranges[place][0] <= low - slack and high + slack <= self._ranges[place][1]):
                raise Refuted(f"state {place} can start outside of its range")
            if not wrong <= self._error[place]:
                raise Refuted(f"the start of state {place} is off by {wrong:.6g} K, more than its error")
        if len(begin) + len(hidden) != len(self._ranges):
            raise Refuted("a state is started by nothing")

    def _hidden(self, begin: dict[int, tuple[float, float, float]]) -> dict[int, tuple[float, float, float]]:
        """Least and largest start of each hidden node, degC, and what its word is off by."""
        certificate, hidden = self._certificate, self._certificate.hidden
        if not hidden:
            return {}
        model = Model(self._words())
        machine = Machine(self._interface, {}, self._space, model, self._of_channel)
        machine.call("rest_hidden")
        n, found = len(self._ranges), {}
        for node, weights in zip(hidden, rest_weights(certificate), strict=True):
            ambient, carried = float(weights.get(None, 0)), 0.0
            between = self._space.temperature(n).times(ambient)
            low, high = sorted(ambient * end for end in self._ambient)
            for place, weight in weights.items():
                if place is not None and weight:
                    between = between + self._space.temperature(place).times(float(weight))
                    least, largest, wrong = begin[place]
                    low, high = low + float(weight) * least, high + float(weight) * largest
                    carried += float(weight) * wrong
            off = (self._degrees_of(model.T[node]) - between).within(1e-12)  # the weights as float64
            found[node] = (low, high, (float(off.largest.max()) + carried) * (1.0 + ROUGHLY))
        return found

    def _read(self, number: int, inequalities: int) -> Verdict:
        """What a reading is off by."""
        part = self._certificate.components[number]
        offset = self._measured.sensors[part.name].offset
        word = abs(offset * self._unit - part.shown_K) + self._unit  # the word's upper half, rounded down
        low, high = self._ranges[part.state] + (-self._error[part.state], self._error[part.state])
        carried, drifted = self._error[part.state], 0.0
        if part.drift is not None:
            drifted = max(map(abs, self._ranges[part.drift])) + self._error[part.drift] + self._unit
        if self._certificate.has_gains:
            word = self._sensors.reading(part, (float(low), float(high)), drifted / self._unit)
            carried = carried * (1.0 + (part.shown_per_K or 0.0))
        if part.drift is not None:
            carried, word = carried + self._error[part.drift], word + self._unit  # its upper word, rounded down
        bound = (carried + word) * (1.0 + ROUGHLY)
        furthest = max(abs(low), abs(high), high - self._ambient[0], self._ambient[1] - low) + abs(offset) * self._unit
        furthest += drifted
        if not furthest * (1.0 + ROUGHLY) < (2.0**31 - 8.0) * self._unit:
            raise Refuted(f"{part.name}: what is read may overflow")
        reading = (bound + self._measured.ambient * self._unit + self._measured.reading_K) * (1.0 + ROUGHLY)
        if not bound <= part.bound_K:
            raise Refuted(f"{part.name}: the error may reach {bound:.6g} K, claimed are {part.bound_K:.6g} K")
        if not reading <= part.reading_K:
            raise Refuted(
                f"{part.name}: what rise_mK gives may be off by {reading:.6g} K, claimed are {part.reading_K:.6g} K"
            )
        return Verdict(part.name, Ratio(part.bound_K), Ratio(part.reading_K), Ratio(bound), inequalities)


def _degrees(thousandths: int, towards: float) -> float:
    return float(np.nextafter(thousandths / 1000.0, towards))


class _Calls(c_ast.NodeVisitor):  # type: ignore[misc]
    """Collects calls of functions of a channel's value alone."""

    def __init__(self, unit: Unit, found: list[tuple[str, int]]) -> None:
        self._unit, self._found = unit, found

    def visit_FuncCall(self, node: c_ast.FuncCall) -> None:
        match node:
            case c_ast.FuncCall(
                name=c_ast.ID(name=name),
                args=c_ast.ExprList(
                    exprs=[
                        c_ast.ArrayRef(
                            name=c_ast.StructRef(name=c_ast.ID(name=of), field=c_ast.ID(name="channel")),
                            subscript=c_ast.Constant(value=channel),
                        )
                    ]
                ),
            ) if of == f"{self._unit.model}_model":
                if (name, int(channel)) not in self._found:
                    self._found.append((name, int(channel)))
                return
        self.generic_visit(node)
