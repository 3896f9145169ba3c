"""Which tests are nearest to a line: of ``gen/`` those that ran it when recorded, of a template by its name."""

from __future__ import annotations

import json
from dataclasses import dataclass, field
from fnmatch import fnmatch
from pathlib import Path

from benchmarks.mutants.defects import Mutant

_DEVICE = "tests/device/test_"
#: Templates and the test files that execute what is emitted from them, nearest first.
BY_TEMPLATE: tuple[tuple[str, tuple[str, ...]], ...] = tuple(
    (pattern, tuple(_DEVICE + name + ".py" if "/" not in name else f"tests/{name}.py" for name in names.split()))
    for pattern, names in (
        ("*/src/commands*", "lost_bytes serial_line sketch"),
        ("*/src/console*", "serial_line sketch drive"),
        ("*/src/output*", "serial_line sketch"),
        ("*/src/drive*", "drive direction sketch"),
        ("*/src/encoder*", "impossible_speed hardware sketch"),
        ("*/src/indicator*", "slots indicator"),
        ("*/src/latch*", "latch sketch"),
        ("*/src/memory*", "memory resume hardware"),
        ("*/src/observer*", "observed_pwm sketch"),
        ("*/src/selftest*", "hardware sketch"),
        ("*/src/channels*", "effects/test_sketch hardware sketch"),
        ("*/src/thermocouples*", "sketch hardware"),
        ("*/project/src/*", "order_of_work starts sketch hardware serial_line"),
        ("*/sensors*", "sensor_limits sensors"),
        ("*/alarms*", "verification/test_alarm_edges verification/test_verify_alarms starts"),
        ("*/effects*", "effects/test_equality effects/test_sketch"),
        ("*/onboard*", "lowering/onboard/test_onboard_primitives verification/test_verify verification/test_shapes"),
        ("*/lib/*", "verification/test_verify verification/test_shapes verification/test_saturation resume sketch"),
        ("*/harness/*alarms*", "verification/test_verify_alarms"),
        ("*/harness/*", "verification/test_verify verification/test_shapes verification/test_saturation"),
    )
)


@dataclass
class Recording:
    """What ran where.

    Attributes
    ----------
    seconds
        By test.
    lines
        By file and line, the tests that ran it.
    """

    seconds: dict[str, float] = field(default_factory=dict)
    lines: dict[str, dict[int, set[str]]] = field(default_factory=dict)

    def read(self, file: Path) -> None:
        """Add what :mod:`benchmarks.mutants.recording` wrote."""
        found = json.loads(file.read_text(encoding="utf-8"))
        names = list(found["seconds"])
        self.seconds |= found["seconds"]
        for path, lines in found["lines"].items():
            mine = self.lines.setdefault(path, {})
            for line, tests in lines.items():
                mine.setdefault(int(line), set()).update(names[i] for i in tests)

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
    """Tests to run, quickest first, one case of each test function before the second of any.

    Parameters
    ----------
    mutant, recording, root
        What was planted, what ran where, and the repository.
    budget_s
        What the tests may take together by the recording; test files of templates, and of rooms that
        were not recorded, are taken whole.
    """
    if mutant.path.startswith("templates/"):
        return list(next((files for pattern, files in BY_TEMPLATE if fnmatch(mutant.path, pattern)), ()))
    seconds = recording.seconds
    if not any(test.startswith(f"tests/{mutant.path.split('/')[1]}/") for test in seconds):
        return _by_name(mutant.path, root)
    by_function: dict[str, list[str]] = {}
    for test in sorted(recording.tests_of(mutant.path, mutant.line), key=lambda name: (seconds[name], name)):
        by_function.setdefault(test.split("[")[0], []).append(test)
    turn = {test: place for tests in by_function.values() for place, test in enumerate(tests)}
    chosen: list[str] = []
    spent = 0.0
    for test in sorted(turn, key=lambda name: (turn[name] // 2, seconds[name], name)):
        spent += seconds[test]
        if chosen and spent > budget_s:
            break
        chosen.append(test)
    return chosen


def _by_name(path: str, root: Path) -> list[str]:
    """Test files of a module's room, those of its own name first."""
    _, room, *_ = path.split("/")
    module = Path(path).stem
    files = sorted((root / "tests" / room).glob("test_*.py"))
    named = [file for file in files if module in file.stem or file.stem.removeprefix("test_") in module]
    return [file.relative_to(root).as_posix() for file in [*named, *(f for f in files if f not in named)]]
