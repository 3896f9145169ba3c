"""Runs that a mistake in logging explains: two sensors in each other's columns, a PWM in percent.

No effect is to be learnt from these. What is asked is much: with the mistake undone the file, as it is, has to miss the
run by no more than its own error and the sensors' noise, and by far less than it does.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import partial
from itertools import combinations

import numpy as np

from gen.arrays import FloatArray
from gen.coefficients import Coefficients
from gen.errors import InputError
from gen.reference.simulate import simulate_run
from gen.runs import Run
from gen.side_by_side import side_by_side

_PERCENT = 100
_FAR_LESS = 0.4
"""Error with the mistake undone, over that of the run as it is, from which it is one."""
_ITS_OWN = 1.5
"""The same over the file's own error and the noise of the run's readings together."""
_LEAST_NOISE_K = 0.1
_OF_A_DEVIATION = 1.4826
"""Standard deviation of normal noise over the median of its absolute values."""


def check_mistakes(coefficients: Coefficients, runs: Sequence[tuple[str, Run]]) -> None:
    """Refuse runs that a mistake in logging explains.

    Parameters
    ----------
    coefficients
        The file.
    runs
        By name.

    Raises
    ------
    InputError
        With the run, the mistake, and what the file misses the run by with it and without.
    """
    found = side_by_side([partial(_mistake, coefficients, run, name) for name, run in runs])
    for (name, _), (place, said) in zip(runs, found, strict=True):
        if said:
            raise InputError(said, file=name, place=place)


def _mistake(coefficients: Coefficients, run: Run, name: str) -> tuple[str, str]:
    """What is mistaken in a run, and its column; nothing of a run that the file explains, or no mistake does."""
    shown = _shown(coefficients, run, name)
    as_it_is, own = _error_K(run, shown), _own_K(coefficients, run)
    if as_it_is <= _ITS_OWN * own:
        return "", ""
    for place, said, other in _others(coefficients, run, shown):
        undone = _error_K(other, _shown(coefficients, other, name))
        if undone <= min(_FAR_LESS * as_it_is, _ITS_OWN * own):
            return place, (
                f"{said}: so taken, the file misses this run by {undone:.2g} K, and as it stands by {as_it_is:.2g} K; "
                "mend it (gen import) and refine anew"
            )
    return "", ""


def _others(coefficients: Coefficients, run: Run, shown: dict[str, FloatArray]) -> Iterator[tuple[str, str, Run]]:
    """Give the run without each mistake that it may hold: a column, what to say, and the run."""
    fastest, run_fastest = coefficients.model.validity[1], int(np.abs(run.pwm).max())
    counts = coefficients.document.input.full_scale / _PERCENT
    if run_fastest <= _PERCENT < fastest:
        pwm = np.rint(run.pwm * counts).astype(np.int64)
        yield "column pwm", "PWM looks like percent, where the file's is in counts", replace(run, pwm=pwm)
    if fastest <= _PERCENT < run_fastest:
        pwm = np.rint(run.pwm / counts).astype(np.int64)
        yield "column pwm", "PWM looks like counts, where the file's is in percent", replace(run, pwm=pwm)
    for one, other in combinations(run.temps, 2):
        # From a wrong start, but mostly near: to look at those pairs alone that promise something.
        crossed = _square(run.temps[one], shown[other]) + _square(run.temps[other], shown[one])
        if crossed < _square(run.temps[one], shown[one]) + _square(run.temps[other], shown[other]):
            temps = {**run.temps, one: run.temps[other], other: run.temps[one]}
            said = f"{one}_degC and {other}_degC look like each other's"
            yield f"column {one}_degC", said, replace(run, temps=temps)


def _shown(coefficients: Coefficients, run: Run, name: str) -> dict[str, FloatArray]:
    columns = simulate_run(coefficients, run, "exact", "auto", name)
    return {part: np.asarray(columns[f"{part}_degC"], dtype=np.float64) for part in run.temps}


def _square(read: FloatArray, shown: FloatArray) -> float:
    """Mean square of what was read less what is shown, K^2; 0 where nothing was read."""
    return float(np.nanmean((read - shown) ** 2)) if np.isfinite(read).any() else 0.0


def _error_K(run: Run, shown: dict[str, FloatArray]) -> float:
    """Root mean square over all parts, each counting alike, K."""
    return float(np.sqrt(np.mean([_square(read, shown[part]) for part, read in run.temps.items()])))


def _own_K(coefficients: Coefficients, run: Run) -> float:
    """What the file errs by on healthy runs, and the noise of this one's readings, together, K."""
    provenance = coefficients.document.provenance
    told = {} if provenance is None else provenance.fit
    squares = [
        _noise_K(read) ** 2 + max((value for key, value in told.get(part, {}).items() if key in _OWN), default=0.0) ** 2
        for part, read in run.temps.items()
    ]
    return float(np.sqrt(np.mean(squares)))


_OWN = ("left_out_rms_K", "rms_K")
"""Figures of the fit that say what the model errs by."""


def _noise_K(read: FloatArray) -> float:
    """Scatter of single readings about their neighbours, K."""
    steps = np.diff(read[np.isfinite(read)])
    scatter = _OF_A_DEVIATION * float(np.median(np.abs(steps))) / np.sqrt(2.0) if steps.size else 0.0
    return max(scatter, _LEAST_NOISE_K)
