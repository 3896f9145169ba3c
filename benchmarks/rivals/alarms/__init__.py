"""Ways to hear of a fault, beside the generated rules.

`blocks` makes a run what all are given, `detectors` are the rivals and how they get their thresholds from healthy runs,
`judge` runs them and `gen`'s rules on the runs of `benchmarks.alarm_hours`, and `table` prints what came of it.
"""
