"""The stand-ins build and test a small project in the layout of the generated one."""

import os
import shutil
import signal
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.platformio.environment import (
    PROXIES,
    PioError,
    environments,
    install,
    pio,
    pio_ci,
    pio_run,
    pio_test,
)

SAMPLE = Path(__file__).parent / "sample"
CASES = 3

# The warnings of the emitted project are errors here; users with another compiler are spared that.
STRICT = {"PLATFORMIO_BUILD_SRC_FLAGS": "-Werror"}


@pytest.fixture
def project(tmp_path: Path) -> Path:
    """Return a copy of the sample project."""
    return Path(shutil.copytree(SAMPLE, tmp_path / "project"))


@pytest.fixture
def variables(tmp_path: Path, project: Path) -> dict[str, str]:
    """Return the environment for running `pio` on the copy."""
    return install(tmp_path / "core", project) | STRICT


def edit_test(project: Path, old: str, new: str) -> None:
    """Replace text in the sample's test."""
    path = project / "test" / "test_model" / "test_main.cpp"
    text = path.read_text()
    assert text.count(old) == 1
    path.write_text(text.replace(old, new))


def test_configuration_is_clean(project: Path, variables: dict[str, str]) -> None:
    lint = pio(["project", "config", "--lint"], project, variables=variables).check()
    assert "free from linting errors" in lint.output
    assert "warning" not in lint.output.lower()
    assert environments(project) == ["mega", "native", "simavr"]


def test_builds_the_firmware(project: Path, variables: dict[str, str]) -> None:
    output = pio_run(project, variables=variables).output
    assert "warning" not in output
    assert "Flash:" in output
    assert {path.name for path in (project / ".pio" / "build" / "mega").glob("firmware.*")} == {
        "firmware.elf",
        "firmware.hex",
    }
    # Only the default environment is built.
    assert not (project / ".pio" / "build" / "simavr").exists()


def test_needs_no_environment_variables_of_the_callers(project: Path) -> None:
    pio_run(project, "mega")


@pytest.mark.parametrize("env", ["native", "simavr"])
def test_cases_pass(project: Path, variables: dict[str, str], env: str) -> None:
    result = pio_test(project, env, variables=variables).check(CASES)
    assert "warning" not in result.run.output
    assert [case.name for case in result.cases] == [
        "test_first_step",
        "test_settles",
        "test_is_deterministic",
    ]


@pytest.mark.parametrize("env", ["native", "simavr"])
def test_a_wrong_value_fails_its_case_only(project: Path, variables: dict[str, str], env: str) -> None:
    edit_test(project, "TEST_ASSERT_EQUAL_INT32(255L * 4096L,", "TEST_ASSERT_EQUAL_INT32(255L * 4096L + 1,")
    result = pio_test(project, env, variables=variables)
    assert result.run.returncode != 0
    assert len(result.cases) == CASES
    # The emulator prints the end of a line as a full stop.
    assert [(case.name, case.message.rstrip(".")) for case in result.failures] == [
        ("test_first_step", "Expected 1044481 Was 1044480")
    ]
    with pytest.raises(PioError):
        result.check(CASES)


def test_a_warning_in_the_sources_is_an_error_here(project: Path, variables: dict[str, str]) -> None:
    narrowing = "\nint8_t narrow(int value);\nint8_t narrow(int value) { return value; }\n"
    main = project / "src" / "main.cpp"
    main.write_text(main.read_text() + narrowing)
    with pytest.raises(PioError, match="Werror=conversion"):
        pio_run(project, variables=variables)


def test_a_warning_in_the_library_is_printed(project: Path, variables: dict[str, str]) -> None:
    source = project / "lib" / "demo_model" / "src" / "demo_model.cpp"
    source.write_text(source.read_text() + "\nint8_t narrow(int v);\nint8_t narrow(int v) { return v; }\n")
    assert "-Wconversion]" in pio_run(project, "mega", variables=variables).output
    assert "-Wconversion]" in pio_test(project, "native", variables=variables).run.output


def test_a_test_that_does_not_compile_is_no_pass(project: Path, variables: dict[str, str]) -> None:
    edit_test(project, "#include <demo_model.h>", "#include <no_such_header.h>")
    with pytest.raises(PioError, match="no_such_header"):
        pio_test(project, "native", variables=variables)


def test_a_firmware_that_prints_nothing_is_ended(project: Path, variables: dict[str, str]) -> None:
    edit_test(project, "void setup() {", "void setup() {\n  for (;;) {\n  }")
    pio_run(project, "simavr", variables=variables)
    with pytest.raises(PioError, match="killed"):
        pio_test(project, "simavr", variables=variables, timeout=6)


def test_no_cases_is_no_pass(project: Path, variables: dict[str, str]) -> None:
    edit_test(project, "  return run_tests();", "  return 0 * sizeof(run_tests());")
    with pytest.raises(PioError, match="no test case"):
        pio_test(project, "native", variables=variables)


def test_a_real_board_is_never_looked_for(project: Path, variables: dict[str, str]) -> None:
    with pytest.raises(ValueError, match="real board"):
        pio_test(project, "mega", variables=variables)
    upload = pio(["run", "-e", "mega", "-t", "upload"], project, variables=variables)
    assert upload.returncode != 0


def test_builds_the_library_example(project: Path, variables: dict[str, str], tmp_path: Path) -> None:
    library = project / "lib" / "demo_model"
    pio_ci(
        library / "examples" / "Basic",
        [library],
        board="megaatmega2560",
        build_dir=tmp_path / "ci",
        variables=variables,
    )
    assert (tmp_path / "ci" / ".pio" / "build" / "megaatmega2560" / "firmware.hex").is_file()


@pytest.fixture
def proxy() -> Iterator[tuple[str, list[str]]]:
    """Yield the address of a proxy that answers nothing, and the list of the peers that turned to it."""
    peers: list[str] = []
    with socket.create_server(("127.0.0.1", 0)) as server:

        def listen() -> None:
            while True:
                try:
                    connection, peer = server.accept()
                except OSError:
                    return
                peers.append(str(peer))
                connection.close()

        thread = threading.Thread(target=listen, daemon=True)
        thread.start()
        yield f"http://127.0.0.1:{server.getsockname()[1]}", peers
        server.shutdown(socket.SHUT_RDWR)
        thread.join()


def test_nothing_tries_the_network(project: Path, variables: dict[str, str], proxy: tuple[str, list[str]]) -> None:
    address, peers = proxy
    watched = variables | dict.fromkeys(PROXIES, address)
    pio_run(project, variables=watched)
    pio_test(project, "native", variables=watched).check(CASES)
    pio_test(project, "simavr", variables=watched).check(CASES)
    assert peers == []

    # The proxy does see what needs the network.
    (project / "platformio.ini").write_text("[env:other]\nplatform = espressif32\n")
    command = [sys.executable, "-m", "platformio", "run"]
    process = subprocess.Popen(command, cwd=project, env=watched, start_new_session=True, stdout=subprocess.DEVNULL)
    while not peers and process.poll() is None:
        time.sleep(0.05)
    if process.poll() is None:
        os.killpg(process.pid, signal.SIGKILL)
    process.wait()
    assert peers != []


def test_a_package_without_stand_in_fails_at_once(project: Path, variables: dict[str, str]) -> None:
    (project / "platformio.ini").write_text("[env:other]\nplatform = espressif32\n")
    with pytest.raises(PioError, match="Installing espressif32") as failed:
        pio_run(project, variables=variables)
    assert "was killed" not in str(failed.value)
