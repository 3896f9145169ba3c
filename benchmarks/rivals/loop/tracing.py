"""What a model misses, traced by `gen refine` and by general tools that get the residual and the same terms.

The runs come from the generator that `tests/refinement` judges `gen refine` by; one effect is planted in each trial.
For each part the tools fit r' (PySINDy) or r of the next minute (SysIdentPy) as a sparse sum of the terms. What they
name is the largest term that is an effect's, of the part that they improve most; the error is of a free run over the
test runs.
"""

from __future__ import annotations

import tempfile
import time
import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

import gen
from benchmarks.rivals.loop.terms import BLOCK_S, SETTLING, Course, FloatArray, courses
from benchmarks.rivals.missing import LibraryMissing, library
from gen.coefficients import load
from tests.refinement.plant import COEFFICIENTS
from tests.refinement.plant_effects import make

KINDS = ("load_heating", "airflow", "coupling")
SEED = 70_001
THRESHOLDS = (0.1, 0.3, 1.0, 3.0)
"""Of PySINDy's sparse fit, K in 1000 s: the sparsest whose free run is hardly worse than the best is taken."""
HARDLY = 1.1
PER_BLOCK = BLOCK_S / 1000.0


@dataclass(frozen=True)
class Sparse:
    """One part's sum of terms: r[k + 1] = r[k] + sum of factors times terms, r of its own among them; K in a minute."""

    factors: FloatArray

    def free_run(self, course: Course) -> FloatArray:
        """The residual from its first value on, K, shape (n,)."""
        terms, made = course.terms.copy(), np.zeros_like(course.residual)
        made[0] = course.residual[0]
        drive = course.terms[:, SETTLING.index("drive")]
        for k in range(len(made) - 1):
            terms[k, 0], terms[k, 1] = made[k] / 10.0, made[k] / 10.0 * drive[k]
            made[k + 1] = np.clip(made[k] + terms[k] @ self.factors, -1e3, 1e3)
        return made

    def error_K(self, own: Sequence[Course]) -> float:
        """Root mean square error of free runs, K."""
        return rms([course.residual - self.free_run(course) for course in own])


@dataclass(frozen=True)
class Traced:
    """One way's answer to one trial.

    Attributes
    ----------
    title, planted
        Who, and what was planted.
    named
        What it names first; empty for nothing.
    others
        How many further effects it names, of all parts.
    before_K, after_K
        Root mean square error on the test runs.
    seconds
        Processor time, s.
    missing
        Why nothing was measured.
    """

    title: str
    planted: str
    named: str = ""
    others: int = 0
    before_K: float = 0.0
    after_K: float = 0.0
    seconds: float = 0.0
    missing: str | None = None


Fit = Callable[[Sequence[Course]], Sparse]


def sindy(own: Sequence[Course]) -> Sparse:
    """PySINDy: sequentially thresholded least squares on smoothed differences."""
    pysindy = library("pysindy")
    fits = []
    for threshold in THRESHOLDS:
        model = pysindy.SINDy(
            optimizer=pysindy.STLSQ(threshold=threshold, alpha=1e-3),
            feature_library=pysindy.PolynomialLibrary(degree=1, include_bias=False),
            differentiation_method=pysindy.SmoothedFiniteDifference(),
        )
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            model.fit([course.residual[:, None] / 10.0 for course in own], t=PER_BLOCK, u=[c.terms[:, 1:] for c in own])
        fits.append(Sparse(np.ravel(model.coefficients()) * 10.0 * PER_BLOCK))
    errors = [fit.error_K(own) for fit in fits]
    good = [fit for fit, error in zip(fits, errors, strict=True) if error <= HARDLY * min(errors)]
    return min(good, key=lambda fit: int(np.count_nonzero(fit.factors)))


