"""A model along a measured run: the run's columns as what drives it."""

from gen.replay.inputs import Inputs, ambient_column, check_inputs, inputs_of, read_for
from gen.replay.meaning import check_meaning
from gen.replay.overruled import overruled_ambient

__all__ = ["Inputs", "ambient_column", "check_inputs", "check_meaning", "inputs_of", "overruled_ambient", "read_for"]
