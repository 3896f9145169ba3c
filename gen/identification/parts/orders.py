"""Which order: by the error on data that took no part in the fit, after what is not physical has been rejected."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from gen.arrays import FloatArray, IntArray
from gen.identification.parts.output_error import OutputErrorFit, OutputErrorProblem
from gen.identification.parts.response import simulate
from gen.identification.parts.start import first_order, ladder
from gen.identification.parts.structure import CANDIDATES, PoleArray, Structure
from gen.identification.parts.uncertainty import Uncertainty, uncertainty

FOLDS = 4
CHUNKS = 20
"""Contiguous stretches into which a run is cut; each takes part in one fold."""
SIGNIFICANT = 2.0
"""A richer structure has to win by this many standard errors of the paired differences."""
WORTH = 0.01
"""And by this share of the held-out error."""
SLOWEST = 10.0
"""A time constant longer than this many runs is not seen in them."""
UNKNOWN = 1.0
"""Standard deviation of a logarithm from which a parameter counts as not identified (a factor of 2.7)."""


@dataclass(frozen=True, eq=False)
class StructureCandidate:
    """One structure, fitted.

    Attributes
    ----------
    structure, fit, uncertainty
        The fit on all data.
    losses
        Mean normalised square error on held-out stretches, shape (stretches,); 1 is the noise level.
    rejected
        Why it cannot be chosen; empty when it can.
    """

    structure: Structure
    fit: OutputErrorFit
    uncertainty: Uncertainty
    losses: FloatArray
    rejected: tuple[str, ...]

    @property
    def loss(self) -> float:
        """Mean over the held-out stretches."""
        return float(np.mean(self.losses))


@dataclass(frozen=True)
class Choice:
    """All candidates and the chosen one, with the reason."""

    candidates: tuple[StructureCandidate, ...]
    chosen: StructureCandidate
    reason: str
    held_out: str


def choose(problem: OutputErrorProblem, progress: Callable[[str], None], most: int = 4) -> Choice:
    """Fit all structures up to an order and choose.

    Parameters
    ----------
    problem
        One component's records.
    progress
        Told what is being done.
    most
        Highest order.
    """
    groups, folds, held_out = folds_of(problem)
    fits: dict[Structure, OutputErrorFit] = {}
    candidates: list[StructureCandidate] = []
    for structure in CANDIDATES:
        if structure.order > most:
            continue
        progress(f"order {structure.name}")
        if structure.order == 1:
            fit = first_order(problem)
        else:
            base = Structure(structure.order) if structure.pair else Structure(structure.order - 1)
            fit = ladder(problem, fits[base], structure)
            if not structure.pair and Structure(base.order, True) in fits:
                # The pair may have found a better fit; one real pole more can start from there too.
                fit = min(fit, _from_pair(problem, fits[Structure(base.order, True)], structure), key=lambda f: f.cost)
        fits[structure] = fit
        candidates.append(candidate_of(problem, fit, groups, folds))
        if structure.order >= 3 and _hopeless(candidates, structure.order):
            break
    chosen, reason = _choose(candidates)
    return Choice(tuple(candidates), chosen, reason, held_out)


def candidate_of(
    problem: OutputErrorProblem, fit: OutputErrorFit, stretch: FloatArray, folds: list[FloatArray]
) -> StructureCandidate:
    """Judge a fit: uncertainty, error on held-out stretches, reasons against it."""
    spread = uncertainty(problem, fit)
    losses = _held_out(problem, fit, stretch, folds)
    return StructureCandidate(fit.layout.structure, fit, spread, losses, (*_unphysical(problem, fit, spread),))


def _hopeless(candidates: list[StructureCandidate], order: int) -> bool:
    """Whether the last two orders brought nothing, so that the next need not be tried."""
    best = min(c.loss for c in candidates if c.structure.order <= order - 2)
    return all(c.loss > best * (1.0 - WORTH) for c in candidates if c.structure.order > order - 2)


def _from_pair(problem: OutputErrorProblem, pair: OutputErrorFit, structure: Structure) -> OutputErrorFit:
    layout = problem.layout(structure)
    poles = pair.layout.structure.poles(pair.theta)
    tau = np.log(1.0 / np.maximum(np.abs(poles), 1e-9)) + np.linspace(0.1, -0.1, poles.shape[-1])
    theta = np.column_stack([tau, np.median(tau) - np.log(20.0) * np.ones(len(tau))])
    vector = np.zeros(layout.size)
    vector[: layout.thetas] = structure.sorted(theta).ravel()
    vector[layout.thetas : layout.thetas + len(layout.positive)] = pair.steady
    return problem.fit(layout, vector, most=20)


def folds_of(problem: OutputErrorProblem) -> tuple[FloatArray, list[FloatArray], str]:
    """Give the stretch number of every row, the masks of the folds (1 = used for fitting), and what they are."""
    stretch = np.empty(int(problem.rows[-1]))
    fold = np.empty(int(problem.rows[-1]), dtype=np.int64)
    by_level: dict[int, set[int]] = {}
    for r, record in enumerate(problem.records):
        for node in set(problem.nodes.tolist()) & set(record.segments.dwell()):
            by_level.setdefault(node, set()).add(r)
    runs = len(problem.records)
    whole = runs >= 3 and all(len(by_level.get(int(node), set())) >= 2 for node in problem.nodes)
    for r, record in enumerate(problem.records):
        rows = slice(int(problem.rows[r]), int(problem.rows[r + 1]))
        chunk = np.minimum(np.arange(len(record.time)) * CHUNKS // len(record.time), CHUNKS - 1)
        stretch[rows] = chunk + CHUNKS * r
        fold[rows] = r % max(min(FOLDS, runs), 2) if whole else (chunk + r) % FOLDS
    masks = [(fold != k).astype(np.float64) for k in np.unique(fold)]
    what = "whole runs" if whole else f"stretches (a {CHUNKS}th of a run each, every {FOLDS}th at a time)"
    return stretch, masks, what


def _held_out(
    problem: OutputErrorProblem, fit: OutputErrorFit, stretch: FloatArray, folds: list[FloatArray]
) -> FloatArray:
    square = np.empty(int(problem.rows[-1]))
    for mask in folds:
        refit = problem.fit(fit.layout, fit.vector, mask, most=6)
        weighted = np.concatenate([w * e for w, e in zip(problem.weights, refit.residuals, strict=True)])
        square = np.where(mask == 0.0, weighted**2, square)
    total = np.bincount(stretch.astype(np.int64), square)
    count = np.bincount(stretch.astype(np.int64))
    return total[count > 0] / count[count > 0]


def _choose(candidates: list[StructureCandidate]) -> tuple[StructureCandidate, str]:
    """Take the simplest that nothing beats by more than chance and by more than a hundredth."""
    allowed = [c for c in candidates if not c.rejected]
    if not allowed:
        first = candidates[0]
        return first, f"every candidate has a fault; order 1 is kept in spite of: {'; '.join(first.rejected)}"
    chosen = allowed[0]
    reason = "no richer structure lowers the error on held-out data"
    for candidate in allowed[1:]:
        if beats(candidate, chosen):
            gain = 1.0 - candidate.loss / chosen.loss
            reason = f"lowers the held-out square error of order {chosen.structure.name} by {gain:.0%}"
            chosen = candidate
    return chosen, reason


def beats(rich: StructureCandidate, simple: StructureCandidate) -> bool:
    """Whether the richer one lowers the held-out error by more than chance and by more than a hundredth."""
    difference = simple.losses - rich.losses
    error = float(np.std(difference, ddof=1) / np.sqrt(len(difference)))
    mean = float(np.mean(difference))
    return mean > SIGNIFICANT * error and mean > WORTH * simple.loss


def _unphysical(problem: OutputErrorProblem, fit: OutputErrorFit, spread: Uncertainty) -> list[str]:
    """Find reasons against a fit: no steady state, negative gain, ringing, parameters that nothing determines."""
    layout = fit.layout
    deviation = spread.deviation
    reasons = []
    longest = max(record.duration for record in problem.records)
    poles = layout.structure.poles(fit.theta)
    slow = 1.0 / np.min(np.abs(poles.real), axis=1)
    at = layout.nodes[slow > SLOWEST * longest]
    if at.size:
        reasons.append(
            f"no steady state: the slowest time constant at PWM {_listed(at)} is over {SLOWEST:g} runs long "
            "(drift, or an unstable system)"
        )
    error = deviation[layout.thetas : layout.thetas + len(layout.positive)]
    negative = layout.positive[fit.steady < -3.0 * error]
    if negative.size:
        reasons.append(f"negative gain at PWM {_listed(negative)}: it would cool when driven")
    ringing = [int(node) for i, node in enumerate(layout.nodes) if _rings(problem, fit, poles, i)]
    if ringing:
        reasons.append(f"rings by more than the noise at PWM {_listed(np.array(ringing))}")
    theta = deviation[: layout.thetas].reshape(-1, layout.order)
    unknown = np.mean(theta > UNKNOWN, axis=0)
    for label, share in zip(layout.structure.labels, unknown, strict=True):
        if share > 0.5:
            reasons.append(f"not identifiable: {label} is uncertain by more than a factor of 2.7 at most speeds")
    smallest = np.median(1.0 / np.max(np.abs(poles), axis=1))
    if layout.order > 1 and smallest < 1.2 * problem.fastest:
        reasons.append(
            f"not identifiable: a time constant runs to the shortest one looked for, {problem.fastest:.2g} s"
        )
    return reasons


def _rings(problem: OutputErrorProblem, fit: OutputErrorFit, poles: PoleArray, node: int) -> bool:
    """Whether the step response at a node overshoots beyond the noise: no passive heat path does."""
    if not np.iscomplexobj(poles) or np.all(np.abs(poles[node].imag) < 1e-9):
        return False
    layout = fit.layout
    height = float(np.max(np.abs(fit.steady))) if fit.steady.size else 1.0
    longest = 8.0 / float(np.min(np.abs(poles[node].real)))
    grid = np.concatenate([np.linspace(0.0, longest / 10.0, 200), np.linspace(longest / 10.0, longest, 200)])
    start = np.zeros((1, layout.order))
    one = np.zeros(len(grid), dtype=np.int64)
    rise = simulate(poles[None, node : node + 1], np.array([[height]]), start, np.array([longest]), one, grid)[0]
    noise = max(record.noise_K + record.quantum_K / 2.0 for record in problem.records)
    return bool(float(np.max(rise)) - height > 2.0 * max(noise, 1e-3))


def _listed(values: IntArray) -> str:
    return ", ".join(str(v) for v in values)
