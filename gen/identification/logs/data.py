"""From run files to records: which components there are, over which ambient, and what cannot be used."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from gen.arrays import FloatArray, IntArray
from gen.coefficients.names import name_fault
from gen.errors import InputError
from gen.identification.drive import common_drive, machine_of
from gen.identification.logs.ambients import ambients_of
from gen.identification.logs.believed import believed_run
from gen.identification.logs.fahrenheit import fahrenheit
from gen.identification.logs.records import Record, condense
from gen.identification.logs.room_followers import followers
from gen.identification.logs.sources import Source, read_sources
from gen.runs import Run

FEWEST = 20
"""Samples that a component needs in a run."""
MOVES_K = 0.5
"""A component whose temperature, over all runs, moves less than this (or four sensor steps) tells nothing."""
MOST_NODES = 12
NEAR = 6
"""Speeds closer than this, in counts, are not told apart."""
HELD = 0.1
"""A speed counts as identified when it is held for this share of the longest hold at any speed."""


@dataclass(frozen=True, eq=False)
class Data:
    """What identification works on.

    Attributes
    ----------
    sources
        The run files.
    records
        By component, one for each run that it was measured in.
    ambient_fixed
        Ambient in degC where it was not measured; None where every run has it measured, or noted as one of its own.
    ambient_measured
        Whether every run has a measured ambient.
    warnings
        What was left out, and why.
    """

    sources: tuple[Source, ...]
    records: dict[str, tuple[Record, ...]]
    ambient_fixed: float | None
    ambient_measured: bool
    warnings: tuple[str, ...]

    @property
    def runs(self) -> list[tuple[str, Run]]:
        """The runs by path."""
        return [(source.path, source.run) for source in self.sources]


def read_data(paths: Sequence[Path], ambient: float | None) -> Data:
    """Read run files and condense them.

    Parameters
    ----------
    paths
        The files.
    ambient
        Fixed ambient in degC for runs without a measured one, or None.

    Raises
    ------
    InputError
        When nothing can be identified from them.
    """
    return make_data(read_sources(paths), ambient)


def make_data(sources: Sequence[Source], ambient: float | None) -> Data:
    """Condense runs in memory, as :func:`read_data` does."""
    by_path = [(source.path, source.run) for source in sources]
    common_drive(by_path)
    machine_of(by_path)
    warnings = [f"{source.path}: {source.run.thinned}" for source in sources if source.run.thinned]
    sources = [sound(source, warnings) for source in sources]
    warnings += apart(sources)
    check_rows(sources)
    names = components_of(sources)
    ambients = ambients_of(sources, ambient, warnings)
    records = _records(sources, names, ambients.levels, warnings)
    warnings += [*fahrenheit(sources, ambients.levels), *followers(sources, list(records))]
    measured = all(s.run.ambient is not None and np.isfinite(s.run.ambient).any() for s in sources)
    return Data(tuple(sources), records, ambients.fixed(ambient), measured, tuple(dict.fromkeys(warnings)))


def check_rows(sources: Sequence[Source]) -> None:
    """Refuse runs in which nothing turns, or that are too short.

    Raises
    ------
    InputError
        With the run's file.
    """
    for source in sources:
        rows = len(source.run.time_s)
        if rows < FEWEST:
            raise InputError(f"found {rows} row(s), expected at least {FEWEST} to identify from", file=source.path)
    # A row's PWM acts until the next one: the last row's acts on nothing.
    if not any(np.any(source.run.pwm[:-1] != 0) for source in sources):
        last = "" if all(source.run.pwm[-1] == 0 for source in sources) else " but the last"
        message = f"found PWM 0 in every row{last}, expected runs in which the motor turns"
        raise InputError(message, file=sources[0].path)


def sound(source: Source, warnings: list[str]) -> Source:
    """Give the run without readings that no part can have shown; the warnings say how many."""
    run = believed_run(source.run)
    warnings += [f"{source.path}: {sentence}" for sentence in run.doubted]
    return replace(source, run=run)


def apart(sources: Sequence[Source]) -> list[str]:
    """A sentence for each run that shares no component with any other: none at all, or one sensor under two names."""
    own = [{name for name, values in s.run.temps.items() if np.isfinite(values).any()} for s in sources]
    said = []
    for k, (source, names) in enumerate(zip(sources, own, strict=True)):
        others = set().union(*own[:k], *own[k + 1 :])
        if not names:
            said.append(
                f"{source.path}: holds no temperature of a part (a column PART_degC with readings) and says nothing; "
                "gen import names columns so"
            )
        elif others and not names & others:
            said.append(
                f"{source.path}: {', '.join(sorted(names))} is in no other run, and {', '.join(sorted(others))} not in "
                "this one: where it is the same sensor, give it the same name (gen import --column)"
            )
    return said


def _records(
    sources: Sequence[Source], names: Sequence[str], ambients: Sequence[FloatArray | float], warnings: list[str]
) -> dict[str, tuple[Record, ...]]:
    """The records of each component that can be identified; the warnings say which cannot."""
    stems = [source.name for source in sources]
    labels = stems if len(set(stems)) == len(stems) else [source.path for source in sources]
    records: dict[str, tuple[Record, ...]] = {}
    for name in names:
        made = [
            _record(label, source, name, around, warnings)
            for label, source, around in zip(labels, sources, ambients, strict=True)
        ]
        found = [record for record in made if record is not None]
        reason = _useless(found)
        if reason:
            warnings.append(f"{name} is left out: {reason}")
        else:
            records[name] = tuple(found)
    if not records:
        reasons = "; ".join(w for w in warnings if "left out" in w)
        raise InputError(f"nothing can be identified: {reasons}", file=sources[0].path)
    return records


def components_of(sources: Sequence[Source]) -> list[str]:
    """Names of the measured components, in the order of the files.

    Raises
    ------
    InputError
        When there are none, or one has a name that cannot be built.
    """
    names: dict[str, str] = {}
    for source in sources:
        for name in source.run.temps:
            names.setdefault(name, source.path)
    for name, path in names.items():
        problem = name_fault(name)
        if problem:
            raise InputError(problem, file=path, place=f"column {name}_degC")
    if not names:
        found = ", ".join(["time_s", "pwm", *sources[0].run.extras])
        others = [c for c in sources[0].run.extras if re.search(r"_(degF|F|K)$", c)]
        hint = f"; {others[0]} is not in degC: convert it" if others else ""
        raise InputError(f"missing column <component>_degC; found {found}{hint}", file=sources[0].path)
    return list(names)


def _record(label: str, source: Source, name: str, ambient: FloatArray | float, warnings: list[str]) -> Record | None:
    run = source.run
    if name not in run.temps:
        return None
    good = int(np.isfinite(run.temps[name]).sum())
    if good < FEWEST:
        kept = " that can be believed" if any(said.startswith(f"{name}_degC:") for said in run.doubted) else ""
        warnings.append(f"{source.path}: {name}_degC has {good} sample(s){kept} only; the run is left out for {name}")
        return None
    if good < 0.5 * len(run.time_s):
        warnings.append(f"{source.path}: {name}_degC is missing in {1.0 - good / len(run.time_s):.0%} of the rows")
    return condense(label, run.time_s, run.pwm, run.temps[name], ambient)


def _useless(records: list[Record]) -> str:
    """Why nothing can be identified from these, or nothing."""
    if not records:
        return "no run holds enough samples of it"
    moves = max(float(np.ptp(record.raw_rise)) for record in records)
    if moves < max(MOVES_K, 4.0 * max(record.quantum_K for record in records)):
        return f"it moves by {moves:.2g} K only in all runs: it does not react, or the runs begin where they end"
    if not any(np.any(record.segments.pwm != 0) for record in records):
        return "PWM is 0 whenever it is measured"
    return ""


def held_speeds(records: Sequence[Record]) -> IntArray:
    """Find the |PWM| at which a transfer function can be identified: what is held long enough.

    Returns
    -------
    array
        Increasing; with PWM 0 when the run cools down for long enough. Empty where no speed is held.
    """
    total: dict[int, float] = {}
    longest: dict[int, float] = {}
    for record in records:
        for pwm, length in zip(record.segments.pwm.tolist(), record.segments.length.tolist(), strict=True):
            if pwm >= 0:
                total[pwm] = total.get(pwm, 0.0) + length
                longest[pwm] = max(longest.get(pwm, 0.0), length)
    if not any(p > 0 for p in longest):
        return np.array([], dtype=np.int64)
    most = max(longest.values())
    whole = sum(record.duration for record in records)
    held = [p for p, length in longest.items() if length >= HELD * most and total[p] >= 0.02 * whole]
    nodes = _thinned(held, total)
    return np.array(nodes if any(p > 0 for p in nodes) else [], dtype=np.int64)


def _thinned(held: list[int], total: dict[int, float]) -> list[int]:
    chosen: list[int] = [0] if 0 in held else []
    for p in sorted((p for p in held if p), key=lambda p: -total[p]):
        if all(abs(p - q) >= NEAR for q in chosen if q) and len([q for q in chosen if q]) < MOST_NODES:
            chosen.append(p)
    return sorted(chosen)


def quantile_speeds(records: Sequence[Record], quantiles: Sequence[float]) -> IntArray:
    """Give the |PWM| above 0 below which these shares of the driven time lie, increasing."""
    shares: dict[int, float] = {}
    for record in records:
        for j, pwm in enumerate(record.segments.pwm.tolist()):
            parts = {pwm: 1.0} if pwm >= 0 else record.segments.mixed[j]
            for level, share in parts.items():
                shares[level] = shares.get(level, 0.0) + share * float(record.segments.length[j])
    levels = np.array(sorted(p for p in shares if p > 0))
    weight = np.cumsum([shares[int(p)] for p in levels])
    picks = {int(levels[np.searchsorted(weight, q * weight[-1])]) for q in quantiles}
    return np.array(_thinned(sorted(picks), dict.fromkeys(picks, 1.0)), dtype=np.int64)
