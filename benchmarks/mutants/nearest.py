"""Which tests are nearest to a line: of ``gen/`` those that ran it when recorded, of a template by its name."""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from fnmatch import fnmatch
from pathlib import Path

from benchmarks.mutants.defects import Mutant

#: Seconds that a test file is taken to last which was not recorded.
UNKNOWN_S = 30.0
#: Of the budget, what goes to tests of the module's own room before any other.
OWN_SHARE = 0.6
#: Rooms whose tests stand in a folder of another name.
_TESTED_BY = {"commands": "cli", "pages": "drawing", "toolchain": "avr"}
_DEVICE = "tests/device/test_"
#: Templates and the test files that execute what is emitted from them, nearest first.
BY_TEMPLATE: tuple[tuple[str, tuple[str, ...]], ...] = tuple(
    (pattern, tuple(_DEVICE + name + ".py" if "/" not in name else f"tests/{name}.py" for name in names.split()))
    for pattern, names in (
        ("*/src/commissioning*", "commissioning"),
        ("*/src/commissioned*", "commissioning"),
        ("*/src/commands*", "lost_bytes serial_line sketch"),
        ("*/src/console*", "serial_line sketch drive"),
        ("*/src/output*", "serial_line sketch"),
        ("*/src/drive*", "drive direction sketch protection"),
        ("*/src/guard*", "protection"),
        ("*/src/relay*", "protection commissioning"),
        ("*/src/encoder*", "impossible_speed hardware sketch"),
        ("*/src/indicator*", "slots indicator"),
        ("*/src/latch*", "latch sketch"),
        ("*/src/memory*", "memory resume hardware"),
        ("*/src/warm*", "warm"),
        ("*/src/snapshot*", "warm memory"),
        ("*/src/crc32*", "memory warm"),
        ("*/src/observer*", "observed_pwm sketch"),
        ("*/src/selftest*", "sketch hardware"),
        ("*/src/channels*", "effects/test_sketch hardware sketch"),
        ("*/src/thermocouples*", "chips sketch hardware"),
        ("*/src/board*", "hardware sketch boot_loader"),
        ("*/project/src/*", "starts warm serial_line order_of_work sketch hardware"),
        ("*/sensors*", "sensor_limits sensors chips"),
        ("*/alarms*", "verification/test_alarm_edges verification/test_verify_alarms starts"),
        ("*/lib/*/protection*", "verification/test_verify_protection protection"),
        ("*/lib/*/forecast*", "verification/test_verify_forecast"),
        ("*/lib/*/heat*", "verification/test_verify_heat"),
        ("*/lib/*/network*", "verification/test_network firmware/test_network_avr"),
        ("*/effects*", "effects/test_equality effects/test_sketch"),
        ("*/*onboard*", "lowering/onboard/test_onboard_primitives verification/test_verify verification/test_shapes"),
        ("*/lib/*", "verification/test_verify verification/test_shapes verification/test_saturation resume sketch"),
        ("*/harness/*alarms*", "verification/test_verify_alarms"),
        ("*/harness/*protection*", "verification/test_verify_protection"),
        ("*/harness/*forecast*", "verification/test_verify_forecast"),
        ("*/harness/*", "verification/test_verify verification/test_shapes verification/test_saturation"),
    )
)

#: Modules of `gen/` whose emitted code or whose lowering slow tests of other rooms judge.
BY_MODULE: tuple[tuple[str, str], ...] = (
    ("gen/*effect*", "effects/test_equality effects/test_hand_written_equations effects/test_accuracy"),
    ("gen/*network*", "verification/test_network"),
    ("gen/*alarms*", "verification/test_verify_alarms"),
    ("gen/*forecast*", "verification/test_verify_forecast"),
    ("gen/*heat*", "verification/test_verify_heat"),
    ("gen/*protection*", "verification/test_verify_protection"),
    ("gen/firmware/sketch/*", "device/test_sketch"),
    ("gen/*onboard*", "lowering/onboard/test_onboard_primitives verification/test_verify"),
    ("gen/firmware/*", "verification/test_verify"),
)


@dataclass
class Recording:
    """What ran where.

    Attributes
    ----------
    seconds
        By test.
    shared
        What several tests need and is made once: seconds by its name.
    needs
        By test, which of it.
    lines
        By file and line, the tests that ran it.
    """

    seconds: dict[str, float] = field(default_factory=dict)
    shared: dict[str, float] = field(default_factory=dict)
    needs: dict[str, set[str]] = field(default_factory=dict)
    lines: dict[str, dict[int, set[str]]] = field(default_factory=dict)

    def read(self, file: Path) -> None:
        """Add what :mod:`benchmarks.mutants.recording` wrote."""
        found = json.loads(file.read_text(encoding="utf-8"))
        names = list(found["seconds"])
        self.seconds |= found["seconds"]
        for key, made in found["shared"].items():
            self.shared[key] = made["seconds"]
            for i in made["tests"]:
                self.needs.setdefault(names[i], set()).add(key)
        for path, lines in found["lines"].items():
            mine = self.lines.setdefault(path, {})
            for line, tests in lines.items():
                mine.setdefault(int(line), set()).update(names[i] for i in tests)

    def cost(self, test: str) -> float:
        """Seconds of a test alone, with all that it needs."""
        return self.seconds[test] + sum(self.shared[key] for key in self.needs.get(test, ()))

    def tests_of(self, path: str, line: int) -> set[str]:
        """Tests that ran a line; of one that runs while its module is imported, those that ran any of its lines."""
        lines = self.lines.get(path, {})
        tests = lines.get(line, set())
        # a statement over several lines is known by its first
        for earlier in range(line - 1, max(line - 12, 0), -1):
            if tests:
                break
            tests = lines.get(earlier, set())
        return tests or {test for each in lines.values() for test in each}


