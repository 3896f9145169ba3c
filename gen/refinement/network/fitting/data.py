"""Runs as the refinement of a network sees them: bins of the later ones and of what the file stands for."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from scipy.ndimage import uniform_filter1d

from gen.arrays import BoolArray, FloatArray
from gen.coefficients import Coefficients
from gen.identification.network.fitting.bins import Binned, binned
from gen.identification.network.fitting.inputs import Inputs, inputs_of
from gen.model.dynamics import MAX_PWM
from gen.refinement.network.changing import excess
from gen.refinement.network.changing.columns import Columns
from gen.refinement.network.changing.freed import freed
from gen.refinement.network.effects import Offered
from gen.refinement.network.fitting.anchors import anchors, declared_density, identified_ambient
from gen.replay import Inputs as Driven
from gen.replay import inputs_of as driven_by
from gen.runs import Run
from gen.side_by_side import side_by_side

BIN_S, FINEST_S = 120.0, 6.0
"""Longest bin where PWM is held for ten minutes at a time, and where it always moves: a mean over minutes is then no
PWM that heats alike."""
OF_A_HOLD, SHORTER = 0.2, 0.25
"""Share of the usual hold of PWM that the longest bin may be, and of the time that holds are shorter than the usual."""
USUAL_BINS, MOST_BINS = 720, 4000
"""About as many bins of the longest kind all later runs together are cut into then, and how many bins they may have."""
MOVES, ITS_OWN = 0.01, 0.05
"""A channel explains nothing that moves by less than this share of its size, or of whose movements less than this share
is not that of |PWM|."""
DEGREE = 3
"""What follows |PWM| does so as a polynomial of this degree, with a value of its own at rest."""
BACKWARDS_S, RESTS_S = 120.0, 300.0
NOT_WILD = 0.999
"""Share of a run's readings that single wild ones are not among."""
ROOM_MOVES_K = 0.3
"""Standard deviation of an ambient that moves."""


@dataclass(frozen=True, eq=False)
class Data:
    """Later runs beside what the file stands for.

    Attributes
    ----------
    inputs
        All bins; the later runs come first, in their order.
    later
        How many runs are later ones.
    columns
        What else drives the motor.
    offered
        What the later runs offer to explain an error with.
    declared
        Density of the errors that the file declares, shape (S,), K^2 s.
    identified_degC
        Lowest and highest ambient of the runs that the file came from, where it says so.
    """

    inputs: Inputs
    later: int
    columns: Columns
    offered: Offered
    declared: FloatArray
    identified_degC: tuple[float, float] | None = None

    @property
    def is_later(self) -> BoolArray:
        """Whether a bin is of a later run, shape (N,)."""
        return np.asarray(self.inputs.run < self.later)


def make_data(coefficients: Coefficients, runs: Sequence[tuple[str, Run]], *, as_declared: bool = False) -> Data:
    """Condense runs.

    Parameters
    ----------
    coefficients
        The file: which nodes are sensed, what the ambient is, which channels it reads.
    runs
        The later runs by name, read with :func:`gen.replay.read_for`.
    as_declared
        Take a measured ambient only where the file names its channel, as the board does; else wherever there is one.
    """
    model = coefficients.model
    names = model.component_names
    driven = [driven_by(coefficients, run, name, as_declared=as_declared) for name, run in runs]
    assert model.network is not None
    own = [channel.column for channel in model.network.channels]
    columns = Columns(_channels(runs, driven, own), excess.count(model.network))
    full_scale = coefficients.document.input.full_scale
    total = sum(float(run.time_s[-1] - run.time_s[0]) for _, run in runs)
    wanted = max(OF_A_HOLD * _usual_hold_s([run for _, run in runs]), total / USUAL_BINS)
    longest = max(float(np.clip(wanted, FINEST_S, BIN_S)), 1.5 * total / MOST_BINS)
    neutral = model.network.neutral()
    along = [
        _Along(name, run, inputs, np.asarray(inputs.ambient, dtype=np.float64), inputs.channels, longest)
        for (name, run), inputs in zip(runs, driven, strict=True)
    ]
    for number, run in enumerate(anchors(coefficients)):
        name = f"the file itself, {number + 1}"
        told = {column: np.full(run.time_s.size, neutral.get(column, 0.0)) for column in columns.channels}
        inputs = driven_by(coefficients, run, name, as_declared=as_declared)
        assert run.ambient is not None
        along.append(_Along(name, run, inputs, run.ambient, told, 2.0 * BIN_S))
    # Where some heat goes by a law of temperature, the file is followed along each run, which takes a second.
    made = side_by_side(
        [partial(_condensed, coefficients, columns, one, later=k < len(runs)) for k, one in enumerate(along)]
    )
    bins = inputs_of(made)
    if not as_declared and model.ambient_channel is None and all(run.ambient is not None for _, run in runs):
        # One number for each run that the file stands for: by how much its room was another.
        bins = replace(bins, room=(bins.run >= len(runs)).astype(np.float64)[:, None])
    return Data(
        bins,
        len(runs),
        columns,
        _offered(runs, driven, columns, names, full_scale),
        declared_density(coefficients),
        identified_ambient(coefficients),
    )


