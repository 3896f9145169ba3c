"""The common form: a few motors are identified each alone, and the form is taken that suits all of them best."""

from __future__ import annotations

import json
from dataclasses import replace
from typing import Any

import numpy as np

from gen.arrays import FloatArray
from gen.errors import CheckFailed
from gen.fleet.folder.store import Kept, Store
from gen.fleet.tasks.common import Common, begun, structure_json, structure_of
from gen.fleet.tasks.motor_data import data_of, usable
from gen.fleet.tasks.work import Arrays, Failed, Progress, computed
from gen.identification.network.fitting.inputs import inputs_of
from gen.identification.network.fitting.scale import Scale, scale_of
from gen.identification.network.fitting.structure import Structure
from gen.identification.network.identify import identify_network
from gen.identification.network.left_out import folds_of, left_out
from gen.identification.network.search import tightened

AT_FIRST = 12
"""Linearisations of a scout's fit in another scout's form."""


def identified_alone(store: Store, *, runs: list[list[str]], ambient: float | None, most_hidden: int) -> Arrays:
    """Identify one motor alone, its form included (a task)."""
    data = data_of(usable(store, [Kept(*run) for run in runs]).sources, ambient)
    found = identify_network(data, lambda _: None, most_hidden)
    scale = scale_of(found.inputs)
    structure, vector = without_warmth(found.found.structure, found.found.vector)
    return {
        "structure": np.array(json.dumps(structure_json(structure))),
        "vector": vector,
        "settling": scale.settling,
        "rise": scale.rise,
        "density": found.found.density,
    }


def without_warmth(structure: Structure, vector: FloatArray) -> tuple[Structure, FloatArray]:
    """Give a form and its shared numbers, shape (p,), without what goes with temperature, which no fleet asks for."""
    shared = np.delete(vector[: structure.size], np.concatenate([structure.still, structure.growing]))
    return replace(structure, natural=0.0, warmth=None), shared


def suits(store: Store, *, runs: list[list[str]], ambient: float | None, common: dict[str, Any]) -> Arrays:
    """Fit a motor in another's form, and give its error on what is left out, K (a task)."""
    form = _begun(common)
    data = data_of(usable(store, [Kept(*run) for run in runs]).sources, ambient, form.structure.sensed)
    inputs = inputs_of(data.coarse)
    problem = form.problem(inputs)
    found = tightened(problem, problem.prior.mean.copy(), form.density, AT_FIRST, rounds=2)
    return {"left_out_K": np.array(left_out(found, folds_of(inputs)).score_K)}


def _begun(said: dict[str, Any]) -> Common:
    return begun(
        structure_of(said["structure"]),
        np.array(said["vector"]),
        Scale(np.array(said["settling"]), np.array(said["rise"])),
        np.array(said["density"]),
    )


def scouts_of(runs: dict[str, list[Kept]], most: int) -> list[str]:
    """Give the motors with the most runs, the first of those with as many; they are spread over the list."""
    longest = max(len(own) for own in runs.values())
    best = [motor for motor in sorted(runs) if len(runs[motor]) == longest]
    if len(best) < most:
        best = sorted(runs, key=lambda motor: (-len(runs[motor]), motor))[:most]
    places = np.unique(np.linspace(0, len(best) - 1, min(most, len(best))).round().astype(int))
    return [best[place] for place in places]


def common_form(
    store: Store,
    runs: dict[str, list[Kept]],
    scouts: list[str],
    ambient: float | None,
    most_hidden: int,
    client: Any,  # noqa: ANN401 - as `work` has it
    progress: Progress,
) -> tuple[Common, list[str]]:
    """Choose the form.

    Parameters
    ----------
    store, runs
        The fleet.
    scouts
        Motors to choose it on.
    ambient, most_hidden
        As of `gen identify`.
    client, progress
        As :func:`gen.fleet.tasks.work.computed` takes them.

    Returns
    -------
    common, lines
        With the first round's spread, and what was tried.

    Raises
    ------
    CheckFailed
        When no scout can be identified.
    """
    own = {motor: {"runs": as_lists(runs[motor]), "ambient": ambient, "most_hidden": most_hidden} for motor in scouts}
    alone = computed(store, identified_alone, own, client, progress)
    lines = [f"{motor}: {result.message}" for motor, result in alone.items() if isinstance(result, Failed)]
    forms = {motor: _plain(result) for motor, result in alone.items() if not isinstance(result, Failed)}
    if not forms:
        raise CheckFailed(f"no motor that was tried can be identified alone: {'; '.join(lines)}")
    pairs = {
        f"{motor} in the form of {of}": {"runs": as_lists(runs[motor]), "ambient": ambient, "common": forms[of]}
        for motor in forms
        for of in forms
    }
    errors = computed(store, suits, pairs, client, progress)
    scores = {}
    for of in forms:
        found = [errors[f"{motor} in the form of {of}"] for motor in forms]
        logs = [np.inf if isinstance(e, Failed) else float(np.log(e["left_out_K"])) for e in found]
        scores[of] = float(np.mean(logs))
        structure = structure_of(forms[of]["structure"])
        lines.append(
            f"form of {of}: {structure.nodes} nodes, {structure.hidden} of them hidden, {len(structure.paths)} paths; "
            f"{np.exp(scores[of]):.3f} K on what is left out of {len(forms)} motor(s)"
        )
    return _begun(forms[min(forms, key=lambda of: (scores[of], of))]), lines


def as_lists(runs: list[Kept]) -> list[list[str]]:
    """Give runs as a task's arguments have them."""
    return [[each.motor, each.day, each.name] for each in runs]


def _plain(result: Arrays) -> dict[str, Any]:
    made: dict[str, Any] = {name: values.tolist() for name, values in result.items() if name != "structure"}
    return {**made, "structure": json.loads(str(result["structure"]))}
