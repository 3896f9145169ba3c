"""Which columns of a table with a row for each reading hold the names, the values and their units."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from itertools import pairwise

import numpy as np

from gen.importing.guessing.evidence import Evidence, Facts
from gen.importing.guessing.names import DEVICES, SERIES, TIME
from gen.importing.units import unit_of

MOST_SERIES = 200
_VALUES = (
    *("value", "_value", "state", "reading", "wert", "messwert", "payload", "varvalue", "valeur", "valore", "valor"),
    *("waarde", "measured_value", "val"),
)
_MOST_STEADY = 0.8
"""Of the rows, those that may have the name of the row before: an operator's remark changes more rarely."""
_ROUND = 0.9
"""Of the rows, that say what the row of the round before said."""
_LEAST_ROWS = 3
"""Of each name, on average."""
_LEAST_UNITS = 0.9
_MOST_SHARED = 0.5
"""Of the rows: where a number of all sensors stays as in the row before."""
_STATE_WORDS = (
    "on off ein aus true false yes no ja nein ok open closed fault error idle run running stop stopped heating cooling "
    "cw ccw forward backward reverse left right auto manual high low max min"
)
_STATES = {"", *_STATE_WORDS.split()}


def names_and_values(evidence: Evidence, told: Collection[str]) -> tuple[str, str] | None:
    """The column of names, and what `--series` has to be told; None of a table with a column for each sensor.

    Parameters
    ----------
    evidence
        The columns.
    told
        Columns of which the user says what they are.
    """
    texts = [facts for name, facts in evidence.facts.items() if name not in told and _names(facts)]
    named = [facts for facts in texts if SERIES.fullmatch(facts.name.casefold())] or _numbered(evidence, told)
    by_turns = [facts for facts in texts if come_by_turns(facts)]
    values = value_column(evidence, {facts.name for facts in named[:1]})
    if not named and (not values or len(by_turns) != 1):
        return None
    found = (named or by_turns)[0]
    several = [facts.name for facts in _of_each(evidence, found)] if not values else []
    return found.name, series_of(found.name, [values] if values and not is_plain_value(values) else several)


def _of_each(evidence: Evidence, of: Facts) -> list[Facts]:
    """Columns of which each name has values of its own: they move from row to row, or differ within rounds of names."""
    found = moving(evidence, {of.name})
    many = len(set(of.texts))
    if not _goes_round(of.texts):
        return found
    whole = len(of.texts) // many * many
    apart = [
        facts
        for facts in evidence.numbers
        if facts.name != of.name
        and facts.values.size == len(of.texts)
        and not _time_like(facts)
        and np.ptp(facts.values[:whole].reshape(-1, many), axis=1).any()
    ]
    return [facts for facts in evidence.numbers if facts in found or facts in apart]


def series_of(names: str, values: Sequence[str]) -> str:
    """What `--series` is told: a column of names, and those of values where they have to be said.

    Parameters
    ----------
    names, values
        Of columns. A comma in one of several would part it.
    """
    return ",".join([names, *(value for value in values if "," not in value)])


def come_by_turns(facts: Facts) -> bool:
    """Whether a column holds a few texts that come by turns and are no units and no states: names, perhaps.

    Parameters
    ----------
    facts
        Of the column.
    """
    return _names(facts) and _turns(facts) and not _all_units(facts) and not _states(facts)


def value_column(evidence: Evidence, but: Collection[str] = ()) -> str:
    """The column of the values: by its name, else the only one of numbers that move; empty where nobody knows.

    Parameters
    ----------
    evidence
        The columns.
    but
        Those that are none.
    """
    named = [name for name in evidence.facts if name.casefold() in _VALUES and name not in but]
    if named:
        return named[0] if len(named) == 1 else ""
    found = moving(evidence, but)
    return found[0].name if len(found) == 1 else ""


def moving(evidence: Evidence, but: Collection[str] = ()) -> list[Facts]:
    """Columns of numbers that move, and are no times.

    Parameters
    ----------
    evidence
        The columns.
    but
        Those that are left out.
    """
    found = [f for f in evidence.numbers if f.name not in but and len(np.unique(f.values)) > 1 and not _time_like(f)]
    if len(found) > 1:  # what all sensors share stays while they are read
        found = [facts for facts in found if not is_shared(facts)]
    return found


def is_shared(facts: Facts) -> bool:
    """Whether numbers mostly stay as in the row before, as those of all sensors do.

    Parameters
    ----------
    facts
        Of a column.
    """
    return bool((facts.steps == 0).mean() >= _MOST_SHARED)


def is_plain_value(name: str) -> bool:
    """Whether a column of values is called so, whatever they are of.

    Parameters
    ----------
    name
        Of the column.
    """
    return name.casefold() in _VALUES


def _numbered(evidence: Evidence, told: Collection[str]) -> list[Facts]:
    """Columns that call sensors or devices by whole numbers, by turns: `sensor_id`, `index`."""
    return [
        facts
        for facts in evidence.numbers
        if facts.name not in told
        and (
            (SERIES.fullmatch(facts.name.casefold()) and _numbers(facts))
            or (DEVICES.fullmatch(facts.name.casefold()) and numbers_by_turns(facts))
        )
    ]


def numbers_by_turns(facts: Facts) -> bool:
    """Whether a column holds a few whole numbers, over and over in one order.

    Parameters
    ----------
    facts
        Of the column.
    """
    return _numbers(facts) and _goes_round(facts.texts)


def _numbers(facts: Facts) -> bool:
    """Whether a column holds a few whole numbers that come by turns."""
    few = min(MOST_SERIES, len(facts.texts) // _LEAST_ROWS)
    return facts.kind == "number" and facts.whole and 1 < len(set(facts.texts)) <= few and _turns(facts)


def _goes_round(texts: Sequence[str]) -> bool:
    """Whether numbers come in one order over and over, as devices are asked; a switch is not turned so evenly."""
    many = len(set(texts))
    same = sum(1 for before, after in zip(texts, texts[many:], strict=False) if before == after)
    return same >= _ROUND * (len(texts) - many)


def unit_column(evidence: Evidence) -> str:
    """The column that holds the unit of each reading; empty without one."""
    return next((name for name, facts in evidence.facts.items() if facts.kind == "text" and _all_units(facts)), "")


def _names(facts: Facts) -> bool:
    """Whether a column holds a few texts that return."""
    return facts.kind == "text" and 1 < len(set(facts.texts)) <= min(MOST_SERIES, len(facts.texts) // _LEAST_ROWS)


def _turns(facts: Facts) -> bool:
    """Whether names come by turns: an operator's remark, or a phase of a test, stays for many rows."""
    texts = facts.texts
    same = sum(1 for before, after in pairwise(texts) if before == after)
    return same <= _MOST_STEADY * len(texts)


def _states(facts: Facts) -> bool:
    """Whether texts say how something is: a relay, a fault, a direction."""
    return {text.strip().casefold() for text in facts.texts} <= _STATES


def _all_units(facts: Facts) -> bool:
    texts = [text.strip() for text in facts.texts if text.strip()]
    return bool(texts) and sum(1 for text in texts if unit_of(text)) >= _LEAST_UNITS * len(texts)


def _time_like(facts: Facts) -> bool:
    return bool(TIME.fullmatch(facts.named[0].casefold())) or bool((facts.steps >= 0).all())
