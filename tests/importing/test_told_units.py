"""Units beside numbers in messages, for a whole table, and dates beside times of day in a workbook."""

from __future__ import annotations

import json
from collections.abc import Callable
from datetime import date, datetime, timedelta
from pathlib import Path

import openpyxl
import pytest

from gen.errors import InputError
from tests.importing.logs import TRUE, same, take, taken, write

BEGIN = datetime(2026, 3, 2, 8, 15)
ROWS: list[dict[str, float]] = [{str(k): float(v) for k, v in row.items()} for row in TRUE.to_dict("records")]
PARTS = ("winding", "casing", "ambient")


def degF(row: dict[str, float], part: str) -> float:
    return round(row[f"{part}_degC"] * 1.8 + 32.0, 2)


def stamp(row: dict[str, float]) -> str:
    return (BEGIN + timedelta(seconds=row["time_s"])).isoformat() + "Z"


def beside(row: dict[str, float]) -> dict[str, object]:
    made: dict[str, object] = {part: {"value": degF(row, part), "unit": "°F"} for part in PARTS}
    return {"ts": stamp(row), "temps": made, "pwm": {"value": row["pwm"], "unit": "counts"}}


def in_a_list(row: dict[str, float]) -> dict[str, object]:
    readings: list[dict[str, object]] = [{"name": part, "value": degF(row, part), "uom": "F"} for part in PARTS]
    readings.append({"name": "pwm", "value": row["pwm"], "uom": "counts"})
    return {"ts": stamp(row), "device": "m7", "readings": readings}


def flat(row: dict[str, float]) -> dict[str, object]:
    made: dict[str, object] = {"ts": stamp(row), "pwm": row["pwm"], "pwm_unit": "counts"}
    for part in PARTS:
        made |= {part: degF(row, part), f"{part}_unit": "degF"}
    return made


def by_name(row: dict[str, float]) -> dict[str, object]:
    units = {**dict.fromkeys(PARTS, "degF"), "pwm": "counts"}
    return {"ts": stamp(row), "units": units, **{part: degF(row, part) for part in PARTS}, "pwm": row["pwm"]}


def for_all(row: dict[str, float]) -> dict[str, object]:
    temps = {part: degF(row, part) for part in PARTS}
    return {"ts": stamp(row), "temperature_unit": "F", **temps, "pwm": {"value": row["pwm"], "unit": "counts"}}


def by_its_place(row: dict[str, float]) -> dict[str, object]:
    return {
        "ts": stamp(row),
        "pwm_counts": row["pwm"],
        **{p: {"temperature": degF(row, p), "unit": "F"} for p in PARTS},
    }


@pytest.mark.parametrize("said", [beside, in_a_list, flat, by_name, for_all, by_its_place])
def test_json_says_the_unit(said: Callable[[dict[str, float]], dict[str, object]], tmp_path: Path) -> None:
    log = write(tmp_path, "\n".join(json.dumps(said(row), ensure_ascii=False) for row in ROWS), name="log.jsonl")
    run = taken(log, tmp_path / "out")
    named = {f"{part}_degC": f"{part}_temperature_degC" for part in PARTS if f"{part}_temperature" in run.temps}
    assert run.ambient is not None
    same(run, TRUE, named)


def test_each_number_goes_by_its_own_unit_where_a_meter_changes_it(tmp_path: Path) -> None:
    lines = []
    for i, row in enumerate(ROWS):
        power = {"value": 0.25, "unit": "kW"} if i % 2 else {"value": 250, "unit": "W"}
        winding = {"value": row["winding_degC"], "unit": "°C"}
        lines.append(json.dumps({"ts": stamp(row), "winding": winding, "power": power}))
    log = write(tmp_path, "\n".join(lines), name="log.jsonl")
    run = taken(log, tmp_path / "out", input="power.value", full_scale=500.0)
    assert run.pwm.tolist() == [128] * len(ROWS)


def test_a_unit_beside_several_numbers_is_none_of_theirs(tmp_path: Path) -> None:
    lines = [
        json.dumps({"ts": stamp(row), "unit": "mA", "winding_degC": row["winding_degC"], "rpm": 900, "pwm": row["pwm"]})
        for row in ROWS
    ]
    run = taken(write(tmp_path, "\n".join(lines), name="log.jsonl"), tmp_path / "out", units={"pwm": "counts"})
    same(run, TRUE[["pwm", "winding_degC"]])
    assert set(run.columns()["speed_rpm"].tolist()) == {900.0}


def test_units_beside_the_arrays_of_one_text(tmp_path: Path) -> None:
    data = {"time": TRUE["time_s"].tolist(), "pwm": TRUE["pwm"].tolist()}
    data |= {part: [degF(row, part) for row in ROWS] for part in PARTS}
    text = json.dumps({"units": {**dict.fromkeys(PARTS, "degF"), "time": "s", "pwm": "counts"}, "data": data})
    same(taken(write(tmp_path, text, name="log.json"), tmp_path / "out"), TRUE)


def test_a_history_of_home_assistant(tmp_path: Path) -> None:
    """One array for each entity; only its first record says its name and unit."""
    history = []
    for entity, unit, cell in (
        ("sensor.winding_temperature", "°F", lambda row: degF(row, "winding")),
        ("sensor.room_temperature", "°F", lambda row: degF(row, "ambient")),
        ("number.motor_duty", "%", lambda row: row["pwm"] / 2.55),
    ):
        records: list[dict[str, object]] = [{"state": f"{cell(r)}", "last_changed": stamp(r)} for r in ROWS]
        records[0] |= {"entity_id": entity, "attributes": {"unit_of_measurement": unit, "friendly_name": entity}}
        history.append(records)
    log = write(tmp_path, json.dumps(history), name="history.json")
    with pytest.raises(InputError, match=r"has a row for each of .*expected --series entity_id"):
        take(log, tmp_path / "none")
    run = taken(log, tmp_path / "out", series="entity_id")
    same(run, TRUE[["time_s", "pwm", "winding_degC", "ambient_degC"]])


@pytest.mark.parametrize("name", ["temp_unit", "Unit"])
def test_a_column_says_the_unit_of_all_temperatures(name: str, tmp_path: Path) -> None:
    """Cold enough to pass for degC: a room of 5 degC is 41 degF."""
    lines = [f"time_s,{name},winding,casing,ambient,pwm_counts"]
    for row in ROWS:
        cold = {part: round((row[f"{part}_degC"] - 16.0) * 1.8 + 32.0, 2) for part in PARTS}
        lines.append(f"{row['time_s']},F,{cold['winding']},{cold['casing']},{cold['ambient']},{row['pwm']:.0f}")
    run = taken(write(tmp_path, "\n".join(lines)), tmp_path / "out")
    same(run, TRUE.assign(**{f"{part}_degC": TRUE[f"{part}_degC"] - 16.0 for part in PARTS}))


def test_a_date_and_a_time_of_day_in_cells_of_a_workbook(tmp_path: Path) -> None:
    book = openpyxl.Workbook()
    sheet = book.active
    assert sheet is not None
    sheet.append(["Date", "Time", "Winding [°C]", "pwm_counts"])
    for row in ROWS:
        at = BEGIN + timedelta(seconds=row["time_s"])
        sheet.append([date(at.year, at.month, at.day), at.time(), row["winding_degC"], row["pwm"]])
    book.save(tmp_path / "log.xlsx")
    run = taken(tmp_path / "log.xlsx", tmp_path / "out")
    same(run, TRUE[["time_s", "pwm", "winding_degC"]])
    assert run.comments["started"].startswith("2026-03-02T08:15:00")
