"""Many motors: their runs in one store, what they have in common, and what makes one of them different.

`folder` keeps runs, models and what else is known of motors; `tasks` are spread over workers, and what was done before
is taken up; `statistics` pools what they found. `identify` finds a common network with each motor's deviation from it;
`watch` tells what all motors, or those of one label, show from what one shows.
"""
