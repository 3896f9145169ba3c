"""A pytest plugin that notes which test runs which lines of ``gen/``, and how long each takes.

``python -m pytest -p benchmarks.mutants.recording --mutants-map build/mutants/lowering.json tests/lowering``
"""

from __future__ import annotations

import json
import signal
import time
from collections import Counter, defaultdict
from collections.abc import Generator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from types import FrameType

import coverage
import pytest

ROOT = Path(__file__).parents[2]


@dataclass(frozen=True)
class Limits:
    """What is left out of a recording: tests that no trial would have the time for.

    Attributes
    ----------
    test_s
        A test (or the making of what it needs) that takes longer is broken off and not noted.
    file_s
        Of one file no further test begins after so long.
    cases
        Of one test function no more cases.
    """

    test_s: float = 6.0
    file_s: float = 15.0
    cases: int = 3


class Recorder:
    """Measures line coverage with the running test as its context.

    Parameters
    ----------
    target
        JSON file to write: ``seconds`` by test; ``shared``: what several tests need is made once (a fixture
        of a module or of the session), by its name seconds and the tests' numbers; ``lines``: file -> line ->
        numbers of tests in ``seconds``' order. Lines that run while something shared is made belong to all
        tests that need it, and those that run while a module is imported to no test.
    limits
        What is left out.
    """

    def __init__(self, target: Path, limits: Limits) -> None:
        self._target = target
        self._limits = limits
        self._seconds: dict[str, float] = {}
        self._shared: dict[str, float] = {}
        self._needs: dict[str, list[str]] = {}
        self._at_present: dict[str, str] = {}
        self._running = ""
        self._making = 0.0
        self._cases: Counter[str] = Counter()
        self._spent: defaultdict[str, float] = defaultdict(float)
        self._passed: set[str] = set()
        self._coverage = coverage.Coverage(data_file=None, source=[str(ROOT / "gen")], config_file=False)

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_protocol(self, item: pytest.Item) -> Generator[None, object, object]:
        """Give the lines from here on to this test."""
        self._running = item.nodeid
        self._coverage.switch_context(item.nodeid)
        self._making = 0.0
        began = time.perf_counter()
        done = yield
        taken = time.perf_counter() - began
        self._spent[item.nodeid.split("::")[0]] += taken
        if item.nodeid in self._passed:
            self._seconds[item.nodeid] = taken - self._making
            names = getattr(item, "fixturenames", [])
            self._needs[item.nodeid] = [self._at_present[name] for name in names if name in self._at_present]
        return done

    @pytest.hookimpl(wrapper=True)
    def pytest_fixture_setup(
        self, fixturedef: pytest.FixtureDef[object], request: pytest.FixtureRequest
    ) -> Generator[None, object, object]:
        """Give the lines of what several tests need to all of them."""
        if fixturedef.scope == "function":
            return (yield)
        key = f"{fixturedef.baseid}::{fixturedef.argname}[{getattr(request, 'param_index', 0)}]"
        self._coverage.switch_context(key)
        began = time.perf_counter()
        try:
            return (yield)
        finally:
            self._shared[key] = time.perf_counter() - began
            self._making += self._shared[key]
            self._at_present[fixturedef.argname] = key
            self._coverage.switch_context(self._running)

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_setup(self, item: pytest.Item) -> Generator[None, object, object]:
        """Leave out what no trial would choose."""
        function, file = item.nodeid.split("[")[0], item.nodeid.split("::")[0]
        self._cases[function] += 1
        if self._cases[function] > self._limits.cases or self._spent[file] > self._limits.file_s:
            pytest.skip("enough recorded")
        with _no_longer_than(self._limits.test_s):
            return (yield)

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_call(self) -> Generator[None, object, object]:
        """Break off what takes too long."""
        with _no_longer_than(self._limits.test_s):
            return (yield)

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """Note tests that passed alone: the others are no measure."""
        if report.when == "call" and report.passed:
            self._passed.add(report.nodeid)

    def pytest_sessionstart(self) -> None:
        """Begin before the tests' modules are imported."""
        self._coverage.start()

    def pytest_sessionfinish(self) -> None:
        """Write what was seen."""
        self._coverage.stop()
        data = self._coverage.get_data()
        number = {test: i for i, test in enumerate(self._seconds)}
        behind: dict[str, list[int]] = {key: [] for key in self._shared}
        for test, keys in self._needs.items():
            for key in keys:
                behind[key].append(number[test])
        lines: dict[str, dict[int, list[int]]] = {}
        for file in sorted(data.measured_files()):
            by_line = data.contexts_by_lineno(file)
            lines[str(Path(file).relative_to(ROOT))] = {
                line: sorted({i for name in names for i in behind.get(name, [number[name]] if name in number else [])})
                for line, names in sorted(by_line.items())
            }
        shared = {key: {"seconds": self._shared[key], "tests": tests} for key, tests in behind.items()}
        self._target.parent.mkdir(parents=True, exist_ok=True)
        found = {"seconds": self._seconds, "shared": shared, "lines": lines}
        self._target.write_text(json.dumps(found), encoding="utf-8")


@contextmanager
def _no_longer_than(seconds: float) -> Generator[None]:
    """Break off as a skipped test; what a test started goes with it, as when it fails."""

    def ring(_signal: int, _frame: FrameType | None) -> None:
        pytest.skip(f"takes more than {seconds:g} s")

    before = signal.signal(signal.SIGALRM, ring)
    signal.setitimer(signal.ITIMER_REAL, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)


def pytest_addoption(parser: pytest.Parser) -> None:
    """Add the options that switch it on and say what is left out."""
    usual = Limits()
    parser.addoption("--mutants-map", type=Path, default=None, help="JSON file for lines by test")
    parser.addoption("--mutants-test", type=float, default=usual.test_s, help="seconds that one test may take")
    parser.addoption("--mutants-file", type=float, default=usual.file_s, help="seconds that one file may take")
    parser.addoption("--mutants-cases", type=int, default=usual.cases, help="cases of one test function")


def pytest_configure(config: pytest.Config) -> None:
    """Switch it on."""
    target = config.getoption("--mutants-map")
    if target is not None:
        limits = Limits(*(config.getoption(f"--mutants-{name}") for name in ("test", "file", "cases")))
        config.pluginmanager.register(Recorder(target, limits), "mutants-recorder")
