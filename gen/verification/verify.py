"""Prove the generated C++ equal to the reference, and judge the reference by the exact solution."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable, Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any, Literal

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
from gen.verification.runners import HOST_BUILDS, AvrRunner, Cost, HostRunner, write_library
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
    label = program.label
    context = project_context(coefficients, program, coefficients.name)
    files: Files = render.library(context)
    if mutation is not None:
        files = mutation(dict(files))
    library = write_library(program, context, files, folder, chip)
    targets: list[TargetResult] = []
    cost: Cost | None = None
    helpers: list[str] = []
    effects: list[EffectCost] = []
    commands = with_channels(every_command(program.model), program.channels, seed=511)
    if target in ("host", "all"):
        profile = campaign(program.model, HOST_LANES, max(600, int(HOST_LENGTH * scale)))
        profile = with_channels(profile, program.channels)
        progress(f"{label}: reference, {profile.samples} samples")
        expected = compare.reference_run(program, profile)
        schedule = compare.reference_run(program, commands)
        for name in host_builds:
            progress(f"{label}: {name}")
            host = HostRunner(library, name)
            targets.append(_compared(program, name, host.run, profile, expected))
            targets.append(_compared(program, f"{name}, every command", host.run, commands, schedule))
    if target in ("avr", "all"):
        profile = campaign(program.model, AVR_LANES, max(600, int(AVR_LENGTH * scale)), seed=2560)
        profile = with_channels(profile, program.channels, seed=2561)
        progress(f"{label}: reference, {profile.samples} samples")
        expected = compare.reference_run(program, profile)
        progress(f"{label}: emulated {chip.name}")
        board = AvrRunner(library, folder / "cache")
        targets.append(_compared(program, board.name, board.run, commands, None, suffix=", every command"))
        targets.append(_compared(program, board.name, board.run, profile, expected))
        cost = board.cost(profile) if targets[-1].differing == 0 else None
        helpers = board.helper_symbols()
        effects = effect_costs(coefficients, program, folder, progress) if chip == MEGA else []
    progress(f"{label}: alarms")
    rules = lower_alarms(coefficients)
    hosts = host_builds if target in ("host", "all") else ()
    length = max(300, int(ALARM_LENGTH * scale))
    board_too = target != "host"
    targets += map(_alarm_result, compare_alarms(library, rules, ALARM_LANES, length, hosts, board=board_too))
    entries = lower_protection(coefficients)
    targets += map(_alarm_result, compare_protection(library, entries, ALARM_LANES, length, hosts, board=board_too))
    ahead = lower_forecast(coefficients, program)
    length = max(40, int(AHEAD_LENGTH * scale))
    targets += map(_alarm_result, compare_forecast(library, ahead, AHEAD_LANES, length, hosts, board=board_too))
    progress(f"{label}: certificate")
    proven = proof_of(coefficients, program, folder)
    progress(f"{label}: exact solution")
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
    expected: compare.Records | None,
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
