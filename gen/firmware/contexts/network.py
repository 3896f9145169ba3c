"""What the templates of a network are told: its states, terms, factors, tables, and the order of a sample."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any, TypedDict

from gen.errors import CheckFailed
from gen.firmware.contexts import network_words
from gen.firmware.contexts.network_terms import Terms, single
from gen.lowering.kinds import OUTPUT_BITS
from gen.lowering.network import fixed
from gen.lowering.network.factors import WORD_BITS, FactorProgram
from gen.lowering.network.laws import LawProgram, RadiationProgram
from gen.lowering.network.program import NetworkProgram
from gen.lowering.network.series import WEIGHT, WHOLE, Product
from gen.lowering.network.start import scale_of
from gen.lowering.program import Program

_LARGEST_TABLES = 61_440
"""Bytes of all tables together: the board reads flash by addresses of 16 bits, and its own code lies there, too."""


class NetworkContext(TypedDict):
    """A network; `orders` are the terms of the series, one after the other."""

    fraction_bits: int
    output_bits: int
    start_mC: tuple[int, int]
    scale: dict[str, int]
    readings: list[dict[str, Any]]
    gains: dict[str, int] | None
    drifts: list[str]
    hidden: list[dict[str, Any]]
    states: list[dict[str, Any]]
    terms: list[dict[str, Any]]
    constants: list[dict[str, Any]]
    stream: list[dict[str, str | None]]
    references: list[dict[str, Any]]
    factors: list[dict[str, Any]]
    laws: list[dict[str, Any]]
    flows: list[dict[str, Any]]
    tables: list[dict[str, Any]]
    orders: list[dict[str, Any]]
    sums: list[dict[str, Any]]
    whole: dict[str, Any]
    downs: list[int]
    ups: list[int]
    thirds: bool
    varying: bool
    slope_unit: str
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
    made = Terms(network, model, program.model.name)
    orders = made.orders()
    size = 4 * sum(table["count"] for table in made.tables)
    if size > _LARGEST_TABLES:
        raise CheckFailed(
            f"$.network: the tables over |PWM| would have {size} bytes, and the board reads {_LARGEST_TABLES} at most; "
            "make some conductances constant, or leave nodes out"
        )
    scale = scale_of(network.fraction_bits)
    gains = None if network.gains is None else network.gains.describe()
    return {
        "fraction_bits": network.fraction_bits,
        "output_bits": OUTPUT_BITS,
        "start_mC": network.start_mC,
        "scale": {**asdict(scale), "half": scale.half},
        "readings": [
            {
                "name": reading.name,
                "offset": reading.offset,
                "gain": reading.gain,
                "state": network.states[reading.state].identifier,
                "node": network.states[reading.node].identifier,
                "drift": None if reading.drift is None else network.states[reading.drift].identifier,
            }
            for reading in network.readings
        ],
        "gains": gains,
        "drifts": [network.states[state].identifier for state in network.drifts],
        "hidden": _hidden(network),
        "states": made.states,
        "terms": made.terms,
        "constants": [term for term in made.terms if term["constant"]],
        "stream": made.stream,
        "references": made.references,
        "factors": [_factor(factor) for factor in network.factors],
        "laws": [_law(law, network) for law in network.laws],
        "flows": made.flows,
        "tables": made.tables,
        "orders": orders,
        "sums": [_sum(product) for product in dict.fromkeys(network.products)],
        "whole": {
            "least": WHOLE.least,
            "lines": ["tst %D[d]", *network_words.multiply(WHOLE, network_words.operands())],
        },
        "downs": sorted(
            {scale.shift, 16}
            | ({WORD_BITS - 8 * WHOLE.least} if network.factors or network.laws else set())
            | ({gains["shown"], gains["back"]} if gains else set())
        ),
        "ups": sorted(
            {
                scale.left,
                *(left for factor in network.factors for left in _lefts(factor)),
                *(left for law in network.laws for left in (law.left, law.up)),
            }
        ),
        "thirds": any(order in WEIGHT for order in range(2, network.orders + 1)),
        "varying": bool(made.tables),
        "slope_unit": single(2.0**-WORD_BITS),
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


def _sum(product: Product) -> dict[str, Any]:
    """A kind of product, as a macro that adds it."""
    use = network_words.fixed_registers(product)
    names = (("Sum", use.sum), ("difference", use.d), ("rate", use.a))
    return {
        "name": product.name,
        "width": product.width,
        "least": product.least,
        "cut": product.cut,
        "lines": network_words.multiply(product, use),
        "registers": ", ".join(f"{what}: {' '.join(registers)}" for what, registers in names) + ".",
    }


def _hidden(network: NetworkProgram) -> list[dict[str, Any]]:
    made = []
    for node, weights in zip(network.hidden, network.rest, strict=True):
        pairs = zip(network.readings, weights.tolist(), strict=True)
        own = [{"node": network.states[reading.node].identifier, "word": word} for reading, word in pairs]
        made.append({"identifier": network.states[node].identifier, "weights": own, "bits": network.rest_bits})
    return made


def _factor(factor: FactorProgram) -> dict[str, Any]:
    return {**asdict(factor), "unit": single(2.0**-factor.bits)}


def _law(law: LawProgram, network: NetworkProgram) -> dict[str, Any]:
    first, second = network.states[law.first].identifier, None
    if law.second is not None:
        second = network.states[law.second].identifier
    made = {**asdict(law), "kind": law.kind, "one": first, "other": second}
    if isinstance(law, RadiationProgram):
        kelvins = 1 << WORD_BITS - network.fraction_bits + law.drop - law.left
        made |= {"half": 1 << law.drop >> 1, "kelvins": kelvins}
    return made


def _lefts(factor: FactorProgram) -> list[int]:
    """By how many bits told values are shifted up for a factor."""
    return [piece.left for piece in factor.pieces if piece.slope] + ([factor.left] if factor.coefficients[1:] else [])
