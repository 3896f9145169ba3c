"""The commands as a user and a script meet them."""

from __future__ import annotations

import hashlib
import json
import os
import re
import shutil
import signal
import subprocess
import sys
import time
from functools import partial
from pathlib import Path

import pytest

from gen.cli import main
from gen.errors import InputError
from gen.files import check_outputs, replace_folder, write_text
from gen.verification import verify as verification
from tests.examples import ROOT

COEFFICIENTS = ROOT / "examples" / "my1016" / "coeffs.json"
OLD = "old"
MANIFEST = json.dumps({"tool": "gen 0.1.0", "files": {"a/b.txt": hashlib.sha256(OLD.encode()).hexdigest()}})
GEN = [sys.executable, "-m", "gen"]


def gen(*arguments: str | Path, cwd: Path | None = None) -> subprocess.CompletedProcess[str]:
    return subprocess.run([*GEN, *map(str, arguments)], capture_output=True, text=True, check=False, cwd=cwd)


@pytest.mark.parametrize("command", ["build", "verify", "check", "simulate"])
def test_every_command_has_help_with_an_example(command: str) -> None:
    done = gen(command, "--help")
    assert done.returncode == 0
    given = "firmware_out" if command == "check" else "examples/"
    assert f"gen {command} {given}" in " ".join(done.stdout.split())


def broken(tmp_path: Path, old: str, new: str) -> Path:
    text = COEFFICIENTS.read_text()
    assert old in text
    path = tmp_path / "broken.json"
    path.write_text(text.replace(old, new, 1))
    return path


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


