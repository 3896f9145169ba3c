"""What is no log, or a broken one: one line with file and place, and nothing is written."""

from __future__ import annotations

import io
import pickle
import zipfile
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from gen.errors import InputError
from gen.importing.mapping import read_mapping
from gen.runs import read_run
from tests.importing.logs import same, take, truth, write

TEXT = str(truth().to_csv(index=False, lineterminator="\n"))


def refused(path: Path, match: str, **options: object) -> str:
    out = path.parent / "runs"
    with pytest.raises(InputError, match=match) as caught:
        take(path, out, **options)
    assert not out.exists()
    assert str(path) in str(caught.value) or caught.value.place in ("--time", "--input", "--column", "--unit")
    return str(caught.value)


def file(tmp_path: Path, data: bytes | str, name: str = "log.csv") -> Path:
    path = tmp_path / name
    path.write_bytes(data.encode() if isinstance(data, str) else data)
    return path


@pytest.mark.parametrize(
    ("data", "match"),
    [
        (b"", "is empty"),
        (b"\n \n\r\n", "is empty"),
        (b"\xef\xbb\xbf", "is empty|no delimiter"),
        (b"# only\n# comments\n", "there are only comments"),
        (b"time_s,pwm,winding_degC\n", "line 1: found no row of numbers"),
        (b"time_s;pwm\ntext;more\n", "line 2: found no row of numbers"),
        (b"just some prose\nof two lines here", "line"),
        (bytes(range(256)) * 40, "neither text nor"),
        (b"\x7fELF" + bytes(200), "is a program"),
        (b"\xd0\xcf\x11\xe0" + bytes(600), r"old Excel workbook .* save it as \.xlsx or CSV"),
        (b"PAR1 is not enough", "cannot be read as Parquet"),
        (b"PK\x03\x04 torn", "cannot be read as an Excel workbook"),
        (b"\x1f\x8b torn", "cannot be unpacked"),
        (b"MATLAB 5.0 MAT-file, torn", "cannot be read as a MATLAB file|found no vectors"),
        (b"MATLAB 7.3 MAT-file" + b" " * 200, "-v7"),
        (b"\x89HDF\r\n\x1a\n", "-v7"),
        (pickle.dumps({"a": np.arange(3)}), "neither text nor|no delimiter|is empty|row"),
    ],
)
def test_files_that_are_no_logs(data: bytes, match: str, tmp_path: Path) -> None:
    refused(file(tmp_path, data), match)


def test_folders_and_files_that_are_not_there(tmp_path: Path) -> None:
    (tmp_path / "folder").mkdir()
    refused(tmp_path / "folder", "is a directory")
    refused(tmp_path / "missing.csv", "no such file")


def test_a_workbook_whose_compressed_rows_are_damaged(tmp_path: Path) -> None:
    packed = io.BytesIO()
    pd.DataFrame({"time_s": [0, 1], "pwm": [0, 1], "a_degC": [20, 21]}).to_excel(packed, index=False)
    data = bytearray(packed.getvalue())
    with zipfile.ZipFile(packed) as archive:
        at = archive.getinfo("xl/worksheets/sheet1.xml").header_offset
    name, extra = (int.from_bytes(data[at + k : at + k + 2], "little") for k in (26, 28))
    data[at + 30 + name + extra] = 0xFF  # a kind of block that deflate does not have
    refused(file(tmp_path, bytes(data), "log.xlsx"), "cannot be read as an Excel workbook")


def test_a_zip_that_is_no_workbook(tmp_path: Path) -> None:
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w") as archive:
        archive.writestr("a.txt", "hello")
    refused(file(tmp_path, packed.getvalue(), "log.xlsx"), "is a zip archive and no workbook")


def test_a_field_of_a_megabyte(tmp_path: Path) -> None:
    lines = TEXT.splitlines()
    lines[10] = '"' + "x" * 1_000_000 + '",1,2,3,4'
    refused(file(tmp_path, "\n".join(lines)), "line 11: field larger than field limit")


def test_a_stray_quote_swallows_one_line_at_most(tmp_path: Path) -> None:
    lines = TEXT.splitlines()
    lines[50] = '"' + lines[50]
    found = take(file(tmp_path, "\n".join(lines)), tmp_path / "runs")
    same(read_run(found.runs[0]), truth())


def test_hundreds_of_thousands_of_columns_are_no_table(tmp_path: Path) -> None:
    refused(file(tmp_path, ",".join(["1"] * 300_000) + "\n1,2\n"), "line|column")


def test_times_that_go_back_all_the_way_are_refused_soon(tmp_path: Path) -> None:
    rng = np.random.default_rng(0)
    frame = pd.DataFrame({"time_s": rng.random(40_000) * 1e5, "pwm": 255, "winding_degC": 20.5})
    refused(file(tmp_path, str(frame.to_csv(index=False))), "time goes back|is a time|clock begins anew")


