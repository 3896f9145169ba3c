"""Run files: what is read, what is written, and where a fault is said to be."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gen.errors import InputError
from gen.runs import Run, read_run, write_columns, write_run
from tests.campaign import FULL
from tests.work import lines

GOOD = "time_s,pwm,brush_degC,ambient_degC,current_A\n0,0,30.25,30,\n0.25,-255,,30.5,0.7\n1e1,51,31,,.5\n"


@pytest.fixture
def file(tmp_path: Path) -> Path:
    return tmp_path / "run.csv"


def written(file: Path, text: str | bytes) -> Path:
    file.write_bytes(text if isinstance(text, bytes) else text.encode())
    return file


def test_good_run(file: Path) -> None:
    run = read_run(written(file, "# motor: MY1016: no load\n# cold\n" + GOOD))
    assert run.time_s.tolist() == [0.0, 0.25, 10.0]
    assert run.pwm.tolist() == [0, -255, 51]
    assert run.pwm.dtype == np.int64
    assert run.temps.keys() == {"brush"}
    assert np.array_equal(run.temps["brush"], [30.25, np.nan, 31.0], equal_nan=True)
    assert run.ambient is not None
    assert np.array_equal(run.ambient, [30.0, 30.5, np.nan], equal_nan=True)
    assert np.array_equal(run.extras["current_A"], [np.nan, 0.7, 0.5], equal_nan=True)
    assert run.comments == {"motor": "MY1016: no load", "cold": ""}


@pytest.mark.parametrize(
    "text",
    [
        "\ufeff" + GOOD,
        GOOD.replace("\n", "\r\n"),
        GOOD + "\n\n",
        GOOD.rstrip("\n"),
        GOOD.replace(",", " , "),
        GOOD.replace("0.25,-255", "\t2.5e-1 ,-2.55E+2"),
        "\n\n" + GOOD,
    ],
)
def test_forms_that_mean_the_same(file: Path, text: str) -> None:
    expected, run = read_run(written(file, GOOD)), read_run(written(file, text))
    assert np.array_equal(run.time_s, expected.time_s)
    assert np.array_equal(run.pwm, expected.pwm)
    assert np.array_equal(run.temps["brush"], expected.temps["brush"], equal_nan=True)
    assert np.array_equal(run.extras["current_A"], expected.extras["current_A"], equal_nan=True)


def test_components_choose_the_columns(file: Path) -> None:
    written(file, "time_s,pwm,brush_degC,board_degC,room_degC\n0,1,2,3,4\n")
    run = read_run(file, ["brush", "bearing"], ambient="room_degC")
    assert run.temps.keys() == {"brush"}
    assert run.extras.keys() == {"board_degC"}
    assert run.ambient is not None
    assert run.ambient.tolist() == [4.0]
    assert read_run(file).ambient is None


FAULTS = [
    ("", None, "the file is empty"),
    (" \n\n", None, "the file is empty"),
    ("# only\n# comments\n", "line 2", "only comments"),
    ("time_s,pwm\n", "line 2", "there are no rows"),
    ("0,0\n0.25,1\n", "line 1", "found numbers, expected a header line"),
    ("time_s,brush_degC\n0,1\n", "line 1", "missing column pwm; found time_s, brush_degC"),
    ("# a: b\npwm\n0\n", "line 2", "missing column time_s; found pwm; `gen import` makes run files of a logger's own"),
    ("time_s;pwm\n0;1\n", "line 1", "missing column time_s; found time_s;pwm; expected commas"),
    ("time_s,pwm,a,a\n0,1,2,3\n", "line 1, column a", "twice in the header"),
    ("time_s,pwm,\n0,1,2\n", "line 1", "column 3 has no name"),
    ("time_s,pwm,x\n0,1,2\n0.25,1\n", "line 3", "found 2 fields, expected 3"),
    ("time_s,pwm,x\n0,1,2,3\n", "line 2", "found 4 fields, expected 3"),
    ("time_s,pwm\n0,1\n\n1,1\n", "line 3", "found an empty line between the rows"),
    ("time_s,pwm\n0,1\n# late: 1\n1,1\n", "line 3", "found a comment, expected it before the header"),
    ("# c\ntime_s,pwm,x\n0,1,2\n1,1,abc\n", "line 4, column x", 'found "abc", expected a number, or nothing'),
    ("time_s,pwm,x\n0,1,NaN\n", "line 2, column x", 'found "NaN", expected a number'),
    ("time_s,pwm,x\n0,1,inf\n", "line 2, column x", 'found "inf", expected a number'),
    ("time_s,pwm,x\n0,1,1e999\n", "line 2, column x", 'found "1e999", expected a finite number'),
    ("time_s,pwm,x\n0,1,1_0\n", "line 2, column x", 'found "1_0", expected a number'),
    ("time_s,pwm,x\n0,1,0x1F\n", "line 2, column x", 'found "0x1F", expected a number'),
    ("time_s,pwm,x\n0,1,1 2\n", "line 2, column x", 'found "1 2", expected a number'),
    ("time_s,pwm,x\n0,1,1.2.3\n", "line 2, column x", 'found "1.2.3", expected a number'),
    ("time_s,pwm,x\n0,1,-\n", "line 2, column x", 'found "-", expected a number'),
    ("time_s,pwm,x\n0,1,1e\n", "line 2, column x", 'found "1e", expected a number'),
    ('time_s,pwm,x\n0,1,"2"\n', "line 2, column x", 'found ""2"", expected a number'),
    ("time_s,pwm\n0,1\n0,1\n", "line 3, column time_s", "found 0, expected more than 0 s"),
    ("time_s,pwm\n1,1\n0.5,1\n", "line 3, column time_s", "found 0.5, expected more than 1 s"),
    ("time_s,pwm\n30.2,1\n30.1,1\n", "line 3, column time_s", "found 30.1, expected more than 30.2 s"),
    ("time_s,pwm,a_degC\n0,1,6000.1\n", "line 2, column a_degC", "found 6000.1, expected a number within"),
    ("time_s,pwm\n1,1\n,1\n", "line 3, column time_s", "found nothing, expected a number in every row"),
    ("time_s,pwm\n1,\n", "line 2, column pwm", "found nothing, expected a number in every row"),
    ("time_s,pwm\n0,1\n1,256\n", "line 3, column pwm", "found 256, expected a whole number -255..255"),
    ("time_s,pwm\n0,-256\n", "line 2, column pwm", "found -256, expected a whole number -255..255"),
    ("time_s,pwm,a_degC\n0,1,20\n1,1,1e300\n", "line 3, column a_degC", "expected a number within -273.15..5000"),
    ("time_s,pwm,a_degC\n0,1,-300\n", "line 2, column a_degC", "found -300, expected a number within"),
    ("time_s,pwm\n0,1\n1e300,1\n", "line 3, column time_s", "expected a number within -1e+12..1e+12"),
    ("time_s,pwm,load_A\n0,1,-1e200\n", "line 2, column load_A", "expected a number within"),
    ("time_s,pwm\n0,1.5\n", "line 2, column pwm", "found 1.5, expected a whole number -255..255"),
    (b"time_s,pwm\n0,1\n1,\xff\n", "line 3", "byte 0xff is not UTF-8; expected a UTF-8 text; `gen import`"),
    (b"time_s,pw\xff\n0,1\n", "line 1", "byte 0xff is not UTF-8"),
]


@pytest.mark.parametrize(("text", "place", "message"), FAULTS)
def test_faults(file: Path, text: str | bytes, place: str | None, message: str) -> None:
    with pytest.raises(InputError) as caught:
        read_run(written(file, text))
    assert caught.value.place == place
    assert caught.value.file == str(file)
    assert message in caught.value.message
    assert "\n" not in str(caught.value)


def test_required_component(file: Path) -> None:
    written(file, GOOD)
    assert read_run(file, ["brush"], require=["brush"]).temps.keys() == {"brush"}
    with pytest.raises(InputError, match="missing column casing_degC; found time_s, pwm, brush_degC"):
        read_run(file, require=["casing"])


def test_files_that_are_none(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no such file"):
        read_run(tmp_path / "none.csv")
    with pytest.raises(InputError, match="is a directory"):
        read_run(tmp_path)


def test_a_fault_far_down_is_located(file: Path) -> None:
    rows = [f"{i / 4},{i % 256},30" for i in range(60_000)]
    rows[45_678] = rows[45_678].replace(",30", ",3o")
    with pytest.raises(InputError, match='line 45680, column x: found "3o"'):
        read_run(written(file, "time_s,pwm,x\n" + "\n".join(rows) + "\n"))


celsius, others = st.floats(-273.15, 5000.0), st.floats(-1e12, 1e12)


@settings(max_examples=100, deadline=None)
@given(
    st.lists(
        st.tuples(st.integers(1, 10**9), st.integers(-255, 255), celsius | st.just(np.nan), celsius, others),
        min_size=1,
        max_size=20,
    ),
    st.booleans(),
)
def test_round_trip_is_exact(
    tmp_path_factory: pytest.TempPathFactory, rows: list[tuple[int, int, float, float, float]], with_ambient: bool
) -> None:
    file = tmp_path_factory.mktemp("runs") / "run.csv"
    columns = list(zip(*rows, strict=True))
    run = Run(
        time_s=np.cumsum(columns[0]) * 0.1,
        pwm=np.array(columns[1], dtype=np.int64),
        temps={"brush": np.array(columns[2], dtype=float)},
        ambient=np.array(columns[3], dtype=float) if with_ambient else None,
        extras={"speed_rpm": np.array(columns[4], dtype=float)},
        comments={"motor": "MY1016: cold", "free": ""},
    )
    write_run(file, run)
    again = read_run(file)
    assert np.array_equal(again.time_s, run.time_s)
    assert np.array_equal(again.pwm, run.pwm)
    assert np.array_equal(again.temps["brush"], run.temps["brush"], equal_nan=True)
    assert np.array_equal(again.extras["speed_rpm"], run.extras["speed_rpm"])
    assert (again.ambient is None) == (run.ambient is None)
    assert again.comments == run.comments


field = st.text('0123456789.eE+-naifNI_ "#\t\x00,\r', max_size=4)


@settings(max_examples=300, deadline=None)
@given(st.lists(st.lists(field, min_size=3, max_size=3), min_size=1, max_size=4))
def test_any_fields_are_read_as_python_would_or_named(
    tmp_path_factory: pytest.TempPathFactory, rows: list[list[str]]
) -> None:
    text = "time_s,pwm,x\n" + "".join(f"{i},0,{','.join(row)}\n" for i, row in enumerate(rows))
    file = written(tmp_path_factory.getbasetemp() / "any.csv", text.replace("x\n", "x,y,z\n", 1))
    try:
        run = read_run(file)
    except InputError as error:
        assert error.place
        return
    for name, index in (("x", 0), ("y", 1), ("z", 2)):
        expected = [float(row[index].strip() or "nan") for row in rows]
        assert np.array_equal(run.extras[name], expected, equal_nan=True)


def test_writing_is_all_or_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file = written(tmp_path / "run.csv", GOOD)
    run = read_run(file)

    def full(*args: object, **kwargs: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("pandas.DataFrame.to_csv", full)
    with pytest.raises(InputError, match="cannot be written: No space left on device"):
        write_run(file, run)
    assert file.read_text(encoding="utf-8") == GOOD
    assert [p.name for p in tmp_path.iterdir()] == ["run.csv"]


def test_places_that_cannot_be_written(tmp_path: Path) -> None:
    columns = {"time_s": np.array([0.0])}
    with pytest.raises(InputError, match="cannot be written"):
        write_columns(tmp_path / "none" / "run.csv", columns)
    with pytest.raises(InputError, match="is a folder"):
        write_columns(tmp_path, columns)
    assert list(tmp_path.iterdir()) == []


def test_a_link_stays_a_link(tmp_path: Path) -> None:
    target, link = tmp_path / "target.csv", tmp_path / "link.csv"
    link.symlink_to(target)
    write_columns(link, {"time_s": np.array([0.5])})
    assert link.is_symlink()
    assert target.read_text(encoding="utf-8") == "time_s\n0.5\n"


def test_names_that_would_break_the_file(tmp_path: Path) -> None:
    column = np.array([0.0])
    for name in ("", "a,b", "a\nb", '"', " a"):
        with pytest.raises(ValueError, match=r"column's name|line break"):
            write_columns(tmp_path / "x.csv", {name: column})
    with pytest.raises(ValueError, match="first colon"):
        write_columns(tmp_path / "x.csv", {"a": column}, {"a:b": "c"})


def test_well_formed_rows_cost_two_lines_and_a_field_each(file: Path) -> None:
    """The slow way, which names faults, takes more than five times as many."""
    header = b"time_s,pwm,brush_degC,bearing_degC,magnet_degC,casing_degC,ambient_degC\n"

    def read(n: int, row: bytes) -> int:
        written(file, header + b"".join(b"%d.25" % i + row for i in range(n)))
        made = lines(lambda: read_run(file))
        assert read_run(file).time_s.size == n
        return made

    half, whole = (read(n, b",12,30.25,41.5,40,39.75,30\n") for n in (20_000, 40_000))
    assert whole < 2.01 * half
    assert whole < 10 * 40_000
    assert read(1_000, b", 12,30.25,41.5,40,39.75,30\n") > 30 * 1_000  # spaces are allowed, and go the slow way


LONG = 60_000


def _long(file: Path, pwm: np.ndarray, columns: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Write a run of LONG rows at 4 Hz."""
    made = {"time_s": np.arange(LONG) * 0.25, "pwm": pwm, **columns}
    write_columns(file, made)
    return made


