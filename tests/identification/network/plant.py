"""Motors as networks, integrated by matrix exponentials of their own: nothing of what identifies them."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np
from scipy.linalg import expm

from gen.arrays import FloatArray, IntArray
from gen.runs import Run

ROW_S = 4.0
ROOM = 25.0


@dataclass(frozen=True, eq=False)
class Plant:
    """Heat capacities in J/K, links (node, node, W/K), surfaces and heats as (node, at rest, more at full speed).

    Conductances to the room grow in a straight line; heats are `first` w + `second` w^2.
    """

    capacity: tuple[float, ...]
    links: tuple[tuple[int, int, float], ...]
    surfaces: tuple[tuple[int, float, float], ...]
    heats: tuple[tuple[int, float, float], ...]
    sensed: dict[str, int]

    @cache  # noqa: B019
    def step(self, level: int) -> tuple[FloatArray, FloatArray, FloatArray]:
        """T -> A T + b room + c over one row at a |PWM|."""
        w, n = level / 255.0, len(self.capacity)
        m, room, heat = np.zeros((n, n)), np.zeros(n), np.zeros(n)
        for i, j, g in self.links:
            m[i, i] -= g
            m[i, j] += g
            m[j, j] -= g
            m[j, i] += g
        for i, rest, more in self.surfaces:
            m[i, i] -= rest + more * w
            room[i] += rest + more * w
        for i, first, second in self.heats:
            heat[i] += first * w + second * w * w
        inverse = 1.0 / np.array(self.capacity)
        whole = np.zeros((n + 2, n + 2))
        whole[:n, :n], whole[:n, n], whole[:n, n + 1] = m * inverse[:, None], room * inverse, heat * inverse
        moved = expm(whole * ROW_S)
        return moved[:n, :n], moved[:n, n], moved[:n, n + 1]

    def true(self, pwm: IntArray, room: FloatArray, start: float | None = None) -> FloatArray:
        """Temperatures of all nodes at each row, shape (N, n), degC; from the room's temperature."""
        state = np.full(len(self.capacity), room[0] if start is None else start)
        made = np.empty((pwm.size, state.size))
        for k, level in enumerate(np.abs(pwm).tolist()):
            made[k] = state
            a, b, c = self.step(level)
            state = a @ state + b * room[k] + c
        return made

    def run(
        self,
        pwm: IntArray,
        rng: np.random.Generator,
        room: FloatArray | float = ROOM,
        noise: float = 0.15,
        *,
        measured: bool = True,
        gaps: float = 0.0,
    ) -> Run:
        """What sensors of 0.25 K read, with noise and gaps."""
        around = np.broadcast_to(np.asarray(room, dtype=np.float64), pwm.shape)
        true = self.true(pwm, around)
        temps = {}
        for name, node in self.sensed.items():
            read = np.round((true[:, node] + rng.normal(0.0, noise, pwm.size)) * 4.0) / 4.0
            read[rng.random(pwm.size) < gaps] = np.nan
            temps[name] = read
        time = ROW_S * np.arange(pwm.size, dtype=np.float64)
        shown = np.round((around + rng.normal(0.0, 0.1, pwm.size)) * 4.0) / 4.0
        return Run(time, pwm, temps, shown if measured else None)


def holds(*parts: tuple[int, float]) -> IntArray:
    """PWM and minutes, one after the other."""
    return np.concatenate([np.full(round(60.0 * minutes / ROW_S), pwm, dtype=np.int64) for pwm, minutes in parts])


EIGHT = Plant(
    capacity=(60.0, 90.0, 150.0, 120.0, 200.0, 80.0, 300.0, 110.0),
    links=((0, 1, 1.2), (1, 2, 0.9), (2, 3, 1.5), (3, 4, 0.8), (4, 6, 1.1), (1, 5, 0.6), (5, 4, 0.9), (2, 7, 0.7)),
    surfaces=((4, 0.25, 0.5), (6, 0.4, 0.2), (7, 0.15, 0.3), (3, 0.1, 0.0)),
    heats=((0, 8.0, 12.0), (1, 2.0, 18.0), (7, 6.0, 2.0)),
    sensed={"brush": 0, "magnet": 2, "casing": 4},
)
"""Three of eight nodes are sensed."""
TWO = Plant(
    capacity=(120.0, 300.0),
    links=((0, 1, 0.8),),
    surfaces=((1, 0.3, 0.4),),
    heats=((0, 6.0, 14.0),),
    sensed={"winding": 0, "casing": 1},
)
"""Every node is sensed."""
