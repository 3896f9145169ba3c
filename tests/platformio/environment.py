"""PlatformIO without its registry: lays out stand-ins for packages, then builds and tests unchanged projects.

`install` fills a `PLATFORMIO_CORE_DIR` from `standins/` and returns the process environment for `pio`;
`pio_run`, `pio_test`, `pio_ci` and `pio` run it under a time limit. Nothing here reaches the network or a
serial device.
"""

import json
import os
import re
import shutil
import signal
import subprocess
import sys
import xml.etree.ElementTree as ET
from collections.abc import Mapping, Sequence
from configparser import RawConfigParser
from dataclasses import dataclass
from pathlib import Path

STANDINS = Path(__file__).parent / "standins"
ARDUINO_AVR = Path("/usr/share/arduino/hardware/arduino/avr")
TOOLS = ("avr-gcc", "avr-g++", "avr-gcc-ar", "avr-gcc-ranlib", "avr-objcopy", "avr-size", "simavr", "g++")
DEBIAN_PACKAGES = "gcc-avr avr-libc binutils-avr simavr arduino-core-avr gcc g++"

# No proxy at all: what asks for the network fails at once, where a dead address is tried again for a minute.
DEAD_PROXY = "http://:0"
PROXIES = ("http_proxy", "https_proxy", "all_proxy")
NO_DEVICE = "/dev/no-device-in-tests"

# They end what hangs; nothing that goes on takes so long, on any machine.
BUILD_SECONDS = 1200.0
TEST_SECONDS = 1200.0

SCONS = """import SCons.Script

SCons.Script.main()
"""


class PioError(AssertionError):
    """`pio` failed, took too long, or ran no test case. The message ends with its output."""


@dataclass(frozen=True)
class PioOutput:
    """What a run of `pio` left behind.

    Attributes
    ----------
    command : the words of the command.
    returncode : its exit status.
    output : its standard output and standard error, interleaved.
    """

    command: tuple[str, ...]
    returncode: int
    output: str

    def check(self) -> "PioOutput":
        """Return itself, or raise `PioError` when `pio` failed."""
        if self.returncode != 0:
            raise PioError(f"{' '.join(self.command)} ended with {self.returncode}\n{self.output}")
        return self


@dataclass(frozen=True)
class PioCase:
    """One test case: its name, status (PASSED, FAILED or SKIPPED), and message if it has one."""

    suite: str
    name: str
    status: str
    message: str


@dataclass(frozen=True)
class PioTestResult:
    """What `pio test` reports.

    Attributes
    ----------
    run : the run of `pio` itself.
    cases : the test cases that ran; never empty.
    errors : what went wrong outside of cases, e.g. the exit status of the test program.
    """

    run: PioOutput
    cases: tuple[PioCase, ...]
    errors: tuple[str, ...]

    @property
    def failures(self) -> tuple[PioCase, ...]:
        """The cases that failed."""
        return tuple(case for case in self.cases if case.status == "FAILED")

    def check(self, cases: int) -> "PioTestResult":
        """Return itself, or raise `PioError` unless exactly `cases` cases ran and all of them passed."""
        self.run.check()
        passed = [case for case in self.cases if case.status == "PASSED"]
        if self.errors or not len(passed) == len(self.cases) == cases:
            raise PioError(f"{len(passed)} of {len(self.cases)} passed, not {cases}\n{self.run.output}")
        return self


