"""`gen live` as a user starts it: address, run file, and what it refuses."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import urllib.error
import urllib.request
from http.cookiejar import CookieJar
from pathlib import Path

import pytest

from gen.runs import read_run
from tests.command import GEN
from tests.examples import ROOT
from tests.live.serving import wait_until

EXAMPLE = ROOT / "examples" / "my1016_rig" / "coeffs.json"
GEN = [*GEN, "live"]
RUN = "time_s,pwm,coil_degC\n" + "".join(f"{k},100,{30 + k}\n" for k in range(50))


def started(*arguments: str | Path, cwd: Path) -> tuple[subprocess.Popen[str], str]:
    """Start it; gives the process and the address that it prints."""
    process = subprocess.Popen(
        [*GEN, *map(str, arguments), "--listen", "0"],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        cwd=cwd,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
    )
    assert process.stderr is not None
    return process, process.stderr.readline().strip()


def ended(process: subprocess.Popen[str], number: int = signal.SIGINT) -> tuple[int, str]:
    process.send_signal(number)
    out, _ = process.communicate(timeout=60)
    return process.returncode, out


def test_a_run_is_played_and_recorded_anew(tmp_path: Path) -> None:
    (tmp_path / "run.csv").write_text(RUN)
    process, address = started("run.csv", "--time-lapse", "1000", "--out", "again.csv", cwd=tmp_path)
    assert re.fullmatch(r"http://127\.0\.0\.1:\d+/\?token=[\w-]{32}", address)
    opener = urllib.request.build_opener(urllib.request.HTTPCookieProcessor(CookieJar()))
    assert b"gen live" in opener.open(address).read()
    base = address.partition("?")[0]
    wait_until(lambda: b"49,100,79" in opener.open(f"{base}1/run.csv").read())
    with pytest.raises(urllib.error.HTTPError, match="403"):
        urllib.request.urlopen(base)
    assert ended(process) == (0, "again.csv: written, 50 rows in all\n")
    assert (
        read_run(tmp_path / "again.csv").temps["coil"].tolist() == read_run(tmp_path / "run.csv").temps["coil"].tolist()
    )


def test_an_emulated_board_is_recorded_and_ends_when_it_is_killed_politely(tmp_path: Path) -> None:
    process, address = started(
        "--emulate", EXAMPLE, "--profile", "0:120", "--time-lapse", "500", "--out", "r.csv", cwd=tmp_path
    )
    opener = urllib.request.build_opener(urllib.request.HTTPCookieProcessor(CookieJar()))
    opener.open(address).read()
    wait_until(lambda: opener.open(address.partition("?")[0] + "1/run.csv").read().count(b"\n") > 30)
    status, out = ended(process, signal.SIGTERM)
    assert (status, out[:6]) == (0, "r.csv:")
    run = read_run(tmp_path / "r.csv")
    assert run.time_s.size > 10
    assert set(run.pwm.tolist()) <= {0, 120}
    assert run.comments["model"] == "my1016_rig"


@pytest.mark.parametrize(
    ("given", "names"), [(["run.csv"], ["again.csv", "one.csv"]), (["--beside"], ["healthy.csv", "faulty.csv"])]
)
def test_two_motors_are_recorded_to_a_file_each(tmp_path: Path, given: list[str], names: list[str]) -> None:
    """A run that was recorded, beside the emulated board of its motor; and that board twice."""
    (tmp_path / "run.csv").write_text(RUN)
    outs = [text for name in names for text in ("--out", name)]
    process, address = started(
        *given, "--emulate", EXAMPLE, "--profile", "0:120", "--time-lapse", "500", *outs, cwd=tmp_path
    )
    opener = urllib.request.build_opener(urllib.request.HTTPCookieProcessor(CookieJar()))
    opener.open(address).read()
    base = address.partition("?")[0]
    wait_until(lambda: all(opener.open(f"{base}{k}/run.csv").read().count(b"\n") > 30 for k in (1, 2)))
    status, out = ended(process)
    assert (status, [line.partition(":")[0] for line in out.splitlines()]) == (0, names)
    first, second = (read_run(tmp_path / name) for name in names)
    assert second.comments["model"] == "my1016_rig"
    assert ("model" in first.comments) == ("--beside" in given)


def test_a_run_file_that_cannot_be_written_does_not_cost_the_other(tmp_path: Path) -> None:
    (tmp_path / "run.csv").write_text(RUN)
    (tmp_path / "gone").mkdir()
    outs = ["--out", "gone/first.csv", "--out", "second.csv"]
    process, address = started("run.csv", "run.csv", "--time-lapse", "1000", *outs, cwd=tmp_path)
    opener = urllib.request.build_opener(urllib.request.HTTPCookieProcessor(CookieJar()))
    opener.open(address).read()
    base = address.partition("?")[0]
    wait_until(lambda: all(b"49,100,79" in opener.open(f"{base}{k}/run.csv").read() for k in (1, 2)))
    (tmp_path / "gone").rmdir()
    process.send_signal(signal.SIGINT)
    out, complaint = process.communicate(timeout=60)
    assert (process.returncode, out) == (2, "")
    assert "gone/first.csv: cannot be written" in complaint
    assert read_run(tmp_path / "second.csv").time_s.size == 50


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ([], "expected a port or a run file, or --emulate COEFFS"),
        (["run.csv", "run.csv", "run.csv"], "two of them at most"),
        (["run.csv", "--emulate", str(EXAMPLE), "--beside"], "two of them at most"),
        (["run.csv", "--beside"], "--beside is of an emulated board: expected --emulate COEFFS"),
        (["run.csv", "run.csv", "--out", "a.csv"], "expected --out as often as there are motors, 2; found it 1 times"),
        (["run.csv", "run.csv", "--out", "a.csv", "--out", "a.csv"], "a.csv: is given twice as a file to write"),
        (["run.csv", "head.csv"], "head.csv: line 1: missing column pwm"),
        (["no-such-port"], "no-such-port: cannot be opened"),
        (["missing.csv"], "missing.csv: there is no such file; expected a run file"),
        (["head.csv"], "head.csv: line 1: missing column pwm"),
        (["run.csv", "--model", "no.json"], "no.json: "),
        (["--emulate", "no.json"], "no.json: "),
        (["run.csv", "--out", "run.csv"], "run.csv: is read by this command and would be overwritten"),
        (["run.csv", "--out", "no/where.csv"], "no/where.csv: cannot be written"),
        (["run.csv", "--listen", "somewhere"], '--listen: found "somewhere", expected PORT or HOST:PORT'),
        (["run.csv", "--listen", "192.0.2.1:80"], "--listen: nobody can listen on 192.0.2.1, port 80"),
        (["--emulate", str(EXAMPLE), "--plant", "model", "--profile", "0:300"], "--profile: found PWM 300"),
    ],
)
def test_bad_usage_is_one_message_and_status_2(tmp_path: Path, arguments: list[str], message: str) -> None:
    (tmp_path / "run.csv").write_text(RUN)
    (tmp_path / "head.csv").write_text(RUN.replace("pwm", "speed"))
    done = subprocess.run([*GEN, *arguments], capture_output=True, text=True, check=False, cwd=tmp_path)
    assert (done.returncode, done.stdout) == (2, "")
    assert message in done.stderr
    assert "Traceback" not in done.stderr


def test_two_pages_cannot_listen_on_one_port(tmp_path: Path) -> None:
    (tmp_path / "run.csv").write_text(RUN)
    process, address = started("run.csv", cwd=tmp_path)
    port = re.findall(r":(\d+)/", address)[0]
    done = subprocess.run(
        [*GEN, "run.csv", "--listen", port], capture_output=True, text=True, check=False, cwd=tmp_path
    )
    assert (done.returncode, done.stderr.count("\n")) == (2, 1)
    assert "nobody can listen on 127.0.0.1" in done.stderr
    assert ended(process)[0] == 0
