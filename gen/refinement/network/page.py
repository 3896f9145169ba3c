"""The story of a network's refinement as one HTML page."""

from __future__ import annotations

from typing import Any

import numpy as np
from markupsafe import Markup

from gen.coefficients import Coefficients
from gen.model.network import Network
from gen.pages.environment import page_environment
from gen.pages.network_drawing import DrawnNode, DrawnPath, network_svg
from gen.pages.panels import panels_svg
from gen.refinement.network.over_time.heat_charts import heat_story
from gen.refinement.network.refine import NetworkRefinement
from gen.refinement.network.tracing.search import Step
from gen.refinement.run_charts import run_pictures
from gen.refinement.run_tables import error_rows, short_names, totals
from gen.refinement.worse import TOLD

_SENTENCES = {
    "explained": "With what is below, what is left on what was left out is near the sensors' noise.",
    "partly explained": "What is below lowers the error on what was left out, but something is left, or the "
    "motor is no longer the one that the file was made from: the names are the nearest, not certain.",
    "nothing missing": "The error is near the sensors' noise; no effect is added.",
    "unexplained": "Something is missing, and no effect of the library explains it on what was left out.",
}
_NOT_WRITTEN = (
    "What is below names what is missing as nearly as the runs tell it. "
    "Nothing of it is in the file: the warnings say why."
)
_IN_IT = "What is below was then found in it."
_ALONE = {
    "explained": "What is left on what was left out is near the sensors' noise, with no effect in it.",
    "partly explained": "Something is left that no effect of the library explains in it.",
    "unexplained": "It does not hold for the test runs.",
    "nothing missing": "",
}
_MOVED = 0.2
"""A conductance that changes by more than this share is drawn as changed."""


def network_refinement_page(found: NetworkRefinement, baseline: Coefficients, refined: Coefficients) -> str:
    """Render the report.

    Parameters
    ----------
    found
        What was found.
    baseline, refined
        The file that it began with, and the one that it led to.
    """
    short = short_names([*found.before.fit, *found.before.test])
    pictures, not_drawn = run_pictures(found, short)
    environment = page_environment(panels=panels_svg)
    return environment.get_template("network_refinement.html.j2").render(
        name=baseline.name,
        input_meaning=baseline.document.input.meaning,
        verdict=found.verdict,
        sentence=_sentence(found) + (TOLD if found.tests_worse else ""),
        judged_on=found.judged_on,
        warnings=found.warnings,
        pictures=pictures,
        not_drawn=not_drawn,
        changed=found.after is not found.before,
        heat=None if found.missing is None else heat_story(found.missing, found.before, short),
        drawings=_drawings(found, baseline, refined),
        steps=_steps(found),
        effects=[_effect(effect) for effect in found.effects],
        totals=totals(found.before, found.after),
        errors=error_rows(found.before, found.after, short),
    )


def _sentence(found: NetworkRefinement) -> str:
    """The verdict in words: that something is named is no promise that the file holds it."""
    written = found.after is not found.before
    if found.lead:
        return f"{found.lead[0].upper()}{found.lead[1:]}. {_IN_IT if found.effects else _ALONE[found.verdict]}"
    return _SENTENCES[found.verdict] if written or not found.effects else _NOT_WRITTEN


def _steps(found: NetworkRefinement) -> list[dict[str, Any]]:
    made = []
    for step in found.traced.steps:
        if step.considered:
            # What was there then: it may have been dropped since.
            beside = [f"{effect.name} ({effect.component})" for effect in step.without.fitted.shape.effects]
            without = f"{step.without.score_K:.2f}"
            made.append({"beside": " and ".join(beside) or "nothing", "without": without, "rows": _rows(step)})
    return made


def _rows(step: Step) -> list[tuple[str, str, str, str]]:
    return [
        (
            f"{one.effect.name}, {one.effect.component}",
            f"{one.judged.score_K:.2f}",
            "<1e-9" if one.p_value < 1e-9 else f"{one.p_value:.1g}",
            "; ".join(one.reasons),
        )
        for one in step.considered
    ]


def _effect(effect: dict[str, Any]) -> dict[str, Any]:
    evidence = effect["evidence"]
    rows = []
    for key, value in effect["parameters"].items():
        ends = evidence["intervals_95"].get(key)
        shown = f"{value:.4g}" if isinstance(value, float) else str(value)
        rows.append([key, shown, f"{ends[0]:.4g} .. {ends[1]:.4g}" if ends else ""])
    return {
        "name": effect["name"],
        "component": effect["component"],
        "near": " and ".join(effect.get("near", ())),
        "title": effect["title"],
        "rows": rows,
        "note": evidence.get("note", ""),
        "lookalikes": evidence["lookalikes"],
    }


def _drawings(found: NetworkRefinement, baseline: Coefficients, refined: Coefficients) -> list[Markup]:
    """The network before and after; once where the file is as it was."""
    old, new = baseline.model.network, refined.model.network
    assert old is not None
    assert new is not None
    if refined.document.network == baseline.document.network:
        return [network_svg("network", "The network", *_drawn(old, old, set()))]
    named = {effect["component"] for effect in found.effects}
    before, after = _drawn(old, old, set()), _drawn(new, old, named)
    # Pictures of the same nodes are compared, so they stand in the same places.
    arrangement = after[1] if [node.name for node in old.nodes] == [node.name for node in new.nodes] else None
    return [
        network_svg("network-before", "The network before", *before, arrangement),
        network_svg("network-after", "The network as refined", *after, arrangement),
    ]


def _drawn(network: Network, before: Network, named: set[str]) -> tuple[list[DrawnNode], list[DrawnPath]]:
    known = {node.name for node in before.nodes}
    heat = {node.name: 0.0 for node in network.nodes}
    for number, source in enumerate(network.heats):
        if not source.factors:
            heat[source.node] += float(network.powers[255, number])
    nodes = [
        DrawnNode(
            node.name, node.sensor is not None, heat[node.name], added=node.name not in known or node.name in named
        )
        for node in network.nodes
    ]
    was = {frozenset((path.first, path.second)): k for k, path in enumerate(before.paths)}
    paths = []
    for number, path in enumerate(network.paths):
        conductance = float(network.conductances[255, number])
        other = was.get(frozenset((path.first, path.second)))
        changed = other is None or _moved(network, number, before, other)
        if conductance > 0.0:
            second = None if path.second is None else network.index(path.second)
            paths.append(DrawnPath(network.index(path.first), second, conductance, added=changed))
    return nodes, paths


def _moved(network: Network, number: int, before: Network, other: int) -> bool:
    """Whether a path conducts otherwise than before at some speed, or by another channel."""
    ratio = network.conductances[:, number] / np.maximum(before.conductances[:, other], 1e-12)
    more = len(network.paths[number].factors) != len(before.paths[other].factors)
    return more or bool(np.max(np.abs(np.log(np.maximum(ratio, 1e-6)))) > _MOVED)
