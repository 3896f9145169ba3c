"""A pytest plugin that notes which test runs which lines of ``gen/``, and how long each takes.

``python -m pytest -p benchmarks.mutants.recording --mutants-map build/mutants/lowering.json tests/lowering``
"""

from __future__ import annotations

import json
import time
from collections.abc import Generator
from pathlib import Path

import coverage
import pytest

ROOT = Path(__file__).parents[2]


class Recorder:
    """Measures line coverage with the running test as its context.

    Parameters
    ----------
    target
        JSON file to write: ``seconds`` by test, and ``lines``: file -> line -> numbers of tests in ``seconds``' order.
        Lines that run while a module is imported belong to no test.
    """

    def __init__(self, target: Path) -> None:
        self._target = target
        self._seconds: dict[str, float] = {}
        self._coverage = coverage.Coverage(data_file=None, source=[str(ROOT / "gen")], config_file=False)

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_protocol(self, item: pytest.Item) -> Generator[None, object, object]:
        """Give the lines from here on to this test."""
        self._coverage.switch_context(item.nodeid)
        began = time.perf_counter()
        done = yield
        self._seconds[item.nodeid] = time.perf_counter() - began
        return done

    def pytest_sessionstart(self) -> None:
        """Begin before the tests' modules are imported."""
        self._coverage.start()

    def pytest_sessionfinish(self, exitstatus: int) -> None:
        """Write what was seen; half a recording would hide the tests that did not come to their turn."""
        self._coverage.stop()
        if exitstatus != pytest.ExitCode.OK:
            return
        data = self._coverage.get_data()
        number = {test: i for i, test in enumerate(self._seconds)}
        lines: dict[str, dict[int, list[int]]] = {}
        for file in sorted(data.measured_files()):
            by_line = data.contexts_by_lineno(file)
            lines[str(Path(file).relative_to(ROOT))] = {
                line: sorted(number[test] for test in tests if test) for line, tests in sorted(by_line.items())
            }
        self._target.parent.mkdir(parents=True, exist_ok=True)
        self._target.write_text(json.dumps({"seconds": self._seconds, "lines": lines}), encoding="utf-8")


def pytest_addoption(parser: pytest.Parser) -> None:
    """Add the option that switches it on."""
    parser.addoption("--mutants-map", type=Path, default=None, help="JSON file for lines by test")


def pytest_configure(config: pytest.Config) -> None:
    """Switch it on."""
    target = config.getoption("--mutants-map")
    if target is not None:
        config.pluginmanager.register(Recorder(target), "mutants-recorder")
