"""A fleet's models: a common form, what its numbers are and how far motors differ, and each motor within that.

Rounds: each motor is fitted in the common form with the fleet's present mean and spread as its prior; what its runs
alone say there, without the prior, is pooled to a new mean and spread (`pooling`). So the equations are linearised
where each motor is believed to be (Lindstrom and Bates, Biometrics 46, 1990).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from gen.errors import CheckFailed, InputError
from gen.fleet.chosen import evenly
from gen.fleet.folder.models import COMMON, model_path, remove_identified, with_model, write_identified
from gen.fleet.folder.store import Kept, Store
from gen.fleet.statistics.pooling import Told, pooled
from gen.fleet.tasks.common import Common, keep, kept
from gen.fleet.tasks.fitting import fitted_in_common, mean_model, model_in_common
from gen.fleet.tasks.motor_data import check_inputs, data_of, usable
from gen.fleet.tasks.scouting import as_lists, common_form, scouts_of
from gen.fleet.tasks.work import Arrays, Failed, Progress, Workers, computed, workers_of

ROUNDS = 2
MOST_POOLED = 36
"""Motors that make the fleet's mean and spread, evenly taken by name: their mean is within a sixth of the spread.

What runs say is linearised, and where they say next to nothing the mistake of that is alike in all motors: it grows
with their number as what they say does, and a hundred motors may outvote what is known of the mean before any run."""
WORSE = 1.3
"""Factor on the median error of fits by which a round's mean and spread may be worse than the best before it."""
MOST_RUNS = 40
"""Of one motor, the newest: what older ones say is in the fleet's mean already."""
SHOWN_RUNS = 2
"""Of each scout, for the errors that the mean's file declares."""


@dataclass(frozen=True)
class Options:
    """What the user sets.

    Attributes
    ----------
    ambient
        In degC, for runs without a measured one, or None.
    max_hidden
        Most hidden nodes.
    scouts
        Motors on which the form is chosen.
    until
        The last day whose runs take part, or None.
    only_new
        Whether the fleet's mean and spread stay, and only motors without a model get one.
    """

    ambient: float | None = None
    max_hidden: int = 3
    scouts: int = 3
    until: str | None = None
    only_new: bool = False


@dataclass(frozen=True)
class Identified:
    """What came out.

    Attributes
    ----------
    left_out_K
        By motor, root mean square error on what was left out of its fit, K.
    refused
        By motor, why there is no model.
    lines
        What else there is to say.
    """

    left_out_K: dict[str, float]
    refused: dict[str, str]
    lines: tuple[str, ...]


def identify_fleet(store: Store, options: Options, workers: Workers, progress: Progress) -> Identified:
    """Identify all motors of a store and write their coefficient files into it.

    Raises
    ------
    InputError
        When the store has no runs, or runs that were driven by different inputs.
    CheckFailed
        When none of the scouts can be identified, or no motor can be fitted in the common form.
    """
    runs = runs_of(store, options.until)
    progress("inputs")
    check_inputs(store, runs)
    lines: list[str] = []
    with workers_of(store, workers) as client:
        if options.only_new:
            common = kept(store)
            there = with_model(store, runs)
            runs = {motor: own for motor, own in runs.items() if motor not in there}
        else:
            scouts = scouts_of(runs, options.scouts)
            common, lines = common_form(store, runs, scouts, options.ambient, options.max_hidden, client, progress)
            some = {motor: runs[motor] for motor in evenly(sorted(runs), MOST_POOLED)}
            common = in_rounds(partial(_fits, store, some, options, client, progress), common)
            progress("common model")
            sources = [s for motor in scouts for s in usable(store, runs[motor]).sources[-SHOWN_RUNS:]]
            text = mean_model(common, data_of(sources, options.ambient, common.structure.sensed))
            write_identified(store, COMMON, text)
            keep(store, common)
        said = common.as_json()
        tasks = {
            motor: {"motor": motor, "runs": as_lists(own), "ambient": options.ambient, "common": said}
            for motor, own in runs.items()
        }
        models = computed(store, model_in_common, tasks, client, progress)
    return _written(store, models, lines)


def runs_of(store: Store, until: str | None = None) -> dict[str, list[Kept]]:
    """Give each motor's newest runs up to a day.

    Raises
    ------
    InputError
        When there are none.
    """
    found = {motor: store.runs(motor) for motor in store.motors()}
    chosen = {motor: [run for run in own if until is None or run.day <= until] for motor, own in found.items()}
    chosen = {motor: own[-MOST_RUNS:] for motor, own in chosen.items() if own}
    if not chosen:
        when = "" if until is None else f" up to {until}"
        raise InputError(f"there are no runs{when}; expected a store that gen fleet add has filled", file=store.url)
    return chosen


def in_rounds(fits_of: Callable[[Common], list[Arrays]], common: Common) -> Common:
    """Fit and pool by turns; where motors are fitted worse for it, stay before it: what was linearised led astray.

    Parameters
    ----------
    fits_of
        What :func:`~gen.fleet.tasks.fitting.fitted_in_common` gives of each motor, the fleet's mean and spread its
        prior.
    common
        Mean and spread to begin with.
    """
    best, least = common, np.inf
    for number in range(ROUNDS + 1):
        fits = fits_of(common)
        off = float(np.median([fit["off_K"] for fit in fits]))
        if off > WORSE * least:
            break
        best, least = common, min(off, least)
        if number < ROUNDS:
            told = Told(np.array([fit["matrix"] for fit in fits]), np.array([fit["vector"] for fit in fits]))
            common = replace(common, pool=pooled(told, common.pool, common.fixed))
    return best


def _fits(
    store: Store,
    runs: dict[str, list[Kept]],
    options: Options,
    client: Any,  # noqa: ANN401 - distributed is imported where it is needed
    progress: Progress,
    common: Common,
) -> list[Arrays]:
    """Fit each motor with the fleet's present mean and spread as its prior."""
    said = common.as_json()
    tasks = {motor: {"runs": as_lists(own), "ambient": options.ambient, "common": said} for motor, own in runs.items()}
    fits = list(computed(store, fitted_in_common, tasks, client, progress).values())
    good = [fit for fit in fits if not isinstance(fit, Failed)]
    if not good:
        reasons = sorted({fit.message for fit in fits if isinstance(fit, Failed)})
        raise CheckFailed(f"no motor can be fitted in the common form: {'; '.join(reasons[:3])}")
    progress("pooling")
    return good


def _written(store: Store, models: dict[str, Arrays | Failed], lines: list[str]) -> Identified:
    errors, refused = {}, {}
    for motor, model in models.items():
        if isinstance(model, Failed):
            # What is there is of another common form, and nothing would tell it from those that are of this one.
            remove_identified(store, model_path(motor))
            refused[motor] = model.message
            continue
        write_identified(store, model_path(motor), str(model["text"]))
        errors[motor] = float(np.sqrt(np.nanmean(model["left_out_K"] ** 2)))
        lines += [f"{motor}: {line}" for line in model["lines"].tolist()]
    return Identified(errors, refused, tuple(lines))
