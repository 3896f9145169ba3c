"""The commands as a user and a script meet them."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from functools import partial
from pathlib import Path

import pytest

from gen.cli import main
from gen.verification import verify as verification
from tests.cli.commands import COEFFICIENTS, GEN, broken, gen
from tests.examples import ROOT


@pytest.mark.parametrize("command", ["build", "verify", "check", "simulate"])
def test_every_command_has_help_with_an_example(command: str) -> None:
    done = gen(command, "--help")
    assert done.returncode == 0
    given = "firmware_out" if command == "check" else "examples/"
    assert f"gen {command} {given}" in " ".join(done.stdout.split())


@pytest.mark.parametrize("command", ["build", "verify", "simulate"])
def test_bad_input_is_one_line_with_file_and_place_and_exit_2(command: str, tmp_path: Path) -> None:
    path = broken(tmp_path, '"order": 3', '"order": 5')
    extras: dict[str, list[str | Path]] = {
        "build": ["--out", tmp_path / "out"],
        "verify": [],
        "simulate": [tmp_path / "run.csv"],
    }
    extra = extras[command]
    done = gen(command, path, *extra)
    assert done.returncode == 2
    assert done.stdout == ""
    lines = done.stderr.strip().splitlines()
    assert len(lines) == 1
    assert str(path) in lines[0]
    assert "$.components[0].order" in lines[0]
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("place", ["", "missing/v.json"])
def test_verify_finds_an_unwritable_output_before_its_work(
    place: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def work(*_: object, **__: object) -> None:
        raise AssertionError("work began")

    monkeypatch.setattr(verification, "verify", work)
    monkeypatch.setattr(sys, "argv", ["gen", "verify", str(COEFFICIENTS), "--json", str(tmp_path / place)])
    with pytest.raises(SystemExit) as ended:
        main()
    assert ended.value.code == 2
    assert capsys.readouterr().err.startswith(f"error: {tmp_path / place}: ")


def test_a_bad_option_is_usage_and_exit_2() -> None:
    done = gen("build", COEFFICIENTS, "--arithmetic", "double")
    assert done.returncode == 2
    assert "Traceback" not in done.stderr


def test_a_bound_over_the_file_s_limit_names_the_component_and_exits_1(tmp_path: Path) -> None:
    path = broken(tmp_path, '"fixed_limit_K": 1e-05', '"fixed_limit_K": 1e-09')
    done = gen("build", path, "--out", tmp_path / "out")
    assert done.returncode == 1
    assert "brush" in done.stderr
    assert "$.accuracy.fixed_limit_K" in done.stderr
    assert not (tmp_path / "out").exists()


def test_build_says_of_each_component_what_is_proven(tmp_path: Path) -> None:
    done = gen("build", ROOT / "examples" / "my1016_rig" / "coeffs.json", "--out", tmp_path / "out")
    assert done.returncode == 0, done.stderr
    lines = done.stdout.splitlines()[1:]
    assert [line.split(":")[0].strip() for line in lines] == ["brush", "bearing", "magnet", "casing"]
    assert all("K from the exact solution" in line for line in lines)


def test_build_says_that_an_effect_s_bound_is_not_proven(tmp_path: Path) -> None:
    done = gen("build", ROOT / "examples" / "two_mass_refined" / "coeffs.json", "--out", tmp_path / "out")
    assert done.returncode == 0, done.stderr
    for name in ("winding", "housing"):
        assert f"{name}, baseline: never more than" in done.stdout
        assert f"{name}, with effects: bound not proven" in done.stdout


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
@pytest.mark.parametrize("at_work", [False, True])
def test_an_interrupted_verify_leaves_no_files_and_says_so(
    number: signal.Signals, at_work: bool, tmp_path: Path
) -> None:
    scratch = tmp_path / "scratch"
    scratch.mkdir()
    process = subprocess.Popen(
        [*GEN, "verify", str(COEFFICIENTS), "--json", str(tmp_path / "v.json")],
        stderr=subprocess.PIPE,
        text=True,
        env={**os.environ, "TMPDIR": str(scratch)},
    )
    time.sleep(0.1)  # before its work the interpreter may still be starting
    while at_work and process.poll() is None and not any(scratch.iterdir()):
        time.sleep(0.05)
    process.send_signal(number)
    said = process.communicate()[1]
    if at_work:
        # Interrupted inside exec(), CPython ends with SIGINT whatever the status: a shell shows 130 for it.
        assert process.returncode in (128 + number, -signal.SIGINT)
        assert said.strip() == "interrupted"
    assert process.returncode != 0
    assert [item for item in tmp_path.rglob("*") if item != scratch] == []


def test_an_interrupt_that_compiled_code_takes_for_an_error_is_one_all_the_same(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def importing(**_: object) -> None:
        try:
            os.kill(os.getpid(), signal.SIGINT)
            time.sleep(5.0)
        except KeyboardInterrupt:
            raise ImportError("numpy failed to import") from None

    monkeypatch.setattr("gen.cli.cli.main", importing)
    with pytest.raises(SystemExit) as ended:
        main()
    assert ended.value.code == 130
    assert capsys.readouterr().err == "interrupted\n"


def test_a_coefficient_file_s_odd_name_does_not_break_the_firmware(tmp_path: Path) -> None:
    path = tmp_path / os.fsdecode(b"a\n#error \xff\\")
    path.write_bytes(COEFFICIENTS.read_bytes())
    done = gen("build", path, "--out", tmp_path / "out")
    assert done.returncode == 0, done.stderr
    header = (tmp_path / "out" / "lib" / "my1016" / "src" / "my1016.h").read_text(encoding="utf-8")
    assert "a?#error ??" in header


def test_a_file_s_bytes_do_not_steer_the_terminal(tmp_path: Path) -> None:
    run = tmp_path / "run.csv"
    run.write_bytes(b"\x1b[2Jtime,pwm\r,b\x07\n1,2,3\n")
    done = gen("simulate", COEFFICIENTS, run, "--out", tmp_path / "out.csv")
    assert done.returncode == 2
    assert "\\x1b[2Jtime" in done.stderr
    assert done.stderr.rstrip("\n").isprintable()


@pytest.mark.parametrize("planted", [True, False])
def test_verify_ends_with_1_if_a_word_differs_and_says_so_in_its_json(
    planted: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """What a script looks at: the status, and the verdict."""

    def wrong(files: dict[str, str]) -> dict[str, str]:
        path = next(path for path in files if path.endswith("_word.h"))
        old = "(uint16_t)(whole & 0xFFFF)"
        assert old in files[path]
        return files | {path: files[path].replace(old, "(uint16_t)(whole & 0xFFFE)", 1)}

    run = partial(verification.verify, mutation=wrong if planted else None)
    monkeypatch.setattr(verification, "verify", run)
    out = tmp_path / "v.json"
    options = ["--arithmetic", "fixed", "--schedule", "table", "--target", "host", "--compilers", "g++"]
    monkeypatch.setattr(
        sys, "argv", ["gen", "verify", str(COEFFICIENTS), *options, "--scale", "0.005", "--json", str(out)]
    )
    try:
        main()
        status: object = 0
    except SystemExit as ended:
        status = ended.code or 0
    assert status == (1 if planted else 0)
    found = json.loads(out.read_text())
    assert found["verdict"] == ("different" if planted else "equal")
    assert (found["differing"] > 0) == planted
    assert {target["target"].split()[0] for target in found["combinations"][0]["targets"]} == {"g++"}
    said = capsys.readouterr()
    assert ("words differ" in said.err) == planted
    assert ("none differs" in said.out) != planted
