"""Whether the run that `gen plan` asks for decides what one short run has left open, on motors of independent physics.

``python -m benchmarks.plan --cases 10 --seed 300 --jobs 2 --json build/plan.json`` prints the table. Each motor
(:mod:`benchmarks.plants.planted`) is identified as a network before something is changed on it. Then one run of
`--fit-hours` is all that is known of the change. Where the name that this run gives is not what was planted, or another
one is tied with it, the case is ambiguous, and counts: `gen plan` plans a run of `--hours`, the plant follows it, and
its sensors read it; beside it stands a run as long of random holds with stops and reversals, in the same room, under
the same channels. What `gen refine` names from the first run with either is compared.

Motors and effects are taken one after the other until there are as many ambiguous cases as asked for.
"""
