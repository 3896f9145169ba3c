"""Errors of one model on fit and test runs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from gen.refinement.run_errors import Curve, Score, total


@dataclass
class Errors:
    """Errors of one model: by run and component, fit and test apart."""

    fit: dict[str, dict[str, Score]] = field(default_factory=dict)
    test: dict[str, dict[str, Score]] = field(default_factory=dict)
    curves: dict[str, Curve] = field(default_factory=dict)

    def summary(self) -> dict[str, Any]:
        """As the JSON summary has it."""
        made: dict[str, Any] = {}
        for key in ("fit", "test"):
            made[key] = total(s for run in getattr(self, key).values() for s in run.values()).summary()
        made["per_run"] = {
            run: {name: s.summary() for name, s in scores.items()} for run, scores in {**self.fit, **self.test}.items()
        }
        return made


FAR, FAR_K = 3.0, 2.0
"""Test runs are missed by far with an error of so many times that of the fit runs, and of so many kelvin."""


def missed(errors: Errors) -> list[str]:
    """A sentence where the test runs are missed by far more than the fit runs, of which the verdict is."""
    fit, test = (
        total(score for run in of.values() for score in run.values()).rmse_K for of in (errors.fit, errors.test)
    )
    if not test > max(FAR * fit, FAR_K):
        return []
    return [
        f"the test runs are missed by {test:.3g} K, the fit runs by {fit:.2g} K: the verdict is of the fit runs alone, "
        "and what the test runs show is in none of them; give one of those to --fit, and look whether it is the same "
        "motor"
    ]


def said_of(paths: Sequence[Path], errors: Errors) -> list[str]:
    """A sentence for each run of which something was left out: rows of a long one, readings that are not believed."""
    left_out = {path: errors.curves[str(path)].left_out for path in paths}
    return [f"{path}: {said}" for path, said in left_out.items() if said]
