"""Sensor and board faults, on this computer and on the emulated Mega: what is used of a bad sample, and how it ends.

    python benchmarks/sensor_faults_table.py [COEFFS] [--only open stuck] [--json FILE]

board: the firmware of the coefficient file (with a copy of the states in EEPROM every minute) on the emulated Mega with
the simulated motor (`gen.rig`), warm from an hour at 60 %, a row for every sample. host: the emitted C++ library (model
and checks) compiled with g++, which gets the very words that the board was given. "off by" is the largest difference of
any sample of the faulty channel that was used from the part's true temperature, beyond what the same channel shows
without a fault: a bad sample that was used would show. Times count from the fault's beginning; "again" from its end.
"""

from __future__ import annotations

import argparse
import json
import tempfile
from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from pathlib import Path

import numpy as np
from rich.box import MARKDOWN
from rich.console import Console
from rich.table import Table

from gen.coefficients import Coefficients, load
from gen.coefficients.wiring import Wiring
from gen.emulate.board import Board
from gen.emulate.firmware import Firmware, build_firmware, cache_folder
from gen.emulate.host import HostDevice
from gen.emulate.plants.plant import STEP_S, Reading
from gen.emulate.plants.rig import RigPlant
from gen.emulate.results import Results, results_of
from gen.emulate.session import Event, Session, run_session
from gen.errors import CheckFailed
from gen.rig import Profile, SensorConfig, SensorFault, warm_start

ROOT = Path(__file__).parent.parent
CHANNEL = "bearing"
INTERVAL_S = 60.0
START_S, END_S, DURATION_S = 40.0, 60.0, 90.0
STUCK_S = (40.0, 900.0, 930.0)
LATE, NOISY = 0x100, 0x4000
NO_INTERRUPTS = "board only: a host has no interrupts to be flooded"
NO_EEPROM = "board only: a host has no EEPROM"
NO_CLOCK = "board only: the library knows samples, no clock"
NO_UART = "board only: the library has no serial line"
SENSOR_FAULTS = {
    "open": SensorFault("open", START_S, END_S),
    "all 0": SensorFault("all_0", START_S, END_S),
    "all 1": SensorFault("all_1", START_S, END_S),
    "stuck": SensorFault("stuck", *STUCK_S[:2]),
    "spike": SensorFault("spike", START_S, END_S, size_K=20.0, every_s=5.0),
    "jump": SensorFault("jump", START_S, END_S, size_K=20.0),
    "jump that stays": SensorFault("jump", START_S, size_K=20.0),
    "came off": SensorFault("off", START_S, END_S),
    "noise burst": SensorFault("noise", START_S, END_S, size_K=20.0),
}


@dataclass(frozen=True)
class Judged:
    """What became of a faulty channel; times in s, None where it did not happen."""

    off_by_K: float
    flagged_s: float | None
    codes: str
    again_s: float | None

    def __str__(self) -> str:
        flagged = "never" if self.flagged_s is None else f"{self.flagged_s:.2f} s"
        again = "no" if self.again_s is None else f"{self.again_s:.2f} s"
        return f"off {self.off_by_K:.2f} K, flagged {flagged}, code {self.codes or '-'}, again {again}"


@dataclass(frozen=True)
class Line:
    """One line of the table."""

    fault: str
    host: Judged | str
    board: Judged | str
    led_s: float | None
    outcome: str


class Recorded:
    """A plant that remembers what it gave: true temperatures, words, and pulses added from outside."""

    def __init__(self, plant: RigPlant) -> None:
        self.plant = plant
        self.true: list[dict[str, float]] = []
        self.words: list[dict[str, int]] = []
        self.pwm: list[int] = []
        self.noise_pulses: Callable[[float], int] = lambda _: 0

    def step(self, pwm: int, dt_s: float) -> Reading:
        """See `gen.emulate.plants.plant.Plant.step`."""
        reading = self.plant.step(pwm, dt_s)
        self.true.append(self.plant.temperatures)
        self.words.append(dict(reading.words))
        self.pwm.append(pwm)
        return replace(reading, pulses=reading.pulses + self.noise_pulses(len(self.true) * dt_s))


