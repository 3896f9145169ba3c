"""Readings that come one by one, each with its time: of brokers, of SenML, of Prometheus, of line protocol."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from gen.errors import InputError
from tests.importing.logs import TRUE, same, take, taken, write

BEGIN = 1772439300
"""2026-03-02T08:15:00 UTC."""
STEP = 10
LATER = TRUE.assign(time_s=float(STEP) * np.arange(len(TRUE)))


def times() -> Iterator[tuple[int, pd.Series]]:
    for i, row in TRUE.iterrows():
        yield BEGIN + STEP * int(str(i)), row


def iso(at: int) -> str:
    return pd.Timestamp(at, unit="s").strftime("%Y-%m-%dT%H:%M:%S+0000")


def broker(head: Callable[[int], str], prefix: str = "motor/") -> str:
    lines = []
    for at, row in times():
        lines.append(f"{head(at)}{prefix}winding {row.winding_degC}")
        lines.append(f"{head(at)}{prefix}casing " + json.dumps({"value": row.casing_degC * 1.8 + 32, "unit": "F"}))
        lines.append(f"{head(at)}{prefix}ambient {row.ambient_degC} °C")
        lines.append(f"{head(at)}{prefix}pwm {row.pwm:.0f}")
    return "\n".join(lines) + "\n"


HEADS: dict[str, Callable[[int], str]] = {
    "%I %t %p": lambda at: f"{iso(at)} ",
    "%U %t %p": lambda at: f"{at}.000000000 ",
    "ISO and colons": lambda at: f"{pd.Timestamp(at, unit='s')} : ",
    "in brackets": lambda at: f"[{pd.Timestamp(at, unit='s')}] ",
    "ts": lambda at: pd.Timestamp(at, unit="s").strftime("%b %d %H:%M:%S "),
}


@pytest.mark.parametrize("head", HEADS)
def test_messages_of_a_broker_are_joined_by_their_times(head: str, tmp_path: Path) -> None:
    log = write(tmp_path, broker(HEADS[head]), name="mqtt.log")
    run = taken(log, tmp_path / "out", units={"winding": "degC", "pwm": "counts"})
    same(run, LATER.assign(time_s=LATER["time_s"] + (0.0 if head != "ts" else run.time_s[0])))
    assert run.comments.get("started", "2026-03-02T08:15:00.000") == "2026-03-02T08:15:00.000"


@pytest.mark.parametrize("zone", ["+0100", "Z+0100"])
def test_messages_as_json(zone: str, tmp_path: Path) -> None:
    """As `mosquitto_sub -F %j` writes them; before 2.0.15 with two zones, of which the second is that of the time."""
    lines = []
    for at, row in times():
        stamp = pd.Timestamp(at + 3600, unit="s").strftime("%Y-%m-%dT%H:%M:%S.%f") + zone
        said = {"winding": row.winding_degC, "casing": row.casing_degC, "ambient": row.ambient_degC, "pwm": row.pwm}
        message = {"tst": stamp, "topic": "lab/motor", "qos": 0, "payloadlen": 9, "payload": json.dumps(said)}
        lines.append(json.dumps(message))
    run = taken(write(tmp_path, "\n".join(lines), name="m.json"), tmp_path / "out", units={"casing": "degC"})
    same(run, LATER)
    assert run.comments["started"] == "2026-03-02T08:15:00.000"


def test_a_message_that_tells_its_own_time(tmp_path: Path) -> None:
    lines = [
        "tele/motor/SENSOR "
        + json.dumps({"Time": iso(at)[:19], "DS18B20": {"Id": "0A", "Temperature": row.winding_degC}, "PWM": row.pwm})
        for at, row in times()
    ]
    run = taken(write(tmp_path, "\n".join(lines)), tmp_path / "out")
    same(run, LATER[["time_s", "pwm", "winding_degC"]], {"winding_degC": "DS18B20_degC"})


def console(*, uptime: bool, mark: str) -> str:
    """Tasmota's: what a switch does and what sensors read are messages of their own, a part of a second apart."""
    lines = ["00:00:00.001 HDW: ESP8266EX", "08:14:59.112 MQT: Attempting connection..."] if mark else []
    head, between = ("MQT: ", " = ") if mark else ("", " ")
    for at, row in times():
        clock = pd.Timestamp(at, unit="s").strftime("%H:%M:%S")
        state = {"UptimeSec": at - BEGIN + 3600} if uptime else {}
        sensors = {"Winding": {"Temperature": row.winding_degC}, "Casing": {"Temperature": row.casing_degC}}
        lines.append(f"{clock}.201 {head}tele/m/STATE{between}" + json.dumps(state | {"PWM": row.pwm}))
        lines.append(f"{clock}.521 {head}tele/m/SENSOR{between}" + json.dumps(sensors | {"TempUnit": "C"}))
    return "\n".join(lines) + "\n"


