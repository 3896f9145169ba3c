"""A motor's runs as the fit takes them: what can be used, and a line for what cannot."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from gen.errors import CheckFailed, InputError
from gen.fleet.folder.store import Kept, Store
from gen.identification.drive import agreed
from gen.identification.logs.sources import MOST_ROWS, Source
from gen.identification.network.data import NetworkData, make_network_data
from gen.identification.network.fitting.bins import Binned
from gen.identification.settings import Settings
from gen.runs import Run
from gen.runs.faults import called_unhealthy, declared_faults
from gen.runs.thinning import thinned


@dataclass(frozen=True)
class Usable:
    """A motor's runs.

    Attributes
    ----------
    sources
        Those to fit.
    lines
        What is left out, and why.
    """

    sources: tuple[Source, ...]
    lines: tuple[str, ...]


def usable(store: Store, kept: Sequence[Kept]) -> Usable:
    """Read runs; what cannot be read, or says that the motor was not healthy, is a line."""
    sources, lines = [], []
    for each in kept:
        try:
            run = read(store, each)
        except InputError as error:
            lines.append(str(error))
            continue
        if not is_healthy(run.comments):
            faults = declared_faults(run.comments)
            lines.append(f"{each.path}: is left out: it says fault {', '.join(faults) or 'without a name'}")
        else:
            sources.append(Source(each.path, run))
    return Usable(tuple(sources), tuple(lines))


def is_healthy(comments: Mapping[str, str]) -> bool:
    """Whether a run does not say that its motor had a fault."""
    return not declared_faults(comments) and not called_unhealthy(comments)


def check_inputs(store: Store, runs: Mapping[str, Sequence[Kept]]) -> None:
    """Check, before anything is fitted, that all runs that would be were driven by one quantity of one full scale.

    Raises
    ------
    InputError
        For a run that says another input than one before it, of whatever motor.
    """
    agreed(
        (f"{store.url}/{kept.path}", comments)
        for motor in sorted(runs)
        for kept in runs[motor]
        if is_healthy(comments := _comments(store, kept))
    )


def _comments(store: Store, kept: Kept) -> dict[str, str]:
    """What a run says; nothing, where it cannot be read: that is a line of its own later."""
    try:
        return store.comments(kept)
    except InputError:
        return {}


def read(store: Store, kept: Kept) -> Run:
    """Read a run; a long one is thinned as `gen identify` does."""
    run = store.run(kept)
    if run.time_s.size <= 2 * MOST_ROWS:
        return run
    columns = {name: np.asarray(values, dtype=np.float64) for name, values in run.columns().items()}
    made = thinned(columns, {name for name in columns if name.endswith("_degC")}, MOST_ROWS)
    return replace(
        run,
        time_s=made["time_s"],
        pwm=made["pwm"].astype(np.int64),
        temps={name: made[f"{name}_degC"] for name in run.temps},
        ambient=None if run.ambient is None else made["ambient_degC"],
        extras={name: made[name] for name in run.extras},
    )


def data_of(sources: Sequence[Source], ambient: float | None, sensed: Sequence[str] = ()) -> NetworkData:
    """Condense a motor's runs.

    Parameters
    ----------
    sources
        The runs.
    ambient
        In degC, for runs without a measured one.
    sensed
        The sensed nodes that are asked for, in order; all that react, where none are.

    Raises
    ------
    InputError
        When nothing can be identified from them.
    CheckFailed
        When a sensed node is missing, or does not move.
    """
    if not sources:
        raise CheckFailed("no run can be used")
    # `gen identify` asks the runs whether those that begin at one level began cold; here nobody does.
    data = make_network_data(sources, ambient, sample_time_s=Settings.sample_time_s).in_any_room()
    if not sensed or tuple(sensed) == data.names:
        return data
    missing = [name for name in sensed if name not in data.names]
    if missing:
        raise CheckFailed(f"{', '.join(missing)}: is not measured, or does not move, in these runs")
    places = [data.names.index(name) for name in sensed]
    return replace(
        data,
        names=tuple(sensed),
        fine=tuple(_only(run, places) for run in data.fine),
        coarse=tuple(_only(run, places) for run in data.coarse),
    )


def _only(run: Binned, places: Sequence[int]) -> Binned:
    at = list(places)
    return replace(
        run,
        reading=run.reading[:, at],
        share=run.share[:, at],
        covered=run.covered[:, at],
        begin=run.begin[at],
        noise_K=run.noise_K[at],
        sample_s=run.sample_s[at],
    )
