"""The emitted firmware itself, run in time on the emulated board with a bench plant."""

from __future__ import annotations

import subprocess
import sys
import time
from collections.abc import Callable
from functools import partial
from itertools import pairwise
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import pytest

from gen.avr.simulator import FREQUENCY_HZ
from gen.coefficients import load
from gen.coefficients.wiring import ChannelInput, Wiring
from gen.emulate.board import Board, EncoderMode
from gen.emulate.firmware import Firmware, build_firmware
from gen.emulate.plants.plant import STEP_S, BenchPlant, Plant, Reading
from gen.emulate.plants.rig import RigPlant
from gen.emulate.results import results_of, summary
from gen.emulate.session import Event, EventKind, Session, _Runner, run_session
from gen.emulate.terminal import PseudoTerminal
from gen.emulate.wiring.devices import ResetCause
from gen.runs import read_run
from tests.command import GEN
from tests.device.variants import variant
from tests.examples import ROOT
from tests.work import HANGS_S, lines

COEFFICIENTS = load(ROOT / "examples" / "my1016" / "coeffs.json")
TEMPERATURES = {"brush": 31.0, "bearing": 30.5, "magnet": 30.25, "casing": 30.0, "ambient": 29.75}
PULSES_PER_S = 22_083.0

MakeBoard = Callable[..., Board]


@pytest.fixture(scope="session")
def firmware(cache: Path) -> Firmware:
    return build_firmware(COEFFICIENTS, "fixed", "table", "coeffs.json", cache)


@pytest.fixture
def make_board(firmware: Firmware) -> MakeBoard:
    def make(plant: Plant | None = None, encoder: EncoderMode = "batched") -> Board:
        wiring = COEFFICIENTS.document.wiring
        assert isinstance(wiring, Wiring)
        return Board(firmware.elf, firmware.cache, wiring, plant or bench(), encoder=encoder)

    return make


def bench() -> BenchPlant:
    return BenchPlant(dict(TEMPERATURES), PULSES_PER_S)


def column(session: Session, name: str) -> list[str]:
    (part,) = session.recorder.parts
    place = part.columns.index(name)
    return [row.split(",")[place] for row in part.rows]


def test_the_firmware_measures_what_the_plant_has_and_drives_what_it_is_told(make_board: MakeBoard) -> None:
    plant = bench()
    session = run_session(make_board(plant), 20.0, profile=((0.0, 153), (10.0, -51)))
    assert (session.recorder.garbled, session.recorder.unheaded) == (0, 0)
    for name, value in TEMPERATURES.items():
        assert set(column(session, f"{name}_degC")) == {f"{value:.2f}"}
    assert {"153", "-51"} <= set(column(session, "pwm"))
    # Timer 0 keeps its pin high for OCR + 1 counts of 256.
    assert {153, 154} & set(plant.pwm_seen) and {-51, -52} & set(plant.pwm_seen)
    assert session.seconds == pytest.approx(20.0, abs=0.001)
    # When the last row was printed, the board's clock and the simulation's were this far apart.
    assert session.time_zero_s is not None
    last = float(column(session, "time_s")[-1]) + session.time_zero_s
    assert 18.5 < last <= 20.0
    assert session.time_zero_s > 0.9  # four samples are confirmed before the model starts
    rpm = [float(text) for text in column(session, "speed_rpm")][3:8]
    assert rpm == pytest.approx([153 / 255 * PULSES_PER_S / 500 * 60] * 5, rel=0.01)


@pytest.mark.parametrize("name", ["directed", "directed_low"])
def test_the_plant_gets_the_signed_pwm_of_a_driver_with_a_direction_pin(name: str, cache: Path) -> None:
    coefficients = variant(name)
    wiring = coefficients.document.wiring
    assert isinstance(wiring, Wiring)
    plant = bench()
    built = build_firmware(coefficients, "fixed", "table", "coeffs.json", cache)
    session = run_session(
        Board(built.elf, built.cache, wiring, plant), 15.0, profile=((0.0, 153), (6.0, -51), (11.0, 0))
    )
    forward, reverse = (153, -52) if name == "directed_low" else (153, -51)  # Timer 0: (OCR + 1) / 256
    acted = [pwm for i, pwm in enumerate(plant.pwm_seen) if i == 0 or pwm != plant.pwm_seen[i - 1]]
    assert acted == [0, forward, reverse, 0]
    assert list(dict.fromkeys(column(session, "pwm"))) == ["153", "-51", "0"]


