"""Many motors: their runs in one store, what they have in common, and what makes one of them different.

`store` and `run_bytes` keep runs, `labels` what else is known of motors; `work` spreads tasks over workers and takes up
what was done before; `identify` finds a common network with each motor's deviation from it; `watch` tells what all
motors, or those of one label, show from what one shows.
"""
