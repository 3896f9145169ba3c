"""An adversary against the bounds of networks: how near to its bound can a node's error be driven?

    python -m benchmarks.attack.networks [COEFFS ...] [--samples 20000] [--lanes 128] [--seed 1]

A beam of lanes runs the board's reference beside the exact solution. Each lane draws PWM, ambient and channels (ends of
their ranges as often as what lies between) and holds them for 1 to 2 000 samples. Every 100 samples the better half, by
the largest share of its bound that one chosen node's error has, takes the place of the worse half, states and all. The
table gives the largest share that was reached, by node that was aimed at.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from rich.box import MARKDOWN
from rich.console import Console
from rich.table import Table

from gen.coefficients import Coefficients, load
from gen.lowering.kinds import Arithmetic
from gen.lowering.lower import lower
from gen.model.network_solution import NetworkSolution
from gen.reference.board import reference_of
from gen.reference.network import ReferenceNetwork

ROOT = Path(__file__).parent.parent.parent
EXAMPLES = tuple(
    ROOT / "examples" / name / "coeffs.json" for name in ("network", "two_nodes", "ten_nodes", "natural_cooling")
)
SELECTION = 100
"""Samples between two selections."""
Array = NDArray[np.float64]


class Beam:
    """Lanes of the reference and of the exact solution, side by side."""

    def __init__(self, coefficients: Coefficients, arithmetic: Arithmetic, lanes: int, seed: int) -> None:
        self.model = coefficients.model
        self.program = lower(coefficients, arithmetic, "table")
        assert self.program.network is not None
        self.network = self.program.network
        self.random = np.random.default_rng(seed)
        self.lanes = lanes
        self.solution = NetworkSolution(self.model)
        self.pwm, self.told = np.zeros(lanes, dtype=np.int64), self._channels()
        self.held = np.zeros(lanes, dtype=np.int64)
        low, high = self.model.domain_temperature
        first = {
            name: self.random.integers(round(low * 1000), round(high * 1000) + 1, lanes)
            for name in self.model.component_names
        }
        board = reference_of(self.program, {n: (v - self.told[0]).tolist() for n, v in first.items()}, self.told)
        assert isinstance(board, ReferenceNetwork)
        self.board = board
        self.exact = self.solution.start({n: v / 1000.0 for n, v in first.items()}, self.told[0] / 1000.0)

    def _channels(self) -> NDArray[np.int64]:
        drawn = []
        for channel in self.program.channels:
            end = self.random.choice([channel.low, channel.high], self.lanes)
            inner = self.random.integers(channel.low, channel.high + 1, self.lanes)
            drawn.append(np.where(self.random.random(self.lanes) < 0.5, end, inner))
        return np.array(drawn, dtype=np.int64)

    def sample(self) -> None:
        """One sample of every lane; what has been held long enough is drawn anew."""
        fresh = self.held <= 0
        low, high = self.model.domain_pwm
        drawn = np.where(
            self.random.random(self.lanes) < 0.5,
            self.random.choice([low, high], self.lanes),
            self.random.integers(low, high + 1, self.lanes),
        )
        self.pwm = np.where(fresh, drawn, self.pwm)
        self.told = np.where(fresh, self._channels(), self.told)
        holds = np.exp(self.random.uniform(0.0, np.log(2000.0), self.lanes)).astype(np.int64)
        self.held = np.where(fresh, holds, self.held - 1)
        columns = {c.column: self.told[k] / 1000.0 for k, c in enumerate(self.program.channels)}
        told = {channel.column: columns[channel.column] for channel in self.program.channels[1:]}
        step = np.full(self.lanes, self.model.sample_time)
        self.exact = self.solution.advance(self.exact, self.pwm, step, self.told[0] / 1000.0, told)
        self.board.set_channels(self.told)
        self.board.step(self.pwm)

    def shares(self) -> Array:
        """Error of each state as a share of its bound, shape (states, lanes)."""
        bound = self.network.proof.error[:, None] + 2.0**-self.network.fraction_bits
        return np.asarray((self.board.temperatures - self.exact.T) / bound)

    def select(self, aim: int, sign: float) -> None:
        """The better half takes the place of the worse half."""
        order = np.argsort(-sign * self.shares()[aim])
        better, worse = order[: self.lanes // 2], order[self.lanes - self.lanes // 2 :]
        self.exact[worse] = self.exact[better]
        self.board.copy_lanes(better, worse)
        self.held[worse] = 0


def attack(coefficients: Coefficients, arithmetic: Arithmetic, samples: int, lanes: int, seed: int) -> dict[str, float]:
    """Largest share of its bound that each state's error was driven to, over both signs and all states aimed at."""
    names = [state.name for state in Beam(coefficients, arithmetic, 1, seed).network.states]
    worst = np.zeros(len(names))
    for aim in range(len(names)):
        for sign in (1.0, -1.0):
            beam = Beam(coefficients, arithmetic, lanes, seed + aim)
            for sample in range(1, samples + 1):
                beam.sample()
                if sample % SELECTION == 0:
                    worst = np.maximum(worst, np.abs(beam.shares()).max(axis=1))
                    beam.select(aim, sign)
    return dict(zip(names, worst.tolist(), strict=True))


def main(arguments: Sequence[str] | None = None) -> None:
    """Print the table; exit status 1 if a bound was exceeded."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("coeffs", type=Path, nargs="*", default=list(EXAMPLES))
    parser.add_argument("--samples", type=int, default=20_000)
    parser.add_argument("--lanes", type=int, default=128)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args(arguments)
    table = Table("network", "arithmetic", "largest share of the bound", "of", box=MARKDOWN)
    largest = 0.0
    arithmetics: tuple[Arithmetic, ...] = ("fixed", "float")
    for path in options.coeffs:
        coefficients = load(path)
        for arithmetic in arithmetics:
            found = attack(coefficients, arithmetic, options.samples, options.lanes, options.seed)
            name, share = max(found.items(), key=lambda item: item[1])
            largest = max(largest, share)
            table.add_row(coefficients.name, arithmetic, f"{share:.3f}", name)
    Console(width=120).print(table)
    if largest > 1.0:
        raise SystemExit("a bound was exceeded")


if __name__ == "__main__":
    main()
