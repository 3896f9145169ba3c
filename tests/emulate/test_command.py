"""`gen emulate` as a user meets it."""

from __future__ import annotations

import json
import os
import re
import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from gen.cli import main
from gen.commands.emulate import _title
from gen.emulate.progress import Milestones
from gen.runs import read_run
from tests.command import GEN
from tests.examples import ROOT

Refuse = Callable[..., str]

COEFFICIENTS = ROOT / "examples" / "my1016" / "coeffs.json"


@pytest.fixture(scope="module")
def home(tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    return {**os.environ, "XDG_CACHE_HOME": str(tmp_path_factory.mktemp("home"))}


@pytest.fixture
def refuse(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Refuse:
    """Run `gen emulate` in this process, where it must end with status 2; give its message."""

    def run(*arguments: str | Path) -> str:
        monkeypatch.setattr(sys, "argv", ["gen", "emulate", *map(str, arguments)])
        with pytest.raises(SystemExit) as ended:
            main()
        assert ended.value.code == 2
        return capsys.readouterr().err

    return run


def emulate(home: dict[str, str], *arguments: str | Path) -> subprocess.CompletedProcess[str]:
    command = [*GEN, "emulate", *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, check=False, env=home)


def test_a_run_with_faults_gives_run_file_summary_and_picture(home: dict[str, str], tmp_path: Path) -> None:
    run, found, plot, image = (tmp_path / name for name in ("run.csv", "run.json", "run.svg", "eeprom.bin"))
    done = emulate(
        home,
        COEFFICIENTS,
        *("--duration", "60", "--profile", "0:102,30:204", "--start", "153:3600", "--ambient", "25"),
        *("--fault", "bearing", "--fault-start", "20", "--sensor-fault", "brush:open:35:45", "--seed", "3"),
        *("--eeprom", image, "--out", run, "--json", found, "--plot", plot),
    )
    assert (done.returncode, told(done.stderr)) == (0, [])
    assert "brush not believed (open, code 1)" in done.stdout
    assert "sensors read beside what is there: " in done.stdout
    measured = read_run(run, ["brush", "bearing", "magnet", "casing"])
    assert 56 <= len(measured.time_s) <= 70
    assert {0, 102, 204} >= set(measured.pwm.tolist()) > {102}
    assert measured.comments["motor_fault"] == "bearing from 20 s"
    assert "encoder batched" in measured.comments["emulated"]
    summary = json.loads(found.read_text())
    assert 0.0 < max(map(abs, summary["sensor_offsets_K"].values())) <= 1.1
    assert set(summary["sensor_offsets_K"]) == {*measured.temps, "ambient"}
    (fault,) = [item for item in summary["disbelieved"] if item["code"] == 1]
    shift = summary["time_zero_s"]
    assert fault["from_s"] + shift == pytest.approx(35.0, abs=0.6)
    assert fault["to_s"] + shift == pytest.approx(45.0, abs=0.6)
    assert summary["board"]["eeprom"]["refused"] == 0
    assert 40.0 < summary["true_at_end_degC"]["brush"] < 90.0
    picture = plot.read_text()
    assert picture.startswith("<?xml")
    assert {"measured − model, K", "brush", "fault: bearing"} <= set(re.findall(r"<text[^>]*>([^<]*)</text>", picture))
    assert image.stat().st_size == 4096


@pytest.mark.parametrize(
    ("fault", "said"),
    [("none", "m, healthy motor, PWM 0:100"), ("bearing from 20 s", "m, fault: bearing from 20 s, PWM 0:100")],
)
def test_a_picture_s_title_says_whether_the_motor_was_healthy(fault: str, said: str) -> None:
    loaded: Any = SimpleNamespace(name="m")
    made: Any = SimpleNamespace(fault=fault)
    assert _title(loaded, made, {"profile": "0:100"}) == said


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--profile", "0:300"], "--profile"),
        (["--profile", "0:1,20000:0"], "--profile"),
        (["--sensor-fault", "rotor:open:1:2"], "--sensor-fault"),
        (["--ambient", "cold"], "--ambient"),
        (["--ambient", "5000"], "error: --ambient: found 5000, expected -273.15 to 1000"),
        (["--power-cut", "20000"], "power_cut"),
        (["--elf", "absent.elf"], "absent.elf"),
        (["--json", "no/such/folder.json"], "folder"),
        (["--encoder", "sometimes"], "encoder"),
    ],
)
def test_bad_options_are_one_message_and_exit_2(
    refuse: Refuse, tmp_path: Path, options: list[str], message: str
) -> None:
    assert message in refuse(COEFFICIENTS, "--out", tmp_path / "run.csv", *options)
    assert not list(tmp_path.iterdir())


def test_a_file_without_wiring_cannot_be_emulated(refuse: Refuse, tmp_path: Path) -> None:
    document = json.loads(COEFFICIENTS.read_text())
    del document["wiring"]
    path = tmp_path / "bare.json"
    path.write_text(json.dumps(document))
    assert "bare.json: $.wiring" in refuse(path, "--out", tmp_path / "run.csv")
    assert not (tmp_path / "run.csv").exists()


def test_an_eeprom_image_of_another_size_is_refused(refuse: Refuse, tmp_path: Path) -> None:
    image = tmp_path / "eeprom.bin"
    image.write_bytes(b"short")
    assert "expected the 4096" in refuse(COEFFICIENTS, "--eeprom", image, "--out", tmp_path / "run.csv")
    assert image.read_bytes() == b"short"


