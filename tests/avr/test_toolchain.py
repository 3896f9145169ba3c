from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest

from gen import toolchain
from gen.errors import InputError
from gen.toolchain import ToolMissing


def fake(folder: Path, name: str, script: str) -> None:
    path = folder / name
    path.write_text(f"#!/bin/sh\n{script}\n", encoding="utf-8")
    path.chmod(0o755)


@pytest.fixture
def bare_path(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    folder = tmp_path / "bin"
    folder.mkdir()
    monkeypatch.setenv("PATH", str(folder))
    return folder


@pytest.mark.parametrize("name", sorted(toolchain.PACKAGES))
def test_every_program_is_found(name: str) -> None:
    assert toolchain.program(name).is_file()


@pytest.mark.parametrize(("name", "package"), sorted(toolchain.PACKAGES.items()))
def test_missing_program_is_named_with_its_package(bare_path: Path, name: str, package: str) -> None:
    with pytest.raises(ToolMissing) as caught:
        toolchain.program(name)
    assert isinstance(caught.value, InputError)
    assert str(caught.value) == (
        f"{name} is missing: it is in the Debian package {package}; install it with: apt-get install -y {package}"
    )


def test_compiler_without_avr_libc(bare_path: Path) -> None:
    fake(bare_path, "avr-g++", "echo crtatmega2560.o")
    with pytest.raises(ToolMissing, match=r"apt-get install -y binutils-avr$"):
        toolchain.avr_compiler()
    fake(bare_path, "avr-ar", "")
    with pytest.raises(ToolMissing, match=r"apt-get install -y avr-libc$"):
        toolchain.avr_compiler()


def test_missing_simavr_headers_and_library(bare_path: Path) -> None:
    fake(bare_path, "gcc", "exit 1")
    with pytest.raises(ToolMissing, match=r"header simavr/sim_elf\.h.*apt-get install -y libsimavr-dev$"):
        toolchain.simavr_flags()
    fake(bare_path, "gcc", "[ $1 = -E ] || echo libsimavr.so")
    with pytest.raises(ToolMissing, match=r"library libsimavr\.so.*apt-get install -y libsimavr-dev$"):
        toolchain.simavr_flags()


def test_everything_is_installed() -> None:
    assert toolchain.avr_compiler().name == "avr-g++"
    assert toolchain.simavr_flags() == ["-lsimavr"]
    assert (toolchain.arduino_core() / "cores/arduino/main.cpp").is_file()


def test_arduino_core_is_looked_for_where_the_environment_says(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(toolchain.ARDUINO_ENVIRONMENT, str(tmp_path))
    with pytest.raises(ToolMissing, match=r"apt-get install -y arduino-core-avr \(or let GEN_ARDUINO_AVR name"):
        toolchain.arduino_core()
    for name in ("cores/arduino/Arduino.h", "variants/mega/pins_arduino.h"):
        (tmp_path / name).parent.mkdir(parents=True)
        (tmp_path / name).touch()
    assert toolchain.arduino_core() == tmp_path


DRIVER = """#!/bin/sh
(while :; do : > "$1/written.$$"; rm -f "$1/written.$$"; done) &
wait
"""
INTERRUPTED = """
import sys, tempfile
from gen import toolchain
with tempfile.TemporaryDirectory(dir=sys.argv[2]) as folder:
    toolchain.run([sys.argv[1], folder])
"""


@pytest.mark.parametrize("again", range(5))
def test_an_interrupted_compiler_ends_with_all_that_it_started(tmp_path: Path, again: int) -> None:
    driver = tmp_path / "driver"
    driver.write_text(DRIVER)
    driver.chmod(0o755)
    scratch = tmp_path / f"scratch{again}"
    scratch.mkdir()
    command = [sys.executable, "-c", INTERRUPTED, str(driver), str(scratch)]
    with subprocess.Popen(command, stderr=subprocess.DEVNULL) as process:
        while not list(scratch.glob("*/written.*")):
            assert process.poll() is None
        process.send_signal(signal.SIGINT)
    assert list(scratch.iterdir()) == []


@pytest.mark.skipif(not hasattr(os, "killpg"), reason="no groups of processes")
def test_a_group_that_is_not_gone_at_once_is_waited_for(monkeypatch: pytest.MonkeyPatch) -> None:
    """What a killed driver started stays in its group until somebody has taken note of its end."""
    gone: list[float] = []
    noted: list[threading.Thread] = []

    def interrupted(process: subprocess.Popen[str]) -> tuple[str, str]:
        child = subprocess.Popen(["sleep", "60"], process_group=process.pid)
        for pipe in (process.stdout, process.stderr):
            assert pipe is not None
            pipe.close()

        def take_note() -> None:
            time.sleep(0.3)
            child.wait()
            gone.append(time.monotonic())

        noted.append(threading.Thread(target=take_note))
        noted[0].start()
        raise KeyboardInterrupt

    monkeypatch.setattr(subprocess.Popen, "communicate", interrupted)
    with pytest.raises(KeyboardInterrupt):
        toolchain.run(["sleep", "60"])
    ended = time.monotonic()
    noted[0].join()
    assert ended > gone[0] - 0.1  # not before it was gone (the thread tells of it a moment later)


def test_a_tool_runs_in_the_environment_that_is_asked_for() -> None:
    done = toolchain.run(["sh", "-c", "echo $WHERE $HOME; echo told >&2; exit 3"], environment={"WHERE": "here"})
    assert (done.stdout, done.stderr, done.returncode) == (f"here {os.environ['HOME']}\n", "told\n", 3)
