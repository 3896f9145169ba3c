"""Where rows come from: a port that is pulled out and plugged in, an emulated board that breaks, a run file."""

from __future__ import annotations

import json
import os
import pty
import re
import tty
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from gen.coefficients import Coefficients, load, parse
from gen.emulate.board import Board
from gen.emulate.firmware import build_firmware
from gen.emulate.plants.model_plant import ModelPlant
from gen.emulate.plants.plant import Changeable
from gen.emulate.plants.rig import RigPlant
from gen.errors import InputError
from gen.live.emulated import EmulatedSource, heat_of
from gen.live.known import Known, known_of
from gen.live.pace import Pace
from gen.live.port import PortSource
from gen.live.replay import ReplaySource
from gen.live.view import View
from gen.runs.faults import declared_faults
from tests.examples import ROOT
from tests.live.serving import HEADER, wait_until

EXAMPLE = ROOT / "examples" / "my1016_rig" / "coeffs.json"


class Plugged:
    """A board's end of a serial line, found under a name that stays."""

    def __init__(self, link: Path) -> None:
        self.board, self._port = pty.openpty()
        tty.setraw(self._port)
        link.unlink(missing_ok=True)
        link.symlink_to(os.ttyname(self._port))
        os.set_blocking(self.board, False)

    def print(self, data: bytes) -> None:
        os.write(self.board, data)

    def told(self) -> bytes:
        try:
            return os.read(self.board, 4096)
        except BlockingIOError:
            return b""

    def pull(self) -> None:
        os.close(self._port)
        os.close(self.board)


def test_a_port_is_opened_anew_when_it_comes_back(tmp_path: Path) -> None:
    link = tmp_path / "board"
    board = Plugged(link)
    source = PortSource(str(link), 115200, View(Known()))
    source.start()
    try:
        wait_until(lambda: source.connected)
        board.print(HEADER + b"0,5,30,30,0,0,0\n1,5,31,30,0,0,0\n2,5,3")
        wait_until(lambda: source.view.recorder.rows == 2)
        board.pull()
        wait_until(lambda: source.link.startswith("waiting for the port"))
        with pytest.raises(InputError, match="nothing was sent"):
            source.send(b"arm\n90\n")
        board = Plugged(link)
        wait_until(lambda: source.connected)
        board.print(b"\n# reset: power\n" + HEADER + b"0,6,32,30,0,0,0\n")
        wait_until(lambda: source.view.recorder.rows == 3)
        source.send(b"arm\n90\n")
        came = bytearray()
        wait_until(lambda: came.extend(board.told()) or b"90\n" in came)  # type: ignore[func-returns-value]
    finally:
        source.stop()
        board.pull()
    status = source.view.status()
    assert (status["rows"], status["garbled"], status["restarts"]) == (3, 1, 1)
    times = [row[0] for row in source.view.since(0)]
    assert times == sorted(set(times))  # type: ignore[type-var]
    assert not source.connected


def test_a_port_that_is_not_there_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"cannot be opened: .*No such file") as caught:
        PortSource(str(tmp_path / "board"), 115200, View(Known()))
    assert caught.value.file == str(tmp_path / "board")