class Bench:
    """Makes boards of one firmware."""

    def __init__(self, coefficients: Coefficients) -> None:
        self.coefficients = coefficients
        wiring = coefficients.document.wiring
        assert wiring is not None
        self.wiring: Wiring = wiring
        self.firmware: Firmware = build_firmware(coefficients, "fixed", "table", "coeffs.json", cache_folder())
        self._warm = warm_start(Profile((0.0,), (153,), 3600.0))

    def board(self, fault: SensorFault | None = None, *, cold: bool = False) -> tuple[Board, Recorded]:
        """Make a board with a motor; its sensors show no offset, so that what is off is the fault's."""
        channels = [chip.channel for chip in self.wiring.thermocouples]
        plant = Recorded(
            RigPlant(
                channels,
                sensors={channel: SensorConfig() for channel in channels},
                sensor_faults={CHANNEL: (fault,)} if fault else {},
                start_degC=None if cold else self._warm,
                pulses_per_revolution=self.wiring.encoder.pulses_per_revolution if self.wiring.encoder else 0,
            )
        )
        return Board(self.firmware.elf, self.firmware.cache, self.wiring, plant), plant

    def run(self, board: Board, duration_s: float, events: list[Event] | None = None) -> tuple[Session, Results]:
        """Run at 60 %, a row for every sample."""
        every_row = Event(3.0, "send", data=b"rows 1\n")
        session = run_session(board, duration_s, profile=((0.0, 153),), events=[every_row, *(events or [])])
        return session, results_of(self.coefficients.document, board, session)


def off_by(session: Session, results: Results, plant: Recorded, from_s: float, to_s: float) -> float:
    """Largest difference of a used sample of the faulty channel from the truth, K, between two times."""
    time_s = results.columns["time_s"] + (session.time_zero_s or 0.0)
    used = results.columns[f"{CHANNEL}_degC"]
    true = np.array([step[CHANNEL] for step in plant.true])
    here = (time_s >= from_s) & (time_s < to_s) & ~np.isnan(used)
    steps = np.clip((time_s[here] / STEP_S).astype(np.int64), 0, len(true) - 1)
    return float(np.max(np.abs(used[here] - true[steps]), initial=0.0))


def on_host(bench: Bench, plant: Recorded, fault: SensorFault) -> Judged:
    """Give the emitted library the words that the board was given."""
    usual = worst = 0.0
    codes: list[int] = []
    flagged = again = None
    with HostDevice(bench.coefficients) as host:
        for number, (words, true, pwm) in enumerate(zip(plant.words, plant.true, plant.pwm, strict=True)):
            code, value = host.sample(words, pwm)[CHANNEL]
            now = number * STEP_S
            off = abs(value - true[CHANNEL]) if code == 0 else 0.0
            if now < fault.start_s:
                usual = max(usual, off)
                continue
            worst = max(worst, off)
            if code:
                codes.append(code)
                flagged = now if flagged is None else flagged
                again = None
            elif again is None and flagged is not None:
                again = now
    told = " ".join(map(str, dict.fromkeys(codes)))
    return Judged(
        round(max(0.0, worst - usual), 2),
        None if flagged is None else flagged - fault.start_s,
        told,
        None if again is None else again - fault.end_s,
    )


def sensor_line(bench: Bench, name: str, fault: SensorFault) -> Line:
    """Run one sensor fault. A stuck sensor shows only while the model moves: from a cold start."""
    stuck = fault.kind == "stuck"
    duration = STUCK_S[2] if stuck else DURATION_S
    board, plant = bench.board(fault, cold=stuck)
    session, results = bench.run(board, duration)
    zero = session.time_zero_s or 0.0
    told = [
        item for item in results.disbelieved if item.channel == CHANNEL and item.from_s + zero >= fault.start_s - 0.5
    ]
    usual = off_by(session, results, plant, 5.0, fault.start_s)
    off = max(0.0, off_by(session, results, plant, fault.start_s, duration) - usual)
    led = [item.from_s for item in results.led if item.pattern == "sensor" and item.from_s >= fault.start_s]
    ends = [item.to_s for item in told]
    last = max((end for end in ends if end is not None), default=None)
    board.close()
    judged = Judged(
        round(off, 2),
        round(told[0].from_s + zero - fault.start_s, 2) if told else None,
        " ".join(dict.fromkeys(str(item.code) for item in told)),
        round(last + zero - fault.end_s, 2) if last is not None and None not in ends else None,
    )
    return Line(
        name,
        on_host(bench, plant, fault),
        judged,
        round(led[0] - fault.start_s, 2) if led else None,
        "runs on" if not session.restarts_s else "restarted",
    )