def install(core_dir: Path, project: Path) -> dict[str, str]:
    """Lay out the stand-ins for a project.

    Parameters
    ----------
    core_dir : becomes `PLATFORMIO_CORE_DIR`; created if need be.
    project : folder with `platformio.ini`; gets Unity in `.pio/libdeps/<env>` for every environment.

    Returns
    -------
    The whole environment for running `pio`, made from this process's without any `PLATFORMIO_*` of its own.

    Raises
    ------
    PioError
        When a tool of the machine is missing.
    """
    _require_tools()
    platforms = core_dir / "platforms"
    scripts = {"atmelavr_builder.py": "main.py", "arduino_framework.py": "frameworks/arduino.py"}
    _copy_platform(platforms, "atmelavr", scripts)
    _copy_platform(platforms, "native", {"native_builder.py": "main.py"})

    packages = core_dir / "packages"
    scons = _package(packages, "tool-scons", "4.41101.0")
    (scons / "scons.py").write_text(SCONS)
    _package(packages, "toolchain-atmelavr", "1.70300.0")
    _package(packages, "tool-avrdude", "1.60300.0")
    framework = _package(packages, "framework-arduino-avr", "5.2.0")
    for folder in ("cores", "variants", "libraries"):
        _link(framework / folder, ARDUINO_AVR / folder)
    simavr = _package(packages, "tool-simavr", "1.10700.0")
    _link(simavr / "bin" / "simavr", Path(_which("simavr")))

    for env in environments(project):
        unity = project / ".pio" / "libdeps" / env / "Unity"
        shutil.copytree(STANDINS / "libraries" / "Unity", unity, dirs_exist_ok=True)
        _write_piopm(unity, "library", "Unity", "2.6.1", owner="throwtheswitch")

    foreign = re.compile("PLATFORMIO_.*|(no|all|http|https)_proxy", flags=re.IGNORECASE)
    inherited = {name: value for name, value in os.environ.items() if not foreign.fullmatch(name)}
    return inherited | {
        "PLATFORMIO_CORE_DIR": str(core_dir),
        "PLATFORMIO_SETTING_ENABLE_TELEMETRY": "No",
        "PLATFORMIO_SETTING_CHECK_PLATFORMIO_INTERVAL": "3650",
        "PLATFORMIO_SETTING_CHECK_PRUNE_SYSTEM_THRESHOLD": "0",
        "PLATFORMIO_DISABLE_UPGRADE_CHECK": "true",
        "PLATFORMIO_DISABLE_PROGRESSBAR": "true",
        "PLATFORMIO_NO_ANSI": "true",
        "PLATFORMIO_UPLOAD_PORT": NO_DEVICE,
        "COLUMNS": "120",
        **dict.fromkeys(PROXIES, DEAD_PROXY),
    }


def environments(project: Path) -> list[str]:
    """Return the names of the environments in a project's `platformio.ini`, in its order."""
    text = (project / "platformio.ini").read_text()
    return re.findall(r"^\[env:([^\]]+)\]", text, flags=re.MULTILINE)


def pio(
    arguments: Sequence[str],
    project: Path,
    *,
    variables: Mapping[str, str] | None = None,
    timeout: float = BUILD_SECONDS,
) -> PioOutput:
    """Run `pio` in a project's folder.

    Parameters
    ----------
    arguments : the words after `pio`.
    project : the folder to run it in.
    variables : its environment, as returned by `install`; by default the stand-ins go into `.pio/standins`.
    timeout : seconds after which `pio` and all that it started are killed.

    Raises
    ------
    PioError
        When the time is over. A failure of `pio` itself is returned, not raised.
    """
    if variables is None:
        variables = install(project / ".pio" / "standins", project)
    command = (sys.executable, "-m", "platformio", *arguments)
    process = subprocess.Popen(
        command,
        cwd=project,
        env=dict(variables),
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        errors="replace",
        start_new_session=True,
    )
    try:
        output, _ = process.communicate(timeout=timeout)
    except subprocess.TimeoutExpired:
        os.killpg(process.pid, signal.SIGKILL)
        output, _ = process.communicate()
        raise PioError(f"pio {' '.join(arguments)} was killed after {timeout:g} s\n{output}") from None
    return PioOutput(command, process.returncode, output)


def pio_run(
    project: Path,
    env: str | None = None,
    *,
    variables: Mapping[str, str] | None = None,
    timeout: float = BUILD_SECONDS,
) -> PioOutput:
    """Build an environment of a project, or its default environments; raise `PioError` on failure."""
    arguments = ["run"] if env is None else ["run", "-e", env]
    return pio(arguments, project, variables=variables, timeout=timeout).check()


def pio_test(
    project: Path,
    env: str,
    *,
    variables: Mapping[str, str] | None = None,
    timeout: float = TEST_SECONDS,
) -> PioTestResult:
    """Run the tests of an environment, on this computer or an emulated board, never on a real one.

    Failed cases are in the result: use its `check`.

    Raises
    ------
    PioError
        When no case ran (the build failed, or the program printed none) or the time is over.
    ValueError
        When the environment would look for a board on a serial port.
    """
    _refuse_serial_port(project, env)
    report = project.resolve() / ".pio" / f"junit-{env}.xml"
    report.unlink(missing_ok=True)
    # With -vv the output holds the compilers' warnings and what the tests printed.
    arguments = ["test", "-vv", "-e", env, "--without-uploading", "--junit-output-path", str(report)]
    report.parent.mkdir(parents=True, exist_ok=True)
    run = pio(arguments, project, variables=variables, timeout=timeout)
    if not report.exists():
        raise PioError(f"pio test -e {env} wrote no report\n{run.output}")
    cases, errors = _read_junit(report)
    if not cases:
        raise PioError(f"pio test -e {env} ran no test case {list(errors)}\n{run.output}")
    return PioTestResult(run, cases, errors)


