"""Which columns of a table with a row for each reading hold the names, the values and their units."""

from __future__ import annotations

from collections.abc import Collection
from itertools import pairwise

import numpy as np

from gen.importing.guessing.evidence import Evidence, Facts
from gen.importing.guessing.names import SERIES, TIME
from gen.importing.units import unit_of

MOST_SERIES = 200
_VALUES = (
    *("value", "_value", "state", "reading", "wert", "messwert", "payload", "varvalue", "valeur", "valore", "valor"),
    *("waarde", "measured_value", "val"),
)
_MOST_STEADY = 0.8
"""Of the rows, those that may have the name of the row before: an operator's remark changes more rarely."""
_LEAST_ROWS = 3
"""Of each name, on average."""
_LEAST_UNITS = 0.9
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
    named = [facts for facts in texts if SERIES.fullmatch(facts.name.casefold())]
    by_turns = [facts for facts in texts if _turns(facts) and not _all_units(facts) and not _states(facts)]
    values = value_column(evidence)
    if not named and (not values or len(by_turns) != 1):
        return None
    found = (named or by_turns)[0].name
    return found, found if not values or values.casefold() in _VALUES else f"{found},{values}"


def value_column(evidence: Evidence) -> str:
    """The column of the values: by its name, else the only one of numbers that move; empty where nobody knows."""
    named = [name for name in evidence.facts if name.casefold() in _VALUES]
    if named:
        return named[0] if len(named) == 1 else ""
    moving = [f for f in evidence.numbers if len(np.unique(f.values)) > 1 and not _time_like(f)]
    return moving[0].name if len(moving) == 1 else ""


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
