"""Prove the generated C++ equal to the reference, and judge the reference by the exact solution."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable, Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any, Literal

from gen.arrays import RecordArray
from gen.avr.chip import BOARDS, MEGA, Chip
from gen.coefficients import Coefficients
from gen.coefficients.wiring import BoardName
from gen.files import scratch
from gen.firmware import render
from gen.firmware.context import project_context
from gen.lowering.alarms import lower_alarms
from gen.lowering.forecast import lower_forecast
from gen.lowering.kinds import Arithmetic, ScheduleKind
from gen.lowering.lower import lower
from gen.lowering.program import Program
from gen.lowering.protection import lower_protection
from gen.verification import compare
from gen.verification.accuracy import LENGTH, ErrorCourse, StepErrors, error_course, step_errors
from gen.verification.compare import Mismatch
from gen.verification.comparisons import Compared, compare_alarms, compare_forecast, compare_protection
from gen.verification.effect_costs import EffectCost, effect_costs
from gen.verification.effects import EFFECTS_LENGTH, course_with_effects
from gen.verification.limits import exceeded
from gen.verification.network import course_of_network
from gen.verification.profiles import Profile, campaign, every_command, with_channels
from gen.verification.proof import proof_of
from gen.verification.runners import HOST_BUILDS, AvrRunner, Cost, HostRunner, Library, write_library
from gen.version import __version__

Target = Literal["host", "avr", "all"]
Files = Mapping[str, str]
Mutation = Callable[[dict[str, str]], Files]

#: Lanes and length of the host's campaign: one million samples and more.
HOST_LANES, HOST_LENGTH = 64, 16_400
#: One 10 800 s run on the emulated board, cut into lanes with their own starts.
AVR_LANES, AVR_LENGTH = 8, 5_400
#: The same for the alarm rules.
ALARM_LANES, ALARM_LENGTH = 24, 1_800
#: Each sample of it moves a model on by as many as the file says.
AHEAD_LANES, AHEAD_LENGTH = 3, 300
#: Lanes judged against the exact solution.
ACCURACY_LANES = 12
#: Samples of the course of the error in a campaign that is cut short: a quarter of an hour.
LEAST_COURSE = 3_600


@dataclass(frozen=True)
class TargetResult:
    """One target's comparison."""

    target: str
    samples: int
    words: int
    differing: int
    mismatch: str | None = None
    profile: dict[str, Any] | None = None


@dataclass(frozen=True)
class CombinationResult:
    """One arithmetic with one schedule."""

    arithmetic: Arithmetic
    schedule: ScheduleKind
    targets: list[TargetResult]
    bound_K: dict[str, float | None]
    error_K: dict[str, float]
    error_course: ErrorCourse
    step_errors: StepErrors
    cost: Cost | None = None
    helpers: list[str] = field(default_factory=list)
    effects: list[EffectCost] = field(default_factory=list)
    exceeded: list[str] = field(default_factory=list)
    proven_K: dict[str, float] = field(default_factory=dict)
    inequalities: int = 0
    refuted: str | None = None

    @property
    def label(self) -> str:
        """The combination for people."""
        return f"{self.arithmetic}/{self.schedule}"

    @property
    def passed(self) -> bool:
        """No word differs, and no error is larger than it may be."""
        return self.equal and not self.exceeded and self.refuted is None

    @property
    def equal(self) -> bool:
        """No word differs."""
        return all(target.differing == 0 for target in self.targets)