def pio_ci(
    source: Path,
    libraries: Sequence[Path],
    *,
    board: str,
    build_dir: Path,
    variables: Mapping[str, str],
    options: Sequence[str] = (),
    timeout: float = BUILD_SECONDS,
) -> PioOutput:
    """Build a library's example with `pio ci`; raise `PioError` on failure.

    Parameters
    ----------
    source : the example's folder.
    libraries : the folders of the libraries that it needs.
    board : PlatformIO's name of the board.
    build_dir : where the build is kept; whatever it holds is lost.
    variables : environment, as returned by `install`.
    options : lines of `platformio.ini` for the environment.
    timeout : seconds.
    """
    arguments = ["ci", str(source.resolve()), f"--board={board}"]
    arguments += [f"--build-dir={build_dir.resolve()}", "--keep-build-dir"]
    arguments += [f"--lib={library.resolve()}" for library in libraries]
    arguments += [f"--project-option={option}" for option in options]
    shutil.rmtree(build_dir, ignore_errors=True)
    build_dir.mkdir(parents=True)
    return pio(arguments, build_dir, variables=variables, timeout=timeout).check()


def _which(tool: str) -> str:
    path = shutil.which(tool)
    if path is None:
        raise PioError(f"{tool} is not installed. These tests need: apt-get install {DEBIAN_PACKAGES}")
    return path


def _require_tools() -> None:
    for tool in TOOLS:
        _which(tool)
    if not (ARDUINO_AVR / "cores" / "arduino" / "Arduino.h").is_file():
        raise PioError(f"no Arduino core in {ARDUINO_AVR}: apt-get install {DEBIAN_PACKAGES}")


def _copy_platform(platforms: Path, name: str, scripts: Mapping[str, str]) -> None:
    """Copy a stand-in platform; `scripts` says which script goes where in its `builder` folder."""
    source, target = STANDINS / "platforms" / name, platforms / name
    ignored = shutil.ignore_patterns("*.py", "__pycache__")
    shutil.copytree(source, target, ignore=ignored, dirs_exist_ok=True)
    for script, place in scripts.items():
        destination = target / "builder" / place
        destination.parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(source / script, destination)
    version: str = json.loads((source / "platform.json").read_text())["version"]
    _write_piopm(target, "platform", name, version)


def _package(packages: Path, name: str, version: str) -> Path:
    """Make a package of PlatformIO's type "tool" that holds only its manifest; return its folder."""
    folder = packages / name
    folder.mkdir(parents=True, exist_ok=True)
    manifest = {"name": name, "version": version, "description": f"Stand-in for platformio/{name}"}
    (folder / "package.json").write_text(json.dumps(manifest))
    _write_piopm(folder, "tool", name, version)
    return folder


def _write_piopm(folder: Path, kind: str, name: str, version: str, owner: str = "platformio") -> None:
    """Write the file that makes PlatformIO take a folder for a package installed from its registry."""
    spec = {"owner": owner, "id": None, "name": name, "requirements": None, "uri": None}
    (folder / ".piopm").write_text(json.dumps({"type": kind, "name": name, "version": version, "spec": spec}))


def _link(link: Path, target: Path) -> None:
    link.parent.mkdir(parents=True, exist_ok=True)
    link.unlink(missing_ok=True)
    link.symlink_to(target)


def _refuse_serial_port(project: Path, env: str) -> None:
    """Raise `ValueError` unless an environment's tests run on this computer or by a command of their own."""
    config = RawConfigParser(strict=False)
    config.read(project / "platformio.ini")
    section = f"env:{env}"
    options: dict[str, str] = {}
    while section:
        options = dict(config[section]) | options
        section = config[section].get("extends", "")
    native = options.get("platform", "").split("@")[0].strip() == "native"
    if not native and "test_testing_command" not in options:
        raise ValueError(f"the tests of {env} would run on a real board")


def _read_junit(report: Path) -> tuple[tuple[PioCase, ...], tuple[str, ...]]:
    """Return the cases that ran and the messages of what went wrong outside of cases."""
    cases: list[PioCase] = []
    errors: list[str] = []
    for suite in ET.parse(report).getroot().iter("testsuite"):
        for case in suite.iter("testcase"):
            status = case.attrib["status"]
            if status == "ERRORED":
                errors += [error.attrib.get("message", "") for error in case.iter("error")]
                continue
            message = "".join(failure.attrib.get("message", "") for failure in case.iter("failure"))
            cases.append(PioCase(suite.attrib["name"], case.attrib["name"], status, message))
    return tuple(cases), tuple(errors)
