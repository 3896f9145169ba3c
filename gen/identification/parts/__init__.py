"""Part by part: transfer functions whose poles and gain depend on speed.

The way of the data: runs -> `records` (condensed, in `logs`) -> `output_error` (transfer functions per speed) ->
`orders` (which order) -> `linearity` -> `general` (schedules over speed) -> `joint` (refined on the runs) ->
`schedule_entries` and `coefficient_file`.
"""
