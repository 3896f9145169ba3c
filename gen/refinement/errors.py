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


def said_of(paths: Sequence[Path], errors: Errors) -> list[str]:
    """A sentence for each run of which something was left out: rows of a long one, readings that are not believed."""
    left_out = {path: errors.curves[str(path)].left_out for path in paths}
    return [f"{path}: {said}" for path, said in left_out.items() if said]