def verify(
    coefficients: Coefficients,
    arithmetics: Iterable[Arithmetic],
    schedules: Iterable[ScheduleKind],
    target: Target,
    *,
    progress: Callable[[str], None] = lambda _: None,
    mutation: Mutation | None = None,
    scale: float = 1.0,
    host_builds: Iterable[str] = tuple(HOST_BUILDS),
    board: BoardName | None = None,
) -> list[CombinationResult]:
    """Compare every asked combination on every asked target.

    Parameters
    ----------
    coefficients
        What to build.
    arithmetics, schedules, target
        What to compare.
    progress
        Told what is being done.
    mutation
        Changes the emitted files before they are compiled: how tests show that a fault is caught.
    scale
        Share of the full campaign's length.
    host_builds
        Which of :data:`gen.verification.runners.HOST_BUILDS` to run.
    board
        Which is emulated; None: the file's own.

    Raises
    ------
    CheckFailed
        If the library has no room in the chip; if the emitted code does not compile, crashes, or a bound exceeds its
        limit.
    """
    programs = []
    for arithmetic, schedule in itertools.product(arithmetics, schedules):
        progress(f"{arithmetic}/{schedule}: lowering")
        programs.append(lower(coefficients, arithmetic, schedule))
    results = []
    for program in programs:
        with scratch("gen-verify-") as folder:
            results.append(
                _combination(
                    coefficients,
                    program,
                    folder,
                    target,
                    progress,
                    mutation,
                    scale,
                    tuple(host_builds),
                    BOARDS[board or coefficients.document.board],
                )
            )
    return results


@dataclass(frozen=True)
class _Bench:
    """One combination's library, and how long to compare it."""

    coefficients: Coefficients
    program: Program
    library: Library
    folder: Path
    progress: Callable[[str], None]
    scale: float
    chip: Chip

    def say(self, what: str) -> None:
        self.progress(f"{self.program.label}: {what}")

    def length(self, full: int, least: int) -> int:
        """Of a campaign that is cut short."""
        return max(least, int(full * self.scale))

    @property
    def every_command(self) -> Profile:
        """A profile that holds each PWM once."""
        return with_channels(every_command(self.program.model), self.program.channels, seed=511)

    def campaign(self, lanes: int, full: int, seeds: tuple[int, int]) -> tuple[Profile, RecordArray]:
        """A profile, and what the reference says of it; of the two seeds one is of commands, one of channels."""
        profile = campaign(self.program.model, lanes, self.length(full, 600), seed=seeds[0])
        profile = with_channels(profile, self.program.channels, seed=seeds[1])
        self.say(f"reference, {profile.samples} samples")
        return profile, compare.reference_run(self.program, profile)


def _combination(
    coefficients: Coefficients,
    program: Program,
    folder: Path,
    target: Target,
    progress: Callable[[str], None],
    mutation: Mutation | None,
    scale: float,
    host_builds: tuple[str, ...],
    chip: Chip,
) -> CombinationResult:
    context = project_context(coefficients, program, coefficients.name)
    files: Files = render.library(context)
    if mutation is not None:
        files = mutation(dict(files))
    library = write_library(program, context, files, folder, chip)
    bench = _Bench(coefficients, program, library, folder, progress, scale, chip)
    hosts = host_builds if target in ("host", "all") else ()
    targets = _on_hosts(bench, hosts) if hosts else []
    cost: Cost | None = None
    helpers: list[str] = []
    effects: list[EffectCost] = []
    if target in ("avr", "all"):
        own, cost, helpers = _on_the_board(bench)
        targets += own
        effects = effect_costs(coefficients, program, folder, progress) if chip == MEGA else []
    targets += _of_rules(bench, hosts, board=target != "host")
    bench.say("certificate")
    proven = proof_of(coefficients, program, folder)
    bench.say("exact solution")
    course = _course(coefficients, program, scale)
    bounds, errors = _bounds(program), course.largest()
    return CombinationResult(
        program.arithmetic,
        program.schedule,
        targets,
        bounds,
        errors,
        course,
        step_errors(program, max(600, int(LENGTH * min(scale, 1.0)))),
        cost,
        helpers,
        effects,
        exceeded(bounds, errors, *coefficients.accuracy.limit(program.arithmetic)),
        proven.proven_K,
        proven.inequalities,
        proven.refuted,
    )


def _on_hosts(bench: _Bench, builds: tuple[str, ...]) -> list[TargetResult]:
    """The recursions, compiled for this computer."""
    profile, expected = bench.campaign(HOST_LANES, HOST_LENGTH, (2026, 17))
    commands = bench.every_command
    schedule = compare.reference_run(bench.program, commands)
    targets = []
    for name in builds:
        bench.say(name)
        host = HostRunner(bench.library, name)
        targets.append(_compared(bench.program, name, host.run, profile, expected))
        targets.append(_compared(bench.program, f"{name}, every command", host.run, commands, schedule))
    return targets


