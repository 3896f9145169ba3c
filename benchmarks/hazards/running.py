"""Runs hazards in processes, and sums up what many flips gave."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import Future, ProcessPoolExecutor
from dataclasses import dataclass

from benchmarks.hazards import commanding, machine, sensing
from benchmarks.hazards.bits import CAMPAIGNS, Flip
from benchmarks.hazards.boards import variant
from benchmarks.hazards.hazard import HAZARDS
from benchmarks.hazards.scene import Outcome, Scene

assert sensing and machine and commanding  # they enter what they have


@dataclass(frozen=True)
class Line:
    """A line of the table: a hazard, or a campaign of `runs` of which `failed` break the goal."""

    name: str
    cause: str
    faults: int
    outcome: Outcome
    runs: int = 1
    failed: tuple[Flip, ...] = ()

    @property
    def passes(self) -> bool:
        """Whether the goal holds, in each run."""
        return self.outcome.passes and not self.failed


def names() -> list[str]:
    """All that can be asked for."""
    return [*HAZARDS, *CAMPAIGNS]


def run_hazard(name: str) -> Outcome:
    """Let a hazard happen."""
    hazard = HAZARDS[name]
    with Scene(variant(hazard.board), others=hazard.others) as scene:
        hazard.script(scene)
        return scene.outcome()


def run_flip(name: str, flip: Flip) -> Outcome:
    """Let one flip of a campaign happen."""
    return CAMPAIGNS[name].run(flip)


def lines(wanted: Sequence[str], counts: Mapping[str, int], jobs: int) -> Iterator[Line]:
    """Run hazards and campaigns, in order.

    Parameters
    ----------
    wanted
        Their names.
    counts
        How many flips each campaign makes.
    jobs
        Processes.
    """
    for kind in {HAZARDS[name].board for name in wanted if name in HAZARDS} | {"relay"}:
        variant(kind)  # built once, before the processes need it
    with ProcessPoolExecutor(jobs) as pool:
        started: dict[str, list[tuple[Flip, Future[Outcome]]]] = {}
        for name in wanted:
            if name in HAZARDS:
                started[name] = [((0, 0), pool.submit(run_hazard, name))]
            else:
                flips = CAMPAIGNS[name].flips(counts[name])
                started[name] = [(flip, pool.submit(run_flip, name, flip)) for flip in flips]
        for name, runs in started.items():
            done = [(flip, future.result()) for flip, future in runs]
            if name in HAZARDS:
                yield Line(name, HAZARDS[name].cause, HAZARDS[name].faults, done[0][1])
            else:
                yield summed(name, CAMPAIGNS[name].cause, done)


def summed(name: str, cause: str, done: Sequence[tuple[Flip, Outcome]]) -> Line:
    """The worst of many runs, and how often they did and ended what."""
    outcomes = [outcome for _, outcome in done]
    ended = [outcome.after_s for outcome in outcomes]
    worst = Outcome(
        did=counted(outcome.did for outcome in outcomes),
        after_s=None if None in ended else max(after for after in ended if after is not None),
        beyond_driven_K=max(outcome.beyond_driven_K for outcome in outcomes),
        beyond_K=max(outcome.beyond_K for outcome in outcomes),
        blind_s=max(outcome.blind_s for outcome in outcomes),
        allowed_s=outcomes[0].allowed_s,
        end=counted(outcome.end for outcome in outcomes),
    )
    failed = tuple(flip for flip, outcome in done if not outcome.passes)
    return Line(name, cause, 1, worst, len(done), failed)


def counted(texts: Iterator[str]) -> str:
    """What came how often, the most frequent first; what came seldom is left out."""
    most = Counter(texts).most_common()
    told = "; ".join(f"{count} x {text}" for text, count in most[:5])
    return told + (f"; {sum(count for _, count in most[5:])} x other" if len(most) > 5 else "")
