"""The sources of a page, from what its command was told."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from gen.coefficients import Coefficients
from gen.emulate.board import Board
from gen.emulate.firmware import build_firmware, cache_folder
from gen.emulate.scenario import Scenario, make_plant
from gen.errors import InputError
from gen.files import shown_name
from gen.live.emulated import FASTEST, EmulatedSource, heat_of
from gen.live.heat import HeatFromRows
from gen.live.known import Known, known_of
from gen.live.pace import Pace
from gen.live.port import PortSource
from gen.live.replay import ReplaySource
from gen.live.source import Source
from gen.live.view import View
from gen.record.profile import parse_profile


@dataclass(frozen=True)
class Emulation:
    """What an emulated board and its motor are made of.

    Parameters
    ----------
    known, file
        The coefficient file, and where it is.
    plant, ambient_degC
        The motor, as ``gen emulate`` has it, and its room.
    profile
        PWM to begin with, as ``gen emulate`` has it.
    """

    known: Coefficients
    file: Path
    plant: str | None
    ambient_degC: float
    profile: str


def make_sources(
    given: Sequence[str | Path], known: Coefficients | None, emulations: Sequence[Emulation], speed: float, baud: int
) -> list[Source]:
    """Make what a page shows: ports and runs, then emulated boards.

    Parameters
    ----------
    given
        Run files (paths) and ports (names).
    known
        The coefficient file of those.
    emulations
        Emulated boards.
    speed
        Simulated seconds in a second here, for all that are not real; the first of them has the control.
    baud
        Of ports.

    Raises
    ------
    InputError
        When a port cannot be opened, a file is none, or nothing can be emulated of it.
    """
    pace = Pace(speed, FASTEST) if emulations else Pace(speed)
    sources: list[Source] = []
    for name in given:
        view = View(Known()) if known is None else View(known_of(known), HeatFromRows(known))
        if isinstance(name, Path):
            sources.append(ReplaySource(name, known, pace, view, leads=not _paced(sources)))
        else:
            sources.append(PortSource(name, baud, view))
    for emulation in emulations:
        sources.append(_emulated(emulation, pace, leads=not _paced(sources)))
    return sources


def _paced(sources: Sequence[Source]) -> bool:
    """Whether one of them has the control of the pace already: a port's time is the world's."""
    return any(source.kind != "port" for source in sources)


def _emulated(emulation: Emulation, pace: Pace, *, leads: bool) -> EmulatedSource:
    known, file = emulation.known, emulation.file
    wiring = known.document.wiring
    if wiring is None or not wiring.thermocouples:
        raise InputError("has no thermocouples: there is nothing to emulate", file=str(file), place="$.wiring")
    steps = parse_profile(emulation.profile) if emulation.profile else ()
    plant = make_plant(Scenario(plant=emulation.plant, ambient=str(emulation.ambient_degC)), known, file).plant
    cache = cache_folder()
    elf = build_firmware(known, "fixed", "table", shown_name(file), cache).elf
    board = Board(elf, cache, wiring, plant, encoder="batched")
    channels = tuple(chip.channel for chip in wiring.thermocouples)
    view = View(known_of(known), heat_of(known, board))
    return EmulatedSource(
        known.name,
        board,
        plant,
        channels,
        plant.typical_faults,
        pace,
        steps,
        view,
        emulation.ambient_degC,
        leads=leads,
    )