def test_no_time_no_input_no_temperature(tmp_path: Path) -> None:
    true = truth()
    refused(file(tmp_path, str(true.drop(columns="time_s").to_csv(index=False))), "no column is a time among pwm")
    refused(file(tmp_path, str(true.drop(columns="pwm").to_csv(index=False))), "no column is a motor's PWM among")
    refused(file(tmp_path, str(true[["time_s", "pwm", "ambient_degC"]].to_csv(index=False))), "no column is a part's")


@pytest.mark.parametrize(
    ("options", "match"),
    [
        ({"time": "clock"}, '--time: found "clock", expected a column'),
        ({"time": "-1"}, "expected an interval above 0 s"),
        ({"input": "torque"}, '--input: found "torque", expected a column'),
        ({"input": "300"}, "expected a column .* or whole counts -255..255"),
        ({"columns": {"coil": "winding_degC"}}, '--column: found "coil", expected one of the columns'),
        ({"columns": {"winding_degC": "a_degC", "casing_degC": "a"}}, "would be there twice; expected another name"),
        ({"columns": {"winding_degC": "a,b_degC"}}, "cannot be a run file's column"),
        ({"units": {"winding_degC": "furlongs"}}, 'found the unit "furlongs"'),
        ({"units": {"time_s": "degC"}}, "expected s, ms"),
        ({"units": {"coil": "degC"}}, '--unit: found "coil"'),
        ({"units": {"coil_degC": "degC"}}, '--unit: found "coil_degC"'),
        ({"runs": "run"}, '--runs: found "run"'),
        ({"input": "pwm", "full_scale": 100.0}, "found 204 counts, more than its full scale of 100"),
    ],
)
def test_options_that_do_not_fit(options: dict[str, object], match: str, tmp_path: Path) -> None:
    path = file(tmp_path, TEXT)
    with pytest.raises(InputError, match=match):
        take(path, tmp_path / "runs", **options)
    assert not (tmp_path / "runs").exists()


def test_what_exists_is_refused_unless_it_is_to_be_overwritten(tmp_path: Path) -> None:
    path, out = file(tmp_path, TEXT), tmp_path / "runs"
    out.mkdir()
    (out / "log.csv").write_text("precious")
    (out / "other.txt").write_text("mine")
    with pytest.raises(InputError, match=r"log\.csv: exists; expected another --out, or --overwrite"):
        take(path, out)
    assert (out / "log.csv").read_text() == "precious"
    take(path, out, overwrite=True)
    same(read_run(out / "log.csv"), truth())
    assert sorted(item.name for item in out.iterdir()) == ["log.csv", "other.txt"]
    with pytest.raises(InputError, match="is read by this command"):
        take(path, tmp_path, overwrite=True)
    with pytest.raises(InputError, match="exists and is no folder"):
        take(path, path)
    assert sorted(item.name for item in tmp_path.iterdir()) == ["log.csv", "runs"]


def test_one_bad_file_of_several_writes_nothing(tmp_path: Path) -> None:
    from gen.interface import import_runs

    good, bad = file(tmp_path, TEXT), file(tmp_path, TEXT.replace("204", "304"), "bad.csv")
    with pytest.raises(InputError):
        import_runs([good, bad], tmp_path / "runs")
    assert not (tmp_path / "runs").exists()


def test_files_of_one_name_do_not_replace_each_other(tmp_path: Path) -> None:
    from gen.interface import import_runs

    for folder in ("a", "b"):
        (tmp_path / folder).mkdir()
    paths = [file(tmp_path / "a", TEXT), file(tmp_path / "b", TEXT, "LOG.csv")]
    assert [path.name for path in import_runs(paths, tmp_path / "runs").runs] == ["log.csv", "LOG_2.csv"]


GOOD_MAPPING = """
[time]
columns = ["time_s"]
[input]
column = "pwm"
[[column]]
from = "winding_degC"
to = "winding_degC"
unit = "degC"
"""


@pytest.mark.parametrize(
    ("text", "match"),
    [
        ("[time", "map.toml: is not TOML: Expected"),
        ("", "map.toml: time: Field required"),
        (GOOD_MAPPING + "colour = 1\n", r"map.toml: column\[0\].colour: Extra inputs"),
        (GOOD_MAPPING.replace('"time_s"]', "1]"), r"time.columns\[0\]: Input should be a valid string, found 1"),
        (
            GOOD_MAPPING.replace('columns = ["time_s"]', "interval_s = -1.0"),
            "time.interval_s: .* greater than 0, found -1",
        ),
        (GOOD_MAPPING.replace('columns = ["time_s"]', "interval_s = inf"), "time.interval_s: .* finite"),
        (GOOD_MAPPING.replace("[input]", "[input]\nfull_scale = nan"), "input.full_scale"),
        (GOOD_MAPPING.replace("[input]", 'unit = "degC"\n[input]'), 'time: .*found the unit "degC"'),
        (GOOD_MAPPING.replace('"pwm"', '"drive"'), 'log.csv: has no column "drive", which the mapping names'),
        (GOOD_MAPPING, 'log.csv: the mapping says nothing of the column "casing_degC"'),
    ],
)
def test_mapping_files_that_do_not_fit(text: str, match: str, tmp_path: Path) -> None:
    mapping = file(tmp_path, text, "map.toml")
    with pytest.raises(InputError, match=match):
        take(file(tmp_path, TEXT), tmp_path / "runs", mapping=mapping)
    assert mapping.read_text() == text
    assert not (tmp_path / "runs").exists()


