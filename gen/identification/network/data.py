"""From run files to bins: which nodes are sensed, over which ambient, and what cannot be used."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from gen.coefficients.base import told
from gen.errors import InputError
from gen.identification.drive import common_drive, machine_of
from gen.identification.logs.ambients import UNKNOWN_K, ambients_of
from gen.identification.logs.data import FEWEST, MOVES_K, apart, check_rows, components_of, sound
from gen.identification.logs.fahrenheit import fahrenheit
from gen.identification.logs.records import resolution
from gen.identification.logs.room_followers import followers
from gen.identification.logs.sources import Source
from gen.identification.network.driving import Driving, driving_of, values_of
from gen.identification.network.fitting.bins import Binned, binned, longest_bin
from gen.identification.network.fitting.driven import kind_of
from gen.identification.network.fitting.followed import FASTEST
from gen.runs import Run

MARGIN, LEAST_RISE_K = 0.5, 40.0
"""Temperatures are described so much of the largest rise beyond the hottest reading; a rise counts as this at least."""
COARSE = 4.0
"""The search works on bins longer by this factor."""


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
        Ambient in degC where it was not measured; None where every run has it measured, or noted as one of its own.
    ambient_measured
        Whether every run has a measured ambient.
    full_scale
        The count that is 100 %.
    warnings
        What was left out or assumed, and why.
    ambient_unsure_K
        Where nothing says the ambient: standard deviation of `ambient_fixed`, K; else 0.
    driving
        Columns that heat the motor beside its PWM.
    driven
        What heats go with: ``power``, ``current`` (its square), or nothing for a motor (see `fitting.driven`).
    least_s
        The shortest time constant that the board can follow, s (see `fitting.followed`); 0 for no limit.
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
    driving: tuple[Driving, ...] = ()
    driven: str = ""
    least_s: float = 0.0

    @property
    def highest_degC(self) -> float:
        """The highest temperature that the model has to describe: that of the runs with a margin."""
        hottest = max(float(np.nanmax(run.reading)) for run in self.fine if np.isfinite(run.reading).any())
        return hottest + MARGIN * max(hottest - self.coldest_degC, LEAST_RISE_K)

    @property
    def coldest_degC(self) -> float:
        """The lowest ambient of the runs."""
        return min(float(run.ambient.min()) for run in self.fine)

    @property
    def ambient_range(self) -> tuple[float, float] | None:
        """The lowest and the highest ambient of the runs, degC, where anything says it."""
        if self.ambient_unsure_K:
            return None
        return told(self.coldest_degC), told(max(float(run.ambient.max()) for run in self.fine))

    @property
    def widest_K(self) -> float:
        """The largest difference to the ambient that it has to describe."""
        return self.highest_degC - self.coldest_degC

    @property
    def taken_for_cold(self) -> bool:
        """Whether that some runs began cold is what they begin at, and nothing more."""
        return any(run.cold for run in self.coarse)

    def in_any_room(self) -> NetworkData:
        """Give the same without that: where runs begin says little of their room."""
        if not self.taken_for_cold:
            return self
        return replace(
            self,
            fine=tuple(replace(run, cold=False, room_K=UNKNOWN_K) for run in self.fine),
            coarse=tuple(replace(run, cold=False, room_K=UNKNOWN_K) for run in self.coarse),
        )

    @property
    def runs(self) -> list[tuple[str, Run]]:
        """The runs by path."""
        return [(source.path, source.run) for source in self.sources]


def make_network_data(
    sources: Sequence[Source],
    ambient: float | None,
    full_scale: int = 255,
    heat: Sequence[str] = (),
    machine: str = "",
    sample_time_s: float = 0.0,
) -> NetworkData:
    """Condense runs.

    Parameters
    ----------
    sources
        The runs.
    ambient
        Fixed ambient in degC for runs without a measured one, or None.
    full_scale
        The count that is 100 %.
    heat
        Columns that heat the motor, too, see :func:`driving_of`.
    machine
        What the input drives (see `gen.runs.drive`); nothing: what the runs say.
    sample_time_s
        The board's, which limits how fast the network may be; 0 for no board.

    Raises
    ------
    InputError
        When nothing can be identified from them.
    """
    by_path = [(source.path, source.run) for source in sources]
    driven = kind_of(common_drive(by_path), machine or machine_of(by_path))
    warnings = [f"{source.path}: {source.run.thinned}" for source in sources if source.run.thinned]
    sources = [sound(source, warnings) for source in sources]
    warnings += apart(sources)
    _check(sources, full_scale)
    names = _reacting(sources, components_of(sources), warnings)
    warnings += followers(sources, names)
    ambients = ambients_of(sources, ambient, warnings, estimated=True)
    warnings += fahrenheit(sources, ambients.levels)
    stems = [source.name for source in sources]
    labels = stems if len(set(stems)) == len(stems) else [source.path for source in sources]
    driving = driving_of(sources, heat)
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
                [one.share(values_of(source, one.column)) for one in driving],
                room_K=ambients.unsure_K if isinstance(around, float) else 0.0,
                cold=cold,
            )
            for label, source, around, cold in zip(labels, sources, ambients.levels, ambients.cold, strict=True)
        )

    return NetworkData(
        sources=tuple(sources),
        names=tuple(names),
        fine=bins(longest),
        coarse=bins(COARSE * longest),
        ambient_fixed=ambients.fixed(ambient),
        ambient_measured=not any(isinstance(a, float) for a in ambients.levels),
        full_scale=full_scale,
        warnings=tuple(dict.fromkeys(warnings)),
        driving=driving,
        driven=driven,
        least_s=FASTEST * sample_time_s,
    )


def _check(sources: Sequence[Source], full_scale: int) -> None:
    check_rows(sources)
    for source in sources:
        high = int(np.abs(source.run.pwm).max())
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
