"""Pictures of whole runs: measured temperature with the model before and after, and the PWM that drove it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from gen.pages.panels import Course, Panel, Panels
from gen.refinement.errors import Errors
from gen.refinement.run_errors import total
from gen.refinement.thinning import Samples

OPEN_CHARTS = 8
"""Charts that are shown at once; the other runs are folded. The first run is shown however many it has."""
MOST_CHARTS = 120
"""Charts on the page. Runs beyond stand in the table of errors only."""
MOST_POINTS, FEWEST_POINTS = 300, 100
ALL_POINTS = 12_000
"""Dots on the page, about: many charts have fewer each."""
LONG_S = 5400.0
"""Runs longer than this are drawn over hours, others over minutes."""


class BeforeAndAfter(Protocol):
    """What was refined."""

    @property
    def before(self) -> Errors:
        """Errors of the model before."""

    @property
    def after(self) -> Errors:
        """And after."""


@dataclass(frozen=True)
class RunPictures:
    """One run's charts, one for each component.

    Attributes
    ----------
    title
        Kind of the run, its name, length and errors.
    charts
        What is drawn.
    shown
        Whether it is open when the page is.
    """

    title: str
    charts: tuple[Panels, ...]
    shown: bool


def run_pictures(found: BeforeAndAfter, short: dict[str, str]) -> tuple[list[RunPictures], int]:
    """Pictures of the test runs, then of the fit runs.

    Parameters
    ----------
    found
        What `gen refine` found.
    short
        Names of the runs as the page has them.

    Returns
    -------
    pictures, left_out
        And how many runs are not drawn.
    """
    names = [*found.before.test, *found.before.fit]
    sizes = np.cumsum([len(found.before.curves[name].measured) for name in names])
    drawn = [name for at, name in enumerate(names) if at == 0 or sizes[at] <= MOST_CHARTS]
    points = int(np.clip(ALL_POINTS // max(int(sizes[-1]), 1), FEWEST_POINTS, MOST_POINTS))
    pictures = [
        RunPictures(
            title=_title(found, name, short[name]),
            charts=tuple(
                _chart(found, name, component, f"run-{at}-{component}", points)
                for component in found.before.curves[name].measured
            ),
            shown=at == 0 or bool(sizes[at] <= OPEN_CHARTS),
        )
        for at, name in enumerate(drawn)
    ]
    return pictures, len(names) - len(drawn)


def _title(found: BeforeAndAfter, name: str, short: str) -> str:
    kind = "test" if name in found.before.test else "fit"
    unit, seconds = _unit(found.before.curves[name].span_s)
    before, after = (_rmse_K(errors, name) for errors in (found.before, found.after))
    change = f"{before:.2f} K" if found.after is found.before else f"{before:.2f} → {after:.2f} K"
    return f"{short}: {kind} run of {found.before.curves[name].span_s / seconds:.3g} {unit}, RMSE {change}"


def _rmse_K(errors: Errors, name: str) -> float:
    return total({**errors.fit, **errors.test}[name].values()).rmse_K


def _unit(span_s: float) -> tuple[str, float]:
    return ("h", 3600.0) if span_s > LONG_S else ("min", 60.0)


def _chart(found: BeforeAndAfter, name: str, component: str, identifier: str, points: int) -> Panels:
    old, new = found.before.curves[name], found.after.curves[name]
    unit, seconds = _unit(old.span_s)

    def course(role: str, samples: Samples, most: int, shape: str = "line") -> Course:
        thin = samples.thinned(most)
        return Course(role, ((thin.time_s - old.start_s) / seconds).tolist(), thin.values.tolist(), shape)

    temperatures = [course("measured", old.measured[component], points, "dots")]
    if not _same(old.model[component], new.model[component]):
        temperatures.append(course("before", old.model[component], points // 2))
    temperatures.append(course("after", new.model[component], points // 2))
    ends = old.measured[component].values.min(), old.measured[component].values.max()
    return Panels(
        identifier=identifier,
        title=component,
        description=f"Temperature of {component}, measured from {ends[0]:.1f} to {ends[1]:.1f} °C, and the model "
        f"before and after; below, PWM from {old.pwm.values.min():g} to {old.pwm.values.max():g}.",
        x_label=f"time ({unit})",
        panels=(
            Panel("°C", tuple(temperatures), 130.0),
            Panel("PWM", (course("drive", old.pwm, points // 2, "steps"),), 48.0, from_zero=True),
        ),
    )


def _same(one: Samples, other: Samples) -> bool:
    return np.array_equal(one.time_s, other.time_s) and np.array_equal(one.values, other.values)
