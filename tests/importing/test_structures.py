"""How tables lie in their files: structures, sheets without their size, archives, records with tags."""

from __future__ import annotations

import io
import json
import zipfile
from pathlib import Path

import numpy as np
import openpyxl
import pytest
import scipy.io

from gen.errors import InputError
from tests.importing.logs import TRUE, csv, same, take, taken, write

COLUMNS = ["time_s", "pwm", "winding_degC", "casing_degC", "ambient_degC"]
TIME, PWM = TRUE["time_s"].to_numpy(), TRUE["pwm"].to_numpy(dtype=float)


def test_structures_with_the_same_fields_keep_them_apart(tmp_path: Path) -> None:
    motor = {"time": TIME, "temp_degC": TRUE["winding_degC"].to_numpy(), "pwm": PWM}
    scipy.io.savemat(tmp_path / "log.mat", {"motor": motor, "room": {"temp_degC": TRUE["ambient_degC"].to_numpy()}})
    run = taken(tmp_path / "log.mat", tmp_path / "out", units={"time": "s", "pwm": "counts"})
    same(run, TRUE[["time_s", "pwm", "winding_degC", "ambient_degC"]], {"winding_degC": "motor_degC"})


def test_an_array_of_structures_goes_by_its_labels(tmp_path: Path) -> None:
    """As Simulink writes a scope's data."""
    signals = np.zeros(3, dtype=[("values", object), ("label", object)])
    for i, name in enumerate(("pwm", "winding_degC", "ambient_degC")):
        signals[i] = (TRUE[name].to_numpy(dtype=float), name.removesuffix("_degC"))
    scipy.io.savemat(tmp_path / "log.mat", {"ScopeData": {"time": TIME, "signals": signals}})
    run = taken(tmp_path / "log.mat", tmp_path / "out", units={"time": "s", "pwm": "counts"})
    same(run, TRUE[["time_s", "pwm", "winding_degC", "ambient_degC"]])


FAHRENHEIT = TRUE["winding_degC"].to_numpy() * 1.8 + 32
KNOWN = ["time_s", "pwm", "winding_degC", "ambient_degC"]
AMBIENT = TRUE["ambient_degC"].to_numpy()
TOLD: dict[str, dict[str, object]] = {
    "beside values": {
        "s": {"time": TIME, "pwm": PWM, "winding": {"value": FAHRENHEIT, "unit": "F"}, "ambient": {"value": AMBIENT}}
    },
    "a timeseries each": {
        "log": {
            name: {"Time": TIME, "Data": data, "DataInfo": {"Units": unit}, "TimeInfo": {"Units": "seconds"}}
            for name, data, unit in (("pwm", PWM, ""), ("winding", FAHRENHEIT, "degF"), ("ambient", AMBIENT, "C"))
        }
    },
    "in a structure of their own": {
        **{"time": TIME, "pwm": PWM, "winding": FAHRENHEIT, "ambient": AMBIENT},
        "units": {"time": "s", "winding": "degF"},
    },
}


@pytest.mark.parametrize("form", TOLD)
def test_units_told_in_structures(form: str, tmp_path: Path) -> None:
    scipy.io.savemat(tmp_path / "log.mat", TOLD[form])
    told = {"time": "s"} if form == "beside values" else {}
    same(taken(tmp_path / "log.mat", tmp_path / "out", units={"pwm": "counts", **told}), TRUE[KNOWN])


def test_signals_with_times_of_their_own_keep_them(tmp_path: Path) -> None:
    winding = {"time": TIME, "data": FAHRENHEIT, "unit": "F"}
    scipy.io.savemat(tmp_path / "log.mat", {"winding": winding, "pwm": {"time": TIME[::2] + 0.1, "data": PWM[::2]}})
    units = {"winding.time": "s", "pwm": "counts"}
    run = taken(tmp_path / "log.mat", tmp_path / "out", units=units)
    known = np.isfinite(run.temps["winding"])
    np.testing.assert_allclose(run.temps["winding"][known], TRUE["winding_degC"][1:])
    np.testing.assert_allclose(run.time_s[known], TIME[1:])
    assert run.pwm[np.flatnonzero(run.time_s > 40.05)[0]] == 0


def test_vectors_of_another_length_are_told(tmp_path: Path) -> None:
    content = {"time_s": TIME, "pwm": PWM, "winding_degC": TRUE["winding_degC"].to_numpy(), "slow_degC": TIME[::2]}
    scipy.io.savemat(tmp_path / "log.mat", content)
    found = take(tmp_path / "log.mat", tmp_path / "out")
    assert found.counted()["first"]["vector of another length, left out"] == "slow_degC"


def with_dimension(data: bytes, said: str) -> bytes:
    """A workbook whose sheet says that it is as large as `said`, or nothing of it."""
    made = io.BytesIO()
    with zipfile.ZipFile(io.BytesIO(data)) as old, zipfile.ZipFile(made, "w") as new:
        for name in old.namelist():
            text = old.read(name)
            if name == "xl/worksheets/sheet1.xml":
                begin, end = text.index(b"<dimension"), text.index(b"/>", text.index(b"<dimension")) + 2
                text = text[:begin] + said.encode() + text[end:]
            new.writestr(name, text)
    return made.getvalue()