@pytest.fixture(scope="module")
def emitted(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A project that nobody edits."""
    folder = tmp_path_factory.mktemp("emitted") / "project"
    assert gen("build", COEFFICIENTS, "--out", folder).returncode == 0
    return folder


def test_check_says_what_is_proven_of_each_part(emitted: Path) -> None:
    done = gen("check", emitted, "--coefficients", COEFFICIENTS)
    assert (done.returncode, done.stderr) == (0, "")
    *parts, last = done.stdout.splitlines()
    assert [line.split(":")[0].strip() for line in parts] == ["brush", "bearing", "magnet", "casing"]
    claimed = json.loads((emitted / "certificate.json").read_text())["components"]
    for line, part in zip(parts, claimed, strict=True):
        word, reading = (float(number) for number in re.findall(r"([\d.e-]+) K", line))
        assert (word, reading) == (part["bound_K"], part["reading_K"])
    assert re.fullmatch(rf"{emitted}: \d+ inequalities hold", last)


@pytest.mark.parametrize("content", [None, '{"format": "gen-certificate", "version": 1', "[]", '{"format": "other"}'])
def test_check_names_a_certificate_that_is_none(content: str | None, tmp_path: Path) -> None:
    if content is not None:
        (tmp_path / "certificate.json").write_text(content)
    done = gen("check", tmp_path)
    assert (done.returncode, done.stdout, done.stderr.count("\n")) == (2, "", 1)
    assert done.stderr.startswith(f"error: {tmp_path / 'certificate.json'}: ")


def test_check_of_a_project_that_is_not_whole(emitted: Path, tmp_path: Path) -> None:
    """Without its manifest it is no project; without a source there is nothing that the claims follow from."""
    project = shutil.copytree(emitted, tmp_path / "project")
    (project / "manifest.json").unlink()
    done = gen("check", project)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.splitlines()[-1].startswith(f"error: {project / 'manifest.json'}: ")
    (project / "lib" / "my1016" / "src" / "my1016_step.h").unlink()
    done = gen("check", project)
    assert (done.returncode, done.stdout) == (1, "")
    assert done.stderr.splitlines()[-1].startswith("failed: the library does not compile: ")


def test_check_fails_with_the_coefficients_of_another_motor(emitted: Path, tmp_path: Path) -> None:
    """Of another name, and of the same name with a gain that differs in its last digit."""
    text = COEFFICIENTS.read_text()
    gain = json.loads(text)["components"][1]["gain"]
    first = str(next(iter(gain.values()))[0])
    assert first in text
    near = tmp_path / "near.json"
    near.write_text(text.replace(first, f"{first}1", 1))
    for other, message in (
        (ROOT / "examples" / "two_mass" / "coeffs.json", "another model or domain"),
        (near, "another equation of bearing"),
    ):
        done = gen("check", emitted, "--coefficients", other)
        assert (done.returncode, done.stdout) == (1, "")
        assert done.stderr.splitlines()[-1] == f"failed: the certificate is about {message}"


def test_build_refuses_a_folder_that_is_not_its_own(tmp_path: Path) -> None:
    (tmp_path / "precious.txt").write_text("mine")
    done = gen("build", COEFFICIENTS, "--out", tmp_path)
    assert done.returncode == 2
    assert (tmp_path / "precious.txt").read_text() == "mine"
    assert [item.name for item in tmp_path.iterdir()] == ["precious.txt"]


def test_an_interrupted_build_leaves_nothing_half_written(tmp_path: Path) -> None:
    for delay in (0.2, 0.6, 0.9, 1.1, 1.3):
        process = subprocess.Popen(
            [*GEN, "build", str(COEFFICIENTS), "--out", str(tmp_path / "out")], stderr=subprocess.PIPE
        )
        time.sleep(delay)
        process.send_signal(signal.SIGINT)
        process.communicate()
        if (tmp_path / "out").exists():
            listed = json.loads((tmp_path / "out" / "manifest.json").read_text())["files"]
            assert all((tmp_path / "out" / path).is_file() for path in listed)
        assert [item.name for item in tmp_path.iterdir() if item.name != "out"] == []


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


def test_a_full_disk_behind_the_output_is_one_line(tmp_path: Path) -> None:
    with Path("/dev/full").open("w") as full:
        done = subprocess.run(
            [*GEN, "simulate", COEFFICIENTS, run_file(tmp_path), "--out", tmp_path / "model.csv"],
            stdout=full,
            stderr=subprocess.PIPE,
            text=True,
            check=False,
        )
    assert done.returncode == 2
    assert done.stderr == "error: the output cannot be written: No space left on device\n"


def test_a_run_goes_through_a_pipe(tmp_path: Path) -> None:
    done = gen("simulate", COEFFICIENTS, run_file(tmp_path), "--out", "/dev/stdout")
    assert done.returncode == 0, done.stderr
    assert "\ntime_s,brush_degC," in done.stdout


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


def test_a_failed_write_keeps_the_old_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder = tmp_path / "out"
    replace_folder(folder, {"manifest.json": MANIFEST, "a/b.txt": OLD})
    renames = []

    def failing(self: Path, target: Path) -> Path:
        renames.append(target)
        if len(renames) == 2:  # the old tree is aside, the new one does not make it
            raise KeyboardInterrupt
        os.rename(self, target)  # noqa: PTH104
        return Path(target)

    monkeypatch.setattr(Path, "rename", failing)
    with pytest.raises(KeyboardInterrupt):
        replace_folder(folder, {"manifest.json": MANIFEST, "a/b.txt": "new"})
    assert (folder / "a" / "b.txt").read_text() == OLD
    assert [item.name for item in tmp_path.iterdir()] == ["out"]


@pytest.mark.parametrize("manifest", [None, "{}", '{"name": "a web page"}', "[]", '{"tool": "gen 0.1.0"}'])
def test_a_folder_of_somebody_else_is_not_replaced(manifest: str | None, tmp_path: Path) -> None:
    folder = tmp_path / "out"
    folder.mkdir()
    (folder / "mine.txt").write_text("precious")
    if manifest is not None:
        (folder / "manifest.json").write_text(manifest)
    with pytest.raises(InputError, match="not written by gen"):
        replace_folder(folder, {"manifest.json": MANIFEST})
    assert (folder / "mine.txt").read_text() == "precious"


def test_a_file_that_somebody_put_into_the_project_is_not_lost(tmp_path: Path) -> None:
    folder = tmp_path / "out"
    tree = {"manifest.json": MANIFEST, "a/b.txt": OLD, "report.html": ""}
    replace_folder(folder, tree)
    (folder / ".pio" / "build").mkdir(parents=True)
    (folder / ".pio" / "build" / "firmware.elf").write_text("made again")
    replace_folder(folder, tree)
    (folder / "a" / "notes.txt").write_text("precious")
    with pytest.raises(InputError, match=r"holds a/notes.txt, which gen did not write"):
        replace_folder(folder, tree)
    assert (folder / "a" / "notes.txt").read_text() == "precious"


def test_an_edited_file_of_the_project_is_lost_only_by_force(tmp_path: Path) -> None:
    out = tmp_path / "out"
    build: list[str | Path] = ["build", COEFFICIENTS, "--out", out]
    assert gen(*build).returncode == 0
    written = (out / "platformio.ini").read_text()
    edited = written + "upload_port = /dev/ttyUSB3\n"
    (out / "platformio.ini").write_text(edited)
    refused = gen(*build)
    assert refused.returncode == 2
    assert "holds platformio.ini, which was edited since gen wrote it" in refused.stderr
    assert (out / "platformio.ini").read_text() == edited
    assert gen(*build, "--force").returncode == 0
    assert (out / "platformio.ini").read_text() == written
    assert gen(*build).returncode == 0


def test_a_link_to_the_project_stays_and_the_current_folder_is_not_replaced(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "real").mkdir()
    (tmp_path / "link").symlink_to("real")
    replace_folder(tmp_path / "link", {"manifest.json": MANIFEST})
    assert (tmp_path / "link").is_symlink()
    assert (tmp_path / "real" / "manifest.json").read_text() == MANIFEST
    monkeypatch.chdir(tmp_path / "real")
    with pytest.raises(InputError, match="holds the current folder"):
        replace_folder(Path(), {"manifest.json": MANIFEST})


def test_a_device_is_written_to_and_a_link_leads_to_the_file(tmp_path: Path) -> None:
    (tmp_path / "link").symlink_to("real.txt")
    write_text(tmp_path / "link", "text")
    assert (tmp_path / "link").is_symlink()
    assert (tmp_path / "real.txt").read_text() == "text"
    assert sorted(item.name for item in tmp_path.iterdir()) == ["link", "real.txt"]
    os.mkfifo(tmp_path / "pipe")
    with subprocess.Popen(["cat", tmp_path / "pipe"], stdout=subprocess.PIPE, text=True) as reader:
        write_text(tmp_path / "pipe", "through the pipe")
        assert reader.communicate()[0] == "through the pipe"
    assert (tmp_path / "pipe").is_fifo()


@pytest.mark.parametrize(
    ("written", "read", "message"),
    [
        (["run.csv"], ["run.csv"], "would be overwritten"),
        (["./run.csv"], ["run.csv"], "would be overwritten"),
        (["a.json", None, "a.json"], [], "given twice"),
        (["."], [], "is a folder"),
        (["missing/a.json"], [], "cannot be written"),
    ],
)
def test_outputs_never_take_another_file_s_place(
    written: list[str | None], read: list[str], message: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(InputError, match=message):
        check_outputs([None if path is None else Path(path) for path in written], map(Path, read))
    assert list(tmp_path.iterdir()) == []


def test_a_measured_run_is_not_overwritten(tmp_path: Path) -> None:
    run = run_file(tmp_path)
    before = run.read_text()
    commands: list[list[str | Path]] = [["simulate", COEFFICIENTS, run], ["identify", run]]
    commands += [["thresholds", COEFFICIENTS, run, "--rules", tmp_path / "rules.json"]]
    for arguments in commands:
        done = gen(*arguments, "--out", run)
        assert done.returncode == 2
        assert f"{run}: is read by this command" in done.stderr
        assert run.read_text() == before


def run_file(tmp_path: Path) -> Path:
    path = tmp_path / "run.csv"
    path.write_text("time_s,pwm,brush_degC\n0,102,40\n0.25,102,\n7.3,204,\n900,0,\n1200.1,0,\n")
    return path


def test_simulate_writes_the_run_s_own_times_and_fixed_agrees_with_exact(tmp_path: Path) -> None:
    import pandas as pd

    run = run_file(tmp_path)
    tables = {}
    for arithmetic in ("exact", "fixed"):
        out = tmp_path / f"{arithmetic}.csv"
        done = gen("simulate", COEFFICIENTS, run, "--arithmetic", arithmetic, "--out", out)
        assert done.returncode == 0, done.stderr
        tables[arithmetic] = pd.read_csv(out, comment="#")
    exact, fixed = tables["exact"], tables["fixed"]
    assert exact.columns.tolist() == ["time_s", "brush_degC", "bearing_degC", "magnet_degC", "casing_degC"]
    assert exact["time_s"].tolist() == [0, 0.25, 7.3, 900, 1200.1]
    assert exact["brush_degC"][0] == 40.0
    assert exact["casing_degC"][0] == 30.0
    # Off the grid the board gives its last grid value: a sample's change apart; the PWM acts from the next grid point.
    for name in ("brush_degC", "bearing_degC", "magnet_degC", "casing_degC"):
        assert (exact[name] - fixed[name]).abs().max() < 0.01
        assert abs(exact[name][1] - fixed[name][1]) < 1e-5
    assert any(column.startswith("brush.x3") for column in fixed.columns)


def test_simulate_names_file_line_and_column_of_a_bad_run(tmp_path: Path) -> None:
    run = run_file(tmp_path)
    run.write_text(run.read_text().replace("7.3,204", "7.3,fast"))
    done = gen("simulate", COEFFICIENTS, run, "--out", tmp_path / "out.csv")
    assert done.returncode == 2
    assert "run.csv: line 4, column pwm" in done.stderr
    assert not (tmp_path / "out.csv").exists()


def test_simulate_measured_start_needs_a_measurement(tmp_path: Path) -> None:
    done = gen("simulate", COEFFICIENTS, run_file(tmp_path), "--start", "measured", "--out", tmp_path / "out.csv")
    assert done.returncode == 2
    assert "column bearing_degC" in done.stderr


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


@pytest.mark.parametrize(
    "arguments",
    [
        ["emulate", str(COEFFICIENTS), "--duration", "nan", "--out", "x.csv"],
        ["emulate", str(COEFFICIENTS), "--sensor-tolerance", "inf", "--out", "x.csv"],
        ["identify", "run.csv", "--sample-time", "nan", "--out", "x.json"],
        ["identify", "run.csv", "--ambient", "1e9", "--out", "x.json"],
        ["verify", str(COEFFICIENTS), "--scale", "nan"],
    ],
)
def test_a_number_that_is_none_is_refused_as_an_option(arguments: list[str], tmp_path: Path) -> None:
    done = subprocess.run([sys.executable, "-m", "gen", *arguments], cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 2
    assert "Invalid value for '--" in done.stderr
    assert "Traceback" not in done.stderr
    assert not list(tmp_path.iterdir())
