"""Recording what a board prints as a run file: `lines` sorts the serial line's text, `port` reads a serial port."""

from gen.record.lines import Part, Recorder

__all__ = ["Part", "Recorder"]
