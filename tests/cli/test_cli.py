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
from tests.cli.commands import COEFFICIENTS, broken
from tests.command import GEN, gen
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


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (
            ["build", "c.json", "--arithmetic", "double"],
            "--arithmetic: 'double' is not one of 'fixed', 'float' (gen build",
        ),
        (["build"], "missing argument 'COEFFS' (gen build"),
        (["build", "a.json", "b.json"], "got unexpected extra argument (b.json) (gen build"),
        (["build", "c.json", "--nothing"], "no such option '--nothing'"),
        (["build", "c.json", "--out"], "option '--out' requires an argument"),
        (
            ["identify", "a.csv", "--out", "c.json", "--max-hidden", "9"],
            "--max-hidden: 9 is not in the range 0<=x<=3 (gen",
        ),
        (["refine", "c.json", "--fit", "--test", "b.csv"], "option '--fit' requires at least one run file (gen refine"),
        (["fleet", "add"], "missing option '--motor' (gen fleet add"),
        (["nothing"], "no such command 'nothing' (gen"),
        (["build", "\x1b[2J\n", "--out"], "option '--out' requires an argument"),
        (["build", "c.json", "\x1b[2J\nb"], "got unexpected extra argument (\\x1b[2J b) (gen build"),
    ],
)
def test_wrong_usage_is_one_line_with_its_place_and_exit_2(arguments: list[str], said: str) -> None:
    done = gen(*arguments)
    assert (done.returncode, done.stdout, done.stderr.count("\n")) == (2, "", 1)
    assert done.stderr.replace("python -m gen", "gen").startswith(f"error: {said}")


def test_without_any_argument_the_help_is_shown() -> None:
    done = gen()
    assert done.returncode == 2
    assert "Commands:" in done.stdout + done.stderr


NOT_YET = """
import os, signal, sys, time
try:
    os.kill(os.getpid(), signal.SIGINT)
    time.sleep(5.0)
except KeyboardInterrupt:
    raise ImportError("as compiled code has it") from None
"""


def test_an_interrupt_while_the_command_is_loaded_is_quiet(tmp_path: Path) -> None:
    """It comes when the first package is imported, which takes it for a failure of its own."""
    (tmp_path / "click.py").write_text(NOT_YET)
    path = os.pathsep.join([str(tmp_path), str(ROOT)])
    done = subprocess.run(
        GEN, capture_output=True, text=True, check=False, cwd=tmp_path, env={**os.environ, "PYTHONPATH": path}
    )
    assert (done.returncode, done.stdout, done.stderr) == (130, "", "interrupted\n")


def test_nothing_slow_is_imported_before_an_interrupt_can_be_taken() -> None:
    looked = "import sys; before = set(sys.modules); import gen.__main__; print(*sorted(set(sys.modules) - before))"
    done = subprocess.run([sys.executable, "-c", looked], capture_output=True, text=True, check=True)
    assert not {"typing", "re", "importlib.metadata", "click", "contextlib"} & set(done.stdout.split())


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
    *lines, asleep = done.stdout.splitlines()[1:]
    assert [line.split(":")[0].strip() for line in lines] == ["brush", "bearing", "magnet", "casing"]
    assert all("K from the exact solution" in line for line in lines)
    # Of the rules only this one asks what a warm start does not know: a brush's slopes.
    assert "after a start from the measured temperatures of a warm motor rules sleep" in asleep
    assert "brush_hot 2 h 02 min" in asleep
    assert "casing_hot" not in asleep


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