@pytest.mark.parametrize(
    ("letters", "quoted"), [(58, '"' + 58 * "x" + '"'), (59, '"' + 59 * "x"), (5000, '"' + 59 * "x")]
)
def test_of_a_wrong_value_as_long_as_a_page_a_message_quotes_sixty_characters(
    letters: int, quoted: str, tmp_path: Path
) -> None:
    mapping = file(
        tmp_path, GOOD_MAPPING.replace('columns = ["time_s"]', f'interval_s = "{letters * "x"}"'), "map.toml"
    )
    with pytest.raises(InputError) as caught:
        read_mapping(mapping)
    assert str(caught.value).partition(", found ")[2] == quoted


def test_a_mapping_is_corrected_in_its_file_and_nowhere_else(tmp_path: Path) -> None:
    mapping = tmp_path / "map.toml"
    path = file(tmp_path, TEXT)
    take(path, tmp_path / "first", mapping=mapping)
    with pytest.raises(InputError, match="--unit: the mapping file exists and says it"):
        take(path, tmp_path / "second", mapping=mapping, units={"winding_degC": "degF"})
    mapping.write_text(
        mapping.read_text().replace('from = "casing_degC"\nto = "casing_degC"', 'from = "casing_degC"\nto = ""')
    )
    assert read_mapping(mapping).entry("casing_degC") is not None
    found = take(path, tmp_path / "second", mapping=mapping)
    assert list(read_run(found.runs[0]).temps) == ["winding"]


def test_files_with_other_columns_make_no_common_mapping(tmp_path: Path) -> None:
    from gen.interface import import_runs

    other = file(tmp_path, str(truth().drop(columns="casing_degC").to_csv(index=False)), "other.csv")
    with pytest.raises(InputError, match=r"other\.csv: has other columns than .*log\.csv"):
        import_runs([file(tmp_path, TEXT), other], tmp_path / "runs", mapping=tmp_path / "map.toml")
    assert not (tmp_path / "map.toml").exists()
    assert len(import_runs([tmp_path / "log.csv", other], tmp_path / "runs").runs) == 2


def test_runs_of_one_logger_are_judged_together(tmp_path: Path) -> None:
    """A run at 60 counts alone may be 60 percent; beside one at 204 it is not."""
    from gen.interface import import_runs

    heads = TEXT.replace("time_s", "t [s]")
    slow = file(tmp_path, heads.replace(",204,", ",60,"), "slow.csv")
    with pytest.raises(InputError, match="counts of 255 or percent"):
        take(slow, tmp_path / "runs")
    found = import_runs([slow, file(tmp_path, heads, "fast.csv")], tmp_path / "runs")
    assert set(read_run(found.runs[0]).pwm.tolist()) == {0, 60}


@pytest.mark.parametrize("frame", ["(1772439300.{i:06d}) can0 123#00112233", "  vcan0  123   [4]  00 11 22 33"])
def test_frames_that_are_not_decoded_are_told_from_a_table(frame: str, tmp_path: Path) -> None:
    log = write(tmp_path, "\n".join(frame.format(i=i) for i in range(50)), name="candump.log")
    with pytest.raises(InputError, match=r"line 1: holds frames of a bus that are not decoded; expected .* cantools"):
        take(log, tmp_path / "out")


RISING = "\n".join(["time_s;pwm;winding_degC", *(f"{2 * i};128;{25.0 + 0.1 * i:.2f}" for i in range(80))])


@pytest.mark.parametrize("lost", range(1, 5))
def test_a_log_that_ends_within_a_number_loses_that_row(lost: int, tmp_path: Path) -> None:
    found = take(file(tmp_path, RISING[:-lost]), tmp_path / "runs")
    assert read_run(found.runs[0]).time_s.size == 79
    (said,) = [what for what in found.counted().index if "breaks off" in what]
    assert found.counted().loc[said, "first"] == "line 81"


@pytest.mark.parametrize("text", [RISING, RISING + "\n", RISING[:-1] + "\n", RISING.replace(".", ",")])
def test_a_log_that_ends_with_a_whole_line_loses_nothing(text: str, tmp_path: Path) -> None:
    assert read_run(take(file(tmp_path, text), tmp_path / "runs").runs[0]).time_s.size == 80


def test_where_numbers_are_of_any_length_the_last_one_may_be_whole(tmp_path: Path) -> None:
    text = "\n".join(["time_s,pwm,winding_degC", *(f"{2 * i},128,{25.0 + 0.1 * i:g}" for i in range(81))])
    assert read_run(take(file(tmp_path, text), tmp_path / "runs").runs[0]).time_s.size == 81