def test_true_and_batched_pulses_give_the_same_speed(make_board: MakeBoard) -> None:
    speeds = {}
    for encoder in ("true", "batched"):
        session = run_session(make_board(encoder=encoder), 8.0, profile=((0.0, 255),))
        speeds[encoder] = [float(text) for text in column(session, "speed_rpm")][3:]
    assert speeds["true"] == pytest.approx(speeds["batched"], rel=0.01)
    assert speeds["true"][0] == pytest.approx(2650.0, rel=0.01)


def test_the_profile_goes_on_after_a_power_cut(make_board: MakeBoard) -> None:
    plant = bench()
    events = [Event(10.1, "power_cut", 5.0)]
    session = run_session(make_board(plant), 30.0, profile=((0.0, 102),), events=events)
    assert session.restarts_s == pytest.approx([15.1], abs=0.05)
    off = plant.pwm_seen[int(10.5 / STEP_S) : int(15.0 / STEP_S)]
    assert set(off) == {0}
    assert plant.pwm_seen[-1] in (102, 103)
    assert len(plant.pwm_seen) == 30.0 / STEP_S + 1  # the plant runs on while the board is off
    times = [float(text) for text in column(session, "time_s")]
    assert all(b > a for a, b in pairwise(times))
    assert times[-1] == pytest.approx(30.0 - (session.time_zero_s or 0.0), abs=1.5)
    assert any("restart" in line for line in session.recorder.parts[0].comments)


def test_an_unbelieved_sample_is_told_and_its_field_empty(make_board: MakeBoard) -> None:
    plant = bench()
    board = make_board(plant)
    plant.words["magnet"] = 0x0004
    session = run_session(board, 20.0)
    assert len(session.recorder.parts[0].rows) > 5  # once the board no longer waits for the sensor
    assert set(column(session, "magnet_degC")) == {""}
    results = results_of(COEFFICIENTS.document, board, session)
    (item,) = results.disbelieved
    assert (item.channel, item.code) == ("magnet", 1)
    found = summary(results, board, session, {"seed": 0})
    assert found["seed"] == 0
    assert found["board"]["thermocouples"]["magnet"]["reads"] >= 15
    assert 0.0 < found["board"]["awake_share"] < 0.1  # mostly the sum over the program at the start


def test_noise_on_the_serial_line_hangs_nothing(make_board: MakeBoard) -> None:
    board = make_board()
    session = run_session(board, 15.0, profile=((0.0, 51),), events=[Event(4.0, "flood", 4.0)])
    times = [float(text) for text in column(session, "time_s")]
    assert times[-1] > 12.0
    assert max(b - a for a, b in pairwise(times)) <= 1.0
    assert session.restarts_s == []
    assert set(column(session, "pwm")[2:]) == {"51"}


def test_simulated_time_costs_few_executed_cycles_and_lines(make_board: MakeBoard) -> None:
    """At full speed, where most pulses come. What the firmware sleeps through costs nothing, and nothing adds up.

    How many simulated seconds that makes in one here: `benchmarks/speed.py`.
    """
    executed, made = [], []
    for seconds in (20.0, 60.0):
        board = make_board()
        made.append(lines(partial(run_session, board, seconds, profile=((0.0, 255),))))
        executed.append(board.mega.cycle - board.mega.asleep)
    assert executed[1] - executed[0] < 0.03 * 40.0 * FREQUENCY_HZ
    steps = 40.0 / STEP_S
    assert made[1] - made[0] < 300 * steps
    assert made[1] < 3.1 * made[0]


def test_gen_log_hears_every_row_of_the_emulated_board(make_board: MakeBoard, tmp_path: Path) -> None:
    out = tmp_path / "logged.csv"
    with PseudoTerminal(tmp_path / "port") as terminal:
        command = [*GEN, "log", str(tmp_path / "port"), "--out", str(out)]
        with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as log:
            terminal.wait()
            while b"?" not in terminal.read():  # it asks a silent board, so it hears by now
                time.sleep(0.05)
            session = run_session(make_board(), 60.0, profile=((0.0, 153),), terminal=terminal)
            terminal.drain()
            log.terminate()
            stdout, stderr = log.communicate(timeout=HANGS_S)
    assert (log.returncode, stderr) == (0, "")
    assert "0 garbled" in stdout
    assert out.read_text(encoding="utf-8") == session.recorder.parts[0].text()
    assert len(read_run(out).time_s) == session.recorder.rows >= 58