def _on_the_board(bench: _Bench) -> tuple[list[TargetResult], Cost | None, list[str]]:
    """The same on the emulated board, what a sample costs there, and what the compiler brought of its own."""
    profile, expected = bench.campaign(AVR_LANES, AVR_LENGTH, (2560, 2561))
    bench.say(f"emulated {bench.chip.name}")
    board = AvrRunner(bench.library, bench.folder / "cache")
    targets = [
        _compared(bench.program, board.name, board.run, bench.every_command, None, suffix=", every command"),
        _compared(bench.program, board.name, board.run, profile, expected),
    ]
    cost = board.cost(profile) if targets[-1].differing == 0 else None
    return targets, cost, board.helper_symbols()


def _of_rules(bench: _Bench, hosts: tuple[str, ...], *, board: bool) -> list[TargetResult]:
    """Alarm rules, protection and forecast."""
    bench.say("alarms")
    library, length = bench.library, bench.length(ALARM_LENGTH, 300)
    rules, entries = lower_alarms(bench.coefficients), lower_protection(bench.coefficients)
    ahead = lower_forecast(bench.coefficients, bench.program)
    compared = [
        *compare_alarms(library, rules, ALARM_LANES, length, hosts, board=board),
        *compare_protection(library, entries, ALARM_LANES, length, hosts, board=board),
        *compare_forecast(library, ahead, AHEAD_LANES, bench.length(AHEAD_LENGTH, 40), hosts, board=board),
    ]
    return [_alarm_result(one) for one in compared]


def _course(coefficients: Coefficients, program: Program, scale: float) -> ErrorCourse:
    lanes = max(2, int(ACCURACY_LANES * min(scale, 1.0)))
    if program.network is not None:
        return course_of_network(program, lanes, max(600, int(EFFECTS_LENGTH * min(scale, 1.0))))
    if program.effects is None:
        return error_course(program, lanes, max(LEAST_COURSE, int(LENGTH * min(scale, 1.0))))
    return course_with_effects(program, coefficients.effects, lanes, max(600, int(EFFECTS_LENGTH * min(scale, 1.0))))


def _bounds(program: Program) -> dict[str, float | None]:
    """What is guaranteed by component; nothing where effects act."""
    changed = {part.name for part in program.effects.components} if program.effects is not None else set()
    return {
        component.name: component.proof.bound_K if component.proof and component.name not in changed else None
        for component in program.parts
    }


def _compared(
    program: Program,
    name: str,
    run: compare.Runner,
    profile: Profile,
    expected: RecordArray | None,
    *,
    suffix: str = "",
) -> TargetResult:
    if expected is None:
        expected = compare.reference_run(program, profile)
    mismatch: Mismatch | None = compare.first_mismatch(expected, run(profile))
    words = profile.samples * compare.words_per_sample(program)
    if mismatch is None:
        return TargetResult(name + suffix, profile.samples, words, 0)
    short, still = compare.shrink(program, run, profile, mismatch)
    return TargetResult(
        name + suffix,
        profile.samples,
        words,
        mismatch.differing,
        str(still),
        short.as_json(still.lane, [channel.column for channel in program.channels]),
    )


def _alarm_result(compared: Compared) -> TargetResult:
    name, expected, difference = compared
    words = expected.size * len(expected.dtype.names or ())
    if difference is None:
        return TargetResult(name, expected.size, words, 0)
    return TargetResult(name, expected.size, words, difference.differing, str(difference))


def _verdict(results: list[CombinationResult]) -> str:
    if not all(result.equal for result in results):
        return "different"
    return "equal" if all(result.passed for result in results) else "inaccurate"


def summary(coefficients: Coefficients, results: list[CombinationResult]) -> dict[str, Any]:
    """The JSON form of a verification, without anything that depends on the machine or the hour."""
    return {
        "tool": f"gen {__version__}",
        "model": coefficients.name,
        "coefficients_sha256": coefficients.sha256,
        "verdict": _verdict(results),
        "samples": sum(target.samples for result in results for target in result.targets),
        "words": sum(target.words for result in results for target in result.targets),
        "differing": sum(target.differing for result in results for target in result.targets),
        "combinations": [asdict(result) for result in results],
    }
