"""What the templates of a network are told: its states, terms, factors, tables, and the order of a sample."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any, TypedDict

import numpy as np

from gen.errors import CheckFailed
from gen.lowering.kinds import OUTPUT_BITS
from gen.lowering.network import fixed
from gen.lowering.network.factors import FactorProgram
from gen.lowering.network.program import HeatProgram, NetworkProgram, StateProgram, TermProgram, Words
from gen.lowering.network.series import EXTRA_SHIFT, WEIGHT
from gen.lowering.network.start import scale_of
from gen.lowering.program import Program
from gen.model.network import Network

_LARGEST_TABLES = 61_440
"""Bytes of all tables together: the board reads flash by addresses of 16 bits, and its own code lies there, too."""
_ORDINAL = {2: "half", 3: "third", 4: "fourth", 5: "fifth"}


class NetworkContext(TypedDict):
    """A network; `orders` are the terms of the series, one after the other."""

    fraction_bits: int
    output_bits: int
    start_mC: tuple[int, int]
    scale: dict[str, int]
    readings: list[dict[str, Any]]
    hidden: list[dict[str, Any]]
    states: list[dict[str, Any]]
    terms: list[dict[str, Any]]
    references: list[dict[str, Any]]
    factors: list[dict[str, Any]]
    weights: list[dict[str, Any]]
    tables: list[dict[str, Any]]
    orders: list[dict[str, Any]]
    places: tuple[str, ...]
    raises: list[int]
    varying: bool
    comments: list[str]


def network_context(program: Program) -> NetworkContext:
    """What the templates need of a program's network.

    Raises
    ------
    CheckFailed
        If its tables are larger than what the board reads of its flash.
    """
    network, model = program.network, program.model.network
    assert network is not None
    assert model is not None
    made = _Terms(network, model, program.model.name)
    orders = made.orders()
    size = 4 * sum(table["count"] for table in made.tables)
    if size > _LARGEST_TABLES:
        raise CheckFailed(
            f"$.network: the tables over |PWM| would have {size} bytes, and the board reads {_LARGEST_TABLES} at most; "
            "make some conductances constant, or leave nodes out"
        )
    scale = scale_of(network.fraction_bits)
    return {
        "fraction_bits": network.fraction_bits,
        "output_bits": OUTPUT_BITS,
        "start_mC": network.start_mC,
        "scale": {"factor": scale.factor, "shift": scale.shift, "half": scale.half},
        "readings": [
            {
                "name": reading.name,
                "offset": reading.offset,
                "state": network.states[reading.state].name,
                "node": network.states[reading.node].name,
            }
            for reading in network.readings
        ],
        "hidden": _hidden(network),
        "states": made.states,
        "terms": made.terms,
        "references": made.references,
        "factors": [_factor(factor) for factor in network.factors],
        "weights": [
            {"word": _ORDINAL[order], "factor": factor} for order, factor in WEIGHT.items() if order <= network.orders
        ],
        "tables": made.tables,
        "orders": orders,
        "places": tuple(f"%{byte}[{half}]" for half in ("lo", "hi") for byte in "ABCD"),
        "raises": sorted({order["raised"] // 8 for order in orders[2:]}),
        "varying": bool(made.tables),
        "comments": _comments(network),
    }


def _comments(network: NetworkProgram) -> list[str]:
    if network.arithmetic == "float":
        return [f"Sums are float32 in words of a temperature, 2^-{network.fraction_bits} K."]
    return [
        f"A temperature's word is 2^-{network.fraction_bits + fixed.LOW_BITS} degC, of which the upper 32 bits are "
        "read. A rate is an unsigned word of its",
        "node's own scale: the sum of its products with differences is exact, and shifted down where it is used.",
    ]


def _hidden(network: NetworkProgram) -> list[dict[str, Any]]:
    made = []
    for node, weights in zip(network.hidden, network.rest, strict=True):
        pairs = zip(network.readings, weights.tolist(), strict=False)
        own = [{"node": network.states[reading.node].name, "word": word} for reading, word in pairs]
        made.append({"name": network.states[node].name, "weights": own})
    return made


def _factor(factor: FactorProgram) -> dict[str, Any]:
    return {**asdict(factor), "unit": _single(2.0**-factor.bits)}


def _single(value: float) -> str:
    """A float32 literal that reads back the same."""
    text = f"{np.float32(value)!r}".removeprefix("np.float32(").removesuffix(")")
    return f"{text}f"


class _Terms:
    """Numbers terms, references and tables as they come."""

    def __init__(self, network: NetworkProgram, model: Network, name: str) -> None:
        self._network, self._model, self._name = network, model, name
        self.terms: list[dict[str, Any]] = []
        self.references: list[dict[str, Any]] = []
        self.tables: list[dict[str, Any]] = []
        self.states = [self._state(k, state) for k, state in enumerate(network.states)]

    def _state(self, number: int, state: StateProgram) -> dict[str, Any]:
        nodes = self._model.nodes
        if number < len(nodes):
            node = nodes[number]
            kind = "hidden" if node.sensor is None else "sensed"
            note = f"{node.description}, {kind}" if node.description else kind
            title = f"{node.name}: {node.capacity:g} J/K, $.network.nodes[{number}]"
        else:
            note = "what its sensor shows, which lags"
            title = f"{state.name}: {note}"
        return {
            "name": state.name,
            "index": number,
            "note": note,
            "title": title,
            "terms": [self._term(t) for t in state.terms],
        }

    def _term(self, program: TermProgram) -> dict[str, Any]:
        term, index = program.term, len(self.terms)
        target = f"{self._name}_{self._network.states[term.target].name}"
        if term.source == "state":
            source, place = f"{self._name}_{self._network.states[term.other].name}", term.other
            label = f"{self._network.states[term.target].name} from {self._network.states[term.other].name}"
        elif term.source == "ambient":
            source, place = "AMBIENT", len(self._network.states)
            label = f"{self._network.states[term.target].name} from the ambient"
        else:
            number = self._reference(program)
            source, place = f"REFERENCE_{number}", len(self._network.states) + 1 + number
            side = "over" if term.growing else "below"
            label = f"{self._network.states[term.target].name} {side} {term.reference:g} degC"
        of, less = (target, source) if term.growing else (source, target)
        label = f"{label}, $.network.{term.label}"
        self.terms.append(
            {"index": index, "label": label, "value": self._value(program.words, term.factors, f"rate{index}", label)}
        )
        return {
            "index": index,
            "of": of,
            "less": less,
            "source": place,
            "growing": term.growing,
            "note": label,
        }

    def _reference(self, program: TermProgram) -> int:
        word = program.reference
        words = [reference["word"] for reference in self.references]
        if word not in words:
            self.references.append({"word": word, "degC": f"{program.term.reference:g}"})
            words.append(word)
        return words.index(word)

    def _value(self, words: Words, factors: tuple[int, ...], key: str, label: str) -> str:
        """C++ that gives a rate, or a heat's word, at this row with its factors."""
        literal = self._word(words, key, label)
        for k in factors:
            if self._network.arithmetic == "fixed":
                literal = f"scaled({literal}, f{k}, {self._network.factors[k].bits})"
            else:
                literal = f"{literal} * f{k}"
        return literal

    def _word(self, words: Words, key: str, label: str) -> str:
        fixed_point = self._network.arithmetic == "fixed"
        literals = [f"{int(word)}UL" if fixed_point else _single(float(word)) for word in words]
        if len(set(literals)) == 1:
            return literals[0]
        bits = {"label": label, "notes": [], "id": key, "count": len(literals), "words": literals}
        self.tables.append(bits)
        return f"pgm_read_{'dword' if fixed_point else 'float'}(&{self._name}_{key}[row])"

    def _heat(self, program: HeatProgram) -> dict[str, str]:
        """What a heat adds to its sum: a signed number times an unsigned word."""
        key, label = self._named(program)
        factors = program.heat.factors
        return {
            "factor": f"f{factors[0]}" if factors else f"{program.unit}L",
            "word": self._value(program.words, factors[1:], key, label),
            "label": label,
        }

    def _single_heat(self, program: HeatProgram) -> str:
        key, label = self._named(program)
        return self._value(program.words, program.heat.factors, key, label)

    def _named(self, program: HeatProgram) -> tuple[str, str]:
        heat = program.heat
        key = "heat" + heat.label.removeprefix("heats[").removesuffix("]")
        return key, f"{self._network.states[heat.target].name}, $.network.{heat.label}"

    def orders(self) -> list[dict[str, Any]]:
        """The terms of the series in the order of a sample."""
        made = []
        for number in range(1, self._network.orders + 1):
            partaking = [k for k, state in enumerate(self._network.states) if state.orders >= number]
            made.append(
                {
                    "number": number,
                    "title": "y1" if number == 1 else f"y{number}: a {_ORDINAL[number]} of h M y{number - 1}",
                    "y": f"y{number}",
                    "given": "v" if number == 1 else f"y{number - 1}",
                    "kept": number < self._network.orders,
                    "raised": self._raised(number),
                    "weight": _ORDINAL[number] if number in WEIGHT else None,
                    "share": _single(1.0 / number),
                    "states": [self._step(number, k) for k in partaking],
                }
            )
        return made

    def _raised(self, number: int) -> int:
        """By how many bits a word of the series is raised to a temperature's whole word; whole bytes from y3 on."""
        if self._network.arithmetic == "float":
            return 0
        return fixed.LOW_BITS + self._network.fraction_bits - self._network.series_bits[number - 1]

    def _step(self, number: int, k: int) -> dict[str, Any]:
        network, state = self._network, self._network.states[k]
        if network.arithmetic == "float":
            heats = [self._single_heat(heat) for heat in state.heats] if number == 1 else []
            return {"name": state.name, "heat": " + ".join(["0.0f", *heats])}
        given = network.fraction_bits if number == 1 else network.series_bits[number - 2]
        own = state.shift + EXTRA_SHIFT.get(number, 0)
        return {
            "name": state.name,
            "heats": [self._heat(heat) for heat in state.heats] if number == 1 else [],
            "to_state": own + given - network.fraction_bits,
            "to_next": own + fixed.LOW_BITS + given - network.series_bits[number - 1],
        }
