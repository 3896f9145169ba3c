"""One thermal network for the whole motor: capacities, conductances and heats, fitted to all runs at once.

The way of the data: runs -> `bins` (means over 5..30 s, inputs over each) -> `structure` (nodes, paths, which numbers
are free) -> `simulation` (exact solution over each bin, and its derivatives) -> `fit` (damped Gauss-Newton with priors)
-> `hidden_nodes` and `prune` (which nodes and paths, by the error on runs left out) -> `telling` (uncertainty, text,
coefficient file).
"""
