"""Serial captures, JSON, Excel, Parquet, MATLAB, packed files."""

from __future__ import annotations

import gzip
import json
from pathlib import Path

import numpy as np
import openpyxl
import pandas as pd
import pytest
from scipy.io import savemat

from gen.errors import InputError
from gen.importing.reading import sources
from gen.runs import read_run
from tests.importing.logs import TRUE, csv, same, take, taken, write


def test_a_serial_capture_with_garbage(tmp_path: Path) -> None:
    lines = csv().splitlines()
    lines[30] = lines[30][:9] + "\x02\x7f"
    lines.insert(50, "rst cause:2, boot mode")
    data = "\r\n".join(lines).encode().replace(lines[80].encode(), b"\xff\xfe\x80\x00garbage")
    path = tmp_path / "capture.log"
    path.write_bytes(data)
    found = take(path, tmp_path / "runs")
    run = read_run(found.runs[0])
    assert run.time_s.size == 118
    same(run, TRUE[TRUE.time_s.isin(run.time_s)])
    assert found.counted().loc["line that is no row of 5 columns", "count"] == 3
    assert found.counted().loc["line that is no row of 5 columns", "first"] == "line 31"


def test_lines_that_name_their_numbers(tmp_path: Path) -> None:
    lines = [f"t:{t:.1f} PWM:{p} T1:{w} T2:{c} amb:{a}" for t, p, w, c, a in TRUE.itertuples(index=False)]
    lines.insert(0, "Motor test v1.2")
    lines[40] = "T1:2"
    found = take(write(tmp_path, "\n".join(lines)), tmp_path / "runs", time="t", units={"t": "s"})
    names = {"winding_degC": "T1_degC", "casing_degC": "T2_degC"}
    same(read_run(found.runs[0]), TRUE.drop(index=39), names)


def test_a_serial_monitor_s_times(tmp_path: Path) -> None:
    stamps = pd.Timestamp("2024-12-31 13:45:00.123") + pd.to_timedelta(TRUE.time_s, unit="s")
    times = stamps.dt.strftime("%H:%M:%S.%f").str[:-3]
    lines = [f"{s} -> T1: {w} C, pwm: {p}" for s, w, p in zip(times, TRUE.winding_degC, TRUE.pwm, strict=True)]
    run = taken(write(tmp_path, "\n".join(lines)), tmp_path / "runs")
    np.testing.assert_allclose(run.time_s - run.time_s[0], TRUE.time_s, atol=1e-9)
    np.testing.assert_array_equal(run.temps["T1"], TRUE.winding_degC)


def test_rows_without_a_header_are_taken_when_they_are_named(tmp_path: Path) -> None:
    path = write(tmp_path, csv(TRUE, header=False))
    with pytest.raises(InputError, match="column_2"):
        take(path, tmp_path / "runs")
    columns = {"column_2": "pwm", "column_3": "winding_degC", "column_4": "casing", "column_5": "ambient_degC"}
    run = taken(path, tmp_path / "runs", columns=columns, units={"column_4": "degC"})
    same(run, TRUE)


_LVM = """LabVIEW Measurement\t
Writer_Version\t2
Separator\tTab
X_Columns\tOne
Date\t2024/03/01
Time\t10:11:12.1230000000000000000
***End_of_Header***\t
\t
Channels\t4\t\t\t\t
Samples\t120\t120\t120\t120
Date\t2024/03/01\t2024/03/01\t2024/03/01\t2024/03/01
Time\t10:11:12.12\t10:11:12.12\t10:11:12.12\t10:11:12.12
X_Dimension\tTime\tTime\tTime\tTime
X0\t0.0E+0\t0.0E+0\t0.0E+0\t0.0E+0
Delta_X\t0.500000\t0.500000\t0.500000\t0.500000
***End_of_Header***\t\t\t\t
X_Value\tPWM\tWinding\tCasing\tAmbient\tComment
"""


def test_a_labview_measurement(tmp_path: Path) -> None:
    """Its preamble holds rows of numbers, and its header a column of comments that no row has."""
    rows = TRUE.to_csv(index=False, header=False, sep="\t", lineterminator="\n")
    same(taken(write(tmp_path, _LVM + rows, name="log.lvm"), tmp_path / "runs"), TRUE)