def test_the_same_seed_gives_the_same_bytes(make_board: MakeBoard) -> None:
    sent = []
    for seed in (7, 7, 8):
        plant = RigPlant(TEMPERATURES, pulses_per_revolution=500, seed=seed)
        sent.append(bytes(run_session(make_board(plant), 10.0, profile=((0.0, 153),)).sent))
    assert sent[0] == sent[1] != sent[2]


def test_a_recorder_that_comes_late_can_ask_for_the_header(make_board: MakeBoard) -> None:
    board = make_board()
    board.mega.run_seconds(5.0)
    assert b"time_s,pwm" in board.mega.uart.take()
    session = run_session(board, 10.0, events=[Event(6.0, "send", data=b"?\n")])
    assert session.recorder.headers == 1
    assert session.recorder.garbled == 0
    assert session.recorder.rows >= 3
    assert session.recorder.parts[0].restarts == []


@pytest.mark.parametrize("busy_s", [0.01, 0.05])
def test_the_pace_is_kept(make_board: MakeBoard, monkeypatch: pytest.MonkeyPatch, busy_s: float) -> None:
    """Four simulated seconds in one, however long this computer needs for a step of them."""
    clock = [100.0]

    def sleep(seconds: float) -> None:
        clock[0] += seconds

    def progress(session: Session) -> None:
        clock[0] += busy_s

    here = SimpleNamespace(monotonic=lambda: clock[0], sleep=sleep)
    monkeypatch.setattr(sys.modules[run_session.__module__], "time", here)
    run_session(make_board(), 4.0, pace=4.0, progress=progress)
    assert clock[0] - 100.0 == pytest.approx(1.0, abs=0.001 + busy_s)


@pytest.mark.parametrize("baud", [9600, 115200])
def test_noise_on_the_line_lasts_as_long_as_it_says(baud: int) -> None:
    """A byte takes ten bits: start, eight, stop."""
    sent = bytearray()
    board = SimpleNamespace(
        mega=SimpleNamespace(uart=SimpleNamespace(send=sent.extend), resets=0), wiring=SimpleNamespace(serial_baud=baud)
    )
    runner = _Runner(cast(Board, board), Session(), (), None)
    runner.happen(Event(0.0, "flood", 4.0))
    assert len(sent) * 10 / baud == pytest.approx(4.0, abs=0.002)
    assert b"\n" in sent[:200]


@pytest.mark.parametrize(("kind", "cause"), [("power_cut", ResetCause.POWER_ON), ("brown_out", ResetCause.BROWN_OUT)])
def test_the_chip_is_told_how_it_lost_its_power(kind: EventKind, cause: ResetCause) -> None:
    cuts: list[tuple[float, ResetCause]] = []
    mega = SimpleNamespace(resets=0, cut_power=lambda off_s, *, cause, seed: cuts.append((off_s, cause)))
    _Runner(cast(Board, SimpleNamespace(mega=mega)), Session(), (), None).happen(Event(3.0, kind, 1.5))
    assert cuts == [(1.5, cause)]


def test_channels_of_the_plant_reach_their_pins() -> None:
    """10 A for each volt around 2.5 V; a contact is closed to ground."""
    inputs = (
        ChannelInput(column="current_A", analog_pin=54, zero_V=2.5, per_V=10.0, min=-20.0, max=20.0),
        ChannelInput(column="fan", contact_pin=62),
    )
    volts: dict[int, float] = {}
    levels: dict[int, bool | None] = {}
    board: Any = Board.__new__(Board)
    pins = SimpleNamespace(drive_analog=volts.__setitem__, drive=levels.__setitem__)
    board.mega = SimpleNamespace(pins=pins)
    board.wiring, board.thermocouples = Wiring(channels=inputs), {}
    board._show(Reading({}, 0, {"current_A": 5.0, "fan": 1.0}))
    assert volts[54] == pytest.approx(3.0)
    assert levels[62] is False
    board._show(Reading({}, 0, {"current_A": -12.0, "fan": 0.0}))
    assert volts[54] == pytest.approx(1.3)
    assert levels[62] is None
