"""What a sensor shows of a temperature, and where a start from a reading puts it: by the C++, and exactly.

With base the ambient or 0 degC a reading is T + g (T - base) + offset, and a start from one without its offset, x, is
at x - g / (1 + g) (x - base). The C++ has a product with an unsigned word for each; both are run on forms.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gen.certificate.exact import ROUGHLY, Ratio
from gen.certificate.network.arithmetic import Arithmetic, Number
from gen.certificate.network.document import Component
from gen.certificate.network.forms import Form, Space
from gen.certificate.network.machine import Machine
from gen.certificate.network.measured import Measured, Shown
from gen.certificate.network.memory import Model
from gen.certificate.network.source import Unit
from gen.certificate.refuted import Refuted

_WEIGHTS = 1e-12
"""K: what exact shares are off by as float64."""
_FIRST, _AMBIENT = 0, 1
"""The temperatures that forms are made of here: what is told or read, and the ambient."""


@dataclass(frozen=True)
class Sensors:
    """The sensors of a network whose gains may be wrong.

    Attributes
    ----------
    unit
        The C++ of the interface.
    measured
        What was found by running it.
    word_K
        What a word counts.
    ambient
        Ends of the ambient, degC.
    """

    unit: Unit
    measured: Measured
    word_K: float
    ambient: tuple[float, float]

    def reading(self, part: Component, ends: tuple[float, float], more: float) -> float:
        """By how much the word that is read may be off from what the board's own state shows, K.

        Parameters
        ----------
        part
            The component.
        ends
            Of the board's state, degC.
        more
            What is added for a drift at most, words; it is off by what its own state is.

        Raises
        ------
        Refuted
            If a word may overflow.
        """
        own, space = self.measured.sensors[part.name], Space([ends, self.ambient], [], 1)
        # The upper word is the state's, rounded down.
        half = 0.5 * (1.0 + ROUGHLY)
        word = self._words(space.temperature(_FIRST)) - space.number(0.5)
        word = word.within(half)
        room = self._room(space)
        made = word + self._share(space, "shown_more", own, word, room, own.gain) + space.number(float(own.offset))
        for reading in (made, made - room):
            if not np.all((reading.largest + more) * (1.0 + ROUGHLY) < 2.0**31 - 8.0):
                raise Refuted(f"{part.name}: what is read may overflow")
        exact = self._exact(part, space, Ratio(part.shown_per_K or 0.0)) + space.number(part.shown_K)
        return self._away(made, exact)

    def start(self, part: Component, asked: tuple[float, float]) -> tuple[tuple[float, float], float]:
        """Where a start puts a node.

        Parameters
        ----------
        part
            The component.
        asked
            Ends of the readings that it is told, degC.

        Returns
        -------
        ends, off
            Of the exact starts, degC; by how much its words may be off from them, K.

        Raises
        ------
        Refuted
            If a word may overflow.
        """
        own = self.measured.sensors[part.name]
        ends = (asked[0] - part.shown_K, asked[1] - part.shown_K)
        back = Ratio(part.shown_per_K or 0.0) / (1 + Ratio(part.shown_per_K or 0.0))
        bases = self.ambient if part.shown_about == "ambient" else (0.0,)
        corners = [float((1 - back) * Ratio(x) + back * Ratio(base)) for x in ends for base in bases]
        space = Space([ends, self.ambient], [], 1)
        wrong = self.measured.start + abs(own.offset - part.shown_K / self.word_K)
        seen = self._words(space.temperature(_FIRST)).within(wrong * (1.0 + ROUGHLY))
        made = seen - self._share(space, "read_more", own, seen, self._room(space), own.back)
        if not np.all(made.largest < 2.0**31 - 8.0):
            raise Refuted(f"{part.name}: a start may overflow")
        return (min(corners), max(corners)), self._away(made, self._exact(part, space, -back))

    def _words(self, temperature: Form) -> Form:
        return temperature.times(1.0 / self.word_K)

    def _room(self, space: Space) -> Form:
        return self._words(space.temperature(_AMBIENT)).within(self.measured.ambient * (1.0 + ROUGHLY))

    def _share(self, space: Space, name: str, own: Shown, word: Form, room: Form, weight: int) -> Form:
        """What a function of the C++ makes of the distance from the base, in words."""
        do = Arithmetic(space)
        over = word - (room if own.about_ambient else space.number(0.0))
        told = do.fitted(Number("int32_t", over.times(-1.0) if own.opposite else over))
        machine = Machine(self.unit, {}, space, Model([]), _no_channel)
        made: Form = machine.call(name, told, do.known(float(weight), "uint32_t")).form
        return made

    @staticmethod
    def _exact(part: Component, space: Space, weight: Ratio) -> Form:
        """A temperature, and a share of its distance from the base, degC."""
        at = space.temperature(_FIRST)
        over = at - space.temperature(_AMBIENT) if part.shown_about == "ambient" else at
        return (at + over.times(float(weight))).within(_WEIGHTS)

    def _away(self, words: Form, exact: Form) -> float:
        return float((words.times(self.word_K) - exact).largest.max()) * (1.0 + ROUGHLY)


def _no_channel(name: str, channel: int) -> Number:
    raise Refuted(f"{name} reads channel {channel}")
