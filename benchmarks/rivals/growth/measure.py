"""Build, run and time models of every size."""

from __future__ import annotations

import resource
import sys
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from benchmarks.rivals.growth.models import components, network
from gen.coefficients import Coefficients
from gen.emulate.firmware import cache_folder
from gen.errors import CheckFailed
from gen.firmware import render
from gen.firmware.context import LibraryContext, project_context
from gen.lowering.kinds import ScheduleKind
from gen.lowering.lower import lower
from gen.lowering.program import Program
from gen.verification.compare import first_mismatch, reference_run
from gen.verification.profiles import campaign, with_channels
from gen.verification.runners import AvrRunner, HostRunner, write_library

LANES, LENGTH = 4, 300
SERIES: tuple[tuple[str, ScheduleKind, tuple[int, ...], Callable[[int], Coefficients]], ...] = (
    ("components of order 1, table", "table", (1, 2, 4, 8, 15, 16), lambda size: components(size, 1)),
    ("components of order 1, on board", "onboard", (1, 4, 16), lambda size: components(size, 1)),
    ("components of order 3, on board", "onboard", (1, 4, 16), lambda size: components(size, 3)),
    ("order of one component, table", "table", (1, 2, 3, 4), lambda size: components(1, size)),
    ("nodes of a network, table", "table", (2, 4, 8, 12, 16), network),
    ("terms in a network of six nodes, table", "table", (0, 1, 2, 3, 4), lambda size: network(6, size)),
    ("effects on two components of order 2, table", "table", (0, 1, 2, 3, 4), lambda size: components(2, 2, size)),
)
"""Kind of growth, schedule, sizes, and what makes a model of one."""
ONCE: tuple[tuple[Coefficients, ScheduleKind], ...] = (
    (components(1, 1), "table"),
    (components(1, 3), "onboard"),
    (network(2, 4), "table"),
    (components(2, 2, 4), "table"),
)
"""Built before anything is timed: the templates and libraries that a kind of model needs are loaded once."""


@dataclass(frozen=True)
class Grown:
    """What a model of one size costs.

    Attributes
    ----------
    series, size
        Of which kind, and how large.
    cycles_held, cycles_change
        Most cycles of a step, and of one with a change of PWM.
    flash_bytes, ram_bytes
        Of the model alone.
    build_s, verify_s
        Processor time, s: lowering with its proof and all text; compiling, running and comparing for this computer and
        the emulated Mega, over the same samples for all sizes.
    equal
        Whether every word was its reference's.
    refused
        Why there is no such model on the board.
    """

    series: str
    size: int
    cycles_held: int = 0
    cycles_change: int = 0
    flash_bytes: int = 0
    ram_bytes: int = 0
    build_s: float = 0.0
    verify_s: float = 0.0
    equal: bool = False
    refused: str | None = None


def grown(quick: bool, tell: Callable[[str], None]) -> list[Grown]:
    """Measure every size in fixed point; `quick`: the first two of each series, and the last."""
    tell("what is made once")
    for coefficients, schedule in ONCE:
        built(coefficients, schedule)
    measured("", 1, ONCE[0][0], "table")
    found = []
    for series, schedule, sizes, make in SERIES:
        for size in (*sizes[:2], *sizes[2:][-1:]) if quick else sizes:
            tell(f"{series}: {size}")
            found.append(measured(series, size, make(size), schedule))
    return found


def built(coefficients: Coefficients, schedule: ScheduleKind) -> tuple[Program, LibraryContext, dict[str, str]]:
    """Lower a model with its proof, and make all text of its library.

    Raises
    ------
    CheckFailed
        When there is no such model on the board.
    """
    program = lower(coefficients, "fixed", schedule)
    context = project_context(coefficients, program, coefficients.name)
    return program, context, render.library(context)


def forget() -> None:
    """Empty what lowering keeps of models before, so that a build counts as in a process of its own."""
    for name, module in list(sys.modules.items()):
        if name.startswith("gen.lowering."):
            for value in vars(module).values():
                if callable(empty := getattr(value, "cache_clear", None)):
                    empty()


def measured(series: str, size: int, coefficients: Coefficients, schedule: ScheduleKind) -> Grown:
    """Build a model, run it, and compare every word; a refusal is told as it stands."""
    forget()
    begun = processor_s()
    try:
        program, context, files = built(coefficients, schedule)
        made = processor_s()
        profile = with_channels(campaign(program.model, LANES, LENGTH), program.channels)
        expected = reference_run(program, profile)
        with tempfile.TemporaryDirectory(prefix="grown-") as folder:
            library = write_library(program, context, files, Path(folder))
            host = HostRunner(library, "g++ -O2").run(profile)
            runner = AvrRunner(library, cache_folder())
            board = runner.run(profile)
            cost = runner.cost(profile)
    except CheckFailed as error:
        return Grown(series, size, refused=str(error).splitlines()[0])
    equal = first_mismatch(expected, host) is None and first_mismatch(expected, board) is None
    return Grown(
        series,
        size,
        cost.cycles_constant,
        cost.cycles_change,
        cost.flash_bytes,
        cost.ram_bytes,
        made - begun,
        processor_s() - made,
        equal,
    )


def processor_s() -> float:
    """Processor time of this process and of those that it started and that have ended, s, to a microsecond."""
    spent = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    return sum(one.ru_utime + one.ru_stime for one in spent)