def board_line(name: str, host: str, session: Session, results: Results, *, extra: str = "") -> Line:
    """Tell how a fault of the board ended."""
    times = results.columns["time_s"]
    gap = float(np.max(np.diff(times[times > 5.0]), initial=0.0))
    late = int(np.count_nonzero(results.columns["flags"].astype(np.int64) & LATE))
    parts = [
        f"{len(session.restarts_s)} restarts",
        f"longest gap {gap:.2f} s",
        f"{late} late rows",
        f"{session.recorder.garbled} garbled",
        extra,
    ]
    noisy = int(np.count_nonzero(results.columns["flags"].astype(np.int64) & NOISY))
    flags = [text for text, count in (("late", late), ("noisy encoder", noisy)) if count]
    return Line(name, host, " ".join(flags) or "nothing to flag", None, ", ".join(part for part in parts if part))


def host_late(bench: Bench) -> str:
    """A late sample on the host: the conversion is unfinished, and the model is stepped for both samples."""
    _, plant = bench.board()
    readings = [plant.step(153, STEP_S).words for _ in range(200)]
    # The room stays as it reads: a step of it that is seen a sample later is another input, not another model.
    readings = [{**words, "ambient": readings[0]["ambient"]} for words in readings]
    with HostDevice(bench.coefficients) as late, HostDevice(bench.coefficients) as punctual:
        codes = set()
        for number, words in enumerate(readings):
            punctual.sample(words, 153)
            codes.add(late.sample(words, 153, finished=number != 150)[CHANNEL][0])
        same = late.state == punctual.state
    return f"code {max(codes - {8})}, model {'equal' if same else 'NOT equal'} to the punctual one's"


def host_reset(bench: Bench) -> str:
    """A reset on the host: states and PWM of a copy, and the model goes on."""
    _, plant = bench.board()
    readings = [plant.step(153, STEP_S).words for _ in range(100)]
    with HostDevice(bench.coefficients) as host:
        for words in readings:
            host.sample(words, 153)
        kept = host.state
        for pwm in (153, 40, 255, -90) * 50:
            host.step(pwm)
        expected = host.state
        host.resume(kept, 153)
        for pwm in (153, 40, 255, -90) * 50:
            host.step(pwm)
        return f"goes on from a copy {'bit for bit' if host.state == expected else 'NOT equally'}"


def starts(session: Session) -> list[str]:
    """How the firmware started, each time."""
    comments = [line for part in session.recorder.parts for line in part.comments]
    return [line.split(" ", 3)[3] for line in comments if "start from" in line]


def write_time(bench: Bench, from_s: float) -> float:
    """Time at which a byte of a copy is half written, s: the first after a time, found by trying."""
    board, _ = bench.board()
    bench.run(board, from_s)
    while board.seconds < from_s + 2.0 * INTERVAL_S:
        board.begin_step()
        while board.seconds < board.steps_end_s - 1e-6:
            board.mega.run_seconds(0.002)  # a byte takes 3.4 ms
            if board.mega.eeprom.busy:
                found = board.seconds
                board.close()
                return found
        board.end_step()
    raise CheckFailed(f"no copy was written to the EEPROM from {from_s:g} s on")


