"""Identify all components of a set of runs."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from gen.arrays import FloatArray
from gen.coefficients.checks.model_checks import FASTEST as FASTEST_OF_A_FILE
from gen.identification.logs.data import Data
from gen.identification.logs.records import Record
from gen.identification.parts.bands import Band, band
from gen.identification.parts.general import General, Judge, choose_forms, guard, misses
from gen.identification.parts.joint import Model, refine
from gen.identification.parts.linearity import Linearity, linearity
from gen.identification.parts.orders import Choice, StructureCandidate, choose
from gen.identification.parts.output_error import OFFSET_PRIOR, OutputErrorFit, OutputErrorProblem
from gen.identification.parts.speeds import choose_speeds, without_gain
from gen.identification.parts.uncertainty import (
    Criteria,
    ResidualTests,
    Uncertainty,
    criteria,
    raw_residual,
    residual_noise,
    residual_tests,
    uncertainty,
)

SETTLED = 0.95
"""A run counts as settled when it reaches this share of its steady rise."""
OFFSET_SURE = 4.0
"""A sensor's offset is believed when it is this many standard deviations from zero, and known to 0.4 K."""
OFFSET_MOST = 2.0 * OFFSET_PRIOR
"""A larger one is no offset, K: more than two sensors differ by. It says that no structure tried fits the part."""
COLDER = 0.5
"""Nor is one with which most runs would begin with the part colder than its surroundings by this, K (two counts): an
ambient that the part follows slowly, or a structure that does not fit, looks like an offset in coolings, not there."""


@dataclass(frozen=True, eq=False)
class Identified:
    """Everything about one component.

    Attributes
    ----------
    name
        The component.
    problem, choice
        Its records, and all structures that were tried.
    fit, spread
        The chosen transfer functions at the identified speeds and their uncertainty.
    offset_sd
        Standard deviation of the sensor's offset, K; None where the runs cannot tell it.
    criteria
        By structure's name and |PWM|.
    tests
        Of the residual of the general model, by run.
    settled
        Share of the steady rise that the runs reach, by |PWM|.
    linearity, general, model, band
        Over speed.
    range
        |PWM| range that the runs cover.
    held
        Whether the speeds were held; else they only span what occurs.
    """

    name: str
    problem: OutputErrorProblem
    choice: Choice
    fit: OutputErrorFit
    spread: Uncertainty
    offset_sd: float | None
    criteria: dict[str, dict[int, Criteria]]
    tests: dict[str, ResidualTests]
    settled: dict[int, float]
    linearity: Linearity
    general: General
    model: Model
    band: Band
    range: tuple[int, int]
    held: bool

    @property
    def speeds(self) -> list[int]:
        """Identified |PWM| above 0."""
        return [int(p) for p in self.fit.layout.positive]

    @property
    def standstill(self) -> bool:
        """Whether cooling at PWM 0 was identified."""
        return bool(self.fit.layout.nodes[0] == 0)


FASTEST = 3.0 / FASTEST_OF_A_FILE
"""Time constants shorter than this many steps of the board are not looked for: three times what a file must keep to,
since curves go on beyond the speeds that were run."""


def identify(
    data: Data, progress: Callable[[str], None], most: int = 4, sample_time: float = 0.25
) -> dict[str, Identified]:
    """Identify every component.

    Parameters
    ----------
    data
        The runs.
    progress
        Told what is being done.
    most
        Highest order to try.
    sample_time
        The board's step, s.
    """
    found = {}
    for name, records in data.records.items():

        def told(text: str, name: str = name) -> None:
            progress(f"{name}: {text}")

        found[name] = identify_component(name, records, told, most, FASTEST * sample_time)
    return found


def identify_component(
    name: str, records: Sequence[Record], progress: Callable[[str], None], most: int, fastest: float
) -> Identified:
    """Identify one component from its records; no time constant below `fastest`, s."""
    progress("speeds")
    speeds = choose_speeds(records, fastest)
    problem = OutputErrorProblem(records, speeds.nodes, fastest)
    choice = choose(problem, progress, most)
    unseen = without_gain(choice.chosen)
    while unseen.size and np.count_nonzero(problem.nodes) > unseen.size:
        # A gain that is zero within its uncertainty would be a guess: its speed is left to the neighbours.
        problem = OutputErrorProblem(records, np.setdiff1d(problem.nodes, unseen), fastest)
        choice = choose(problem, progress, most)
        unseen = without_gain(choice.chosen)
    fit, spread, offset_sd = _with_offset(problem, choice.chosen)
    progress("schedules")
    general = choose_forms(problem, fit, spread)
    general, model = _refined(problem, fit, spread, general)
    progress("residuals")
    return Identified(
        name=name,
        problem=problem,
        choice=choice,
        fit=fit,
        spread=spread,
        offset_sd=offset_sd,
        criteria={c.structure.name: _criteria(problem, c, choice) for c in choice.candidates},
        tests=_tests(problem, model),
        settled=_settled(problem, fit, held=speeds.held),
        linearity=linearity(fit),
        general=general,
        model=model,
        band=band(general, model, *speeds.range),
        range=speeds.range,
        held=speeds.held,
    )


