"""The search for one component in one form: starts, resumes, held levels, and guided runs of all lengths."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from benchmarks.attack.adjoint import Plan, Sweep
from benchmarks.attack.board import Array, Board, Copy, Integers
from benchmarks.attack.exact import BITS, ExactComponent, kelvins
from benchmarks.attack.functional import Functional, measured
from benchmarks.attack.rollout import Guide, Track, search
from gen.lowering.program import AnyComponent


@dataclass(frozen=True)
class Effort:
    """How much work goes into one component in one form.

    Attributes
    ----------
    longest
        Samples of the longest run.
    lanes, rounds
        Sequences that are improved at once, and how often.
    blocks
        Pieces that a run is planned in.
    choices, beam
        PWM that are tried at each sample on the board's words, and how many runs go on from there.
    starts
        Starts that are tried, over the whole range.
    """

    longest: int
    lanes: int
    rounds: int
    blocks: int
    choices: int
    beam: int
    starts: int


THOROUGH = Effort(longest=50_000, lanes=12, rounds=40, blocks=200, choices=24, beam=2, starts=400_000)
QUICK = Effort(longest=2_500, lanes=6, rounds=10, blocks=50, choices=12, beam=2, starts=20_000)
BRIEF = Effort(longest=500, lanes=4, rounds=6, blocks=25, choices=8, beam=1, starts=5_000)

#: Lengths of runs in slowest time constants; rounding alone needs one or two, a transient less.
_LENGTHS = (0.25, 0.5, 1.0, 2.0, 4.0)
#: The shortest runs, in samples: what a change does at once.
_SHORTEST = (4, 64)
#: Plans that are played on the board's words for each sign: the most promising ones of the linear system.
_PLAYED = 2
#: Samples for which every level is held from every kind of start.
_HELD = 24
#: How far from the planned start one with a worse rounding may lie, in thousandths of a kelvin.
_NEARBY = 500


@dataclass(frozen=True)
class Finding:
    """The worst that was found.

    Attributes
    ----------
    error_K
        ``|x1 - T|``, by the exact solution.
    start_mK
        The start.
    rows
        The domain's row of each sample up to there.
    """

    error_K: float
    start_mK: int
    rows: tuple[int, ...]


def attack(component: AnyComponent, exact: ExactComponent, effort: Effort, rng: np.random.Generator) -> Finding:
    """Search for the largest error of a component's words."""
    board = Board(component)
    copy = Copy.of(board, exact.steady)
    starts = _Starts(board, effort, rng)
    tracks = [Track(start, [], [starts.word(start)]) for start in starts.worst()]
    tracks.append(_levels(board, exact, copy, starts))
    with np.errstate(all="ignore"):  # an unproven form may be unstable
        functional = measured(board, exact, copy, rng)
        for sweep, plan, block in _plans(functional, component, effort, rng):
            start = starts.near(plan.rise, plan.sign)
            for choices, beam in ((1, 1), (effort.choices, effort.beam)):  # as planned, and with an eye on rounding
                guide = Guide(plan.costates, sweep.candidates(plan, choices), block, beam)
                tracks.append(search(board, exact, copy, start, guide))
    findings = [_judged(board, exact, track) for track in tracks]
    return max(findings, key=lambda finding: finding.error_K)


def _plans(
    functional: Functional, component: AnyComponent, effort: Effort, rng: np.random.Generator
) -> list[tuple[Sweep, Plan, int]]:
    """The most promising plans over all lengths, and one that lasts long enough for rounding to add up."""
    ends = (component.start_range_mK[0] / 1000.0, component.start_range_mK[1] / 1000.0)
    lengths = sorted({min(effort.longest, max(4, round(t / functional.slowest))) for t in _LENGTHS} | set(_SHORTEST))
    found: list[tuple[float, int, Sweep, Plan, int]] = []
    for samples in lengths:
        blocks = min(samples, effort.blocks)
        block = samples // blocks
        sweep = Sweep(functional, block, blocks, ends)
        plan = sweep.plans(effort.lanes, effort.rounds, rng)
        found.append((float(np.nanmax(np.nan_to_num(plan.gain, nan=-np.inf))), samples, sweep, plan, block))
    usable = [entry for entry in found if np.isfinite(entry[0])]
    usable.sort(key=lambda entry: -entry[0])
    long = [entry for entry in usable if entry[1] >= min(effort.longest, 1.0 / functional.slowest)]
    chosen = {id(entry): entry for entry in (*usable[:_PLAYED], *long[:1])}
    return [(sweep, _best_lanes(plan), block) for _, _, sweep, plan, block in chosen.values()]


