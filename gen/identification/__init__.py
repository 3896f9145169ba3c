"""Identification: from measured runs to a speed-scheduled model with evidence that it is good enough.

The way of the data: runs -> `records` (condensed) -> `output_error` (transfer functions per speed) -> `orders` (which
order) -> `linearity` -> `general` (schedules over speed) -> `joint` (refined on the runs) -> `schedule_entries` and
`coefficient_file`.
"""
