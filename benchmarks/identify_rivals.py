"""Other identifiers on the same runs: error of a free run on fresh profiles, side by side.

Run:  python -m benchmarks.identify_rivals [COUNT]

SysIdentPy takes part where it is installed (`pip install sysidentpy`, best in an environment of its own).
All rivals get block means of 20 s, a grid on which the poles are easy to tell from 1, the ambient taken off, and the
runs after each other. They predict what the sensor reads, so what it reads (without noise) is what all are judged by.
"""

from __future__ import annotations

import os
import sys
import warnings
from collections.abc import Callable

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares
from scipy.signal import lfilter

from benchmarks.scheduled_plants import AMBIENT, Plant, fresh_profile, random_plant, simulate, step_runs
from gen.identification.logs.data import make_data
from gen.identification.logs.sources import Source
from gen.identification.parts.coefficient_file import coefficient_text
from gen.identification.parts.identify import identify
from gen.identification.settings import Settings
from gen.model import ExactSolution
from gen.runs import Run

FloatArray = NDArray[np.float64]
STEP = 20
Predictor = Callable[[NDArray[np.int64]], FloatArray]


def blocks(values: FloatArray) -> FloatArray:
    """Means over the step."""
    count = len(values) // STEP
    return np.asarray(values[: count * STEP].reshape(count, STEP).mean(axis=1))


def pairs(runs: list[Run]) -> list[tuple[FloatArray, FloatArray]]:
    """Input |PWM| / 255 and rise of each run on the coarse grid."""
    return [(blocks(np.abs(run.pwm) / 255.0), blocks(run.temps["part"]) - AMBIENT) for run in runs]


def gen_identify(runs: list[Run]) -> Predictor:
    """This project; what it found of the sensor's offset is added, as the rivals' models hold it too."""
    data = make_data([Source(f"run{i}.csv", run) for i, run in enumerate(runs)], None)
    found = identify(data, lambda _: None)
    _, loaded = coefficient_text(data, found, Settings("plant"))
    solution, offset = ExactSolution(loaded.model), found["part"].fit.offset

    def predict(pwm: NDArray[np.int64]) -> FloatArray:
        return blocks(solution.simulate_times(np.arange(len(pwm), dtype=np.float64), pwm)["part"] + offset)

    return predict


def arx(order: int) -> Callable[[list[Run]], Predictor]:
    """ARX by least squares of the one-step error, with a constant."""

    def fit(runs: list[Run]) -> Predictor:
        rows, target = [], []
        for u, y in pairs(runs):
            columns = [y[order - k : len(y) - k] for k in range(1, order + 1)]
            columns += [u[order - k : len(u) - k] for k in range(1, order + 1)]
            rows.append(np.column_stack([*columns, np.ones(len(y) - order)]))
            target.append(y[order:])
        solved = np.linalg.lstsq(np.vstack(rows), np.concatenate(target), rcond=None)[0]
        a, b, c = solved[:order], solved[order : 2 * order], solved[-1]

        def predict(pwm: NDArray[np.int64]) -> FloatArray:
            u = blocks(np.abs(pwm) / 255.0)
            drive = np.convolve(u, np.append(0.0, b))[: len(u)] + c
            return np.asarray(lfilter([1.0], np.append(1.0, -a), drive), dtype=np.float64)

        return predict

    return fit


def output_error(runs: list[Run]) -> Predictor:
    """One linear system of order 2 by simulation error (scipy), with an offset."""
    data = pairs(runs)

    def response(p: FloatArray, u: FloatArray) -> FloatArray:
        one, two = np.exp(-STEP / np.exp(p[:2]))
        first = lfilter([0.0, 1.0 - one], [1.0, -one], u)
        second = lfilter([0.0, 1.0 - two], [1.0, -two], u)
        return np.asarray(p[2] * first + p[3] * second + p[4], dtype=np.float64)

    start = np.array([7.5, 5.5, 30.0, 5.0, 0.0])

    def residual(p: FloatArray) -> FloatArray:
        return np.concatenate([response(p, u) - y for u, y in data])

    found = least_squares(residual, start, x_scale="jac")
    return lambda pwm: response(found.x, blocks(np.abs(pwm) / 255.0))


def sysidentpy(runs: list[Run]) -> Predictor:
    """Polynomial NARMAX of degree 2 by FROLS (SysIdentPy), structure by its own BIC."""
    from sysidentpy.basis_function import Polynomial
    from sysidentpy.model_structure_selection import FROLS
    from sysidentpy.parameter_estimation import LeastSquares

    data = pairs(runs)
    u, y = np.concatenate([d[0] for d in data]), np.concatenate([d[1] for d in data])
    model = FROLS(
        order_selection=True,
        n_info_values=12,
        info_criteria="bic",
        ylag=2,
        xlag=2,
        estimator=LeastSquares(),
        basis_function=Polynomial(degree=2),
    )
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        model.fit(X=u[:, None], y=y[:, None])
    begin = float(np.mean([d[1][0] for d in data]))

    def predict(pwm: NDArray[np.int64]) -> FloatArray:
        drive = blocks(np.abs(pwm) / 255.0)
        initial = np.full((len(drive), 1), begin)
        with warnings.catch_warnings(), np.errstate(all="ignore"):
            warnings.simplefilter("ignore")
            return np.asarray(model.predict(X=drive[:, None], y=initial), dtype=np.float64).ravel()

    return predict


RIVALS: dict[str, Callable[[list[Run]], Predictor]] = {
    "gen identify": gen_identify,
    "ARX order 1": arx(1),
    "ARX order 2": arx(2),
    "output error, one linear system of order 2": output_error,
    "SysIdentPy, NARMAX degree 2": sysidentpy,
}


def compare(
    plant: Plant, rng: np.random.Generator, who: dict[str, Callable[[list[Run]], Predictor]]
) -> dict[str, float]:
    """Give the root mean square error on a fresh profile at the identified speeds, by rival, K."""
    runs = step_runs(plant, rng)
    pwm = fresh_profile(rng, known=True)
    true = blocks(simulate(plant, pwm)) - AMBIENT + plant.bias
    errors = {}
    for name, fit in who.items():
        with np.errstate(all="ignore"):
            errors[name] = float(np.sqrt(np.mean((fit(runs)(pwm) - true) ** 2)))
    return errors


def main() -> None:
    """Print the table for 30 plants, or as many as asked for."""
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 30
    who = dict(RIVALS)
    try:
        import sysidentpy as _  # noqa: F401
    except ImportError:
        del who["SysIdentPy, NARMAX degree 2"]
        print("SysIdentPy is not installed: left out")
    found: dict[str, list[float]] = {name: [] for name in who}
    for seed in range(count):
        rng = np.random.default_rng([20262, seed])
        for name, error in compare(random_plant(rng), rng, who).items():
            found[name].append(error)
    print(f"Free run on fresh profiles at the identified speeds, {count} plants: root mean square error in K")
    print(f"{'':<44} median  95th percentile  diverged")
    for name, errors in found.items():
        finite = np.array([e for e in errors if np.isfinite(e) and e < 1e3])
        if finite.size:
            median, high = np.percentile(finite, [50, 95])
            print(f"{name:<44} {median:6.2f} {high:16.2f} {len(errors) - len(finite):9d}")
        else:
            print(f"{name:<44} {'-':>6} {'-':>16} {len(errors):9d}")


if __name__ == "__main__":
    main()
