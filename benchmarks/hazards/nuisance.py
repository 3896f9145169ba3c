"""A healthy motor for hours: does the board stop it?"""

from __future__ import annotations

import random
import re
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass

from benchmarks.hazards.boards import Variant, variant
from gen.emulate.board import Board
from gen.emulate.plants.rig import RigPlant
from gen.emulate.session import Event, run_session
from gen.rig import SensorConfig

PIECE_H = 1.0
"""Each piece is a board that was just switched on."""
ASKED_S = 10.0
"""The computer that drives asks for the status so often."""
_STOP = re.compile(rb"# event: ([\d.]+) protection (\w+) begins")


@dataclass(frozen=True)
class Healthy:
    """How long the motor ran, how many commands it got, and what the board did to it."""

    hours: float
    commands: int
    stops: tuple[str, ...]


def run_healthy(hours: float, seed: int, jobs: int) -> Healthy:
    """Run the simulated motor of `gen.rig` at random commands.

    Parameters
    ----------
    hours
        Simulated time, h, in pieces of `PIECE_H`.
    seed
        Of the commands and of the sensors' noise.
    jobs
        Processes.
    """
    variant("relay")
    pieces = max(1, round(hours / PIECE_H))
    with ProcessPoolExecutor(jobs) as pool:
        found = list(pool.map(_piece, range(seed * 1000, seed * 1000 + pieces)))
    stops = tuple(stop for piece in found for stop in piece.stops)
    return Healthy(sum(piece.hours for piece in found), sum(piece.commands for piece in found), stops)


def commands(seed: int, seconds: float) -> list[Event]:
    """Random PWMs in both directions, held for 5 s to 10 min, and duty cycles of seconds."""
    drawn = random.Random(seed)
    events, time_s = [], 6.0
    while time_s < seconds:
        if drawn.random() < 0.2:
            pwm, on_s, off_s = drawn.randrange(60, 256), drawn.uniform(2.0, 30.0), drawn.uniform(2.0, 30.0)
            for _ in range(drawn.randrange(3, 12)):
                events += [Event(time_s, "command", pwm=pwm), Event(time_s + on_s, "command", pwm=0)]
                time_s += on_s + off_s
        else:
            pwm = drawn.choice((0, 1, 1, 1, -1)) * drawn.randrange(20, 256)
            events.append(Event(time_s, "command", pwm=pwm))
            time_s += drawn.uniform(5.0, 600.0)
    return [event for event in events if event.time_s < seconds]


def _piece(seed: int) -> Healthy:
    board, seconds = variant("relay"), PIECE_H * 3600.0
    encoder = board.wiring.encoder
    assert encoder is not None
    drawn = random.Random(f"{seed} start")
    room = drawn.uniform(5.0, 40.0)
    plant = RigPlant(
        [chip.channel for chip in board.wiring.thermocouples],
        sensors={chip.channel: SensorConfig() for chip in board.wiring.thermocouples},
        ambient_degC=room,
        pulses_per_revolution=encoder.pulses_per_revolution,
        seed=seed,
    )
    given = commands(seed, seconds)
    asked = [Event(ASKED_S * k + 0.1, "send", data=b"?\n") for k in range(1, int(seconds / ASKED_S))]
    emulated = Board(board.firmware.elf, board.firmware.cache, board.wiring, plant, encoder="batched")
    try:
        sent = bytes(run_session(emulated, seconds, events=[*given, *asked]).sent)
    finally:
        emulated.close()
    return Healthy(PIECE_H, len(given), tuple(_stops(board, seed, sent)))


def _stops(board: Variant, seed: int, sent: bytes) -> list[str]:
    """What stops, of all that the board did."""
    found = [(match[1].decode(), match[2].decode()) for match in _STOP.finditer(sent)]
    return [
        f"seed {seed}, {time_s} s: {label}"
        for time_s, label in found
        if board.actions.get(label) in ("stop", "open_relay", "derate")
    ]
