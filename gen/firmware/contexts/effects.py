"""What the templates of the effects are told: numbers and expressions; statements are the templates' own."""

from __future__ import annotations

from typing import TypedDict

from gen.firmware.contexts.components import places_of
from gen.firmware.effect_tapes import Statement, Table, TapePrinter
from gen.lowering.effects.program import (
    GUARD_BITS,
    KELVIN_BITS,
    KELVIN_LIMIT,
    WEIGHT_BITS,
    Chain,
    EffectComponent,
    EffectsProgram,
    Follower,
    Inner,
    Lag,
)
from gen.lowering.fixed.component import FixedComponent
from gen.lowering.fixed.formats import CARRY_FACTOR, RESIDUE_BITS, WORD_BITS, Format
from gen.lowering.float32 import FloatComponent
from gen.lowering.program import Program
from gen.reference.lanes import word_bits

_KELVIN_END = KELVIN_LIMIT << KELVIN_BITS
_RISE_END_mK = 1 << 30


class Drives(TypedDict):
    """What heat there is: the steady rise of the part's own chain (None without one), and each follower's target."""

    steps: list[Statement]
    chain: str | None
    targets: list[str]


class Start(TypedDict):
    """From what a sensor shows to the start of the baseline, of the chain, of followers and of inner states."""

    steps: list[Statement]
    rise_mK: str
    chain: str | None
    own: list[str]
    inner: list[str]


class Reading(TypedDict):
    """From the rise, or from the lag before, to the next lag or to what the sensor shows."""

    steps: list[Statement]
    result: str


class Part(TypedDict):
    """One component's effects; `layout` is None in float32, `chain_shift` takes the chain's words to kelvins' words."""

    order: int
    substeps: int
    saturates: bool
    layout: Format | None
    chain: Chain | None
    chain_shift: int
    heats: bool
    followers: tuple[Follower, ...]
    inners: tuple[Inner, ...]
    lags: tuple[Lag, ...]
    notes: tuple[str, ...]
    sixth: tuple[int, ...]
    drives: Drives
    start: Start
    readings: list[Reading]
    tables: list[Table]


class Tracked(TypedDict):
    """A component whose rise is kept; `felt` is the place of its rise in a moment, `base_shift` as `chain_shift`."""

    name: str
    shape: str
    place: str
    limits: tuple[int, int]
    base_shift: int
    felt: int | None
    part: Part | None


class TrackedContext(TypedDict):
    """The components whose rises are kept.

    `parts` are those with effects, `felt` those whose rise is in some drive. `heating`, `finer` and `shown` name
    components: with states that add to the rise, with one more term in its mean, with a reading of their own.
    `states`: there are states of 64 bits.
    """

    tracked: list[Tracked]
    parts: list[Tracked]
    felt: list[Tracked]
    states: bool
    heating: list[str]
    finer: list[str]
    shown: list[str]


class EffectsContext(TrackedContext):
    """All effects."""

    elapsed_limit: int
    kelvin_bits: int
    start_end: int
    weight_bits: int
    carry_factor: int
    chain_bits: int
    word_bits: int


def effects_context(program: Program) -> EffectsContext | None:
    """What the templates need of the effects; None without any.

    Parameters
    ----------
    program
        What is emitted.
    """
    effects = program.effects
    if effects is None:
        return None
    return {
        **_of_tracked(_tracked(program, effects)),
        "elapsed_limit": effects.elapsed_limit,
        "kelvin_bits": KELVIN_BITS,
        "start_end": KELVIN_LIMIT * 1000,
        "weight_bits": WEIGHT_BITS,
        "carry_factor": CARRY_FACTOR,
        "chain_bits": WORD_BITS + GUARD_BITS,
        "word_bits": WORD_BITS + GUARD_BITS - RESIDUE_BITS,
    }


def _of_tracked(tracked: list[Tracked]) -> TrackedContext:
    parts = [(component["name"], component["part"]) for component in tracked if component["part"]]
    felt = [component for component in tracked if component["felt"] is not None]
    return {
        "tracked": tracked,
        "parts": [component for component in tracked if component["part"]],
        "felt": felt,
        "states": any(part["followers"] or part["inners"] or part["lags"] for _, part in parts),
        "heating": [name for name, part in parts if part["heats"]],
        "finer": [component["name"] for component in felt if component["part"] and component["part"]["sixth"]],
        "shown": [name for name, _ in parts],
    }


def _tracked(program: Program, effects: EffectsProgram) -> list[Tracked]:
    places = places_of(program)
    found: list[Tracked] = []
    for index, limits in zip(effects.tracked, effects.rise_limits, strict=True):
        lowered = program.components[index]
        part = effects.component(index)
        found.append(
            {
                "name": lowered.name,
                "shape": places[index][0],
                "place": places[index][1],
                "limits": limits,
                "base_shift": word_bits(lowered) - KELVIN_BITS,
                "felt": effects.felt.index(index) if index in effects.felt else None,
                "part": None if part is None else _part(effects, part, lowered),
            }
        )
    return found


def _part(effects: EffectsProgram, part: EffectComponent, lowered: FixedComponent | FloatComponent) -> Part:
    printer = TapePrinter(lowered.name, effects)
    drives, start = _drives(printer, part), _start(printer, part)
    printer.reading()
    readings: list[Reading] = [
        {"steps": printer.body(tape), "result": printer.output(tape, 0, KELVIN_BITS, str(_KELVIN_END))}
        for tape in part.readings
    ]
    return {
        "order": lowered.order,
        "substeps": lowered.substeps,
        "saturates": lowered.saturates,
        "layout": lowered.layout if isinstance(lowered, FixedComponent) else None,
        "chain": part.chain,
        "chain_shift": part.chain.fraction_bits - KELVIN_BITS if part.chain is not None else 0,
        "heats": part.heats,
        "followers": part.followers,
        "inners": part.inners,
        "lags": part.lags,
        "notes": part.notes,
        "sixth": part.sixth,
        "drives": drives,
        "start": start,
        "readings": readings,
        "tables": printer.tables,
    }


def _drives(printer: TapePrinter, part: EffectComponent) -> Drives:
    tape, chain = part.drives, part.chain
    first = 0 if chain is None else 1
    return {
        "steps": printer.body(tape),
        "chain": None if chain is None else printer.output(tape, 0, chain.fraction_bits, str(chain.limit), wide=True),
        "targets": [
            printer.output(tape, number, KELVIN_BITS, str(_KELVIN_END)) for number in range(first, len(tape.outputs))
        ],
    }


def _start(printer: TapePrinter, part: EffectComponent) -> Start:
    tape, chain = part.start, part.chain
    first = 1 if chain is None else 2
    inner = first + len(part.followers)
    return {
        "steps": printer.body(tape),
        "rise_mK": printer.output(tape, 0, 0, str(_RISE_END_mK)),
        "chain": None if chain is None else printer.output(tape, 1, chain.fraction_bits, str(chain.limit), wide=True),
        "own": [printer.output(tape, number, KELVIN_BITS, str(_KELVIN_END)) for number in range(first, inner)],
        "inner": [
            printer.output(tape, inner + i, state.fraction_bits, str(_inner_end(state)))
            for i, state in enumerate(part.inners)
        ],
    }


def _inner_end(inner: Inner) -> int:
    """Largest magnitude of an inner state's word: a temperature's, or a share's."""
    return _KELVIN_END if inner.fraction_bits == KELVIN_BITS else 1 << WEIGHT_BITS