@pytest.mark.parametrize("within", [(), ("data",), ("Payload", "fields")])
def test_json_lines(tmp_path: Path, within: tuple[str, ...]) -> None:
    """What a message wraps its numbers in says nothing of them."""
    lines = []
    for record in TRUE.to_dict("records"):
        message = {"time_s": record.pop("time_s"), "pwm": record.pop("pwm"), "temps": record}
        for name in within:
            message = {name: message}
        lines.append(json.dumps(message))
    path = write(tmp_path, "\n".join(lines) + '\n{"torn', name="log.jsonl")
    found = take(path, tmp_path / "runs")
    same(read_run(found.runs[0]), TRUE)
    assert found.counted().loc["line that is no JSON object", "first"] == "line 121"


@pytest.mark.parametrize("named", ["name", "id"])
def test_json_lists_of_named_sensors(tmp_path: Path, named: str) -> None:
    """Each by its own name, in whatever order; not by its place in the list."""
    lines = []
    for number, record in enumerate(TRUE.to_dict("records")):
        message = {"time_s": record.pop("time_s"), "pwm": record.pop("pwm")}
        sensors = [{named: str(name).removesuffix("_degC"), "value": value} for name, value in record.items()]
        lines.append(json.dumps({**message, "sensors": sensors[:: -1 if number % 2 else 1]}))
    found = take(write(tmp_path, "\n".join(lines), name="log.jsonl"), tmp_path / "runs")
    same(read_run(found.runs[0]), TRUE)


def test_json_lists_whose_ids_are_of_messages_go_by_place(tmp_path: Path) -> None:
    lines = [
        json.dumps({"time_s": row.pop("time_s"), "pwm": row.pop("pwm"), "log": [{"id": f"m{k * 7919:08d}", **row}]})
        for k, row in enumerate(TRUE.to_dict("records"))
    ]
    found = take(write(tmp_path, "\n".join(lines), name="log.jsonl"), tmp_path / "runs")
    assert len(read_run(found.runs[0]).temps) == 2


def test_json_lists_that_hold_one_sensor_at_a_time_part_them(tmp_path: Path) -> None:
    lines = [
        json.dumps(
            {"time_s": k, "pwm": 120, "sensors": [{"name": ("winding", "casing")[k % 2], "temp": 21.25 + k % 2}]}
        )
        for k in range(60)
    ]
    run = read_run(take(write(tmp_path, "\n".join(lines), name="log.jsonl"), tmp_path / "runs").runs[0])
    assert {name: set(values[np.isfinite(values)]) for name, values in run.temps.items()} == {
        "winding": {21.25},
        "casing": {22.25},
    }


def test_json_lists_without_names_go_by_place(tmp_path: Path) -> None:
    records = [{"time_s": 2.0 * k, "pwm": 120, "T": [20.0 + 0.1 * k, 21.0 + 0.05 * k]} for k in range(60)]
    found = take(write(tmp_path, "\n".join(map(json.dumps, records)), name="log.jsonl"), tmp_path / "runs")
    assert len(read_run(found.runs[0]).temps) == 2


def test_a_json_array(tmp_path: Path) -> None:
    same(taken(write(tmp_path, str(TRUE.to_json(orient="records")), name="log.json"), tmp_path / "runs"), TRUE)


COLUMNS = {str(name): TRUE[name].tolist() for name in TRUE}
RECORDS = TRUE.to_dict("records")


@pytest.mark.parametrize("indent", [None, 2])
@pytest.mark.parametrize(
    "tree",
    [
        {"meta": {"fw": "1"}, "samples": RECORDS},
        {"samples": RECORDS},
        {"meta": {"fw": "1", "tags": ["a", "b"]}, "data": {"samples": RECORDS}},
        {"meta": {"fw": "1"}, **COLUMNS},
        {"meta": {"fw": "1"}, "data": COLUMNS},
        {"results": [{"series": [{"name": "motor", "columns": list(COLUMNS), "values": TRUE.to_numpy().tolist()}]}]},
        {"columns": list(COLUMNS), "index": list(range(len(TRUE))), "data": TRUE.to_numpy().tolist()},
    ],
)
def test_a_table_within_a_json_document(tree: object, indent: int | None, tmp_path: Path) -> None:
    same(taken(write(tmp_path, json.dumps(tree, indent=indent), name="log.json"), tmp_path / "runs"), TRUE)


def test_two_tables_within_a_json_document_are_named(tmp_path: Path) -> None:
    path = write(tmp_path, json.dumps({"a": RECORDS, "b": {"c": RECORDS[:7]}, "d": 1}), name="log.json")
    with pytest.raises(InputError, match=r"holds several tables \(\$\.a, \$\.b\.c\); expected one"):
        take(path, tmp_path / "runs")