def _usual_hold_s(runs: Sequence[Run]) -> float:
    """For how long PWM is held while the motor turns, s: a quarter of that time lies in shorter holds, as ramps are."""
    held: list[FloatArray] = []
    for run in runs:
        changes = np.flatnonzero(np.diff(run.pwm)) + 1
        begins = np.concatenate([[0], changes])
        lengths = np.diff(np.append(run.time_s[begins], run.time_s[-1]))
        held.append(lengths[run.pwm[begins] != 0])
    lengths = np.sort(np.concatenate(held))
    if not lengths.sum():
        return np.inf
    return float(lengths[np.searchsorted(np.cumsum(lengths), SHORTER * lengths.sum())])


@dataclass(frozen=True, eq=False)
class _Along:
    """A run, what drives the file along it, its ambient, its channels, and the longest bin, s."""

    name: str
    run: Run
    inputs: Driven
    ambient: FloatArray
    channels: Mapping[str, FloatArray]
    longest: float


def _condensed(coefficients: Coefficients, columns: Columns, one: _Along, *, later: bool) -> Binned:
    """The bins of a run."""
    model = coefficients.model
    assert model.network is not None
    run = freed(one.run, model.network, one.ambient)
    carried = excess.excesses(coefficients, run, one.inputs)
    further = columns.of_run(run.pwm.astype(np.float64), one.channels, carried, later=later)
    full_scale = coefficients.document.input.full_scale
    return binned(one.name, run, model.component_names, one.ambient, full_scale, one.longest, further)


def _channels(runs: Sequence[tuple[str, Run]], driven: Sequence[Driven], own: Sequence[str]) -> tuple[str, ...]:
    """Channels that every run has and that say more than |PWM| does, and those that the model reads anyway."""
    common = set.intersection(*(set(inputs.channels) for inputs in driven))
    known = np.concatenate([_by_pwm(run) for _, run in runs])
    moving = []
    for name in sorted(common):
        each = zip(runs, driven, strict=True)
        values = np.abs(np.concatenate([_slow(run, inputs.channels[name]) for (_, run), inputs in each]))
        left = values - known @ np.linalg.lstsq(known, values, rcond=None)[0]
        size = float(np.sqrt(np.mean(values**2)))
        if np.std(left) > max(MOVES * size, ITS_OWN * float(np.std(values))):
            moving.append(name)
    return tuple(dict.fromkeys([*own, *moving]))


def _by_pwm(run: Run) -> FloatArray:
    """What goes with |PWM|, averaged as channels are, shape (rows, DEGREE + 2)."""
    share = np.abs(run.pwm) / MAX_PWM
    turning = (share > 0.0).astype(np.float64)
    columns = [1.0 - turning, *(turning * share**power for power in range(DEGREE + 1))]
    return np.column_stack([_slow(run, column) for column in columns])


def _slow(run: Run, values: FloatArray) -> FloatArray:
    """A channel's mean over a minute about each row: noise heats nothing."""
    rows = max(1, round(60.0 / max(float(np.median(np.diff(run.time_s))), 1e-6)))
    return np.asarray(uniform_filter1d(values, min(rows, values.size), mode="nearest"), dtype=np.float64)


def _offered(
    runs: Sequence[tuple[str, Run]],
    driven: Sequence[Driven],
    columns: Columns,
    sensed: Sequence[str],
    full_scale: int,
) -> Offered:
    backwards = rests = 0.0
    turned = np.zeros(101)
    for _, run in runs:
        step = np.diff(run.time_s)
        backwards += float(step[run.pwm[:-1] < 0].sum())
        rests += float(step[run.pwm[:-1] == 0].sum())
        turning = run.pwm[:-1] != 0
        percent = np.rint(np.minimum(np.abs(run.pwm[:-1]) / full_scale, 1.0) * 100.0).astype(int)
        turned += np.bincount(percent[turning], step[turning], turned.size)
    every = {name: np.concatenate([inputs.channels[name] for inputs in driven]) for name in columns.channels}
    return Offered(
        ranges={name: (float(values.min()), float(values.max())) for name, values in every.items()},
        typical={name: float(np.median(values)) for name, values in every.items()},
        backwards=backwards > BACKWARDS_S,
        rests=rests > RESTS_S,
        room_measured=all(run.ambient is not None for _, run in runs),
        room_moves=_room_moves(runs),
        turned_s=tuple(turned.tolist()),
        hottest_degC=_hottest([run for _, run in runs], sensed),
    )


def _hottest(runs: Sequence[Run], sensed: Sequence[str]) -> dict[str, float]:
    """The highest readings but for single wild ones, degC, of each sensor that read anything."""
    found: dict[str, float] = {}
    for name in sensed:
        each = [run.temps[name][np.isfinite(run.temps[name])] for run in runs if name in run.temps]
        highest = [float(np.quantile(readings, NOT_WILD)) for readings in each if readings.size]
        if highest:
            found[name] = max(highest)
    return found


def _room_moves(runs: Sequence[tuple[str, Run]]) -> bool:
    """Whether every run has a measured ambient, and they move."""
    rooms = [run.ambient for _, run in runs if run.ambient is not None]
    return len(rooms) == len(runs) and float(np.nanstd(np.concatenate(rooms))) > ROOM_MOVES_K