def test_thinning_keeps_samples_as_they_are_and_every_change_of_pwm(file: Path) -> None:
    random = np.random.default_rng(3)
    pwm = np.repeat(random.integers(-255, 256, 60), LONG // 60)
    values = np.where(random.random(LONG) < 0.1, np.nan, np.round(random.normal(40, 5, LONG) * 4) / 4)
    current = np.where(np.arange(LONG) % 2 == 0, 1.0, 3.0)
    full = _long(file, pwm, {"casing_degC": values, "current_A": current})
    run = read_run(file, most_rows=6_000)
    assert 4_000 < run.time_s.size < 8_000
    assert run.rows_in_file == LONG
    assert run.thinned == f"60000 rows, of which {run.time_s.size} are used: errors are of these"
    assert read_run(file).thinned == ""
    assert run.time_s[0] == 0.0
    assert run.time_s[-1] == full["time_s"][-1]
    rows = np.rint(run.time_s * 4).astype(int)
    assert np.array_equal(run.pwm, pwm[rows])
    assert np.array_equal(run.temps["casing"], values[rows], equal_nan=True)
    held = run.pwm[np.searchsorted(run.time_s, full["time_s"], side="right") - 1]
    assert np.array_equal(held, pwm)
    whole = np.average(run.extras["current_A"][:-1], weights=np.diff(run.time_s))
    assert whole == pytest.approx(np.mean(current[:-1]), abs=1e-3)


@pytest.mark.parametrize("sensors", [2, 3])
def test_thinning_leaves_sensors_that_take_turns_their_share(file: Path, sensors: int) -> None:
    """One row in ten of those with a reading is to stay: of two sensors in turn that would be always the same one."""
    row = np.arange(LONG)
    turns = {f"t{i}_degC": np.where(row % (10 * sensors) == 10 * i, 30.0 + i, np.nan) for i in range(sensors)}
    _long(file, np.full(LONG, 102), turns)
    run = read_run(file, most_rows=600)
    counts = [int(np.isfinite(values).sum()) for values in run.temps.values()]
    assert min(counts) > 450 / sensors
    assert max(counts) - min(counts) <= 2


def test_thinning_goes_on_where_a_sensor_was_lost(file: Path) -> None:
    """One that dies after a tenth of the run takes nothing from the others in the rest."""
    row = np.arange(LONG)
    lost, whole = np.where(row < LONG // 10, 30.0, np.nan), np.full(LONG, 40.0)
    _long(file, np.full(LONG, 102), {"bearing_degC": lost, "winding_degC": whole})
    run = read_run(file, most_rows=6_000)
    after = run.time_s > 0.11 * run.time_s[-1]
    assert int(np.isfinite(run.temps["winding"][after]).sum()) > 4_500


def test_thinning_averages_a_pwm_that_changes_with_every_row(file: Path) -> None:
    random = np.random.default_rng(4)
    pwm = -np.clip(100 + random.integers(-9, 10, LONG), 0, 255)
    _long(file, pwm, {"casing_degC": np.full(LONG, 30.0)})
    run = read_run(file, most_rows=600)
    assert run.time_s.size < 1_000
    assert np.all(run.pwm < 0)
    assert np.average(run.pwm[:-1], weights=np.diff(run.time_s)) == pytest.approx(pwm.mean(), abs=0.1)


def test_a_fault_in_a_row_that_thinning_takes_out_is_found(file: Path) -> None:
    rows = [f"{i / 4},{i // 1000},30" for i in range(LONG)]
    rows[54_321] = rows[54_320]
    with pytest.raises(InputError, match="line 54323, column time_s"):
        read_run(written(file, "time_s,pwm,x_degC\n" + "\n".join(rows) + "\n"), most_rows=100)


def test_what_a_board_says_of_its_model_is_no_measurement(file: Path) -> None:
    written(file, "time_s,pwm,brush_degC,brush_model_degC,my_model_degC,flags\n0,1,30,31,32,0\n")
    run = read_run(file)
    assert run.temps.keys() == {"brush", "my_model"}
    assert run.extras.keys() == {"brush_model_degC", "flags"}


_PEAK = """
import resource, sys
from gen.runs import read_run
peak = lambda: resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024
before = peak()
run = read_run(sys.argv[1], most_rows=100_000)
print(peak() - before)
"""


@pytest.mark.campaign
def test_memory_of_a_long_log(file: Path) -> None:
    """Thirty bytes a row for time, PWM, ambient and four temperatures: a third of a gigabyte for ten million rows."""
    n = 10_000_000 if FULL else 500_000
    row = b",12,30.25,41.5,40,39.75,30\n"
    with file.open("wb") as stream:
        stream.write(b"time_s,pwm,brush_degC,bearing_degC,magnet_degC,casing_degC,ambient_degC\n")
        for first in range(0, n, 100_000):
            stream.write(b"".join(b"%d.25" % i + row for i in range(first, first + 100_000)))
    done = subprocess.run([sys.executable, "-c", _PEAK, str(file)], capture_output=True, text=True, check=True)
    assert int(done.stdout) < 60 * n + 60e6