def test_excel(tmp_path: Path) -> None:
    book = openpyxl.Workbook()
    sheet = book.active
    assert sheet is not None
    sheet.append(["Bench 3"])
    sheet.append([])
    sheet.append(["Time", "PWM", "Winding °C", "Casing °C", "Ambient °C"])
    begin = pd.Timestamp("2024-05-01 08:00:00")
    for time, *rest in TRUE.itertuples(index=False):
        sheet.append([(begin + pd.Timedelta(seconds=time)).to_pydatetime(), *map(float, rest)])
    book.create_sheet("Notes").append(["nothing here"])
    book.save(tmp_path / "log.xlsx")
    found = take(tmp_path / "log.xlsx", tmp_path / "runs")
    same(read_run(found.runs[0]), TRUE)
    assert "sheet without a table: Notes" in found.counted().index


def workbook(path: Path, sheets: dict[str, list[list[object]]]) -> Path:
    book = openpyxl.Workbook()
    book.remove(book.worksheets[0])
    for name, rows in sheets.items():
        sheet = book.create_sheet(name)
        for row in rows:
            sheet.append(row)
    book.save(path)
    return path


DATA: list[list[object]] = [[str(name) for name in TRUE], *TRUE.astype(float).to_numpy().tolist()]
NOISE: list[list[object]] = [[i % 3, i % 5] for i in range(100)]
INFO: list[list[object]] = [["Motor test 11"], [], ["Operator", "J. Smith"], ["Samples", 120]]
SUMMARY: list[list[object]] = [["Channel", "Min", "Max"], ["Winding", 21.5, 61.0], ["Casing", 21.0, 33.0]]


@pytest.mark.parametrize("mapped", [False, True])
def test_sheets_that_stand_beside_the_log_are_told_and_left_out(mapped: bool, tmp_path: Path) -> None:
    path = workbook(tmp_path / "log.xlsx", {"Info": INFO, "Data": DATA, "Summary": SUMMARY})
    options = {"mapping": tmp_path / "map.toml"} if mapped else {}
    found = take(path, tmp_path / "runs", **options)
    assert [run.name for run in found.runs] == ["log.csv"]
    same(read_run(found.runs[0]), TRUE)
    assert {"sheet that is no log: Info", "sheet that is no log: Summary"} <= set(found.counted().index)
    if mapped:
        same(taken(path, tmp_path / "again", **options), TRUE)


def test_of_two_long_sheets_one_can_be_chosen(tmp_path: Path) -> None:
    path = workbook(tmp_path / "log.xlsx", {"Scope, raw": [["a", "b"], *NOISE], "Data": DATA})
    with pytest.raises(InputError, match=r"sheet Scope, raw.*or --sheet NAME, of 'Scope, raw', Data, if only one"):
        take(path, tmp_path / "runs")
    run = taken(path, tmp_path / "runs", sheet="Data", mapping=tmp_path / "map.toml")
    same(run, TRUE)
    same(taken(path, tmp_path / "again", mapping=tmp_path / "map.toml"), TRUE)


def test_two_logs_of_other_columns_in_one_workbook_are_two_runs_or_one_is_chosen(tmp_path: Path) -> None:
    path = workbook(tmp_path / "log.xlsx", {"A": DATA, "B": [row[:3] for row in DATA]})
    assert [run.name for run in take(path, tmp_path / "two").runs] == ["log_A.csv", "log_B.csv"]
    with pytest.raises(
        InputError, match=r"has other columns than .*; or --sheet NAME, of A, B, if only one is the log"
    ):
        take(path, tmp_path / "runs", mapping=tmp_path / "map.toml")
    same(taken(path, tmp_path / "runs", sheet="A"), TRUE)


def test_a_sheet_that_is_not_there_is_refused(tmp_path: Path) -> None:
    path = workbook(tmp_path / "log.xlsx", {"Info": INFO, "Data": DATA})
    with pytest.raises(InputError, match='--sheet: found "data", expected one of the sheets Info, Data'):
        take(path, tmp_path / "runs", sheet="data")
    with pytest.raises(InputError, match='is no workbook; expected one with the sheet "Data"'):
        take(write(tmp_path, csv()), tmp_path / "runs", sheet="Data")


@pytest.mark.parametrize("units", ["header", "row", ""])
@pytest.mark.parametrize("shown", ["0%", "0.00%", '"a "0 %', "[Red]-0.0%;0.0%"])
def test_a_share_that_excel_shows_in_percent_is_in_percent(shown: str, units: str, tmp_path: Path) -> None:
    """A cell that reads 80% holds 0.8."""
    book = openpyxl.Workbook()
    sheet = book.active
    assert sheet is not None
    sheet.append(["t [s]", "Duty [%]" if units == "header" else "Duty", "Winding °C", "Casing °C", "Ambient °C"])
    if units == "row":
        sheet.append(["s", "%", "°C", "°C", "°C"])
    for time, pwm, *rest in TRUE.itertuples(index=False):
        sheet.append([time, pwm / 255, *rest])
        sheet.cell(sheet.max_row, 2).number_format = shown
    book.save(tmp_path / "log.xlsx")
    same(taken(tmp_path / "log.xlsx", tmp_path / "runs"), TRUE)


