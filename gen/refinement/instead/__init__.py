"""A file with transfer functions: refined part by part, and where that does not explain it as one network.

The way of the data: `refine` -> `parts/` -> where they explain the runs, that is it; else `network` (identified from
the same runs, and held against the parts on runs left out) -> `settling` (whether it is the motor of the file) ->
`network/`, which traces in it what is left.
"""
