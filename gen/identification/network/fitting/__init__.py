"""One structure and its numbers: bins of runs, the simulation with its derivatives, priors, and the minimum."""
