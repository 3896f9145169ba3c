"""What commands write, and what they never overwrite."""

from __future__ import annotations

import errno
import json
import os
import signal
import subprocess
import time
from pathlib import Path

import pytest

from gen.errors import InputError
from gen.files import check_outputs, replace_folder, replacing, write_text
from tests.cli.commands import COEFFICIENTS, MANIFEST, OLD, run_file
from tests.command import GEN, gen


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


def test_only_what_happens_to_the_file_itself_is_said_of_it(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError), replacing(tmp_path / "a.txt"):
        (tmp_path / "missing").read_bytes()
    with pytest.raises(InputError, match=r"a\.txt: cannot be written: No space left"), replacing(tmp_path / "a.txt"):
        raise OSError(errno.ENOSPC, "No space left on device")
    with pytest.raises(InputError, match="cannot be written"), replacing(tmp_path / "missing" / "a.txt"):
        pass
    assert list(tmp_path.iterdir()) == []


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


@pytest.mark.parametrize("option", ["--profile", "--ambient", "--load", "--channel"])
def test_an_emulated_run_does_not_take_the_place_of_what_drives_it(option: str, tmp_path: Path) -> None:
    course = tmp_path / "course.csv"
    course.write_text("time_s,pwm\n0,100\n", encoding="utf-8")
    told = f"fan={course}" if option == "--channel" else str(course)
    done = gen("emulate", COEFFICIENTS, option, told, "--out", course)
    assert done.returncode == 2
    assert "would be overwritten" in done.stderr
    assert course.read_text(encoding="utf-8") == "time_s,pwm\n0,100\n"


def test_no_command_takes_the_place_of_a_measured_run_that_it_does_not_read(tmp_path: Path) -> None:
    run = run_file(tmp_path)
    other, before = tmp_path / "other.csv", run.read_text()
    other.write_text("# source: a logger\n" + before, encoding="utf-8")
    commands: list[list[str | Path]] = [
        ["simulate", COEFFICIENTS, other, "--out", run],
        ["emulate", COEFFICIENTS, "--out", run],
        ["emulate", COEFFICIENTS, "--out", tmp_path / "new.csv", "--json", run],
        ["init", other, "--out", run],
        ["log", "/dev/null", "--out", run],
        ["live", other, "--out", run],
    ]
    for arguments in commands:
        done = gen(*arguments)
        assert done.returncode == 2
        assert "holds a measured run and would be overwritten" in done.stderr
        assert run.read_text() == before
    assert sorted(item.name for item in tmp_path.iterdir()) == ["other.csv", "run.csv"]


def test_what_was_emulated_may_be_emulated_again(tmp_path: Path) -> None:
    run = tmp_path / "run.csv"
    run.write_text("# model: m\n# emulated: gen\ntime_s,pwm,brush_degC\n0,1,20\n", encoding="utf-8")
    check_outputs([run], [])


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("log.csv", b"Zeit;Wicklung\n0;20,5\n1;20,6\n"),
        ("log.csv", "Zeit;Wicklung\n0;20,5\n".encode("utf-16")),
        ("log.xlsx", b"PK\x03\x04" + bytes(100)),
        ("log.jsonl", b'{"t": 0, "T1": 20.5}\n{"t": 1, "T1": 20.6}\n'),
        ("log.json", b'[{"t": 0, "T1": 20.5}, {"t": 1, "T1": 20.6}]'),
        ("serial.txt", b"boot\nT1:20.5 T2:20.1\n"),
    ],
)
def test_no_command_takes_the_place_of_a_logger_s_own_file(name: str, text: bytes, tmp_path: Path) -> None:
    log = tmp_path / name
    log.write_bytes(text)
    done = gen("init", COEFFICIENTS, "--out", log)
    assert done.returncode == 2
    assert f"{log}: may be a logger's file and would be overwritten" in done.stderr
    assert log.read_bytes() == text


def test_what_was_written_is_written_again(tmp_path: Path) -> None:
    """A model, a simulated run, a page, a picture, what an interrupted program left empty."""
    (tmp_path / "empty.json").touch()
    for name in ("empty.json", "start.json", "start.txt"):
        for _ in range(2):
            assert gen("init", run_file(tmp_path), "--out", tmp_path / name).returncode == 0
    run = tmp_path / "emulated.csv"
    for _ in range(2):
        assert gen("emulate", COEFFICIENTS, "--duration", "5", "--out", run).returncode == 0
    for name in ("simulated.csv", "run.html", "run.svg", "run.png"):
        command: list[str | Path] = ["simulate", COEFFICIENTS, run] if name.endswith("csv") else ["plot", run]
        for _ in range(2):
            done = gen(*command, "--out", tmp_path / name)
            assert done.returncode == 0, done.stderr