def _refined(
    problem: OutputErrorProblem, fit: OutputErrorFit, spread: Uncertainty, general: General
) -> tuple[General, Model]:
    """Refine the best option; go on to the next where the refined one misses the speeds or is not physical."""
    judge = Judge(problem, fit)
    base = judge.base()
    deviation = spread.deviation[fit.layout.thetas : fit.layout.thetas + len(judge.nodes)]
    x = judge.nodes.astype(np.float64)
    allowed = [option for option in general.options if not option.rejected][:6] or [general.chosen]
    for option in allowed:
        model = refine(problem, fit, option.shape, option.vector)
        theta, steady = model.evaluate(x)
        own = judge.errors(theta[None], steady[None])[0]
        if not guard(option.shape, model.vector, fit) and not misses(own, base, deviation):
            rest = tuple(o for o in general.options if o is not option)
            return General((option, *rest)), model
    unrefined = refine(problem, fit, allowed[0].shape, allowed[0].vector, most=1)
    return general, unrefined


def _with_offset(
    problem: OutputErrorProblem, chosen: StructureCandidate
) -> tuple[OutputErrorFit, Uncertainty, float | None]:
    """Also estimate the sensor's offset, where the runs can tell it from the rise, and keep it where it is sure."""
    fit, spread = chosen.fit, chosen.uncertainty
    layout = problem.layout(chosen.structure, offset=True)
    trial = problem.fit(layout, np.append(fit.vector, 0.0))
    found = uncertainty(problem, trial)
    deviation = float(found.deviation[-1])
    if deviation > 0.4:
        return fit, spread, None
    sure = abs(trial.offset) > OFFSET_SURE * deviation and trial.cost < fit.cost
    # As measured: a fitted start takes over whatever the structure cannot follow in the first minutes.
    begin = float(np.median([np.mean(record.rise[:3]) for record in problem.records])) - trial.offset
    if sure and abs(trial.offset) <= OFFSET_MOST and begin > -COLDER:
        return trial, found, deviation
    return fit, spread, deviation


def _criteria(problem: OutputErrorProblem, candidate: StructureCandidate, choice: Choice) -> dict[int, Criteria]:
    """Criteria at each identified speed, from the raw samples in the segments of that speed.

    The number of effective samples is that of the chosen structure: criteria are only comparable over the same data.
    """
    errors: dict[int, list[FloatArray]] = {}
    values: dict[int, list[FloatArray]] = {}
    effective: dict[int, float] = {}
    for r, record in enumerate(problem.records):
        error = raw_residual(problem, candidate.fit, r)
        pwm = record.segments.pwm[record.raw_segment]
        for node in candidate.fit.layout.positive.tolist():
            mine = pwm == node
            if mine.any():
                errors.setdefault(node, []).append(error[mine])
                values.setdefault(node, []).append(record.raw_rise[mine])
                share = choice.chosen.uncertainty.noises[r].effective * float(mine.mean())
                effective[node] = effective.get(node, 0.0) + share
    parameters = candidate.structure.order + 2.0
    return {
        node: criteria(np.concatenate(errors[node]), np.concatenate(values[node]), effective[node], parameters)
        for node in sorted(errors)
    }


def _tests(problem: OutputErrorProblem, model: Model) -> dict[str, ResidualTests]:
    result = {}
    for record, residual in zip(problem.records, model.residuals, strict=True):
        result[record.run] = residual_tests(record, residual_noise(record, residual, 0.0))
    return result


def _settled(problem: OutputErrorProblem, fit: OutputErrorFit, *, held: bool) -> dict[int, float]:
    """Largest share of the way to the steady rise that a hold (or, where no speed is held, a run) goes, by |PWM|."""
    poles = np.abs(np.asarray(fit.layout.structure.poles(fit.theta)).real)
    result: dict[int, float] = {}
    first = len(fit.layout.nodes) - len(fit.layout.positive)
    for i, node in enumerate(fit.layout.positive.tolist()):
        slow = float(np.min(poles[first + i]))
        for record in problem.records:
            lengths = record.segments.length[record.segments.pwm == node] if held else np.array([record.duration])
            if lengths.size:
                share = 1.0 - float(np.exp(-slow * lengths.max()))
                result[node] = max(result.get(node, 0.0), share)
    return result
