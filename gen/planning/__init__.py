"""What to run next: of a network and its runs, the run that tells most.

`hypotheses` says what remains, `stage` what a run would be like, `expected` what it would tell, `search` looks for the
best one, `planned_run` is what comes of it, `plan` is the whole.
"""
