"""What came of a run: alarms, sensors that were not believed, differences from the model."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from gen.arrays import BoolArray, FloatArray
from gen.avr.compile import sizes
from gen.avr.simulator import EmulatedChip
from gen.coefficients.document import Document
from gen.coefficients.protecting import protections
from gen.emulate.board import Board
from gen.emulate.session import Session
from gen.emulate.wiring.divider import Divider
from gen.emulate.wiring.led import Seen, read_led
from gen.record import Part


@dataclass(frozen=True)
class Alarm:
    """One alarm of one rule.

    Parameters
    ----------
    rule
        Its name.
    raised_s, ended_s
        Times of the first row that shows it, and of the first that does not any more (None: never).
    led_s
        When the LED first blinked the rule's number, None: never.
    """

    rule: str
    raised_s: float
    ended_s: float | None
    led_s: float | None


@dataclass(frozen=True)
class Disbelief:
    """Rows in which a thermocouple's sample was not used: its code, and the times of the first row with and without."""

    channel: str
    code: int
    from_s: float
    to_s: float | None


@dataclass(frozen=True)
class Acted:
    """The board's acting on one cause: its name, and the times of the first row with it and without (None: never)."""

    cause: str
    from_s: float
    to_s: float | None


@dataclass(frozen=True)
class Results:
    """What a run says; times are the run file's, s.

    Attributes
    ----------
    columns
        Every numeric column of the run file, NaN where a field is empty.
    alarms, acted, disbelieved, led
        In order of time.
    flags
        Every bit of the column ``flags`` that was ever set, as one number.
    """

    columns: dict[str, FloatArray]
    alarms: list[Alarm]
    acted: list[Acted]
    disbelieved: list[Disbelief]
    led: list[Seen]
    flags: int


def results_of(document: Document, board: Board, session: Session) -> Results:
    """Gather a run's results."""
    edges = board.led
    led = read_led(edges, session.seconds) if edges is not None else []
    part = session.recorder.parts[0] if session.recorder.parts else Part(("time_s",))
    text = _text_columns(part)
    columns = {name: _numbers(values) for name, values in text.items()}
    return Results(
        columns=columns,
        alarms=_alarms([rule.name for rule in document.alarms], columns, led),
        acted=_acted([entry.label for entry in protections(document)], columns),
        disbelieved=_disbelieved(
            [chip.channel for chip in document.wiring.thermocouples] if document.wiring else [], columns, text
        ),
        led=led,
        flags=int(np.bitwise_or.reduce(columns["flags"].astype(np.int64), initial=0)) if "flags" in columns else 0,
    )


def summary(results: Results, board: Board, session: Session, settings: dict[str, Any]) -> dict[str, Any]:
    """Give a run's results for JSON.

    Parameters
    ----------
    results, board, session
        The run.
    settings
        What it was run with; stands first.
    """
    mega = board.mega
    taken = sizes(mega.elf)
    return settings | {
        "seconds": session.seconds,
        "wall_s": round(session.wall_s, 3),
        "interrupted": session.interrupted,
        "rows": session.recorder.rows,
        "garbled_lines": session.recorder.garbled,
        "time_zero_s": session.time_zero_s,
        "restarts_s": session.restarts_s,
        "alarms": [asdict(alarm) for alarm in results.alarms],
        "acted": [asdict(item) for item in results.acted],
        "disbelieved": [asdict(item) for item in results.disbelieved],
        "led": [asdict(item) for item in results.led],
        "flags": results.flags,
        "measured_minus_model_K": _differences(results.columns),
        "board": {
            "flash_bytes": taken.flash,
            "ram_bytes": taken.ram,
            "awake_share": round(1.0 - mega.asleep / mega.cycle, 6),
            "stack_bytes": deepest_stack(mega),
            "pulses": mega.encoder.sent,
            "thermocouples": {
                name: asdict(chip.counts)
                for name, chip in board.thermocouples.items()
                if not isinstance(chip, Divider)  # a voltage does not know who looks at it
            },
            "eeprom": asdict(mega.eeprom.counts),
        },
    }


def deepest_stack(mega: EmulatedChip) -> int:
    """Give the deepest stack since the start, in bytes, of a firmware that fills its free RAM with one byte at start.

    What `Stack.use` looks for is gone then. A frame that is reserved and never written to is not seen.
    """
    floor = mega.memory.address("_end")
    memory = np.frombuffer(mega.memory.peek(floor, mega.stack.top - floor), dtype=np.uint8)
    used = np.flatnonzero(memory != memory[0])
    return int(memory.size - used[0]) if used.size else 0


def _text_columns(part: Part) -> dict[str, list[str]]:
    rows = [row.split(",") for row in part.rows]
    return {name: [row[i] for row in rows] for i, name in enumerate(part.columns)}


def _numbers(values: list[str]) -> FloatArray:
    return np.array([float(text) if text else np.nan for text in values], dtype=np.float64)


def _spans(present: BoolArray, time_s: FloatArray) -> list[tuple[float, float | None]]:
    """First and one past the last time of every run of True."""
    edges = np.flatnonzero(np.diff(np.concatenate(([False], present, [False])).astype(np.int8)))
    starts, ends = edges[::2], edges[1::2]
    return [
        (float(time_s[a]), float(time_s[b]) if b < len(time_s) else None) for a, b in zip(starts, ends, strict=True)
    ]


def _alarms(rules: list[str], columns: dict[str, FloatArray], led: list[Seen]) -> list[Alarm]:
    if "alarms" not in columns:
        return []
    time_s, mask = columns["time_s"], columns["alarms"].astype(np.int64)
    alarms = []
    for bit, rule in enumerate(rules):
        for raised, ended in _spans((mask >> bit & 1).astype(np.bool_), time_s):
            blinked = [
                item.from_s for item in led if item.pattern == f"alarm {bit + 1}" and item.from_s >= raised - 1.0
            ]
            alarms.append(Alarm(rule, raised, ended, blinked[0] if blinked else None))
    return sorted(alarms, key=lambda alarm: alarm.raised_s)


def _acted(causes: list[str], columns: dict[str, FloatArray]) -> list[Acted]:
    if "protection" not in columns:
        return []
    mask = columns["protection"].astype(np.int64)
    found = [
        Acted(cause, start, end)
        for bit, cause in enumerate(causes)
        for start, end in _spans((mask >> bit & 1).astype(np.bool_), columns["time_s"])
    ]
    return sorted(found, key=lambda item: item.from_s)


def _disbelieved(channels: list[str], columns: dict[str, FloatArray], text: dict[str, list[str]]) -> list[Disbelief]:
    if "sensors" not in text:
        return []
    digits = np.array([list(code.zfill(len(channels))) for code in text["sensors"]]).reshape(-1, len(channels))
    found = []
    for place, channel in enumerate(channels):
        for code in sorted(set(digits[:, place]) - {"0"}):
            spans = _spans(digits[:, place] == code, columns["time_s"])
            found += [Disbelief(channel, int(code), start, end) for start, end in spans]
    return sorted(found, key=lambda item: item.from_s)


def _differences(columns: dict[str, FloatArray]) -> dict[str, dict[str, float]]:
    found = {}
    for name in columns:
        component = name.removesuffix("_model_degC")
        if component == name or f"{component}_degC" not in columns:
            continue
        difference = columns[f"{component}_degC"] - columns[name]
        difference = difference[~np.isnan(difference)]
        if difference.size:
            found[component] = {
                "mean": round(float(difference.mean()), 4),
                "lowest": round(float(difference.min()), 4),
                "highest": round(float(difference.max()), 4),
                "last": round(float(difference[-1]), 4),
            }
    return found
