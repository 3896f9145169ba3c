"""What templates are told of a network's terms: numbered as they come, and the order in which a sample adds them."""

from __future__ import annotations

from typing import Any

import numpy as np

from gen.firmware.contexts import network_words
from gen.lowering.network import fixed
from gen.lowering.network.program import HeatProgram, NetworkProgram, StateProgram, TermProgram, Words
from gen.lowering.network.series import FIRST, WEIGHT
from gen.model.network import Network

_ORDINAL = {2: "half", 3: "third", 4: "fourth", 5: "fifth"}


def single(value: float) -> str:
    """A float32 literal that reads back the same."""
    text = f"{np.float32(value)!r}".removeprefix("np.float32(").removesuffix(")")
    return f"{text}f"


class Terms:
    """Numbers terms, references and tables as they come."""

    def __init__(self, network: NetworkProgram, model: Network, name: str) -> None:
        self._network, self._model, self._name = network, model, name
        self.terms: list[dict[str, Any]] = []
        self.references: list[dict[str, Any]] = []
        #: Values that differ from a state's by what a law makes of a difference, in the order in which terms use them.
        self.flows: list[dict[str, Any]] = []
        self._first_reference = len(network.states) + 1 + sum(1 + (law.second is not None) for law in network.laws)
        self.tables: list[dict[str, Any]] = []
        #: What is gathered at the beginning of a sample, and where it is, by term and by heat.
        self.stream: list[dict[str, str | None]] = []
        self.states = [self._state(k, state) for k, state in enumerate(network.states)]

    def _state(self, number: int, state: StateProgram) -> dict[str, Any]:
        nodes = self._model.nodes
        if number < len(nodes):
            node = nodes[number]
            kind = "hidden" if node.sensor is None else "sensed"
            note = f"{node.description}, {kind}" if node.description else kind
            title = f"{node.name}: {node.capacity:g} J/K, $.network.nodes[{number}]"
        else:
            drifts = number in self._network.drifts
            note = "how far its sensor has drifted since the start" if drifts else "what its sensor shows, which lags"
            title = f"{state.name}: {note}"
        return {
            "name": state.name,
            "identifier": state.identifier,
            "index": number,
            "note": note,
            "title": title,
            "bent": any(term.term.law is not None for term in state.terms),
            "terms": [self._term(t) for t in state.terms],
            "heats": [self._heat(heat) for heat in state.heats] if self._network.arithmetic == "fixed" else [],
        }

    def _gathered(self, name: str, value: str, label: str, key: str | None = None) -> int:
        """Place of a word that is gathered at the beginning of a sample; `key` names its table if it is one's word."""
        tables = [table["id"] for table in self.tables]
        flash = f"&{self._name}_{key}[row]" if key in tables else None
        self.stream.append({"id": name, "value": value, "label": label, "flash": flash})
        return len(self.stream) - 1

    def _term(self, program: TermProgram) -> dict[str, Any]:
        term, index = program.term, len(self.terms)
        target = f"{self._name}_{self._network.states[term.target].identifier}"
        if term.source == "state":
            source, place = f"{self._name}_{self._network.states[term.other].identifier}", term.other
            label = f"{self._network.states[term.target].name} from {self._network.states[term.other].name}"
        elif term.source == "ambient":
            source, place = "AMBIENT", len(self._network.states)
            label = f"{self._network.states[term.target].name} from the ambient"
        else:
            number = self._reference(program)
            source, place = f"REFERENCE_{number}", self._first_reference + number
            side = "over" if term.growing else "below"
            label = f"{self._network.states[term.target].name} {side} {term.reference:g} degC"
        of, less = (target, source) if term.growing else (source, target)
        label = f"{label}, $.network.{term.label}"
        value = self._value(program.words, term.factors, f"rate{index}", label)
        constant = int(program.words[0]) if program.constant and not term.factors else None
        self.terms.append({"index": index, "label": label, "value": value, "constant": constant is not None})
        single = constant is not None or self._network.arithmetic == "float"
        table = None if term.factors else f"rate{index}"
        made = {
            "index": index,
            "of": of,
            "less": less,
            "source": place,
            "growing": term.growing,
            "constant": constant,
            "word": None if single else self._gathered(f"R{index}", value, label, table),
            "note": label,
            "rate": f"R{index}",
        }
        return {**made, "later": made} if term.law is None else self._with_law(made, program)

    def _with_law(self, made: dict[str, Any], program: TermProgram) -> dict[str, Any]:
        """A term whose first difference is a law's, and whose rate in later terms is one times the law's slope."""
        law, index = program.term.law, made["index"]
        assert law is not None
        own, name = self._network.laws[law.index], f"R{index}_LATER"
        note = f"{made['note']}.{own.kind}"
        later = {**made, "rate": name, "constant": None, "note": note}
        if self._network.arithmetic == "fixed":
            rate = f"R{index}" if made["constant"] is not None else f"gathered[R{index}]"
            value = f"{self._name}_scaled({rate}, slope[{law.index}])"
            later["word"] = self._gathered(name, value, f"{note}, later terms")
        number = len(self.flows)
        self.flows.append(
            {"state": made["less"], "sign": "-" if law.first == program.term.target else "+", "law": law.index}
        )
        place = len(self._network.states) + 1 + number
        return {**made, "of": f"FLOW_{number}", "source": place, "note": note, "later": later, "law": law.index}

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
        literals = [f"{int(word)}UL" if fixed_point else single(float(word)) for word in words]
        if len(set(literals)) == 1:
            return literals[0]
        bits = {"label": label, "notes": [], "id": key, "count": len(literals), "words": literals}
        self.tables.append(bits)
        return f"pgm_read_{'dword' if fixed_point else 'float'}(&{self._name}_{key}[row])"

    def _heat(self, program: HeatProgram) -> dict[str, Any]:
        """What a heat adds to its sum: a word times its first factor, or shifted up."""
        key, label = self._named(program)
        factors = program.heat.factors
        word = self._value(program.words, factors[1:], key, label)
        name = key.upper()
        if factors:
            at = self._gathered(f"{name}_FACTOR", f"(uint32_t)f{factors[0]}", f"{label}, factor")
            self._gathered(name, word, label, None if factors[1:] else key)
            value = f"{self._name}_product((int32_t)gathered[{name}_FACTOR], gathered[{name}], {FIRST.least}, true)"
        else:
            at = self._gathered(name, word, label, None if factors[1:] else key)
            value = f"(int64_t)gathered[{name}] * (INT64_C(1) << {program.left})"
        return {"factor": bool(factors), "left": program.left, "word": at, "value": value, "label": label}

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
                "share": single(1.0 / number),
            }
            if network.arithmetic == "float":
                order["states"] = [self._single_step(number, k) for k in partaking]
            else:
                product = network.products[number - 1]
                order["kept_bytes"] = f"{product.least}, {str(product.cut).lower()}"
                order["states"] = self._steps(order, partaking)
            made.append(order)
        return made

    def _single_step(self, number: int, k: int) -> dict[str, Any]:
        state = self._network.states[k]
        heats = [self._single_heat(heat) for heat in state.heats] if number == 1 else []
        return {"identifier": state.identifier, "heat": " + ".join(["0.0f", *heats]), "bent": self.states[k]["bent"]}

    def _steps(self, order: dict[str, Any], partaking: list[int]) -> list[dict[str, Any]]:
        """The states' sums in one order, each as C++ and as a block of assembly."""
        network, number = self._network, order["number"]
        product, kept = network.products[number - 1], order["kept"]
        width = network.products[number].width if kept else 0
        fraction = WEIGHT.get(number + 1)
        # Values are read from where the order before has put them: in turns ahead of the others and behind them.
        values, states = self._first_reference + len(self.references), len(network.states)
        given, handed_on = (0, 4 * values) if number % 2 else (4 * values, 0)
        made, position = [], 0
        for k in partaking:
            own, state = network.states[k], self.states[k]
            bits = fixed.sum_bits(network.products, network.series_bits, network.fraction_bits, number) + own.shift
            to_state = bits - network.fraction_bits - fixed.LOW_BITS
            to_next = bits - network.series_bits[number - 1] if kept else 0
            block = network_words.Block(product, position)
            block.begin(given + product.width * k)
            terms = [term if number == 1 else term["later"] for term in state["terms"]]
            for term in terms:
                still = number > 1 and term["source"] >= states
                source = None if still else given + product.width * term["source"]
                block.term(term["note"], source, term["constant"], term["word"], growing=term["growing"])
            for heat in state["heats"] if number == 1 else []:
                if heat["factor"]:
                    block.scaled_heat(heat["label"], heat["word"])
                else:
                    block.heat(heat["label"], heat["word"], heat["left"])
            block.hand_on(to_state, network_words.STATE_BYTES * k, to_next, handed_on + width * k, width, fraction)
            if kept and k == partaking[-1]:
                block.still([handed_on + width * other for other in range(states) if other not in partaking], width)
            position = block.position
            made.append(
                {
                    "name": own.name,
                    "identifier": own.identifier,
                    "terms": [self._product(order, term) for term in terms],
                    "heats": state["heats"] if number == 1 else [],
                    "to_state": to_state,
                    "word": self._word_of(to_next, width, fraction),
                    "parts": block.rows(f"{self._name.upper()}_"),
                }
            )
        return made

    def _word_of(self, bits: int, width: int, fraction: int | None) -> str:
        """C++ that hands a sum on."""
        if fraction is None:
            return f"{self._name}_shifted(sum, {bits})"
        below = 8 if width < 4 else 0
        return f"fraction({self._name}_shifted(sum, {bits - below}), {fraction}){f' >> {below}' if below else ''}"

    def _product(self, order: dict[str, Any], term: dict[str, Any]) -> dict[str, str]:
        """A term's difference and its rate as C++."""
        given, below = order["given"], 8 * (4 - self._network.products[order["number"] - 1].width)
        rate = f"gathered[{term['rate']}]" if term["constant"] is None else term["rate"]
        return {
            "of": f"{given}[{term['of']}]",
            "less": f"{given}[{term['less']}]",
            "rate": f"{rate} >> {below}" if below else rate,
            "note": term["note"],
        }
