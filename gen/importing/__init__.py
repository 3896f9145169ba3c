"""Logs of any logger to run files: what was recorded, by whatever, as this tool takes it.

Reading knows of meaning no more than what names of columns say (:mod:`~gen.importing.reading` gives tables of cells),
guessing knows nothing of files
(:mod:`~gen.importing.guessing` gives a mapping with how sure each part of it is), converting guesses nothing
(:mod:`~gen.importing.convert` makes runs of a table and a mapping, and counts what is no sample).
"""

from gen.importing.convert import Splitting
from gen.importing.converted import Converted
from gen.importing.guessing.decide import Decided, doubts
from gen.importing.guessing.guesses import Choices, Guess
from gen.importing.importing import Plan, Written, plan, write
from gen.importing.mapping import Mapping, read_mapping

__all__ = [
    "Choices",
    "Converted",
    "Decided",
    "Guess",
    "Mapping",
    "Plan",
    "Splitting",
    "Written",
    "doubts",
    "plan",
    "read_mapping",
    "write",
]