def recorded(folder: Path) -> Recording:
    """All recordings of a folder."""
    made = Recording()
    for file in sorted(folder.glob("*.json")):
        made.read(file)
    return made


def nearest(mutant: Mutant, recording: Recording, root: Path, budget_s: float) -> list[str]:
    """Tests to run: those of the module's own name and room first, then the quickest of all.

    Parameters
    ----------
    mutant, recording, root
        What was planted, what ran where, and the repository.
    budget_s
        What the tests may take together by the recording. Where it leaves room, files with tests that were too
        slow to record are taken whole, as if each took `UNKNOWN_S`.
    """
    if mutant.path.startswith("templates/"):
        files = next((files for pattern, files in BY_TEMPLATE if fnmatch(mutant.path, pattern)), ())
        return _of_files(files, recording, budget_s)
    tests = recording.tests_of(mutant.path, mutant.line)
    if not tests:
        return _of_files(_by_name(mutant.path, root), recording, budget_s)
    own = sorted(test for test in tests if _is_near(test, mutant.path))
    chosen = _affordable(own, recording, OWN_SHARE * budget_s)
    chosen += _affordable(sorted(tests.difference(chosen)), recording, budget_s, chosen)
    whole = int((budget_s - _seconds(chosen, recording)) / UNKNOWN_S)
    return [*chosen, *_importing(mutant.path, root)[:whole]] if whole > 0 else chosen


def _is_near(test: str, path: str) -> bool:
    """A test of the module's room, or one whose file is named after the module."""
    module = Path(path).stem.strip("_")
    return test.startswith(f"tests/{path.split('/')[1]}/") or f"_{module}.py" in test


def _affordable(tests: Iterable[str], recording: Recording, budget_s: float, before: Sequence[str] = ()) -> list[str]:
    """As many as the budget has room for beside those before, at least one in all; the quickest first.

    One case of each test function comes before the second of any.
    """
    made = {key for test in before for key in recording.needs.get(test, ())}
    spent = _seconds(before, recording)
    cost = {test: recording.cost(test) for test in tests}
    by_function: dict[str, list[str]] = {}
    for test in sorted(cost, key=lambda name: (cost[name], name)):
        by_function.setdefault(test.split("[")[0], []).append(test)
    turn = {test: place for cases in by_function.values() for place, test in enumerate(cases)}
    chosen: list[str] = []
    for test in sorted(turn, key=lambda name: (turn[name] // 2, cost[name], name)):
        more = recording.needs.get(test, set()) - made
        spent += recording.seconds[test] + sum(recording.shared[key] for key in more)
        if (chosen or before) and spent > budget_s:
            break
        made |= more
        chosen.append(test)
    return chosen


def _seconds(tests: Iterable[str], recording: Recording) -> float:
    """What tests take together, and what they share once."""
    tests = list(tests)
    made = {key for test in tests for key in recording.needs.get(test, ())}
    return sum(recording.seconds[test] for test in tests) + sum(recording.shared[key] for key in made)


def _of_files(files: Sequence[str], recording: Recording, budget_s: float) -> list[str]:
    """Recorded tests of these files, file by file in turns; then whole files, for what was too slow to record."""
    chosen: list[str] = []
    for file in files:
        mine = [test for test in recording.seconds if test.startswith(f"{file}::")]
        chosen += _affordable(mine, recording, budget_s / len(files)) if mine else []
    whole = max(int((budget_s - _seconds(chosen, recording)) / UNKNOWN_S), 0 if chosen else 1)
    return [*chosen, *files[:whole]]


def _importing(path: str, root: Path) -> list[str]:
    """Test files that are named after a module or import it by its name, then those that judge what it makes."""
    module = path.removesuffix(".py").removesuffix("/__init__").replace("/", ".")
    named = re.compile(rf"\b{re.escape(module)}\b|from {re.escape(module.rpartition('.')[0])} import")
    found = {file for file in (root / "tests").rglob("test_*.py") if named.search(file.read_text(encoding="utf-8"))}
    files = {file.relative_to(root).as_posix() for file in found}
    own = {file for file in _by_name(path, root) if Path(path).stem in Path(file).stem}
    judged = next((names.split() for pattern, names in BY_MODULE if fnmatch(path, pattern)), [])
    first = sorted(files | own, key=lambda file: (file not in own, not _is_near(file, path), file))
    return list(dict.fromkeys([*first, *(f"tests/{name}.py" for name in judged)]))


def _by_name(path: str, root: Path) -> list[str]:
    """Test files of a module's room, those of its own name first."""
    room = path.split("/")[1].removesuffix(".py")
    module = Path(path).stem
    files = sorted((root / "tests" / _TESTED_BY.get(room, room)).rglob("test_*.py"))
    named = [file for file in files if module in file.stem or file.stem.removeprefix("test_") in module]
    return [file.relative_to(root).as_posix() for file in [*named, *(f for f in files if f not in named)]]
