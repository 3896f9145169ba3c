"""Attack files: build each in every form, and search every component of what was built."""

from __future__ import annotations

import json
import tempfile
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.attack.exact import ExactComponent
from benchmarks.attack.random_files import random_document
from benchmarks.attack.report import Attacked, Refused, Report, Timed
from benchmarks.attack.search import Effort, attack
from benchmarks.attack.victim import FORMS, built, refused_by_the_command
from gen.lowering.kinds import Arithmetic, ScheduleKind
from gen.lowering.program import Program

Say = Callable[[str], None]


def attack_file(
    path: Path,
    name: str,
    effort: Effort,
    seed: int,
    report: Report,
    say: Say,
    forms: Sequence[tuple[Arithmetic, ScheduleKind]] = FORMS,
    *,
    by_command: bool = True,
) -> None:
    """Attack one file in all forms; its first refusal is repeated by the command where ``by_command`` asks for it.

    The file has no effects: a bound is the baseline's.
    """
    document = json.loads(path.read_text(encoding="utf-8"))
    exact: dict[int, ExactComponent] = {}
    told = not by_command
    for arithmetic, schedule in forms:
        form = f"{arithmetic}/{schedule}"
        made = built(path, arithmetic, schedule)
        report.timed.append(Timed(name, form, made.seconds, made.crash))
        if made.crash:
            say(f"{name} {form}: CRASH\n{made.crash}")
        elif made.refusal:
            wrong = "" if told else refused_by_the_command(path, arithmetic, schedule)
            told = True
            report.refused.append(Refused(name, form, made.refusal, wrong))
            say(f"{name} {form}: refused in {made.seconds:.1f} s: {made.refusal}{f'  WRONG: {wrong}' if wrong else ''}")
        elif made.program is not None:
            for entry in _attacked(made.program, document, exact, name, effort, seed):
                report.attacked.append(entry)
                say(f"{entry.line()}  built in {made.seconds:.1f} s")


def attack_random(numbers: Sequence[int], effort: Effort, seed: int, report: Report, say: Say) -> None:
    """Attack the random files of some numbers."""
    with tempfile.TemporaryDirectory() as folder:
        for number in numbers:
            path = Path(folder) / f"random{number}.json"
            path.write_text(json.dumps(random_document(seed, number)), encoding="utf-8")
            attack_file(path, path.stem, effort, seed, report, say)


def _attacked(
    program: Program,
    document: dict[str, Any],
    exact: dict[int, ExactComponent],
    name: str,
    effort: Effort,
    seed: int,
) -> list[Attacked]:
    allowed = document.get("accuracy", {}).get("unproven") is not None
    found = []
    for index, component in enumerate(program.components):
        if index not in exact:
            exact[index] = ExactComponent(document, index)
        rng = np.random.default_rng([seed, index])
        finding = attack(component, exact[index], effort, rng)
        found.append(
            Attacked(
                file=name,
                component=component.name,
                order=component.order,
                form=program.label,
                bound_K=None if component.proof is None else component.proof.bound_K,
                found_K=finding.error_K,
                allowed=allowed,
                start_mK=finding.start_mK,
                samples=len(finding.rows),
            )
        )
    return found