def board_lines(bench: Bench) -> dict[str, Callable[[], Line]]:
    """Every fault of the board."""

    def missed_deadline() -> Line:
        board, _ = bench.board()
        session, results = bench.run(board, 60.0, [Event(40.0, "held_up", 0.4)])
        codes = {item.code for item in results.disbelieved if item.from_s > 5.0}
        return board_line("missed deadline, 0.4 s", host_late(bench), session, results, extra=f"codes {sorted(codes)}")

    def storm() -> Line:
        board, plant = bench.board()
        plant.noise_pulses = lambda t: 90_000 if 40.0 <= t < 43.0 else 0
        session, results = bench.run(board, 60.0)
        return board_line("360 000 edges/s on the encoder, 3 s", NO_INTERRUPTS, session, results)

    def reset() -> Line:
        board, _ = bench.board()
        session, results = bench.run(board, 60.0, [Event(30.0, "reset")])
        return board_line("reset in mid-run", host_reset(bench), session, results, extra="; ".join(starts(session)))

    def power_cut() -> Line:
        cut_s = write_time(bench, 3.0 * INTERVAL_S)
        board, _ = bench.board()
        session, results = bench.run(board, cut_s + 30.0, [Event(cut_s, "power_cut", 2.0)])
        return board_line("power cut in an EEPROM write", NO_EEPROM, session, results, extra="; ".join(starts(session)))

    def corrupted() -> Line:
        told = []
        for damaged in (False, True):
            board, _ = bench.board()
            bench.run(board, 1.5 * INTERVAL_S)
            if damaged:
                image = bytearray(board.mega.eeprom.image)
                written = [place for place, byte in enumerate(image[:-8]) if byte != 0xFF]
                image[written[len(written) // 2]] ^= 0x10
                board.mega.eeprom.image = bytes(image)
            session, results = bench.run(board, 1.5 * INTERVAL_S + 20.0, [Event(board.seconds + 1.0, "power_cut", 1.0)])
            told += starts(session)
        extra = f"intact: {told[0]}; one bit turned: {told[1]}"
        return board_line("corrupted EEPROM", NO_EEPROM, session, results, extra=extra)

    def rollover() -> Line:
        board, _ = bench.board()
        board.mega.start_clock_at(2**32 - 30_000)
        session, results = bench.run(board, 60.0)
        return board_line("millis() rolls over after 30 s", NO_CLOCK, session, results)

    def flood() -> Line:
        board, _ = bench.board()
        session, results = bench.run(board, 60.0, [Event(30.0, "flood", 10.0)])
        extra = f"PWM stays {results.columns['pwm'][-1]:.0f}"
        return board_line("serial flood, 10 s", NO_UART, session, results, extra=extra)

    return {
        "missed deadline": missed_deadline,
        "storm": storm,
        "reset": reset,
        "power cut": power_cut,
        "corrupted EEPROM": corrupted,
        "rollover": rollover,
        "flood": flood,
    }


def main() -> None:
    """Run the faults and print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("coefficients", type=Path, nargs="?", default=ROOT / "examples" / "my1016" / "coeffs.json")
    parser.add_argument("--only", nargs="+", help="names of faults")
    parser.add_argument("--json", type=Path)
    options = parser.parse_args()
    document = json.loads(options.coefficients.read_text())
    document["wiring"]["memory"] = {"interval_s": INTERVAL_S}
    with tempfile.TemporaryDirectory() as folder:
        often = Path(folder) / options.coefficients.name
        often.write_text(json.dumps(document))
        bench = Bench(load(often))
    jobs: dict[str, Callable[[], Line]] = {
        name: (lambda name=name, fault=fault: sensor_line(bench, name, fault))  # type: ignore[misc]
        for name, fault in SENSOR_FAULTS.items()
    }
    jobs |= board_lines(bench)
    lines = []
    with Console(stderr=True).status("") as status:
        for name, job in jobs.items():
            if options.only is None or name in options.only:
                status.update(name)
                lines.append(job())
    table = Table("fault", "host", "emulated Mega", "LED, s", "the board", box=MARKDOWN)
    for line in lines:
        led = "" if line.led_s is None else f"{line.led_s:.2f}"
        table.add_row(line.fault, str(line.host), str(line.board), led, line.outcome)
    Console(width=400).print(table)
    if options.json is not None:
        options.json.write_text(json.dumps([asdict(line) for line in lines], indent=1) + "\n")


if __name__ == "__main__":
    main()
