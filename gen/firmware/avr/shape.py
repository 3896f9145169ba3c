"""One shape's part of the block: a loop over its components and runs."""

from __future__ import annotations

from dataclasses import dataclass

from gen.firmware.avr.additions import additions
from gen.firmware.avr.increment import increment
from gen.firmware.avr.registers import COEFFICIENT_BYTES, COMPONENTS, RUNS, STATE_BYTES, D, product_bytes
from gen.firmware.avr.text import AsmText
from gen.lowering.fixed.formats import Format


@dataclass(frozen=True)
class ShapeCode:
    """What is written for one shape.

    Attributes
    ----------
    name
        What its labels end in.
    layout
        Formats of its components.
    count, runs
        How many components it has, and how many times each runs in a sample.
    carried
        Whether a change of PWM needs q alone.
    last
        Whether no other shape follows.
    end
        Where Z is after the last component: its lowest byte tells whether another one is left. "" where that is not
        known: then r10 counts.
    """

    name: str
    layout: Format
    count: int
    runs: int
    carried: bool
    last: bool
    end: str

    @property
    def counts(self) -> bool:
        """Whether r10 counts the components."""
        return self.count > 1 and not self.end

    @property
    def increment_label(self) -> str:
        """Where q alone is computed from."""
        return f".Lq{self.name}%="

    @property
    def _walks(self) -> bool:
        """Whether the pointers are walked along, as order 1 does."""
        return self.layout.order == 1 and self.runs == 1 and (self.count > 1 or not self.last)

    def advance(self, text: AsmText) -> None:
        """The increment and the chain of additions, for each component and run."""
        self._begin(text)
        increment(text, self.layout, self.increment_label, walks=self._walks)
        if self.carried:
            text.group("T: only q was wanted.", "brtc 1f", f"rjmp .Lt{self.name}%=", "1:")
        additions(text, self.layout, walks=self._walks)
        self._end(text)

    def leave(self, text: AsmText) -> None:
        """Give back what a change of PWM needs of the product."""
        first = self.layout.carry_byte
        taken = product_bytes(self.layout.product_shifts[-1])[first : first + len(D)]
        results = (f"mov r{d}, r{r}" for d, r in zip(D, taken, strict=True))
        text.group("The result.", f".Lt{self.name}%=:", *results, "rjmp 9f")

    def _begin(self, text: AsmText) -> None:
        if self.count > 1:
            counter = [f"ldi r18, {self.count}", f"mov r{COMPONENTS}, r18"] if self.counts else []
            text.group("Each component.", *counter, f".Lc{self.name}%=:")
        if self.runs > 1:
            text.group("Each run.", f"ldi r18, {self.runs}", f"mov r{RUNS}, r18", f".Lr{self.name}%=:")

    def _end(self, text: AsmText) -> None:
        if self.runs > 1:
            text.group("", f"dec r{RUNS}", "breq 1f", f"rjmp .Lr{self.name}%=", "1:")
        if not self._walks and (self.count > 1 or not self.last):
            order = self.layout.order
            steps = (f"adiw r30, {STATE_BYTES * order}", f"adiw r28, {COEFFICIENT_BYTES * (order + 1)}")
            text.group("The next component.", *steps)
        if self.count > 1:
            done = f"dec r{COMPONENTS}" if self.counts else f"cpi r30, lo8({self.end})"
            text.group("", done, "breq 1f", f"rjmp .Lc{self.name}%=", "1:")
