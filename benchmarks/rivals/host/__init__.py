"""What the tools cost on this computer, as ratios within one run.

`simulators` times a sample of the MY1016's four components in each simulator; `commands` starts each command, and does
some work with three; `work` identifies and refines from runs of any number and length, which `runs` writes; `process`
runs a command and tells its processor time and its memory, and `table` prints what came of all.
"""