def test_a_percent_sign_that_a_number_format_only_quotes_changes_nothing(tmp_path: Path) -> None:
    book = openpyxl.Workbook()
    sheet = book.active
    assert sheet is not None
    sheet.append(["t [s]", "Duty", "Winding °C"])
    for time, pwm, winding, *_ in TRUE.itertuples(index=False):
        sheet.append([time, pwm / 255 * 100, winding])
        sheet.cell(sheet.max_row, 2).number_format = '0.0"%"'
    book.save(tmp_path / "log.xlsx")
    same(taken(tmp_path / "log.xlsx", tmp_path / "runs"), TRUE[["time_s", "pwm", "winding_degC"]])


def test_parquet_with_an_index_of_times(tmp_path: Path) -> None:
    stamps = pd.DatetimeIndex(pd.Timestamp("2024-05-01", tz="UTC") + pd.to_timedelta(TRUE.time_s, unit="s"), name="ts")
    TRUE.drop(columns="time_s").set_index(stamps).to_parquet(tmp_path / "log.parquet")
    same(taken(tmp_path / "log.parquet", tmp_path / "runs"), TRUE)


def test_matlab(tmp_path: Path) -> None:
    columns: dict[str, object] = {str(name): TRUE[name].to_numpy().reshape(-1, 1) for name in TRUE}
    savemat(tmp_path / "a.mat", columns)
    same(taken(tmp_path / "a.mat", tmp_path / "a"), TRUE)
    savemat(tmp_path / "b.mat", {"log": columns, "room": 21.0})
    same(taken(tmp_path / "b.mat", tmp_path / "b"), TRUE)


def test_rows_of_matlab_are_counted_from_1(tmp_path: Path) -> None:
    again = TRUE.assign(time_s=TRUE.time_s.where(TRUE.time_s < TRUE.time_s.max(), TRUE.time_s.iloc[-2]))
    savemat(tmp_path / "log.mat", {str(name): again[name].to_numpy() for name in again})
    counted = take(tmp_path / "log.mat", tmp_path / "runs").counted()
    assert set(counted["first"]) == {"row 120, column time_s"}


def test_a_packed_file(tmp_path: Path) -> None:
    (tmp_path / "log.csv.gz").write_bytes(gzip.compress(csv().encode()))
    found = take(tmp_path / "log.csv.gz", tmp_path / "runs")
    assert [path.name for path in found.runs] == ["log.csv"]
    same(read_run(found.runs[0]), TRUE)


@pytest.mark.parametrize("spare", [0, 1, -1])
def test_what_unpacks_to_more_than_the_most_is_refused_and_not_cut(
    spare: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    text = csv().encode()
    monkeypatch.setattr(sources, "_MOST_BYTES", len(text) + spare)
    (tmp_path / "log.csv.gz").write_bytes(gzip.compress(text))
    if spare < 0:
        with pytest.raises(InputError, match="unpacks to more than"):
            take(tmp_path / "log.csv.gz", tmp_path / "runs")
    else:
        same(taken(tmp_path / "log.csv.gz", tmp_path / "runs"), TRUE)


@pytest.mark.parametrize(
    ("corner", "mark", "units"), [("time_s", ",", False), ("Channel", ";", True), ("Zeit [s]", "\t", False)]
)
def test_a_row_for_each_channel_and_a_column_for_each_time(corner: str, mark: str, units: bool, tmp_path: Path) -> None:
    decimal = "," if mark == ";" else "."
    rows = [[corner, *(["Unit"] if units else []), *(str(t) for t in TRUE["time_s"])]]
    for name, unit in (("pwm", ""), ("winding", "°F"), ("casing", "°C")):
        values = TRUE[name if name == "pwm" else f"{name}_degC"].to_numpy()
        values = np.round(values * 1.8 + 32, 6) if unit == "°F" and units else values
        rows.append([name, *([unit] if units else []), *(f"{value:g}" for value in values)])
    text = "\n".join(mark.join(row) for row in rows).replace(".", decimal)
    run = taken(write(tmp_path, text), tmp_path / "out", units={"pwm": "counts"})
    same(run, TRUE[["time_s", "pwm", "winding_degC", "casing_degC"]])
