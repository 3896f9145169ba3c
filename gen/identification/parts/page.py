"""The report of an identification: one HTML file without outside links."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from typing import Any

from jinja2 import Environment

from gen.coefficients import Coefficients
from gen.identification.choice.decision import Decision
from gen.identification.logs.data import Data
from gen.identification.parts import figures
from gen.identification.parts.identify import Identified
from gen.identification.parts.summary import own_miss, summary
from gen.pages.environment import page_environment
from gen.version import __version__

_OPTIONS = 8


def report_html(
    data: Data, found: Mapping[str, Identified], coefficients: Coefficients, choice: Decision | None = None
) -> str:
    """Write the report.

    Parameters
    ----------
    data, found
        The runs and what was identified from them.
    coefficients
        The coefficient file that was made of it.
    choice
        Why it is this kind of model, where that was not asked for.
    """
    whole = summary(data, found)
    return (
        _environment()
        .get_template("identification.html.j2")
        .render(
            version=__version__,
            coefficients=coefficients,
            whole=whole,
            choice=choice,
            parts=[_part(item, whole["components"][name]) for name, item in found.items()],
        )
    )


@cache
def _environment() -> Environment:
    # A minus sign, and not a hyphen, at which a line may end.
    return page_environment(
        g4=lambda value: f"{value:.4g}".replace("-", "\N{MINUS SIGN}"), k2=lambda value: f"{value:+.2f}"
    )


def _part(item: Identified, numbers: dict[str, Any]) -> dict[str, Any]:
    """What the template shows of one component."""
    charts = [("Measured (dots) and free run of the model (lines)", figures.fits(item))]
    charts.append(("Residual, means over a 200th of each run", figures.residuals(item)))
    if len(item.speeds) > 1:
        charts.append(("Steady rise over speed", figures.rises(item)))
        charts.append(("Time constants over speed", figures.times(item)))
    charts.append(("Pole map", figures.pole_map(item)))
    good = [option for option in item.general.options if not option.rejected]
    bad = [option for option in item.general.options if option.rejected]
    return {
        "name": item.name,
        "numbers": numbers,
        "speeds": item.speeds,
        "charts": charts,
        "labels": item.fit.layout.structure.labels,
        "options": [_option(option, item) for option in (good or item.general.options)[:_OPTIONS]],
        "rejected": [_option(option, item) for option in bad[:_OPTIONS]],
        "counts": (len(item.general.options), len(bad)),
        "chosen": item.general.chosen,
        "own_K": own_miss(item).error_K,
        "offset_sd": item.offset_sd,
    }


def _option(option: Any, item: Identified) -> dict[str, Any]:  # noqa: ANN401
    left = option.left_out
    return {
        "time": option.shape.time.words,
        "gain": option.shape.gain.words,
        "score": f"{option.score:.2f}",
        "own": f"{max(abs(option.own.steady_K)):.2f}",
        "left": [f"{value:.2f}" for value in left.rms_K] if left is not None else ["" for _ in item.speeds],
        "reason": option.rejected,
    }
