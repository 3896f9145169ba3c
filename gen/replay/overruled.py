"""Where a run's own ambient is not what the model counts from."""

from __future__ import annotations

import numpy as np

from gen.coefficients import Coefficients
from gen.replay.inputs import inputs_of
from gen.runs import Run, with_noted_ambient

_FAR_K = 1.0
"""A room that differs by more moves every modelled temperature by more than sensors of this kind are off."""


def overruled_ambient(coefficients: Coefficients, run: Run, file: str) -> str | None:
    """Say that a run's ambient, measured or noted in a comment, differs from the fixed one that the model counts from.

    Parameters
    ----------
    coefficients
        The model with its effects, of which one may bring the ambient.
    run
        Read with :func:`gen.replay.read_for`.
    file
        The run file's name for messages.

    Returns
    -------
    str or None
        What to warn of; None where they are within 1 K in the mean, or the model counts from the run's own.

    Raises
    ------
    InputError
        When what a comment notes is no temperature.
    """
    fixed = coefficients.model.ambient_fixed
    own = with_noted_ambient(run, file).ambient
    if fixed is None or own is None or np.all(np.isnan(own)):
        return None
    if any(applied.effect.replaces_ambient for applied in coefficients.effects):
        return None
    counted, mean = float(np.mean(inputs_of(coefficients, run, file).ambient)), float(np.nanmean(own))
    if abs(counted - mean) <= _FAR_K:
        return None
    return (
        f"{file}: its ambient is {mean:.1f} degC in the mean, and the model counts from the {fixed:g} degC that "
        f"$.ambient.fixed_degC says"
    )
