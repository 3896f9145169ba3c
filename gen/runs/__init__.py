"""Run files: measured or simulated channels over time, as CSV. The only place that knows this format.

Comment lines ``# key: value`` may come first, then a header line, then one row per sample. An empty field is
a missing sample (NaN here). ``time_s`` and ``pwm`` must be there in every row; the rest may be empty.
"""

from gen.runs.head import check_head
from gen.runs.noted import noted_ambient, noted_in, with_noted_ambient
from gen.runs.reader import Contents, check_run, read_run
from gen.runs.run import AMBIENT, EXPECTS, Run
from gen.runs.writer import comment_lines, write_columns, write_run

__all__ = [
    "AMBIENT",
    "EXPECTS",
    "Contents",
    "Run",
    "check_head",
    "check_run",
    "comment_lines",
    "noted_ambient",
    "noted_in",
    "read_run",
    "with_noted_ambient",
    "write_columns",
    "write_run",
]
