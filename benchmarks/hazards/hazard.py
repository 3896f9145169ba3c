"""What a hazard is, and a place to enter it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from benchmarks.hazards.boards import Kind
from benchmarks.hazards.scene import Scene

Script = Callable[[Scene], None]


@dataclass(frozen=True)
class Hazard:
    """One line of the table.

    Attributes
    ----------
    name, cause
        What can happen, and by what.
    script
        Lets it happen.
    board
        Which board it happens to.
    faults
        How many there are at once; the goal is about one.
    others
        Thermocouples that have a MAX31855 in place of a MAX6675.
    """

    name: str
    cause: str
    script: Script
    board: Kind = "relay"
    faults: int = 1
    others: tuple[str, ...] = ()


HAZARDS: dict[str, Hazard] = {}


def add(
    name: str, cause: str, script: Script, *, board: Kind = "relay", faults: int = 1, others: tuple[str, ...] = ()
) -> None:
    """Enter a hazard."""
    assert name not in HAZARDS, name
    HAZARDS[name] = Hazard(name, cause, script, board, faults, others)


def hazard(name: str, cause: str, *, board: Kind = "relay", faults: int = 1) -> Callable[[Script], Script]:
    """Enter the function below as a hazard's script."""

    def enter(script: Script) -> Script:
        add(name, cause, script, board=board, faults=faults)
        return script

    return enter