def _best_lanes(plan: Plan) -> Plan:
    """The best lanes of each sign."""
    order = np.argsort(-plan.gain)
    kept = np.concatenate([order[plan.sign[order] == sign][:_PLAYED] for sign in (1.0, -1.0)])
    return Plan(
        plan.modes[kept],
        plan.sign[kept],
        plan.rise[kept],
        plan.states[:, kept],
        plan.costates[:, kept],
        plan.gain[kept],
    )


class _Starts:
    """What rounding does to starts: all of the range if it is small enough, else its ends and many in between."""

    def __init__(self, board: Board, effort: Effort, rng: np.random.Generator) -> None:
        low, high = board.component.start_range_mK
        if high - low < effort.starts:
            tried = np.arange(low, high + 1)
        else:
            ends = effort.starts // 8
            parts = (np.arange(low, low + ends), np.arange(high - ends, high + 1), np.array([0]))
            tried = np.unique(np.concatenate([*parts, rng.integers(low, high, effort.starts - 2 * ends)]))
        self._tried = tried[(tried >= low) & (tried <= high)]
        state = board.start(self._tried.tolist())
        self._words = board.word(state)
        self.errors: Array = board.rise(state) - self._tried / 1000.0

    def worst(self) -> list[int]:
        """The starts that are furthest off, up and down, and both ends."""
        places = {int(self.errors.argmax()), int(self.errors.argmin()), 0, len(self._tried) - 1}
        return [int(self._tried[place]) for place in sorted(places)]

    def word(self, start_mK: int) -> int:
        """The word that a start becomes."""
        return int(self._words[np.searchsorted(self._tried, start_mK)])

    def near(self, rise: Array, sign: Array) -> list[int]:
        """Starts close to given rises in K whose own error has the sign that is pushed to."""
        found = []
        for target, direction in zip(np.rint(rise * 1000.0), sign, strict=True):
            place = int(np.clip(np.searchsorted(self._tried, target), 0, len(self._tried) - 1))
            first, last = max(0, place - _NEARBY), min(len(self._tried), place + _NEARBY + 1)
            found.append(int(self._tried[first + int((direction * self.errors[first:last]).argmax())]))
        return found


def _levels(board: Board, exact: ExactComponent, copy: Copy, starts: _Starts) -> Track:
    """Every level held for a while, from the worst starts, the ends and the middle."""
    rows = len(exact.steady)
    low, high = board.component.start_range_mK
    chosen = [*starts.worst(), 0 if low <= 0 <= high else low, (low + high) // 2]
    start = [value for value in chosen for _ in range(rows)]
    held: Integers = np.tile(np.arange(rows), len(chosen))[None, :, None]
    nothing = np.zeros((_HELD + 1, len(start), 2 * exact.order + 1))
    return search(board, exact, copy, start, Guide(nothing, np.repeat(held, _HELD, axis=0), 1))


def _judged(board: Board, exact: ExactComponent, track: Track) -> Finding:
    """The largest error of a run, by the exact solution."""
    shift = BITS - board.fraction_bits
    low, high = board.component.start_range_mK
    rises = exact.rises(max(low, min(high, track.start_mK)), track.rows)
    errors = [abs((word << shift) - rise) for word, rise in zip(track.words, rises, strict=True)]
    worst = max(range(len(errors)), key=errors.__getitem__)
    return Finding(kelvins(errors[worst]), track.start_mK, tuple(track.rows[:worst]))
