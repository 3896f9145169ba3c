"""Starting values: time constants from a grid or from a simpler fit, gains by linear least squares."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from gen.arrays import FloatArray
from gen.identification.parts.output_error import Layout, OutputErrorFit, OutputErrorProblem
from gen.identification.parts.structure import Structure

_GRID = 9


def common(problem: OutputErrorProblem, layout: Layout, theta: FloatArray) -> FloatArray:
    """Complete structure parameters to a vector: rises, initial values and offset by linear least squares.

    Parameters
    ----------
    theta
        Shape (nodes, order).
    """
    vector = np.zeros(layout.size)
    vector[: layout.thetas] = theta.ravel()
    linear = np.arange(layout.thetas, layout.size)
    residuals, jacobian = problem.evaluate(layout, vector)
    target = np.concatenate([w * e for w, e in zip(problem.weights, residuals, strict=True)])
    matrix = -jacobian[:, linear]
    # A hint of damping: a rise or a state that the data do not show stays zero.
    damping = 1e-6 * np.sqrt(np.mean(matrix**2) * len(target)) * np.eye(len(linear))
    solved = np.linalg.lstsq(np.vstack([matrix, damping]), np.append(target, np.zeros(len(linear))), rcond=None)[0]
    vector[linear] = solved
    return vector


def first_order(problem: OutputErrorProblem) -> OutputErrorFit:
    """Fit order 1 from a grid of time constants common to all speeds."""
    layout = problem.layout(Structure(1))
    longest = max(record.duration for record in problem.records)
    shortest = max(2.0 * problem.fastest, longest / 300.0)
    starts = []
    for tau in np.geomspace(shortest, 3.0 * longest, _GRID):
        vector = common(problem, layout, np.full((len(layout.nodes), 1), np.log(tau)))
        starts.append((_cost(problem, layout, vector), vector))
    starts.sort(key=lambda item: item[0])
    fits = [problem.fit(layout, vector) for _, vector in starts[:2]]
    return min(fits, key=lambda fit: fit.cost)


def richer(simple: OutputErrorFit, structure: Structure) -> Iterator[FloatArray]:
    """Give structure parameters for one more pole, or for a pair, from a fit without it, shape (nodes, order)."""
    theta = simple.theta
    if structure.pair:
        split = np.log(1.5)
        for zeta in (0.8, 1.3):
            fast = theta[:, -2:].mean(axis=1)
            yield np.column_stack([theta[:, :-2], fast, np.full(len(theta), np.log(zeta))])
        fast = np.full(len(theta), theta[:, -2:].mean() - split)
        yield np.column_stack([theta[:, :-2], fast, np.zeros(len(theta))])
        return
    fastest = np.full(len(theta), np.median(theta[:, -1]))
    for factor in (3.0, 12.0, 50.0):
        yield np.column_stack([theta, fastest - np.log(factor)])
    # A slower pole beside the known ones, which then become faster.
    slow = np.median(theta[:, 0])
    yield np.column_stack([np.full(len(theta), slow + np.log(2.5)), theta - np.log(1.3)])


def ladder(problem: OutputErrorProblem, simple: OutputErrorFit, structure: Structure) -> OutputErrorFit:
    """Fit a structure from several starts, composed node by node of the best."""
    layout = problem.layout(structure)
    fits = [problem.fit(layout, common(problem, layout, theta), most=15) for theta in richer(simple, structure)]
    best = min(fits, key=lambda fit: fit.cost)
    composed = _compose(problem, layout, fits)
    final = [problem.fit(layout, best.vector)]
    if composed is not None:
        final.append(problem.fit(layout, composed))
    return min(final, key=lambda fit: fit.cost)


def _compose(problem: OutputErrorProblem, layout: Layout, fits: list[OutputErrorFit]) -> FloatArray | None:
    """Take each node's parameters from the fit that suits the records at that node best."""
    costs = np.array(
        [[np.sum((w * e) ** 2) for w, e in zip(problem.weights, fit.residuals, strict=True)] for fit in fits]
    )
    theta = np.empty((len(layout.nodes), layout.order))
    chosen = []
    for i, node in enumerate(layout.nodes):
        at = [r for r, record in enumerate(problem.records) if node in record.segments.dwell()]
        pick = int(np.argmin(costs[:, at].sum(axis=1))) if at else int(np.argmin(costs.sum(axis=1)))
        chosen.append(pick)
        theta[i] = fits[pick].theta[i]
    if len(set(chosen)) == 1:
        return None
    return common(problem, layout, theta)


def _cost(problem: OutputErrorProblem, layout: Layout, vector: FloatArray) -> float:
    residuals = [record.rise - problem.model(layout, vector[None, :], r)[0] for r, record in enumerate(problem.records)]
    return sum(float(np.sum((w * e) ** 2)) for w, e in zip(problem.weights, residuals, strict=True))