@pytest.mark.parametrize("mark", ["MQT", ""], ids=["console", "broker"])
@pytest.mark.parametrize("uptime", [True, False])
def test_a_time_that_some_messages_tell_is_not_that_of_all(uptime: bool, mark: str, tmp_path: Path) -> None:
    """The lines' own is: by how long a device runs, no row would have had a temperature."""
    run = taken(write(tmp_path, console(uptime=uptime, mark=mark)), tmp_path / "out", units={"STATE.PWM": "counts"})
    known = np.isfinite(run.temps["winding"])
    np.testing.assert_allclose(run.temps["winding"][known], TRUE["winding_degC"])
    np.testing.assert_allclose(run.time_s[known] - run.time_s[0], 0.32 + STEP * np.arange(len(TRUE)), atol=1e-6)
    assert run.pwm[known].tolist() == TRUE["pwm"].tolist()


def test_rows_of_which_none_tells_a_temperature_are_refused(tmp_path: Path) -> None:
    log = write(tmp_path, console(uptime=True, mark=""))
    with pytest.raises(InputError, match=r"no row with a time and an input has a reading of SENSOR\.Winding"):
        take(
            log,
            tmp_path / "out",
            time="STATE.UptimeSec",
            units={"STATE.PWM": "counts"},
            columns={"SENSOR.Winding.Temperature": "winding_degC"},
        )
    assert not list((tmp_path / "out").glob("*.csv"))


def test_messages_without_times_say_how_to_record_them(tmp_path: Path) -> None:
    log = write(tmp_path, broker(lambda at: ""), name="mqtt.log")
    with pytest.raises(
        InputError, match=r"or --time SECONDS .* better, record with times: mosquitto_sub -F '%U %t %p'"
    ):
        take(log, tmp_path / "out")
    same(taken(log, tmp_path / "out", time=str(STEP), units={"pwm": "counts"}), LATER)


def test_states_at_the_ends_of_topics_are_no_names(tmp_path: Path) -> None:
    """As ESPHome publishes."""
    text = broker(HEADS["%U %t %p"], "node/sensor/").replace(" {", "/state {")
    text = "\n".join(
        " ".join([at, f"{topic.removesuffix('/state')}/state", said])
        for at, topic, said in (line.split(" ", 2) for line in text.splitlines())
    )
    text = f"{BEGIN}.000000000 node/status online\n{text}"
    run = taken(write(tmp_path, text), tmp_path / "out", units={"pwm": "counts"})
    assert sorted(run.temps) == ["sensor_casing", "sensor_winding"]  # only `node` stands before all


def senml() -> list[list[dict[str, object]]]:
    packs: list[list[dict[str, object]]] = []
    for at, row in times():
        packs.append(
            [
                {"bn": "urn:dev:mac:0024befffe804ff1:", "bt": BEGIN, "n": "winding", "t": at - BEGIN, "u": "Cel"},
                {"n": "casing", "u": "K", "t": at - BEGIN, "v": row.casing_degC + 273.15},
                {"n": "ambient", "u": "Cel", "t": at - BEGIN, "v": row.ambient_degC},
                {"n": "duty", "u": "/", "t": at - BEGIN, "v": row.pwm / 255},
                {"n": "speed", "u": "1/min", "t": at - BEGIN, "v": 10.0 * row.pwm},
            ]
        )
        packs[-1][0]["v"] = row.winding_degC
    return packs


