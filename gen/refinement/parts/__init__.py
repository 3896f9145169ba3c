"""Part by part: effects beside transfer functions, traced at each component.

The way of the data: condensed runs -> `stacked_runs` -> `hypotheses`, fitted by `simulation_fit` -> `judgement` on
left-out runs -> `trace` (added one by one, by the `steps` of a `trace_state`; `pairs`, `judged_on_stretches`) ->
`refine`.
"""