def test_a_board_that_says_nothing_is_asked_for_its_columns(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("gen.live.port._ASK_EVERY_S", 0.2)
    board = Plugged(tmp_path / "board")
    source = PortSource(str(tmp_path / "board"), 115200, View(Known()))
    source.start()
    try:
        came = bytearray()
        wait_until(lambda: came.extend(board.told()) or b"?\n" in came)  # type: ignore[func-returns-value]
    finally:
        source.stop()
        board.pull()


def quick_tree() -> dict[str, Any]:
    """The example with one rule, which a bearing that is 1.5 K over the model raises after five seconds."""
    tree: dict[str, Any] = json.loads(EXAMPLE.read_text(encoding="utf-8"))
    tree["alarms"] = [
        {
            "name": "bearing_warm",
            "kind": "above_model",
            "component": "bearing",
            "speed_percent": [10, 100],
            "persistence_s": 5,
            "threshold_K": 3.0,
            "hysteresis_K": 0.5,
        }
    ]
    return tree


@pytest.fixture(scope="module")
def quick() -> Coefficients:
    return parse(json.dumps(quick_tree()).encode())


FAULT = "heat:bearing=+2000%"


@pytest.fixture
def source(quick: Coefficients, tmp_path_factory: pytest.TempPathFactory) -> Iterator[EmulatedSource]:
    made = emulated(quick, tmp_path_factory.getbasetemp())
    made.start()
    try:
        wait_until(lambda: made.view.recorder.rows > 2)
        yield made
    finally:
        made.stop()


def emulated(
    quick: Coefficients, cache: Path, pace: Pace | None = None, *, leads: bool = True, rig: bool = False
) -> EmulatedSource:
    """An emulated board of a file, whose motor is the file itself, or the rig."""
    wiring = quick.document.wiring
    assert wiring is not None
    channels = tuple(chip.channel for chip in wiring.thermocouples)
    plant: Changeable = ModelPlant(quick, channels, pulses_per_revolution=500)
    if rig:
        plant = RigPlant(channels, pulses_per_revolution=500)
    elf = build_firmware(quick, "fixed", "table", "quick.json", cache).elf
    board = Board(elf, cache, wiring, plant, encoder="batched")
    view = View(known_of(quick), heat_of(quick, board))
    return EmulatedSource(quick.name, board, plant, channels, (FAULT,), pace or Pace(1000.0), (), view, leads=leads)


def column(source: EmulatedSource, name: str) -> list[float | None]:
    place = source.view.columns().index(name)
    return [row[place] for row in source.view.since(0)]


def test_a_command_reaches_the_emulated_firmware(source: EmulatedSource) -> None:
    assert set(column(source, "pwm")) == {0.0}
    source.send(b"arm\n90\n")
    wait_until(lambda: column(source, "pwm")[-1] == 90.0)
    speed = [value for value in column(source, "speed_rpm") if value is not None]
    wait_until(lambda: (column(source, "speed_rpm")[-1] or 0.0) > 500.0)
    assert speed[0] == 0.0


def test_a_fault_that_is_switched_on_raises_the_board_s_alarm_and_ends_it(source: EmulatedSource) -> None:
    source.send(b"arm\n200\n")
    wait_until(lambda: source.view.recorder.rows > 60)
    assert source.view.status()["alarms"] == []
    source.change("fault", FAULT)
    wait_until(lambda: source.view.status()["alarms"] == ["bearing_warm"])
    source.change("fault", "none")
    source.stop()
    comments = dict(re.findall(r"^# (\w+): (.*)$", source.view.text(), re.MULTILINE))
    assert declared_faults(comments) == [comments["motor_fault"]]
    assert comments["motor_fault"].startswith(f"{FAULT} from ")
    assert any("alarm bearing_warm" in line for line in source.view.status()["lines"])
    assert any(f"fault of the motor is now {FAULT}" in line for line in source.view.status()["lines"])


def test_a_fault_of_any_size_can_be_typed_and_one_that_cannot_be_is_said(source: EmulatedSource) -> None:
    source.send(b"arm\n200\n")
    source.change("own fault", "heat:rotor=+20%")
    wait_until(lambda: any('has no part "rotor"' in line for line in source.view.status()["lines"]))
    assert settings(source) == {"fault": "none", "own fault": ""}  # what it cannot have is not set
    source.change("own fault", FAULT)
    wait_until(lambda: source.view.status()["alarms"] == ["bearing_warm"])
    assert settings(source) == {"fault": "none", "own fault": FAULT}
    source.change("fault", FAULT)
    wait_until(lambda: settings(source) == {"fault": FAULT, "own fault": ""})


def settings(source: EmulatedSource) -> dict[str, float | str]:
    """What a page that opens now would show of the motor's faults."""
    return {control.name: control.value for control in source.controls() if "fault" in control.name}


def test_a_sensor_that_is_broken_on_the_page_is_not_believed_by_the_board(source: EmulatedSource) -> None:
    source.change("sensor casing", "open")
    wait_until(lambda: {"channel": "casing", "state": "open"} in source.view.status()["sensors"])
    assert column(source, "casing_degC")[-1] is None
    source.change("sensor casing", "none")
    wait_until(lambda: {"channel": "casing", "state": "ok"} in source.view.status()["sensors"])


def test_the_room_can_be_warmed(source: EmulatedSource) -> None:
    source.change("ambient", 45.0)
    wait_until(lambda: (column(source, "ambient_degC")[-1] or 0.0) >= 44.75)


def test_the_rig_s_shaft_can_be_loaded(quick: Coefficients, source: EmulatedSource, tmp_path: Path) -> None:
    assert "load" not in {control.name for control in source.controls()}  # of a file, which knows no torque
    loaded = emulated(quick, tmp_path, rig=True)
    slider = next(control for control in loaded.controls() if control.name == "load")
    assert (slider.form, slider.low, slider.high) == ("slider", 0.0, 1.0)
    loaded.start()
    try:
        wait_until(lambda: loaded.view.recorder.rows > 2)
        loaded.send(b"arm\n200\n")
        wait_until(lambda: (column(loaded, "speed_rpm")[-1] or 0.0) > 1900.0)
        loaded.change("load", 1.0)
        wait_until(lambda: (column(loaded, "speed_rpm")[-1] or 0.0) < 1700.0)
        loaded.change("load", 0.0)
        wait_until(lambda: (column(loaded, "speed_rpm")[-1] or 0.0) > 1900.0)
        with pytest.raises(InputError):
            loaded.change("load", -0.1)
    finally:
        loaded.stop()
    comments = re.findall(r"^# shaft_load: (.*) Nm from", loaded.view.text(), re.MULTILINE)
    assert comments == ["1", "0"]
    assert declared_faults(dict(re.findall(r"^# (\w+): (.*)$", loaded.view.text(), re.MULTILINE))) == []


@pytest.mark.parametrize(
    ("name", "value"),
    [("ambient", 200.0), ("ambient", "x"), ("fault", "heat:rotor=+1%"), ("pace", 0.0), ("colour", 1.0)],
)
def test_what_cannot_be_set_is_refused(source: EmulatedSource, name: str, value: float | str) -> None:
    with pytest.raises(InputError):
        source.change(name, value)


def replayed(path: Path, model: Coefficients | None = None) -> View:
    view = View(Known() if model is None else known_of(model))
    source = ReplaySource(path, model, Pace(1e5), view)
    source.start()
    wait_until(lambda: source.link == "came to its end")
    source.stop()
    with pytest.raises(InputError):
        source.send(b"arm\n90\n")
    return view


def test_a_run_file_is_played_as_it_stands(tmp_path: Path) -> None:
    path = tmp_path / "run.csv"
    path.write_text(
        "# who: Zo\u00eb\ntime_s,pwm,coil_degC,Power (W),2nd,sensors\n-1,5,30,1e-7,,1\n3,-5,,12.5,1,10\n",
        encoding="utf-8",
    )
    view = replayed(path)
    assert view.columns() == ["time_s", "pwm", "coil_degC", "Power__W_", "_2nd", "sensors"]
    assert view.since(0) == [[-1.0, 5.0, 30.0, 1e-7, None, 1.0], [3.0, -5.0, None, 12.5, 1.0, 10.0]]
    assert view.status()["garbled"] == 0


def test_a_run_gets_the_model_s_temperatures_beside_it(tmp_path: Path) -> None:
    model = load(EXAMPLE)
    path = tmp_path / "run.csv"
    rows = "".join(f"{10 * k},153,30,30,{11000 if k else 0}\n" for k in range(60))
    path.write_text("time_s,pwm,brush_degC,ambient_degC,sensors\n" + rows, encoding="utf-8")
    view = replayed(path, model)
    columns = view.columns()
    place = {name: columns.index(name) for name in ("brush_model_degC", "brush_low", "brush_high")}
    modelled = [row[place["brush_model_degC"]] for row in view.since(0)]
    assert modelled[0] == pytest.approx(30.0)
    assert np.all(np.diff(np.array(modelled, dtype=float)) > 0.0)
    assert all(row[place["brush_low"]] < row[place["brush_high"]] for row in view.since(0))  # type: ignore[operator]
    assert [sensor["state"] for sensor in view.status()["sensors"]] == ["open", "open", "ok", "ok", "ok"]
