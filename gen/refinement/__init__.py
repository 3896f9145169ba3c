"""Refinement: from a baseline and measured runs to the effects that it lacks. It reads run and coefficient files only.

The way of the data: runs -> `condense` (along the baseline) -> `admission` -> `stacked_runs` -> `hypotheses`, fitted
by `simulation_fit` -> `judgement` on left-out runs -> `trace` (added one by one, by the `steps` of a `trace_state`;
`pairs`, `judged_on_stretches`) -> `refine`.
"""