@pytest.mark.parametrize("form", ["one array", "a pack a line"])
def test_senml(form: str, tmp_path: Path) -> None:
    packs = senml()
    joined = json.dumps([record for pack in packs for record in pack], indent=1)
    log = write(tmp_path, joined if form == "one array" else "\n".join(map(json.dumps, packs)), name="log.senml")
    run = taken(log, tmp_path / "out")
    same(run, LATER.assign(speed_rpm=10.0 * LATER["pwm"]))
    assert run.comments["started"] == "2026-03-02T08:15:00.000"


def test_base_values_and_units_of_senml(tmp_path: Path) -> None:
    records: list[dict[str, object]] = [{"bn": "motor/", "bt": BEGIN, "bu": "Cel", "bv": 20.0}]
    for at, row in times():
        records.append({"n": "winding", "t": at - BEGIN, "v": round(row.winding_degC - 20.0, 1)})
        records.append({"n": "pwm", "t": at - BEGIN, "u": "%", "v": row.pwm / 2.55 - 20.0})
    run = taken(write(tmp_path, json.dumps(records), name="log.json"), tmp_path / "out")
    same(run, LATER[["time_s", "pwm", "winding_degC"]])


def exposition(stamp: Callable[[int], str], before: Callable[[int], str] = lambda at: "") -> str:
    lines = []
    for at, row in times():
        lines.append(f"{before(at)}# HELP motor_temperature_celsius Of its parts.")
        lines.append("# TYPE motor_temperature_celsius gauge")
        for part in ("winding", "casing", "ambient"):
            labels = f'{{instance="pi:9100",sensor="{part}"}}'
            lines.append(f"motor_temperature_celsius{labels} {row[f'{part}_degC']}{stamp(at)}")
        lines += ["# TYPE motor_pwm gauge", f'motor_pwm{{instance="pi:9100"}} {row.pwm:.0f}{stamp(at)}']
    return "\n".join(lines) + "\n"


SCRAPES = {
    "in ms": exposition(lambda at: f" {at}000"),
    "OpenMetrics": exposition(lambda at: f" {at}.000") + "# EOF\n",
    "a time before each": exposition(lambda at: "", lambda at: f"{at}\n"),
}


@pytest.mark.parametrize("form", SCRAPES)
def test_scrapes_of_prometheus(form: str, tmp_path: Path) -> None:
    run = taken(write(tmp_path, SCRAPES[form], name="scrape.txt"), tmp_path / "out")
    same(run, LATER)
    assert run.comments["started"] == "2026-03-02T08:15:00.000"


def test_scrapes_without_times_say_how_to_record_them(tmp_path: Path) -> None:
    log = write(tmp_path, exposition(lambda at: ""), name="scrape.txt")
    with pytest.raises(InputError, match=r"better, put the time of each scrape before it: \(date \+%s; curl"):
        take(log, tmp_path / "out")
    same(taken(log, tmp_path / "out", time=str(STEP)), LATER)


def test_a_range_of_prometheus_api(tmp_path: Path) -> None:
    """A series lacks a sample that the others have: rows stand in the order of their times all the same."""
    result: list[dict[str, object]] = []
    for name in ("pwm", "winding_degC", "casing_degC", "ambient_degC"):
        part = name.removesuffix("_degC")
        labels = {"__name__": "motor_pwm"} if name == "pwm" else {"__name__": "motor_temp_celsius", "sensor": part}
        values = [[at, str(row[name])] for at, row in times() if name != "pwm" or at != BEGIN + 5 * STEP]
        result.append({"metric": labels | {"job": "motor"}, "values": values})
    tree = {"status": "success", "data": {"resultType": "matrix", "result": result}}
    same(taken(write(tmp_path, json.dumps(tree), name="range.json"), tmp_path / "out"), LATER)


