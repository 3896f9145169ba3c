"""From run files to bins: which nodes are sensed, over which ambient, and what cannot be used."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from gen.errors import InputError
from gen.identification.data import (
    ALIKE_K,
    FEWEST,
    MOST_ROWS,
    MOVES_K,
    Source,
    components_of,
    first_readings,
    said_ambient,
    sound,
)
from gen.identification.drive import common_drive
from gen.identification.network.bins import Binned, FloatArray, binned, longest_bin
from gen.identification.records import resolution
from gen.runs import Run, read_run

COARSE = 4.0
"""The search works on bins longer by this factor."""
SAME_ROOM_K = 4.0
"""Rooms of several runs differ by no more than this: what begins warmer does not begin cold."""
UNKNOWN_K = 5.0
"""Standard deviation of a room that nothing says about where the coldest run begins, K."""


@dataclass(frozen=True, eq=False)
class NetworkData:
    """What the fit works on.

    Attributes
    ----------
    sources
        The run files.
    names
        The sensed nodes.
    fine, coarse
        Bins of each run: for the last fit, and for the search.
    ambient_fixed
        Ambient in degC where it was not measured, or None.
    ambient_measured
        Whether every run has a measured ambient.
    full_scale
        The count that is 100 %.
    warnings
        What was left out or assumed, and why.
    ambient_unsure_K
        Where nothing says the ambient: standard deviation of `ambient_fixed`, K; else 0.
    """

    sources: tuple[Source, ...]
    names: tuple[str, ...]
    fine: tuple[Binned, ...]
    coarse: tuple[Binned, ...]
    ambient_fixed: float | None
    ambient_measured: bool
    full_scale: int
    warnings: tuple[str, ...]
    ambient_unsure_K: float = 0.0

    @property
    def runs(self) -> list[tuple[str, Run]]:
        """The runs by path."""
        return [(source.path, source.run) for source in self.sources]


def read_network_data(paths: Sequence[Path], ambient: float | None, full_scale: int) -> NetworkData:
    """Read run files and condense them.

    Parameters
    ----------
    paths
        The files.
    ambient
        Fixed ambient in degC for runs without a measured one, or None.
    full_scale
        The count that is 100 %.

    Raises
    ------
    InputError
        When nothing can be identified from them.
    """
    sources = [Source(str(path), read_run(path, most_rows=MOST_ROWS)) for path in paths]
    return make_network_data(sources, ambient, full_scale)


def make_network_data(sources: Sequence[Source], ambient: float | None, full_scale: int = 255) -> NetworkData:
    """Condense runs in memory, as :func:`read_network_data` does."""
    common_drive((source.path, source.run) for source in sources)
    warnings = [f"{source.path}: {source.run.thinned}" for source in sources if source.run.thinned]
    sources = [sound(source, warnings) for source in sources]
    _check(sources, full_scale)
    names = _reacting(sources, components_of(sources), warnings)
    ambients, unsure = _ambients(sources, ambient, warnings)
    stems = [source.name for source in sources]
    labels = stems if len(set(stems)) == len(stems) else [source.path for source in sources]
    longest = longest_bin([source.run for source in sources])

    def bins(width: float) -> tuple[Binned, ...]:
        return tuple(
            binned(
                label,
                source.run,
                names,
                around,
                full_scale,
                width,
                room_K=unsure if isinstance(around, float) else 0.0,
            )
            for label, source, around in zip(labels, sources, ambients, strict=True)
        )

    return NetworkData(
        sources=tuple(sources),
        names=tuple(names),
        fine=bins(longest),
        coarse=bins(COARSE * longest),
        ambient_fixed=_usual(ambients, ambient),
        ambient_measured=not any(isinstance(a, float) for a in ambients),
        full_scale=full_scale,
        warnings=tuple(dict.fromkeys(warnings)),
    )


def _usual(ambients: Sequence[FloatArray | float], given: float | None) -> float | None:
    """The ambient of a run that does not say it: the median of those that were not measured."""
    levels = [level for level in ambients if isinstance(level, float)]
    return float(np.median(levels)) if levels else given


def _check(sources: Sequence[Source], full_scale: int) -> None:
    if not any(np.any(source.run.pwm != 0) for source in sources):
        raise InputError("found PWM 0 in every row, expected runs in which the motor turns", file=sources[0].path)
    for source in sources:
        rows, high = len(source.run.time_s), int(np.abs(source.run.pwm).max())
        if rows < FEWEST:
            raise InputError(f"found {rows} row(s), expected at least {FEWEST} to identify from", file=source.path)
        if high > full_scale:
            message = f"found |PWM| {high}, over the full scale of {full_scale}; expected another --full-scale"
            raise InputError(message, file=source.path, place="column pwm")


def _reacting(sources: Sequence[Source], names: Sequence[str], warnings: list[str]) -> list[str]:
    """The parts that move in some run; the warnings say which do not."""
    kept, reasons = [], []
    for name in names:
        known = [source.run.temps[name] for source in sources if name in source.run.temps]
        known = [values[np.isfinite(values)] for values in known]
        known = [values for values in known if values.size >= FEWEST]
        if not known:
            reasons.append(f"{name} is left out: no run holds enough samples of it")
            continue
        moves = max(float(np.ptp(values)) for values in known)
        if moves < max(MOVES_K, 4.0 * max(resolution(values) for values in known)):
            reasons.append(f"{name} is left out: it moves by {moves:.2g} K only in all runs: it does not react")
            continue
        kept.append(name)
    if not kept:
        raise InputError(f"nothing can be identified: {'; '.join(reasons)}", file=sources[0].path)
    warnings += reasons
    return kept


def _ambients(
    sources: Sequence[Source], fixed: float | None, warnings: list[str]
) -> tuple[list[FloatArray | float], float]:
    """The ambient of each run, and what all of them may be off by together, standard deviation, K.

    Where nothing says it a run that begins like the coldest ones begins in its room; others are taken to stand in the
    room of those.
    """
    said = [said_ambient(source, fixed, warnings) for source in sources]
    levels = [float(np.mean(level)) for level in said if level is not None]
    starts = [first_readings(source.run) for source in sources]
    coldest = min(
        min(firsts) for firsts, level in zip(starts, said, strict=True) if firsts and (level is None or levels)
    )
    usual = float(np.median(levels)) if levels else coldest
    found: list[FloatArray | float] = []
    for source, level, firsts in zip(sources, said, starts, strict=True):
        if level is not None:
            found.append(level)
            continue
        own = float(np.median(firsts)) if firsts else usual
        alike = bool(firsts) and max(firsts) - min(firsts) <= ALIKE_K
        if alike and own - usual <= SAME_ROOM_K:
            warnings.append(
                f"{source.path}: no ambient_degC; a cold start is assumed, so {own:g} degC, where the run begins"
            )
            found.append(own)
        else:
            warnings.append(
                f"{source.path}: no ambient_degC, and a warm start; {usual:g} degC is taken, as in the others"
            )
            found.append(usual)
    return found, 0.0 if levels else UNKNOWN_K
