"""Options mean what their help says, and a fault in one is named with it."""

from __future__ import annotations

from pathlib import Path

import pytest

from gen.emulate.options import parse_events, parse_sensor_faults, parse_signal, parse_start, parse_told
from gen.emulate.plants.plant import Ran
from gen.emulate.session import Event
from gen.errors import InputError
from gen.rig import NODES, SensorFault
from gen.rig.signals import value


def test_a_signal_is_a_number_pairs_or_a_file(tmp_path: Path) -> None:
    file = tmp_path / "day.csv"
    file.write_text("time_s,pwm,ambient_degC\n0,0,20\n50,0,\n100,0,30\n", encoding="utf-8")
    for text, at_50, straight in (
        ("30", 30.0, True),
        ("-5.5", -5.5, True),
        ("0:20,100:30", 25.0, True),
        ("0:20,100:30", 20.0, False),
        (str(file), 25.0, True),
    ):
        signal = parse_signal(text, "--ambient", column="ambient_degC", straight=straight)
        assert value(signal, 50.0) == at_50
        assert value(signal, 1e6) == (30.0 if ":" in text or "csv" in text else at_50)


@pytest.mark.parametrize("text", ["warm", "0:20,0:30", "0:20:3", "1:", "1e999"])
def test_a_bad_signal_is_refused(text: str) -> None:
    with pytest.raises(InputError, match="--ambient"):
        parse_signal(text, "--ambient", column="ambient_degC", straight=True)


@pytest.mark.parametrize("text", ["5000", "-300", "0:30,60:5000"])
def test_a_value_out_of_its_range_is_told_with_the_option(text: str, tmp_path: Path) -> None:
    for given in (text, str(tmp_path / "room.csv")):
        (tmp_path / "room.csv").write_text("time_s,pwm,ambient_degC\n0,0,20\n50,0,5000\n", encoding="utf-8")
        with pytest.raises(InputError, match=r"--ambient: found -?\d+, expected -273.15 to 1000"):
            parse_signal(given, "--ambient", column="ambient_degC", straight=True, within=(-273.15, 1000.0))


def test_a_warm_start_by_name_or_by_history() -> None:
    assert parse_start(None, NODES) == {}
    assert parse_start("brush=60,casing=45.5", NODES) == {"brush": 60.0, "casing": 45.5}
    assert parse_start("-153:3600", NODES) == Ran(-153, 3600.0)


@pytest.mark.parametrize("text", ["brush", "gearbox=3", "brush=hot", "300:10", "153:0", ""])
def test_a_bad_start_is_refused(text: str) -> None:
    with pytest.raises(InputError, match="--start"):
        parse_start(text, NODES)


def test_channels_are_told_over_time() -> None:
    told = parse_told(("fan=1", "current_A=0:2.5,60:4"))
    assert [value(told["current_A"], t) for t in (0.0, 59.0, 60.0)] == [2.5, 2.5, 4.0]
    assert value(told["fan"], 1e5) == 1.0


@pytest.mark.parametrize("texts", [("fan",), ("=1",), ("fan=on",), ("fan=1", "fan=2")])
def test_bad_channels_are_refused(texts: tuple[str, ...]) -> None:
    with pytest.raises(InputError, match="--channel"):
        parse_told(texts)


def test_sensor_faults() -> None:
    faults = parse_sensor_faults(("brush:open:10:20", "brush:jump:30:40:5.5", "casing:all_1:0:1"), ["brush", "casing"])
    assert faults == {
        "brush": (SensorFault("open", 10.0, 20.0), SensorFault("jump", 30.0, 40.0, size_K=5.5)),
        "casing": (SensorFault("all_1", 0.0, 1.0),),
    }


@pytest.mark.parametrize(
    "text",
    ["brush:open:10", "rotor:open:1:2", "brush:broken:1:2", "brush:open:2:1", "brush:open:x:1", "b:open:1:2:3:4"],
)
def test_a_bad_sensor_fault_is_refused(text: str) -> None:
    with pytest.raises(InputError, match="--sensor-fault"):
        parse_sensor_faults((text,), ["brush"])


def test_events() -> None:
    events = parse_events(
        100.0, button=("5", "6:2"), reset=(7.0,), power_cut=("8:3",), send=("9:rows 1",), flood=("1",)
    )
    assert Event(5.0, "press") in events and Event(8.0, "release") in events
    assert Event(8.0, "power_cut", 3.0) in events
    assert Event(9.0, "send", data=b"rows 1\n") in events
    assert Event(1.0, "flood", 1.0) in events and Event(7.0, "reset") in events


@pytest.mark.parametrize(
    "options", [{"button": ("x",)}, {"power_cut": ("5:0",)}, {"send": ("5",)}, {"reset": (100.0,)}, {"flood": ("-1",)}]
)
def test_bad_events_are_refused(options: dict[str, tuple[str, ...]]) -> None:
    with pytest.raises(InputError):
        parse_events(100.0, **options)  # type: ignore[arg-type]
