"""The study's tables computed again from its transfer functions (Table 4.3) and its two models."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from typing import NamedTuple

import control
import numpy as np
import pandas as pd
from numpy.typing import NDArray

from examples.my1016.study.tables import STEADY_S, TRANSIENT_S, Study, counts
from gen.model import ThermalModel

ROUNDED_K = 1.1
"""Tables 4.6 and 4.8 are printed in whole degrees, of values that were read off rounded ones."""
EXACT_K = 0.2


class Entry(NamedTuple):
    """One printed number beside the computed one, in the table's own unit."""

    table: str
    component: str
    what: str
    printed: float
    computed: float
    tolerance: float = math.inf
    """Largest difference that printing explains."""

    @property
    def difference(self) -> float:
        """Computed minus printed."""
        return self.computed - self.printed

    @property
    def agrees(self) -> bool:
        """Whether printing explains the difference."""
        return abs(self.difference) <= self.tolerance


class PoleStatistics(NamedTuple):
    """Poles of one component over speed, in rad/s."""

    mean: NDArray[np.complex128]
    """Shape (order,)."""
    variance: NDArray[np.float64]
    """Sample variance of the complex values, E|p - mean|^2 with n - 1, shape (order,)."""
    cv: NDArray[np.float64]
    """sqrt(variance) / |Re mean|, shape (order,). That is how the study's 0.74 of the brush comes about: the scatter of
    the imaginary part counts, its mean does not."""


def pole_statistics(study: Study, component: str) -> PoleStatistics:
    """Compute Table 4.4 for one component."""
    poles = np.stack([g.poles for g in study.kept(component)])
    mean = poles.mean(axis=0)
    variance = np.sum(np.abs(poles - mean) ** 2, axis=0) / (len(poles) - 1)
    return PoleStatistics(mean, variance, np.sqrt(variance) / np.abs(mean.real))


def rises(study: Study, system: Callable[[str, int], control.TransferFunction]) -> pd.DataFrame:
    """Give the rises in K at both times of the five steps from cold.

    Parameters
    ----------
    study
        Its components and speeds.
    system
        Gives the transfer function of a component at a PWM: ``model.transfer_function`` of a model, or
        ``study.identified``, which stands in for the measurement, as that is not published.

    Returns
    -------
    DataFrame
        A row a speed in percent, columns (component, time in s).
    """
    time = np.arange(0, STEADY_S + 1, TRANSIENT_S)
    columns = {}
    for name in study.components:
        pwm = [counts(percent) for percent in study.speeds]
        curves = np.stack([p * control.step_response(system(name, p), time).outputs for p in pwm])
        columns[name, TRANSIENT_S], columns[name, STEADY_S] = curves[:, 1], curves[:, -1]
    return pd.DataFrame(columns, index=list(study.speeds))


def reproduce(study: Study, averaged: ThermalModel, variable: ThermalModel) -> list[Entry]:
    """Compute every table again; give all entries in the order of the tables."""
    identified = rises(study, study.identified)
    averaged_error = rises(study, averaged.transfer_function) - identified
    variable_error = rises(study, variable.transfer_function) - identified
    return [
        *_poles(study),
        *_averaged(study),
        *_errors("4.6", averaged_error, study.averaged_minus_measured, STEADY_S, ROUNDED_K),
        *_errors("4.8", averaged_error, study.averaged_minus_measured, TRANSIENT_S, ROUNDED_K),
        *_errors("4.11", variable_error, study.variable_minus_measured, STEADY_S, EXACT_K),
        *_errors("4.13", variable_error, study.variable_minus_measured, TRANSIENT_S, EXACT_K),
        # Read at the end of the runs; nothing is promised of the ends of the identified curves.
        *_errors("4.1", study.ambient + identified, {STEADY_S: study.measured_steady_degC}, STEADY_S, math.inf),
    ]


def _poles(study: Study) -> Iterator[Entry]:
    for name in study.components:
        found, printed = pole_statistics(study, name), study.poles[name]
        for i, (real, imag) in enumerate(printed.mean):
            label = f"pole {i + 1}" if len(printed.mean) > 1 else "pole"
            yield Entry("4.4", name, f"{label} mean", real, found.mean[i].real, 0.02 * abs(real))
            if imag:
                yield Entry("4.4", name, f"{label} mean, imaginary", imag, found.mean[i].imag, 0.02 * abs(imag))
            if printed.variance is not None:
                variance = printed.variance[i]
                yield Entry("4.4", name, f"{label} variance", variance, found.variance[i], 0.01 * variance)
            yield Entry("4.4", name, f"{label} CV", printed.cv[i], found.cv[i], 0.02)


def _averaged(study: Study) -> Iterator[Entry]:
    for name in study.components:
        printed = study.averaged_pole[name]
        gain = float(np.mean([g.numerator for g in study.kept(name)]))
        yield Entry("4.5", name, "numerator", printed.numerator, gain, 0.01 * printed.numerator)
        computed = np.real(np.poly(pole_statistics(study, name).mean))
        order = len(computed) - 1
        for k in range(1, order + 1):
            p = printed.denominator[k]
            yield Entry("4.5", name, f"denominator s^{order - k}", p, float(computed[k]), 0.02 * abs(p))


def _errors(
    table: str, computed: pd.DataFrame, printed: dict[int, dict[str, tuple[float, ...]]], time: int, tolerance: float
) -> Iterator[Entry]:
    for name in computed.columns.unique(0):
        for speed, found, value in zip(computed.index, computed[name][time], printed[time][name], strict=True):
            yield Entry(table, name, f"{speed} %, {time} s", value, found, tolerance)
