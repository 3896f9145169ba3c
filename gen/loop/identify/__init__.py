"""Identification: from measured runs to a speed-scheduled model with evidence that it is good enough.

The way of the data: runs -> `records` (condensed) -> `fit` (transfer functions per speed) -> `orders` (which order) ->
`linearity` -> `general` (schedules over speed) -> `joint` (refined on the runs) -> `emit` (coefficient file).
"""