@pytest.mark.parametrize("said", ["", '<dimension ref="A1"/>'])
def test_a_workbook_whose_sheet_does_not_know_its_size(said: str, tmp_path: Path) -> None:
    book = openpyxl.Workbook()
    sheet = book.active
    assert sheet is not None
    sheet.append(["bench 3"])
    sheet.append(COLUMNS)
    for row in TRUE[COLUMNS].itertuples(index=False):
        sheet.append(list(row))
    sheet.append([TIME[-1] + 0.5, 0])  # ends early
    data = io.BytesIO()
    book.save(data)
    (tmp_path / "log.xlsx").write_bytes(with_dimension(data.getvalue(), said))
    run = taken(tmp_path / "log.xlsx", tmp_path / "out")
    assert run.time_s.size == len(TRUE) + 1
    np.testing.assert_allclose(run.temps["winding"][:-1], TRUE["winding_degC"])


def test_numbers_typed_as_text_with_decimal_commas(tmp_path: Path) -> None:
    book = openpyxl.Workbook()
    sheet = book.active
    assert sheet is not None
    sheet.append(COLUMNS)
    for row in TRUE[COLUMNS].itertuples(index=False):
        typed = str(row[2]).replace(".", ",") if row[0] % 2.0 else row[2]
        sheet.append([row[0], row[1], typed, str(row[3]).replace(".", ","), row[4]])
    book.save(tmp_path / "log.xlsx")
    same(taken(tmp_path / "log.xlsx", tmp_path / "out"), TRUE)


def test_archives_and_foreign_files_are_told_what_they_are(tmp_path: Path) -> None:
    with zipfile.ZipFile(tmp_path / "log.zip", "w") as archive:
        archive.writestr("log.csv", csv())
    with pytest.raises(InputError, match="is a zip archive and no workbook; unpack it"):
        take(tmp_path / "log.zip", tmp_path / "out")
    (tmp_path / "log.h5").write_bytes(b"\x89HDF\r\n\x1a\n" + bytes(200))
    with pytest.raises(InputError, match="is an HDF5 file"):
        take(tmp_path / "log.h5", tmp_path / "out")


def test_records_of_fields_and_tags(tmp_path: Path) -> None:
    """As Telegraf writes them: a record for each sensor, and what is the same in all is no name."""
    lines = []
    for i, row in enumerate(TRUE.itertuples()):
        for part in ("winding", "casing", "ambient"):
            value = getattr(row, f"{part}_degC")
            tags = {"host": "pi", "sensor": part}
            lines.append({"fields": {"temp_c": value}, "name": "w1", "tags": tags, "timestamp": 1772439300 + 10 * i})
        tags = {"host": "pi", "sensor": "motor"}
        lines.append({"fields": {"pwm": row.pwm}, "name": "drive", "tags": tags, "timestamp": 1772439300 + 10 * i})
    log = write(tmp_path, "\n".join(map(json.dumps, lines)), name="telegraf.json")
    run = taken(log, tmp_path / "out", units={"motor.pwm": "counts"})
    same(run, TRUE.assign(time_s=10.0 * np.arange(len(TRUE))))
    assert run.comments["started"].startswith("2026-03-02T08:15:00")


@pytest.mark.parametrize("tags", [None, {}])
def test_records_without_tags_from_time_0_on(tags: object, tmp_path: Path) -> None:
    lines = []
    for row in TRUE.itertuples():
        at = row.Index  # s since the board began
        lines.append({"fields": {"temp": row.winding_degC}, "tags": {"sensor": "winding"}, "timestamp": at})
        lines.append({"fields": {"pwm": row.pwm}, "tags": tags, "timestamp": at})
    log = write(tmp_path, "\n".join(map(json.dumps, lines)), name="telegraf.json")
    run = taken(log, tmp_path / "out", units={"timestamp": "s", "pwm": "counts"})
    same(run, TRUE[["pwm", "winding_degC"]].assign(time_s=np.arange(len(TRUE))))


def test_json_that_breaks_off_is_told_where(tmp_path: Path) -> None:
    text = json.dumps([{"time_s": row.time_s, "T1": row.winding_degC} for row in TRUE.itertuples()], indent=1)
    with pytest.raises(InputError, match=r"line 3\d\d, column \d+: begins as JSON and is none from here on"):
        take(write(tmp_path, text[: text.index("57.5")], name="log.json"), tmp_path / "out")


def test_json_of_any_depth_is_refused_in_a_line(tmp_path: Path) -> None:
    for text in ('[{"a":' * 20_000, '[{"a":' * 20_000 + "1" + "}]" * 20_000):
        with pytest.raises(InputError):
            take(write(tmp_path, text, name="log.json"), tmp_path / "out")


@pytest.mark.parametrize("column", [2, 3], ids=["the input", "a part"])
def test_formulas_that_nobody_computed_are_told(column: int, tmp_path: Path) -> None:
    """As a library writes them: Excel stores their values, and a part would be gone without."""
    book = openpyxl.Workbook()
    sheet = book.active
    assert sheet is not None
    sheet.append(["t [s]", "PWM", "Winding [°C]", "Casing [°C]"])
    for row in TRUE.itertuples(index=False):
        sheet.append([float(value) for value in row[:4]])
    for line in range(2, sheet.max_row + 1):
        sheet.cell(line, column, f"={sheet.cell(line, column).value}*1")
    path = tmp_path / "log.xlsx"
    book.save(path)
    with pytest.raises(InputError, match=r"120 formulas have no stored value, .* open the workbook in a spreadsheet"):
        take(path, tmp_path / "out")
