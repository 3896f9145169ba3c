"""What one run of the recursion does to the state: an affine map, and everything that roundings may add to it.

A component with a carry hands its x[n-1] a share of q when PWM changes. The combination

    W = x - e[n-2] share q(x)        q(x) = a . x + k, the board's own q as if nothing were rounded

then is the same before and after a change but for roundings, whatever |PWM| and ambient it was before: everything is
said in W. x follows from W and q, and where PWM or the ambient has just changed, from W and the old q, which is a
number of known size. The ambient's word, which S is raised by, is a symbol of its own.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from gen.arrays import FloatArray
from gen.certificate.affine import Affine, Reach, Space
from gen.certificate.document import Part
from gen.certificate.exact import Ratio, Ratios, floats
from gen.certificate.machine import Coefficients, Machine, State
from gen.certificate.refuted import Refuted
from gen.certificate.source import Project


@dataclass(frozen=True)
class Drive:
    """q(x) = linear . x + ambient a + constant in its own unit, and the share that x[n-1] has of it.

    Attributes
    ----------
    linear, ambient, constant
        Shapes (n, P), (P,) and (P,); x are the state's words, a is the ambient's.
    share
        Words of x[n-1] for a unit of q; 0 without a carry.
    """

    linear: Ratios
    ambient: Ratios
    constant: Ratios
    share: Ratio


@dataclass(frozen=True)
class Run:
    """W -> matrix W + ambient a + constant + sum of columns t, ``|t| <= 1``, at every |PWM|, in words.

    Attributes
    ----------
    matrix, ambient, constant
        Shapes (P, n, n), (P, n) and (P, n); a is the ambient's word.
    columns
        Shape (P, m, n), to the nearest float64.
    """

    matrix: Ratios
    ambient: Ratios
    constant: Ratios
    columns: FloatArray


class Recursion:
    """A component's recursion as its C++ has it.

    Parameters
    ----------
    project, arithmetic, part
        What runs.
    table
        R0 .. R[n-1] and S, shape (P, n + 1).
    ambient
        Whether the ambient's word is added to S.

    Raises
    ------
    Refuted
        If the C++ is not understood.
    """

    def __init__(self, project: Project, arithmetic: str, part: Part, table: Ratios, *, ambient: bool = False) -> None:
        self._project, self._arithmetic, self._part = project, arithmetic, part
        self._order, self._rows = part.order, len(table)
        # Symbols: the state's words, the old q, the ambient's word.
        self._symbols, self._place = part.order + 2, part.order + 1
        self._now = Coefficients(
            [table[:, i] for i in range(part.order)], table[:, part.order], self._place if ambient else None
        )
        self.carries = f"{part.shape}_carry" in project.functions
        if self.carries != (f"{part.shape}_drive" in project.functions or (arithmetic == "float" and part.order > 1)):
            raise Refuted(f"{part.name}: its functions are not those of one form")
        self.drive, self._factor = self._ideal_drive()

    def runs(self, reach: Callable[[Ratio], Reach]) -> tuple[list[Run], Ratio]:
        """The run of the recursion with a PWM held, and the one after a change; and the largest |q|, in its unit.

        Parameters
        ----------
        reach
            Encloses W and, as its last symbols, the old q and the ambient's word, given what the former may be at most.

        Raises
        ------
        Refuted
            If a number may leave its type.
        """
        without = Space(self._symbols, self._rows, reach(Ratio(0)))
        largest = max(np.abs(end).max() for end in without.ends(self._q_of_w(without)))
        space = Space(self._symbols, self._rows, reach(largest))
        machine = Machine(self._project, self._arithmetic, space)
        state = self._settled(space, machine)
        before = self._before(machine, state)
        found = [self._run(space, self._advanced(machine, state, None))]
        if machine.runs != self._part.substeps and self._arithmetic == "fixed":
            raise Refuted(
                f"{self._part.name}: {machine.runs} runs in a sample, {self._part.substeps} in the certificate"
            )
        if self.carries:
            found.append(self._changed(space, machine, before))
        return found, largest

    def _ideal_drive(self) -> tuple[Drive, Ratio]:
        """q, its share, and the units of what the carry is given of it in a unit of q."""
        n, space = self._order, Space(self._symbols, self._rows)
        machine = Machine(self._project, self._arithmetic, space)
        state = State([machine.word(space.symbol(i, "word")) for i in range(n)])
        q = self._q(machine, state)
        linear, ambient, constant = q.linear[:n], q.linear[self._place], q.constant
        if not self.carries:
            return Drive(linear, ambient, constant, Ratio(0)), Ratio(1)
        given = self._before(machine, state)
        factor = given.linear[0, 0] / linear[0, 0]
        if np.any(given.linear != factor * q.linear) or np.any(given.constant != factor * constant):
            raise Refuted(f"{self._part.name}: what is carried is no share of q")
        old = space.symbol(n, given.kind).times(factor)
        self._carry(machine, state, old)
        added = state.x[n - 2].value - space.symbol(n - 2, "word")
        share = -added.linear[n, 0]
        if (
            np.any(added.linear[:n] != share * linear)
            or np.any(added.linear[n] != -share)
            or np.any(added.linear[self._place] != share * ambient)
            or np.any(added.constant != share * constant)
        ):
            raise Refuted(f"{self._part.name}: what is carried is no share of the change of q")
        return Drive(linear, ambient, constant, share), factor

    def _q(self, machine: Machine, state: State) -> Affine:
        """q as the C++ computes it, in its own unit."""
        shape = self._part.shape
        if self._arithmetic == "float" and self._order == 1:
            before = state.x[0].value
            copy = State([machine.word(before)])
            machine.call(f"{shape}_advance", copy, self._now)
            return copy.x[0].value - before
        q = machine.call(f"{shape}_increment", state, self._now)
        return q if isinstance(q, Affine) else q.value

    def _before(self, machine: Machine, state: State) -> Affine:
        """What the C++ keeps of q for a change of PWM."""
        if not self.carries or self._arithmetic == "float":
            return self._q(machine, state)
        found: Affine = machine.call(f"{self._part.shape}_drive", state, self._now)
        return found

    def _carry(self, machine: Machine, state: State, before: Affine) -> Affine | None:
        """Hand the share over; float32 gives q after that."""
        shape = self._part.shape
        if self._arithmetic == "float":
            q: Affine = machine.call(f"{shape}_carry", state, self._now, before)
            return q
        after = machine.call(f"{shape}_drive", state, self._now)
        machine.call(f"{shape}_carry", state, before, after)
        return None

    def _advanced(self, machine: Machine, state: State, q: Affine | None) -> State:
        shape = self._part.shape
        if self._arithmetic == "float" and self._order > 1:
            if q is None:
                q = machine.call(f"{shape}_increment", state, self._now)
            machine.call(f"{shape}_advance", state, q)
        else:
            machine.call(f"{shape}_advance", state, self._now)
        return state

    def _settled(self, space: Space, machine: Machine) -> State:
        """x of W at one |PWM|."""
        words = [space.symbol(i, "word") for i in range(self._order)]
        if self.carries:
            words[self._order - 2] += self._q_of_w(space).times(self.drive.share)
        return State([machine.word(word) for word in words])

    def _q_of_w(self, space: Space) -> Affine:
        """q(x) where x = W + e share q(x)."""
        q = space.number(self.drive.constant, "word") + space.symbol(self._place, "word").times(self.drive.ambient)
        for i in range(self._order):
            q += space.symbol(i, "word").times(self.drive.linear[i])
        if not self.carries:
            return q
        return q.times(1 / (1 - self.drive.linear[self._order - 2] * self.drive.share))

    def _changed(self, space: Space, machine: Machine, before: Affine) -> Run:
        """The first run after a change of PWM: x of W and the old q."""
        n = self._order
        words = [space.symbol(i, "word") for i in range(n)]
        words[n - 2] += space.symbol(n, "word").times(self.drive.share)
        state = State([machine.word(word) for word in words])
        # What the old q was rounded by, at whichever |PWM|; nothing after a start.
        low, high = self._rounding_of(space, before)
        old = space.uncertain(space.symbol(n, before.kind).times(self._factor), low, high)
        return self._run(space, self._advanced(machine, state, self._carry(machine, state, old)))

    def _rounding_of(self, space: Space, before: Affine) -> tuple[Ratio, Ratio]:
        ideal = self._q_of_w(space).times(self._factor)
        rest = before - ideal.as_kind(before.kind)
        if rest.linear.any():
            raise Refuted(f"{self._part.name}: q is not the same for the carry as for the run")
        low, high = space.ends(rest)
        return min(low.min(), Ratio(0)), max(high.max(), Ratio(0))

    def _run(self, space: Space, state: State) -> Run:
        """W after the run, from x after it."""
        n, share = self._order, self.drive.share
        after = [cell.value for cell in state.x]
        if self.carries:
            q = space.number(self.drive.constant, "word") + space.symbol(self._place, "word").times(self.drive.ambient)
            for i in range(n):
                q += after[i].times(self.drive.linear[i])
            after[n - 2] -= q.times(share)
        symbols = sorted({symbol for value in after for symbol in value.noise})
        constant = np.array([value.constant for value in after]).T
        columns = np.zeros((self._rows, len(symbols) + 1, n))
        for m, symbol in enumerate(symbols):
            low, high = space.ranges[symbol]
            for i, value in enumerate(after):
                if symbol in value.noise:
                    columns[:, m, i] = floats(value.noise[symbol]) * floats(high - low) / 2
                    constant[:, i] = constant[:, i] + value.noise[symbol] * (high + low) / 2
        old = np.array([value.linear[n] for value in after]).T  # the old q lies about 0
        columns[:, -1] = floats(old * space.ends(space.symbol(n, "word"))[1][:, None])
        matrix = np.array([value.linear[:n] for value in after]).transpose(2, 0, 1)
        ambient = np.array([value.linear[self._place] for value in after]).T
        return Run(matrix, ambient, constant, columns)
