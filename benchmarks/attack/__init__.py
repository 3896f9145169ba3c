"""An attacker of the guaranteed error: see :mod:`benchmarks.attack.__main__` and docs/proof.md."""
