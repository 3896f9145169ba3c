"""Logs of real machines that nobody planted anything in: `gen` against models that were fitted by hand.

``python -m benchmarks.real_machines --data FOLDER`` prints, for every log in the folder, the error on runs that took no
part in any fit: the last value held, three hand-fitted references, and what `gen identify` and `gen refine` make of the
same runs. Every model starts from the run's first reading and is then on its own. The logs are not in this repository;
docs/real_machines.md says where they come from, and a log that is missing is left out.
"""
