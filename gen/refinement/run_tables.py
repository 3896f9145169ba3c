"""Errors before and after as tables of the report."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from gen.refinement.errors import Errors


def short_names(paths: Sequence[str]) -> dict[str, str]:
    """File names where they tell the runs apart, else the paths as they were given."""
    names = [Path(path).name for path in paths]
    return dict(zip(paths, names if len(set(names)) == len(names) else paths, strict=True))


def totals(before: Errors, after: Errors) -> list[list[str]]:
    """All fit runs, and all test runs: RMSE before and after, largest before and after, K."""
    old, new = before.summary(), after.summary()
    return [[key, *_four(old[key], new[key])] for key in ("fit", "test")]


def error_rows(before: Errors, after: Errors, short: dict[str, str]) -> dict[str, list[list[str]]]:
    """Rows of run, component and the same four figures, test runs first.

    Parameters
    ----------
    before, after
        Errors of both models.
    short
        Names of the runs as the page has them.
    """
    old, new = before.summary()["per_run"], after.summary()["per_run"]
    return {
        kind: [
            [short[run] if first else "", name, *_four(old[run][name], new[run][name])]
            for run, parts in getattr(before, kind).items()
            for first, name in zip([True] + [False] * len(parts), parts, strict=False)
        ]
        for kind in ("test", "fit")
    }


def _four(before: dict[str, float], after: dict[str, float]) -> list[str]:
    return [f"{which[key]:.2f}" for key in ("rmse_K", "max_abs_K") for which in (before, after)]