@pytest.mark.parametrize(
    ("by_series", "parts"), [(False, "000000000"), (True, "000000000"), (False, "000"), (False, "")]
)
def test_line_protocol(by_series: bool, parts: str, tmp_path: Path) -> None:
    lines = []
    for at, row in times():
        lines += [f"motor,host=pi,part={p} temp={row[f'{p}_degC']} {at}{parts}" for p in ("winding", "casing")]
        lines += [f"room,host=pi ambient={row.ambient_degC} {at}{parts}"]
        lines += [f'drive,host=pi pwm={row.pwm:.0f}i,state="runs, well" {at}{parts}']
    if by_series:  # as a database exports
        lines.sort(key=lambda line: line.split(" ")[0])
    run = taken(write(tmp_path, "\n".join(lines), name="points.txt"), tmp_path / "out")
    same(run, LATER)
    assert run.comments["started"] == "2026-03-02T08:15:00.000"


PARTS = ("pwm", "winding", "casing")
FRAME = TRUE.rename(columns=lambda name: name.removesuffix("_degC"))
MS = [1000 * (BEGIN + STEP * i) for i in range(len(TRUE))]
SERIES: dict[str, object] = {
    "Grafana's panel": [
        {"target": n, "datapoints": [[v, t] for v, t in zip(FRAME[n], MS, strict=True)]} for n in PARTS
    ],
    "Highcharts": [{"name": n, "data": [[t, v] for v, t in zip(FRAME[n], MS, strict=True)]} for n in PARTS],
    "Plotly": {"data": [{"name": n, "x": MS, "y": FRAME[n].tolist()} for n in PARTS], "layout": {"title": "motor"}},
    "ThingsBoard": {
        n: [{"ts": t, "value": str(v)} for v, t in reversed(list(zip(FRAME[n], MS, strict=True)))] for n in PARTS
    },
    "InfluxDB 1": {
        "results": [
            {
                "series": [
                    {
                        "name": "motor",
                        **({"tags": {"part": n}} if n != "pwm" else {}),
                        "columns": ["time", "pwm" if n == "pwm" else "temp"],
                        "values": [[t, v] for v, t in zip(FRAME[n], MS, strict=True)],
                    }
                    for n in PARTS
                ]
            }
        ]
    },
    "Grafana's frames": {
        "results": {
            "A": {
                "frames": [
                    {
                        "schema": {
                            "fields": [
                                {"name": "Time", "type": "time"},
                                {"name": n, "type": "number", "labels": {"part": n}, "config": {"unit": unit}},
                            ]
                        },
                        "data": {"values": [MS, (FRAME[n] * scale + offset).round(6).tolist()]},
                    }
                    for n, unit, scale, offset in (
                        ("pwm", "", 1, 0),
                        ("winding", "fahrenheit", 1.8, 32),
                        ("casing", "celsius", 1, 0),
                    )
                ]
            }
        }
    },
}


@pytest.mark.parametrize("form", SERIES)
def test_a_series_of_samples_for_each_signal(form: str, tmp_path: Path) -> None:
    log = write(tmp_path, json.dumps(SERIES[form], default=float), name="log.json")
    run = taken(log, tmp_path / "out", units={"pwm": "counts"})
    same(run, LATER[["time_s", "pwm", "winding_degC", "casing_degC"]])
    assert run.comments["started"] == "2026-03-02T08:15:00.000"


def test_series_that_nothing_tells_apart_are_not_mixed(tmp_path: Path) -> None:
    tree = [{"target": "motor", "datapoints": [[v, t] for v, t in zip(FRAME[n], MS, strict=True)]} for n in PARTS]
    with pytest.raises(InputError):
        take(write(tmp_path, json.dumps(tree, default=float), name="log.json"), tmp_path / "out", input="100")


def test_samples_without_as_many_times_are_refused_in_a_line(tmp_path: Path) -> None:
    tree = [{"name": n, "x": MS, "y": FRAME[n].tolist()} for n in PARTS]
    frame = {"schema": {"fields": [{"name": "t", "type": "time"}, {"name": "w"}]}, "data": {"values": [MS, [1.0, 2.0]]}}
    for odd in (
        {"frames": [frame]},
        [{**tree[0], "y": [1.0, 2.0, 3.0]}, *tree[1:]],
        {"frames": [frame | {"data": {"values": [MS, 5]}}]},
    ):
        with pytest.raises(InputError):
            take(write(tmp_path, json.dumps(odd, default=float), name="log.json"), tmp_path / "out", input="100")
