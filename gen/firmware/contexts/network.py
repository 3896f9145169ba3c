"""What the templates of a network are told: its states, terms, factors, tables, and the order of a sample."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any, TypedDict

import numpy as np

from gen.errors import CheckFailed
from gen.firmware.contexts import network_words
from gen.lowering.kinds import OUTPUT_BITS
from gen.lowering.network import fixed
from gen.lowering.network.factors import WORD_BITS, FactorProgram
from gen.lowering.network.program import HeatProgram, NetworkProgram, StateProgram, TermProgram, Words
from gen.lowering.network.series import WEIGHT, WHOLE
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
    varying_terms: list[dict[str, Any]]
    references: list[dict[str, Any]]
    factors: list[dict[str, Any]]
    tables: list[dict[str, Any]]
    orders: list[dict[str, Any]]
    sums: list[dict[str, Any]]
    words: list[dict[str, Any]]
    word_kinds: list[tuple[int, int]]
    take_ups: list[dict[str, Any]]
    take_up_kinds: list[int]
    warmths: list[dict[str, Any]]
    fractions: list[dict[str, Any]]
    uppers: list[int]
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
        "scale": {**asdict(scale), "half": scale.half},
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
        "varying_terms": [term for term in made.terms if not term["constant"]],
        "references": made.references,
        "factors": [_factor(factor) for factor in network.factors],
        "tables": made.tables,
        "orders": orders,
        **_sums(network, orders),
        "varying": bool(made.tables),
        "comments": _comments(network),
    }


def _comments(network: NetworkProgram) -> list[str]:
    if network.arithmetic == "float":
        return [f"Sums are float32 in words of a temperature, 2^-{network.fraction_bits} K."]
    return [
        f"A temperature's word is 2^-{network.fraction_bits + fixed.LOW_BITS} degC, of which the upper 32 bits are "
        "read. A rate is an unsigned word of its",
        "node's own scale: the sum of its products with differences is shifted down where it is used. Later terms of",
        "the series are of the upper bytes of rates, and of differences that fill as many.",
    ]


class _Sums(TypedDict):
    """What the words of a network need: products, shifts, fractions."""

    sums: list[dict[str, Any]]
    words: list[dict[str, Any]]
    word_kinds: list[tuple[int, int]]
    take_ups: list[dict[str, Any]]
    take_up_kinds: list[int]
    warmths: list[dict[str, Any]]
    fractions: list[dict[str, Any]]
    uppers: list[int]


def _sums(network: NetworkProgram, orders: list[dict[str, Any]]) -> _Sums:
    products = sorted({WHOLE, *network.products}, key=lambda product: -product.sum_bytes)
    whole = WHOLE.sum_bytes
    # Starts and hidden nodes; factors.
    words = {(whole, scale_of(network.fraction_bits).shift, 4), (whole, 16, 4)}
    words |= {(whole, WORD_BITS - 8 * WHOLE.least, 4)} if network.factors else set()
    take_ups, warmths, fractions, uppers = set(), set(), set(), set()
    for order in orders if network.arithmetic == "fixed" else []:
        uppers |= {order["width"]} - {4}
        take_ups |= {(order["bytes"], state["to_state"]) for state in order["states"]}
        warmths |= {heat["left"] for state in order["states"] for heat in state["heats"] if not heat["factor"]}
        if order["kept"]:
            words |= {(order["bytes"], state["to_next"], order["next_width"]) for state in order["states"]}
            fractions |= {(order["next_width"], order["number"] + 1)} if order["number"] + 1 in WEIGHT else set()
    return {
        "sums": [network_words.sum_context(product) for product in products],
        "words": [network_words.word(*key) for key in sorted(words, reverse=True)],
        "word_kinds": sorted({(width, count) for count, _, width in words}, reverse=True),
        "take_ups": [network_words.take_up(*key) for key in sorted(take_ups, reverse=True)],
        "take_up_kinds": sorted({count for count, _ in take_ups}, reverse=True),
        "warmths": [network_words.heat(left) for left in sorted(warmths)],
        "fractions": [network_words.fraction(width, WEIGHT[k], _ORDINAL[k]) for width, k in sorted(fractions)],
        "uppers": sorted(uppers, reverse=True),
    }


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
            source = f"{self._name}_{self._network.states[term.other].name}"
            label = f"{self._network.states[term.target].name} from {self._network.states[term.other].name}"
        elif term.source == "ambient":
            source = "AMBIENT"
            label = f"{self._network.states[term.target].name} from the ambient"
        else:
            source = f"REFERENCE_{self._reference(program)}"
            side = "over" if term.growing else "below"
            label = f"{self._network.states[term.target].name} {side} {term.reference:g} degC"
        of, less = (target, source) if term.growing else (source, target)
        label = f"{label}, $.network.{term.label}"
        key = f"rate{index}"
        value = self._value(program.words, term.factors, key, label)
        constant = program.constant and not term.factors
        self.terms.append({"index": index, "label": label, "value": value, "constant": constant})
        return {"index": index, "of": of, "less": less, "source": term.source, "constant": constant, "note": label}

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
                literal = f"{self._name}_scaled({literal}, f{k})"
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

    def _heat(self, program: HeatProgram) -> dict[str, Any]:
        """What a heat adds to its sum: a word times its first factor, or shifted up."""
        key, label = self._named(program)
        factors = program.heat.factors
        return {
            "factor": f"f{factors[0]}" if factors else None,
            "left": program.left,
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
        network, made = self._network, []
        for number in range(1, network.orders + 1):
            partaking = [k for k, state in enumerate(network.states) if state.orders >= number]
            order = {
                "number": number,
                "title": "y1" if number == 1 else f"y{number}: a {_ORDINAL[number]} of h M y{number - 1}",
                "y": f"y{number}",
                "given": "v" if number == 1 else f"y{number - 1}",
                "kept": number < network.orders,
                "share": _single(1.0 / number),
            }
            if network.arithmetic == "float":
                order["states"] = [self._single_step(number, k) for k in partaking]
            else:
                order |= self._shape(number)
                order["states"] = [self._step(order, k) for k in partaking]
                order["still"] = [state.name for state in network.states if state.orders < number]
            made.append(order)
        return made

    def _shape(self, number: int) -> dict[str, Any]:
        """Bytes of an order's words and sums."""
        products = self._network.products
        own = products[number - 1]
        following = products[number].width if number < len(products) else 0
        return {"bytes": own.sum_bytes, "width": own.width, "next_width": following}

    def _single_step(self, number: int, k: int) -> dict[str, Any]:
        state = self._network.states[k]
        heats = [self._single_heat(heat) for heat in state.heats] if number == 1 else []
        return {"name": state.name, "heat": " + ".join(["0.0f", *heats])}

    def _step(self, order: dict[str, Any], k: int) -> dict[str, Any]:
        """A state's sum in one order: its products, and how far it is shifted down for whom."""
        network, state, number = self._network, self._network.states[k], order["number"]
        bits = fixed.sum_bits(network.products, network.series_bits, network.fraction_bits, number) + state.shift
        step: dict[str, Any] = {
            "name": state.name,
            "terms": [self._product(order, term) for term in self.states[k]["terms"]],
            "heats": [self._heat(heat) for heat in state.heats] if number == 1 else [],
            "to_state": bits - network.fraction_bits - fixed.LOW_BITS,
        }
        if order["kept"]:
            step["to_next"] = bits - network.series_bits[number - 1]
            word = f"{self._name}_word{order['next_width']}<{step['to_next']}>(sum)"
            step["word"] = f"{self._name}_{_ORDINAL[number + 1]}({word})" if number + 1 in WEIGHT else word
        return step

    def _product(self, order: dict[str, Any], term: dict[str, Any]) -> dict[str, str]:
        """A term's difference and its rate; neither the ambient nor a fixed temperature has a part in later orders."""
        given = order["given"]
        fixed_places = ("AMBIENT", "REFERENCE_")
        of, less = (
            "0" if order["number"] > 1 and place.startswith(fixed_places) else f"{given}[{place}]"
            for place in (term["of"], term["less"])
        )
        rate, width = f"R{term['index']}", order["width"]
        if not term["constant"]:
            rate = f"rate[{rate}]" if width == 4 else f"{self._name}_upper{width}(rate[{rate}])"
        elif width < 4:
            rate = f"({self._name}_Rate{width})({rate} >> {32 - 8 * width})"
        return {"of": of, "less": less, "rate": rate, "note": term["note"]}
