"""Parts or one network: the network where it is good; else the error of both on what was left out says which is taken.

The way of the data: run files -> `models` (either kind, from runs in memory) -> `folds` (what is left out) ->
`left_out` (what each kind, fitted without, errs by there) -> `compared` (by how much, and how sure that is) ->
`decision` (which, and in which words) -> `choose`.
"""