def narmax(own: Sequence[Course]) -> Sparse:
    """SysIdentPy: forward regression with orthogonal least squares, number of terms by its BIC."""
    frols = library("sysidentpy.model_structure_selection").FROLS
    basis = library("sysidentpy.basis_function").Polynomial(degree=1)
    squares = library("sysidentpy.parameter_estimation").LeastSquares()
    inputs, residual = np.vstack([c.terms[:, 1:] for c in own]), np.concatenate([c.residual for c in own])
    model = frols(
        order_selection=True, n_info_values=inputs.shape[1], info_criteria="bic", ylag=1, xlag=[[1]] * inputs.shape[1],
        estimator=squares, basis_function=basis,
    )  # fmt: skip
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        model.fit(X=inputs, y=residual[:, None])
    factors = np.zeros(inputs.shape[1] + 1)
    for code, value in zip(np.ravel(model.final_model), np.ravel(model.theta), strict=True):
        if code:  # 0 is a constant, 1001 the residual itself, 2001, 3001, .. the inputs
            factors[int(code) // 1000 - 1] = value * (10.0 if int(code) == 1001 else 1.0)
    factors[0] -= 10.0
    return Sparse(factors)


RIVALS: Mapping[str, Fit] = {"PySINDy": sindy, "SysIdentPy": narmax}


def traced(kinds: Sequence[str], tell: Callable[[str], None]) -> list[Traced]:
    """Plant each effect, and let all trace it."""
    found = []
    for kind in kinds:
        with tempfile.TemporaryDirectory(prefix="rivals-") as folder:
            fit, test, _ = make(Path(folder), (kind,), SEED)
            tell(f"gen refine: {kind}")
            found.append(ours(kind, COEFFICIENTS, fit, test))
            coefficients = load(COEFFICIENTS)
            learnt, judged = courses(coefficients, fit), courses(coefficients, test)
        for title, way in RIVALS.items():
            tell(f"{title}: {kind}")
            found.append(rival(title, way, kind, learnt, judged))
    return found


def rival(
    title: str, way: Fit, kind: str, learnt: Mapping[str, Sequence[Course]], judged: Mapping[str, Sequence[Course]]
) -> Traced:
    """Let one tool trace one trial."""
    begun = time.process_time()
    try:
        fits = {part: way(own) for part, own in learnt.items()}
    except LibraryMissing as error:
        return Traced(title, kind, missing=str(error))
    seconds = time.process_time() - begun
    gain = {part: rms([c.residual for c in own]) - fits[part].error_K(own) for part, own in learnt.items()}
    best = max(gain, key=lambda part: gain[part])
    first = named(fits[best], learnt[best])
    everywhere = {(part, name) for part, own in learnt.items() for name in named(fits[part], own)}
    before = rms([course.residual for own in judged.values() for course in own])
    after = rms([c.residual - fits[part].free_run(c) for part, own in judged.items() for c in own])
    return Traced(title, kind, first[0] if first else "", max(0, len(everywhere) - 1), before, after, seconds)


def named(fit: Sparse, own: Sequence[Course]) -> list[str]:
    """Effects whose terms take part, the largest first."""
    names = own[0].names
    sizes = np.abs(fit.factors) * np.sqrt(np.mean(np.vstack([course.terms for course in own]) ** 2, axis=0))
    order = [names[k].split()[0] for k in np.argsort(-sizes) if sizes[k] > 0.0 and names[k] not in SETTLING]
    return list(dict.fromkeys(order))


def rms(errors: Sequence[FloatArray]) -> float:
    """Root mean square of all together."""
    return float(np.sqrt(np.mean(np.concatenate(errors) ** 2)))


def ours(kind: str, model: Path, fit: Sequence[Path], test: Sequence[Path]) -> Traced:
    """Let `gen refine` trace one trial.

    Parameters
    ----------
    kind
        What was planted.
    model
        The coefficient file that the runs are held against.
    fit, test
        Run files.
    """
    begun = time.process_time()
    found = gen.refine(gen.load(model), fit=list(fit), test=list(test))
    seconds = time.process_time() - begun
    details = found.details()
    effects = [one["name"] for one in details["effects"] if not one.get("evidence", {}).get("within_tolerance")]
    before, after = (float(details[when]["test"]["rmse_K"]) for when in ("before", "after"))
    others = len(set(effects[1:]) - set(effects[:1]))
    return Traced("gen refine", kind, effects[0] if effects else "", others, before, after, seconds)
