"""The logs that are in the repository: identify on some runs, predict one that took no part, free-running.

Run:  python -m benchmarks.real_machines.shipped

``python -m docs.figures`` draws the curves.
"""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np
from numpy.typing import NDArray

import gen
from gen.identification.logs.data import read_data
from gen.identification.parts.coefficient_file import coefficient_text, usable
from gen.identification.parts.identify import identify
from gen.identification.settings import Settings
from gen.reference.simulate import simulate_run
from gen.runs import read_run

RUNS = Path(__file__).parents[2] / "examples" / "measured"
CASES = {
    "Temperature Control Lab, heater 1": (
        ("tclab/apm_2nd_mimo_heater1.csv", "tclab/apm_energy_mimo_heater1.csv"),
        "tclab/apm_hybrid_mimo_heater1.csv",
    ),
    "Temperature Control Lab, heater 2": (
        ("tclab/apm_2nd_mimo_heater2.csv", "tclab/apm_energy_mimo_heater2.csv"),
        "tclab/apm_hybrid_mimo_heater2.csv",
    ),
    "brushless motor at stall": (("bldc/run2.csv", "bldc/run3.csv", "bldc/run13.csv"), "bldc/run14.csv"),
}


@dataclass(frozen=True, eq=False)
class Prediction:
    """A component of the run that was not used.

    Attributes
    ----------
    case, component, order
        What was predicted, and the identified order.
    time, measured, model
        Shape (N,), s and degC.
    """

    case: str
    component: str
    order: str
    time: NDArray[np.float64]
    measured: NDArray[np.float64]
    model: NDArray[np.float64]

    @property
    def rms_K(self) -> float:
        """Root mean square error, K."""
        return float(np.sqrt(np.nanmean((self.model - self.measured) ** 2)))

    @property
    def largest_K(self) -> float:
        """Largest error, K."""
        return float(np.nanmax(np.abs(self.model - self.measured)))

    @property
    def moved_K(self) -> float:
        """How far the temperature moved in the run, K."""
        return float(np.nanmax(self.measured) - np.nanmin(self.measured))


def predict(case: str) -> tuple[list[Prediction], list[str]]:
    """Identify on a case's runs and predict its test run; also give what was left out."""
    fit, test = CASES[case]
    settings = Settings("machine")
    data = read_data([RUNS / path for path in fit], None)
    data, found = usable(data, identify(data, lambda _: None), settings)
    _, loaded = coefficient_text(data, found, settings)
    run = read_run(RUNS / test, loaded.model.component_names)
    columns = simulate_run(loaded, run, "exact", "auto", test)
    result = [
        Prediction(
            case,
            name,
            item.fit.layout.structure.name,
            run.time_s,
            run.temps[name],
            np.asarray(columns[f"{name}_degC"], dtype=np.float64),
        )
        for name, item in found.items()
    ]
    return result, [warning for warning in data.warnings if "left out" in warning]


def predict_network(case: str) -> list[Prediction]:
    """The same with one network for all of the machine's parts; its order says how many nodes it has."""
    fit, test = CASES[case]
    found = gen.identify([RUNS / path for path in fit], model="network", name="machine")
    names = found.model.components
    run = read_run(RUNS / test, names)
    shown = gen.simulate(found.model, RUNS / test)
    nodes = f"{len(found.details()['nodes'])} nodes"
    return [
        Prediction(case, name, nodes, run.time_s, run.temps[name], shown[f"{name}_degC"].to_numpy(dtype=np.float64))
        for name in names
        if name in run.temps
    ]


def main() -> None:
    """Print the table."""
    print("case                               component  order  moved (K)  rms error (K)  largest (K)")
    for case in CASES:
        found, left_out = predict(case)
        for p in found:
            print(f"{case:<34} {p.component:<10} {p.order:<6} {p.moved_K:9.1f} {p.rms_K:14.2f} {p.largest_K:12.2f}")
        for warning in left_out:
            print(f"{'':<34} {warning}")
        for p in predict_network(case):
            name = "  as a network"
            print(f"{name:<34} {p.component:<10} {p.order:<6} {p.moved_K:8.1f} {p.rms_K:14.2f} {p.largest_K:12.2f}")


if __name__ == "__main__":
    main()