def told(stderr: str) -> list[str]:
    """What was said beside the plain lines that tell how far the run is."""
    return [line for line in stderr.splitlines() if not re.fullmatch(r"\d+ of \d+ s after \d+ s", line)]


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_an_interruption_keeps_what_was_simulated(home: dict[str, str], tmp_path: Path, number: signal.Signals) -> None:
    run, found, plot = (tmp_path / name for name in ("run.csv", "run.json", "run.svg"))
    command = [*GEN, "emulate", str(COEFFICIENTS), "--out", str(run)]
    command += ["--duration", "1000000", "--json", str(found), "--plot", str(plot)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=home) as running:
        assert running.stderr is not None
        line = running.stderr.readline()  # the first plain line: the run is under way
        running.send_signal(number)
        running.send_signal(number)  # impatience does no harm
        _, stderr = running.communicate(timeout=60.0)
    passed = re.fullmatch(r"(\d+) of 1000000 s after \d+ s\n", line)
    assert passed
    assert running.returncode == 130
    (message,) = told(stderr)
    kept = re.fullmatch(rf"interrupted: (\d+) of 1000000 s are kept in {re.escape(str(run))}", message)
    assert kept and int(kept[1]) >= int(passed[1])
    measured = read_run(run, ["brush"])
    assert float(measured.time_s[-1]) == pytest.approx(int(kept[1]), abs=5.0)
    comment = re.fullmatch(r"after (\d+\.\d\d) of 1000000 s", measured.comments["interrupted"])
    assert comment and abs(float(comment[1]) - int(kept[1])) <= 0.5
    assert json.loads(found.read_text())["interrupted"] is True
    assert sorted(path.name for path in tmp_path.iterdir()) == ["run.csv", "run.json", "run.svg"]


def test_a_run_says_what_the_profile_that_it_follows_is_to_decide(home: dict[str, str], tmp_path: Path) -> None:
    profile, run = tmp_path / "profile.csv", tmp_path / "run.csv"
    said = '{"pairs":[],"holds":[[102,3.0]]}'
    profile.write_text(f"# plan: by hand\n# expects: {said}\ntime_s,pwm\n0,102\n2,0\n", encoding="utf-8")
    done = emulate(home, COEFFICIENTS, "--duration", "3", "--profile", profile, "--out", run)
    assert done.returncode == 0, done.stderr
    assert read_run(run).comments["expects"] == said


def test_an_interruption_before_the_first_row_leaves_nothing(home: dict[str, str], tmp_path: Path) -> None:
    port = tmp_path / "port"
    command = [*GEN, "emulate", str(COEFFICIENTS), "--out", str(tmp_path / "run.csv")]
    command += ["--pty", str(port)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=home) as running:
        assert running.stderr is not None
        assert "waiting until it is opened" in running.stderr.readline()
        running.send_signal(signal.SIGINT)
        _, stderr = running.communicate(timeout=60.0)
    assert running.returncode == 130
    assert stderr.strip() == "interrupted"
    assert not list(tmp_path.iterdir())


def test_the_line_s_end_ends_a_recording_in_order(home: dict[str, str], tmp_path: Path) -> None:
    """What `gen log` says when the emulator that it records has come to its end."""
    port = tmp_path / "port"
    command = [*GEN, "emulate", str(COEFFICIENTS), "--out", str(tmp_path / "run.csv")]
    command += ["--pty", str(port), "--duration", "20", "--time-lapse", "20"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=home) as running:
        assert running.stderr is not None
        running.stderr.readline()
        log = [*GEN, "log", str(port), "--out", str(tmp_path / "log.csv")]
        done = subprocess.run(log, capture_output=True, text=True, check=False, timeout=120.0)
        running.communicate(timeout=60.0)
    assert (done.returncode, done.stderr) == (0, "")
    assert re.search(r"^  the line was closed after \d+ s$", done.stdout, re.MULTILINE)
    assert len(read_run(tmp_path / "log.csv").time_s) == len(read_run(tmp_path / "run.csv").time_s)


def test_a_profile_that_is_recorded_drives_a_board_that_nobody_has_armed(home: dict[str, str], tmp_path: Path) -> None:
    port, out = tmp_path / "port", tmp_path / "log.csv"
    command = [*GEN, "emulate", str(COEFFICIENTS), "--out", str(tmp_path / "run.csv")]
    command += ["--pty", str(port), "--duration", "60", "--time-lapse", "10", "--profile", "0:0"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=home) as running:
        assert running.stderr is not None
        running.stderr.readline()
        log = [*GEN, "log", str(port), "--out", str(out), "--profile", "0:0,1:153"]
        done = subprocess.run(log, capture_output=True, text=True, check=False, timeout=120.0)
        running.communicate(timeout=60.0)
    assert (done.returncode, done.stderr) == (0, "")
    assert read_run(out).pwm[-1] == 153


def test_the_clock_may_start_anywhere_up_to_its_rollover(refuse: Refuse, tmp_path: Path) -> None:
    out = ("--out", tmp_path / "run.csv")
    assert "--clock" not in refuse(tmp_path / "missing.json", *out, "--clock", str(2**32 - 1))
    assert "--clock" in refuse(tmp_path / "missing.json", *out, "--clock", str(2**32))


def test_plain_lines_come_soon_then_now_and_then() -> None:
    milestones = Milestones()
    told = [second for second in range(201) if milestones.due(second / 1000.0, float(second))]
    assert told == [5, 35, 65, 95, 100, 130, 160, 190, 200]  # 100 and 200: another tenth is done
